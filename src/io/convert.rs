//! Converts a file to another file in one call.

use std::path::Path;

use mocap_figure::convert::Conversion;
use mocap_formats::{Export, FormatInfo};
use mocap_scene::error::Result;
use mocap_scene::files::ReplacePolicy;
use mocap_scene::process::SkeletonMesh;

use crate::export::Exporter;
use crate::import::Importer;

/// Converts the motion file `from` to the file `to`, as `mocap convert` does without options. The extension of `to`
/// sets the format. Returns the written files, with their warnings.
///
/// The output is in metres with +Y up, except in formats that keep the unit and the axes of the source, such as BVH.
/// `convert` replaces an output of mocap, but not a file that may be a source. To set options, use [`Importer`],
/// [`Conversion`] and [`Exporter`]. A job of the package `mocap-job` also writes arrays.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// let to = std::env::temp_dir().join("mocap_convert.glb");
/// let written = mocap::convert("fixtures/real/cmu_short.bvh", &to)?;
/// assert!(written.len() > 1000);
/// # Ok::<(), mocap::Error>(())
/// ```
///
/// # Errors
/// The errors of [`Importer::import`], [`Conversion::apply`] and [`Exporter::export`].
pub fn convert(from: impl AsRef<Path>, to: impl AsRef<Path>) -> Result<Export> {
    let (from, to) = (from.as_ref(), to.as_ref());
    ReplacePolicy::new([from]).check_ahead(to)?;
    let row = FormatInfo::of_output(to);
    let mesh = row.map_or(SkeletonMesh::Skinned, |row| row.mesh(false));
    let importer = Importer::new()
        .skeleton_mesh(mesh)
        .gltf_meshes(mesh == SkeletonMesh::Own)
        .morph_targets(row.is_some_and(|row| row.takes_morph_targets(from)));
    let mut scene = importer.import(from)?;
    let keeps_units = row.is_some_and(FormatInfo::keeps_units);
    Conversion::new().keep_units(keeps_units).apply(&mut scene)?;
    Exporter::new().export(&scene, to)
}
