//! Tests of the JSON file next to a BVH file.

use mocap::bvh::BvhOptions;

use mocap::scene::UpAxis;
use mocap::verify::Verifier;
use mocap::{Code, Exporter, Importer, SkeletonMesh};

#[test]
fn a_sidecar_says_how_a_bvh_file_was_made_to_every_reader() {
    let folder = tempfile::tempdir().unwrap();
    let source = "../../fixtures/real/cmu_short.bvh";
    let mut scene = Importer::new()
        .skeleton_mesh(SkeletonMesh::None)
        .import(source)
        .unwrap();
    // An unnamed unit, a part of the motion, and a motion in place: the BVH file alone does not show these.
    scene.convert_units(0.0123, UpAxis::Y);
    scene.trim(10.0, 40.0);
    scene.put_in_place();
    let (alone, beside) = (folder.path().join("alone.bvh"), folder.path().join("beside.bvh"));
    Exporter::new().export(&scene, &alone).unwrap();
    assert!(!Verifier::new().files(source, &alone).unwrap().is_within(1e-3));
    let exporter = Exporter::new().bvh(BvhOptions::new().sidecar(true));
    let written = exporter.export(&scene, &beside).unwrap();
    assert_eq!(written.files[0].name(), "beside.bvh.json");

    assert_eq!(std::fs::read(&alone).unwrap(), std::fs::read(&beside).unwrap());
    let verified = Verifier::new().files(source, &beside).unwrap();
    assert!(verified.is_within(1e-5), "{verified:?}");
    assert!(verified.has_provenance);
    let read = mocap::import(&beside).unwrap();
    assert_eq!(
        (read.metadata.metres_per_unit, read.metadata.up),
        (Some(1.0), Some(UpAxis::Y))
    );
    assert_eq!(mocap::import(&alone).unwrap().metadata.metres_per_unit, None);

    // The JSON file belongs to this file only. A JSON file of another kind is ignored.
    let mut text = std::fs::read(&beside).unwrap();
    text.push(b'\n');
    std::fs::write(&beside, &text).unwrap();
    assert_eq!(
        Verifier::new().files(source, &beside).unwrap_err().code(),
        Code::InvalidValue
    );
    assert_eq!(mocap::import(&beside).unwrap().metadata.metres_per_unit, None);
    std::fs::write(folder.path().join("alone.bvh.json"), "{\"somebody\": \"else's\"}").unwrap();
    assert!(mocap::import(&alone).unwrap().warnings.is_empty());
    let error = exporter.export(&scene, &alone).unwrap_err();
    assert_eq!(error.code(), Code::OutputExists);
}
