//! The mesh files of robots: their paths, and the extent of binary STL and OBJ.

use std::path::{Path, PathBuf};

use glam::DVec3;
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::limits::is_plausible;
use mocap_scene::scene::robot::ShapeKind;

use crate::Source;
use crate::named_file::{LEVELS, below, near};
use crate::text::quote;
use crate::warnings::Warnings;

/// A robot mesh from a file in `folder`, scaled by `scale`.
pub(super) fn mesh_shape(
    source: &Source<'_>,
    folder: &str,
    file: &str,
    scale: DVec3,
    warnings: &mut Warnings,
) -> ShapeKind {
    let beside = source.name.parent().unwrap_or(Path::new(""));
    let extension = Path::new(file).extension().unwrap_or_default().to_ascii_lowercase();
    let extension = extension.to_str().unwrap_or_default();
    let (paths, is_near) = candidates(folder, file);
    let paths = paths.into_iter().map(|path| beside.join(path));
    let is_known = ["stl", "obj", "dae"].contains(&extension);
    let mut found = paths
        .filter(|_| is_known)
        .filter_map(|path| Some(((source.open)(&path).ok()?, path)));
    let (bytes, path) = found
        .next()
        .map_or((Vec::new(), None), |(bytes, path)| (bytes, Some(path)));
    if path.is_none() && !is_near {
        let message = format!(
            "the path of the mesh {} leads too far away from the robot",
            quote(file.as_bytes())
        );
        let expected = format!("a relative path with at most {LEVELS} parent folders");
        let found = Path::new(folder).join(file).display().to_string();
        let help = "write a relative path, or put the mesh into the robot's folder";
        warnings.distinct(
            Diagnostic::new(Code::MissingFile, message)
                .expected_found(expected, found)
                .help(help),
        );
    }
    let bounds = match extension {
        "stl" => stl(&bytes),
        "obj" => obj(&bytes),
        _ => None,
    };
    ShapeKind::Mesh {
        file: file.to_owned(),
        bounds: bounds
            .filter(|[low, high]| low.is_finite() && high.is_finite())
            .map(|[low, high]| {
                let (a, b) = (low * scale, high * scale);
                [a.min(b), a.max(b)]
            }),
        scale,
        path,
        surface: None,
    }
}

/// The possible paths of the file, and whether the robot may refer to it:
/// - the path as written
/// - for a `package://` address, the path within the package, or including the package, in the robot's folder or a
///   parent folder
/// - the file name in the robot's folder, as for files dropped on a page
pub fn candidates(folder: &str, file: &str) -> (Vec<PathBuf>, bool) {
    let mut paths = match file
        .strip_prefix("package://")
        .map(|address| address.trim_start_matches('/'))
    {
        None => {
            let written = Path::new(folder).join(file.strip_prefix("file://").unwrap_or(file));
            Vec::from_iter(near(written))
        }
        Some(address) => {
            let inside = below(address).map(|whole| [whole.components().skip(1).collect(), whole]);
            let inside: Vec<PathBuf> = inside
                .into_iter()
                .flatten()
                .filter(|path| path != Path::new(""))
                .collect();
            let above = (0..=LEVELS).map(|levels| PathBuf::from("../".repeat(levels)));
            above
                .flat_map(|above| inside.iter().map(move |inside| above.join(inside)).collect::<Vec<_>>())
                .collect()
        }
    };
    let is_near = !paths.is_empty();
    paths.extend(Path::new(file).file_name().map(PathBuf::from));
    (paths, is_near)
}

fn extend(bounds: &mut Option<[DVec3; 2]>, point: DVec3) {
    if !point.to_array().into_iter().all(is_plausible) {
        return;
    }
    let [low, high] = bounds.unwrap_or([point; 2]);
    *bounds = Some([low.min(point), high.max(point)]);
}

/// The bounding box of a binary STL file. The file has 80 bytes, the number of triangles, then 50 bytes for each
/// triangle.
pub fn stl(bytes: &[u8]) -> Option<[DVec3; 2]> {
    /// Bytes of a triangle of binary STL: twelve numbers of 32 bits, and an attribute of 16.
    const TRIANGLE: usize = 50;
    let count = u32::from_le_bytes(*bytes.get(80..84)?.first_chunk::<4>()?) as usize;
    let triangles = &bytes[84..];
    // The file may have fewer triangles than it claims.
    if triangles.len() / TRIANGLE < count {
        return None;
    }
    let mut bounds = None;
    for triangle in triangles.chunks_exact(TRIANGLE).take(count) {
        let (numbers, _) = triangle[12..48].as_chunks::<4>();
        let numbers: Vec<f64> = numbers
            .iter()
            .map(|bytes| f64::from(f32::from_le_bytes(*bytes)))
            .collect();
        for corner in numbers.chunks_exact(3) {
            extend(&mut bounds, DVec3::from_slice(corner));
        }
    }
    bounds
}

/// The bounding box of an OBJ file, from its lines `v x y z`.
pub fn obj(bytes: &[u8]) -> Option<[DVec3; 2]> {
    let text = std::str::from_utf8(bytes).ok()?;
    let mut bounds = None;
    for line in text.lines() {
        let mut words = line.split_ascii_whitespace();
        if words.next() != Some("v") {
            continue;
        }
        let mut number = || words.next()?.parse::<f64>().ok();
        if let (Some(x), Some(y), Some(z)) = (number(), number(), number()) {
            extend(&mut bounds, DVec3::new(x, y, z));
        }
    }
    bounds
}
