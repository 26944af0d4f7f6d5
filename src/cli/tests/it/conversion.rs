//! Tests that `mocap convert` gives the bytes of the library's `Conversion`.

use mocap::convert::{FirstFrame, Moment, RestPoseSource, RootMotion};
use mocap::gltf::GltfOptions;
use mocap::scene::UpAxis;
use mocap::{Conversion, Importer, SkeletonMesh};

use crate::at_root;

#[test]
fn the_program_and_the_library_write_the_same_bytes() {
    let new = Conversion::new;
    let cases: [(&str, &[&str], Conversion); 8] = [
        ("cmu_short.bvh", &[], new()),
        ("cmu_02_01.amc", &["--fps", "30"], new().frame_rate(30.0)),
        ("py_c3d_motion.c3d", &[], new()),
        (
            "cmu_short.bvh",
            &["--unit", "inch", "--up", "z"],
            new().metres_per_unit(0.0254).up(UpAxis::Z),
        ),
        (
            "cmu_short.bvh",
            &["--trim", "0.1..50f", "--fps", "30"],
            new().trim(Moment::Seconds(0.1), Moment::Frame(50)).frame_rate(30.0),
        ),
        (
            "cmu_short.bvh",
            &["--drop-first-frame", "auto", "--rest", "frame:7", "--root-motion"],
            new()
                .first_frame(FirstFrame::DropRestPose)
                .rest(RestPoseSource::Frame(7))
                .root(RootMotion::Extract),
        ),
        (
            "cmu_short.bvh",
            &["--drop-first-frame", "yes", "--in-place"],
            new().first_frame(FirstFrame::Drop).root(RootMotion::InPlace),
        ),
        ("lecture_Test.bvh", &["--unit", "0.25"], new().metres_per_unit(0.25)),
    ];
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("out.glb");
    for (file, options, conversion) in cases {
        let input = format!("fixtures/real/{file}");
        let run = crate::program::command(&["convert", &input])
            .arg(&output)
            .args(options)
            .output()
            .unwrap();
        let words = crate::program::words(&run);
        assert!(run.status.success(), "{options:?}: {words}");
        // An AMC file without a frame rate gets the requested rate.
        let importer = Importer::new().skeleton_mesh(SkeletonMesh::Skinned);
        let importer = match file.ends_with("amc") {
            true => importer.retime(30.0),
            false => importer,
        };
        let mut scene = importer.import(at_root(&input)).unwrap();
        for assumption in conversion.apply(&mut scene).unwrap() {
            assert!(words.contains(&format!("{assumption}\n")), "{options:?}: {words}");
        }
        let glb = GltfOptions::default().write_glb(&scene).unwrap();
        assert!(glb == std::fs::read(&output).unwrap(), "{file} {options:?}");
    }
}
