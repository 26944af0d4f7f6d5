//! The truth matrix: each kind of corruption in each format, and what is no corruption; both verdicts.
//!
//! A kind that changes no byte of a format is not in it. `MOCAP_ALL=1 cargo test truth` tries all.

mod kinds;

use std::collections::HashMap;
use std::path::Path;

use mocap::arrays::{ArrayOptions, Arrays};
use mocap::verify::Verifier;
use mocap::{Conversion, Exporter, Importer, Scene, SkeletonMesh};

use self::kinds::KINDS;
use crate::sample::Sample;

/// The formats, and the name under which another program wrote the file. Parquet needs its feature.
const FORMATS: &[&str] = &[
    "glb",
    "glb of another program",
    "gltf",
    "fbx",
    "bvh",
    "mclip",
    "vrma",
    "usda",
    "usdz",
    "trc",
    "npz",
    "csv",
    #[cfg(feature = "parquet")]
    "parquet",
];

const LYING: &str = "the up axis of a file without provenance is found from its first frame";
const END_SITE: &str = "other programs leave end sites out";

const CHOICE: &str = "arrays and markers may have a choice of joints";
const NO_ROTATIONS: &str = "markers have positions alone";
const BONES: &str =
    "a VRM animation has bones in the hierarchy of VRM, and of others than those that it requires no more";
const POSITIONS: &str = "the bound of packed clips is one of positions, and of rotations that move no joint";

/// What is known not to be found, with the reason.
const MISSED: &[(&str, &str, &str)] = &[
    ("Z up for Y up", "glb of another program", LYING),
    ("Z up for Y up", "bvh", LYING),
    ("Z up for Y up", "mclip", LYING),
    ("lying on the ground", "glb of another program", LYING),
    ("lying on the ground", "bvh", LYING),
    ("lying on the ground", "mclip", LYING),
    ("an end site is missing", "glb of another program", END_SITE),
    ("an end site is missing", "bvh", END_SITE),
    ("an end site is missing", "mclip", END_SITE),
    ("Z up for Y up", "trc", LYING),
    ("lying on the ground", "trc", LYING),
    ("a forearm turned about itself, its hand back", "trc", NO_ROTATIONS),
    ("an end site is missing", "trc", CHOICE),
    ("an end site is missing", "npz", CHOICE),
    ("an end site is missing", "csv", CHOICE),
    ("an end site is missing", "parquet", CHOICE),
    ("a joint is missing", "npz", CHOICE),
    ("a joint is missing", "csv", CHOICE),
    ("a joint is missing", "parquet", CHOICE),
    ("a joint is missing", "vrma", BONES),
    ("a joint renamed", "vrma", BONES),
    ("another parent", "vrma", BONES),
    ("a forearm turned about itself, its hand back", "mclip", POSITIONS),
];

/// The bytes of a file that is written there; nothing where its format cannot hold the scene.
fn written(scene: &Scene, path: &Path) -> Option<Vec<u8>> {
    let motion = || Arrays::of(scene, &ArrayOptions::new());
    match path.extension()?.to_str()? {
        "npz" => Some(motion().ok()?.to_npz()),
        "csv" => Some(motion().ok()?.to_csv().into()),
        #[cfg(feature = "parquet")]
        "parquet" => motion().ok()?.to_parquet("walk").ok(),
        _ => {
            Exporter::new().overwrite(true).export(scene, path).ok()?;
            std::fs::read(path).ok()
        }
    }
}

#[test]
fn every_corruption_is_found_in_every_format_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let source = folder.path().join("walk.bvh");
    std::fs::copy("../../fixtures/real/cmu_short.bvh", &source).unwrap();
    let mut scene = Importer::new()
        .skeleton_mesh(SkeletonMesh::Skinned)
        .import(&source)
        .unwrap();
    Conversion::new().apply(&mut scene).unwrap();
    let cells: Vec<_> = KINDS
        .iter()
        .flat_map(|kind| FORMATS.iter().map(move |format| (kind, *format)))
        .collect();
    let mut wrong = Vec::new();
    let mut whole: HashMap<&str, Option<Vec<u8>>> = HashMap::new();
    for (kind, format) in Sample::new().some(cells, 16) {
        let mut changed = scene.clone();
        (kind.change)(&mut changed);
        let path = folder.path().join(format!("out.{}", format.split(' ').next().unwrap()));
        let written = |scene: &Scene| written(scene, &path);
        let whole = &*whole.entry(format).or_insert_with(|| written(&scene));
        let Some(mut bytes) = written(&changed) else { continue };
        let is_same = whole.as_ref() == Some(&bytes) && !format.starts_with("gltf");
        if format.ends_with("program") {
            let name = b"\"mocap\"";
            let place = bytes.windows(name.len()).position(|window| window == name).unwrap();
            bytes[place..place + name.len()].copy_from_slice(b"\"other\"");
        }
        std::fs::write(&path, &bytes).unwrap();
        let verdict = Verifier::new().files(&source, &path);
        let passes = verdict.as_ref().is_ok_and(|verified| verified.is_within(1e-3));
        let is_missed = MISSED.iter().any(|(name, of, _)| *name == kind.name && *of == format);
        let should_pass = !kind.is_wrong || is_same || is_missed;
        if passes != should_pass {
            let verdict = verdict.map(|found| {
                (
                    found.max_error,
                    found.rotation_error,
                    found.findings,
                    found.metres_per_unit,
                )
            });
            wrong.push(format!("{}, {format}: {verdict:?}", kind.name));
        }
    }
    assert!(wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong.join("\n"));
}

/// Whole files are accepted in every written format, and none that ends early, with the last row of numbers too.
#[test]
fn a_file_that_was_cut_off_is_refused_in_every_format() {
    let folder = tempfile::tempdir().unwrap();
    let source = folder.path().join("walk.bvh");
    std::fs::write(&source, crate::cut::first_frames("real/cmu_short.bvh", 12)).unwrap();
    let mut scene = mocap::import(&source).unwrap();
    Conversion::new().apply(&mut scene).unwrap();
    for extension in FORMATS.iter().filter(|format| !format.contains(' ')) {
        let path = folder.path().join(format!("out.{extension}"));
        let bytes = written(&scene, &path).unwrap();
        for length in [
            bytes.len(),
            bytes.len() - 20,
            bytes.len() * 2 / 3,
            bytes.len() / 9,
            3,
            0,
        ] {
            std::fs::write(&path, &bytes[..length]).unwrap();
            let verdict = Verifier::new().files(&source, &path);
            let passes = verdict.as_ref().is_ok_and(|verified| verified.is_within(1e-3));
            let of = bytes.len();
            assert_eq!(passes, length == of, "{extension}, {length} bytes of {of}: {verdict:?}");
        }
    }
}
