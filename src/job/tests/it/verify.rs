//! Tests that `verify` finds defects, reports their place, and finds nothing in correct files.

use std::path::PathBuf;

use mocap::glam::{Quat, Vec3};
use mocap::gltf::GltfOptions;
use mocap::gltf::report::Provenance;

use mocap::scene::{Channel, UpAxis};
use mocap::verify::Verifier;
use mocap::verify::report::FindingKind;
use mocap::verify::report::Verification;
use mocap::{Code, Exporter, Importer, Limits, RootOffset, Scene, SkeletonMesh};

use crate::cut;
use crate::sample::Sample;

fn fixture(file: &str) -> String {
    format!("../../fixtures/real/{file}")
}

fn import(file: &str) -> Scene {
    Importer::new()
        .skeleton_mesh(SkeletonMesh::Skinned)
        .import(fixture(file))
        .unwrap()
}

fn glb(scene: &Scene) -> Vec<u8> {
    GltfOptions::default().write_glb(scene).unwrap()
}

/// The `glb` file without the record of this crate.
fn as_of_another_program(glb: &[u8]) -> Vec<u8> {
    let place = glb.windows(7).position(|window| window == b"\"mocap\"").unwrap();
    let mut changed = glb.to_vec();
    changed[place..place + 7].copy_from_slice(b"\"other\"");
    changed
}

#[test]
fn every_step_is_replayed_from_the_provenance() {
    type Step = fn(&mut Scene);
    let steps: [(Step, usize); 7] = [
        (|_| (), 339),
        (|scene| scene.convert_units(0.0254, UpAxis::Z), 339),
        (|scene| scene.trim(100.0, 200.0), 101),
        (
            |scene| {
                scene.trim(50.0, 300.0);
                scene.trim(50.0, 150.0);
                scene.convert_units(0.01, UpAxis::Y);
            },
            101,
        ),
        (
            |scene| {
                scene.trim(1.0, f64::INFINITY);
                scene.convert_units(0.0254, UpAxis::Z);
                scene.put_in_place();
            },
            338,
        ),
        (
            |scene| {
                scene.convert_units(0.0254, UpAxis::Z);
                scene.extract_root_motion();
            },
            339,
        ),
        (
            |scene| {
                let rate = scene.animations[0].ticks_per_second;
                scene.resample(2.0 * rate, &Limits::default()).unwrap();
                scene.convert_units(0.0254, UpAxis::Z);
            },
            677,
        ),
    ];
    let source = import("z_up_dab.bvh");
    for (index, (step, frames)) in steps.into_iter().enumerate() {
        let mut scene = source.clone();
        step(&mut scene);
        let verified = Verification::of(&source, &glb(&scene)).unwrap();
        // The skeleton is 44 units of the file tall, so the tolerance is 1e-6 of its height.
        let tolerance = 44.0 * verified.metres_per_unit * 1e-6;
        assert!(verified.max_error < 2.0 * tolerance, "steps {index}: {verified:?}");
        let counts = (verified.frames, verified.joints, verified.end_sites);
        assert_eq!(counts, (frames, 27, 7), "steps {index}");
        assert!(verified.missing.is_empty() && verified.missing_end_sites.is_empty());
        assert!(verified.has_provenance);
    }
}

#[test]
fn a_joint_that_is_off_is_named_with_its_frame_and_distance() {
    let source = import("cmu_short.bvh");
    let mut scene = source.clone();
    scene.convert_units(0.01, UpAxis::Y);
    let tip = scene
        .nodes
        .iter()
        .find(|node| node.name == "EndSite_LeftToeBase")
        .unwrap();
    let offset = tip.transform.w_axis.truncate().as_dvec3();
    let toes = |channel: &&mut Channel| channel.node_name == "LeftToeBase";
    let channel = scene.animations[0].channels.iter_mut().find(toes).unwrap();
    let rotation = &mut channel.rotation_keys.values[40];
    *rotation *= Quat::from_rotation_x(0.1);

    // A rotation by 0.1 about X moves the tip along a chord of its circle around X.
    let expected = 2.0 * f64::sin(0.05) * offset.y.hypot(offset.z);
    let verified = Verification::of(&source, &glb(&scene)).unwrap();
    assert!(
        (verified.max_error - expected).abs() < 1e-6,
        "{} is not {expected}",
        verified.max_error
    );
    let worst = verified.worst.unwrap();
    assert_eq!((worst.joint.as_str(), worst.frame), ("EndSite_LeftToeBase", 40));
    assert!((worst.seconds - 40.0 * 0.008_333_3).abs() < 1e-9);
    let mean_square = expected * expected / (75.0 * 38.0);
    assert!((verified.rms_error - mean_square.sqrt()).abs() < 1e-6);
}

#[test]
fn resampling_is_compared_at_its_own_frames_and_its_loss_is_a_figure_of_its_own() {
    let source = import("cmu_12_01_walk.bvh");
    let lost = [60.0, 30.0, 25.0].map(|rate| {
        let mut scene = source.clone();
        scene.resample(rate, &Limits::default()).unwrap();
        scene.convert_units(0.056_444, UpAxis::Y);
        let verified = Verification::of(&source, &glb(&scene)).unwrap();
        assert!(verified.is_within(1e-5), "{rate}: {verified:?}");
        assert!(verified.frames < 270);
        let lost = verified.resampling.unwrap();
        assert!((519..=524).contains(&lost.frames), "{lost:?}");
        lost.max_error
    });
    assert!(lost[0] > 1e-5 && lost[1] > lost[0], "{lost:?}");
    // A T-pose that was blended over a thirtieth of a second would be half a metre off.
    assert!(lost[1] < 0.03, "{lost:?}");
}

/// The motion jumps away from the rest pose in its first frame. In files with a pose for each frame, the jump is
/// between two frames. A frame within the jump equals the pose before or the pose after it, not a mixture of the two
/// poses.
#[test]
fn a_jump_is_compared_at_the_frames_that_the_file_has() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("walk.bvh"), cut::first_frames("real/cmu_12_01_walk.bvh", 60)).unwrap();
    let source = mocap::import(path("walk.bvh")).unwrap();
    // The frame of the source that is nearest to a frame of the file.
    let nearest = |frame: usize, rate: f64| (frame as f64 * 120.0 / rate).round() as usize;
    for rate in [24.0, 30.0, 60.0, 100.0, 240.0, 480.0] {
        let mut scene = source.clone();
        scene.resample(rate, &Limits::default()).unwrap();
        let steps = Provenance::of(&scene);
        for extension in ["bvh", "trc", "fbx", "vrma", "glb", "usda", "mclip"] {
            let output = path(&format!("out.{extension}"));
            let mut metres = scene.clone();
            metres.convert_units(0.056_444, UpAxis::Y);
            let provenance = Provenance::of(&metres);
            Exporter::new().overwrite(true).export(&metres, &output).unwrap();
            let verifier = Verifier::new().provenance(provenance);
            let verified = verifier.files(path("walk.bvh"), &output).unwrap();
            let allowed = if extension == "mclip" { 1e-3 } else { 2e-5 };
            assert!(verified.is_within(allowed), "{extension}, {rate}: {verified:?}");
        }
        // Whole frames of the source, read from the text of the file, and the frames in the jump.
        Exporter::new().overwrite(true).export(&scene, path("out.bvh")).unwrap();
        let rows = |name: &str| -> Vec<Vec<f32>> {
            let text = std::fs::read_to_string(path(name)).unwrap();
            let lines = text.lines().skip_while(|line| !line.starts_with("Frame Time"));
            let numbers = |line: &str| line.split_whitespace().map(|word| word.parse().unwrap()).collect();
            lines.skip(1).map(numbers).collect()
        };
        let (ours, theirs) = (rows("walk.bvh"), rows("out.bvh"));
        let mut compared = 0;
        for (frame, row) in theirs.iter().enumerate() {
            let at = frame as f64 * 120.0 / rate;
            if at < 1.0 || at.fract() == 0.0 {
                let expected = &ours[nearest(frame, rate)];
                let off = row.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                assert!(off < 2e-3, "{rate}, row {frame}: {off}");
                compared += 1;
            }
        }
        assert!(compared > 10 || rate == 100.0, "{rate}: {compared}");
        // `verify` finds a changed row.
        let mut wrong = scene.clone();
        wrong.animations[0].channels[0].position_keys.values[3].x += 0.2;
        Exporter::new().overwrite(true).export(&wrong, path("out.bvh")).unwrap();
        let verifier = Verifier::new().provenance(steps);
        let verified = verifier.files(path("walk.bvh"), path("out.bvh")).unwrap();
        assert!(!verified.is_within(1e-3), "{rate}: {verified:?}");
    }
}

/// The frame time .0083333 means 1/120. The rounding changes no frame, and changes the time of each frame by only one
/// part in 250,000.
#[test]
fn the_rate_that_a_rounded_frame_time_means_loses_nothing() {
    let source = import("cmu_12_01_walk.bvh");
    let mut scene = source.clone();
    scene.resample(120.0, &Limits::default()).unwrap();
    scene.convert_units(0.056_444, UpAxis::Y);
    let verified = Verification::of(&source, &glb(&scene)).unwrap();
    assert_eq!(verified.frames, 524);
    assert!(verified.max_error < 2e-6, "{verified:?}");
}

#[test]
fn files_of_other_programs_are_compared_by_name_and_size() {
    let source = import("z_up_dab.bvh");
    let mut scene = source.clone();
    scene.convert_units(0.0254, UpAxis::Z);
    for (node, name) in [(0, "mixamorig:Hips"), (1, "SPINE"), (2, "Spine 1")] {
        let old = std::mem::replace(&mut scene.nodes[node].name, name.into());
        for channel in &mut scene.animations[0].channels {
            if channel.node_name == old {
                channel.node_name = name.into();
            }
        }
    }
    let verified = Verification::of(&source, &as_of_another_program(&glb(&scene))).unwrap();
    assert!(!verified.has_provenance);
    assert_eq!(verified.missing, ["Hips"]);
    assert_eq!((verified.frames, verified.joints, verified.end_sites), (339, 26, 7));
    assert!((verified.metres_per_unit / 0.0254 - 1.0).abs() < 1e-5);
    assert!(verified.max_error < 1e-4, "{verified:?}");
}

#[test]
fn a_file_that_ends_early_is_compared_as_far_as_it_goes() {
    let source = import("z_up_dab.bvh");
    let mut scene = source.clone();
    scene.trim(0.0, 99.0);
    let verified = Verification::of(&source, &as_of_another_program(&glb(&scene))).unwrap();
    assert_eq!(verified.frames, 339);
    assert_eq!(kinds(&verified), [FindingKind::MissingFrames]);
    assert!(!verified.is_within(f64::INFINITY));
}

fn kinds(verified: &Verification) -> Vec<FindingKind> {
    verified.findings.iter().map(|finding| finding.kind).collect()
}

/// Changes of a scene that the file does not record.
#[test]
fn every_attack_is_found() {
    type Attack = fn(&mut Scene);
    fn rename(scene: &mut Scene, from: &str, to: &str) {
        let node = scene.nodes.iter_mut().find(|node| node.name == from).unwrap();
        node.name = to.into();
        let channels = scene.animations.iter_mut().flat_map(|clip| &mut clip.channels);
        for channel in channels.filter(|channel| channel.node_name == from) {
            channel.node_name = to.into();
        }
    }
    let attacks: [(&str, Attack, &[FindingKind]); 8] = [
        (
            "one frame of all",
            |scene| scene.trim(0.0, 0.0),
            &[
                FindingKind::Provenance,
                FindingKind::MissingFrames,
                FindingKind::MissingFrames,
            ],
        ),
        (
            "the last frame dropped",
            |scene| scene.trim(0.0, 73.0),
            &[FindingKind::Provenance, FindingKind::MissingFrames],
        ),
        (
            "the first frame dropped",
            |scene| scene.trim(1.0, 74.0),
            &[FindingKind::Provenance, FindingKind::MissingFrames],
        ),
        (
            "slower",
            |scene| scene.animations[0].ticks_per_second *= 0.9,
            &[FindingKind::ExtraFrames],
        ),
        (
            "renamed",
            |scene| rename(scene, "Head", "Kopf"),
            &[FindingKind::MissingJoint, FindingKind::ExtraJoint],
        ),
        (
            "left and right swapped",
            |scene| {
                rename(scene, "LeftLeg", "swap");
                rename(scene, "RightLeg", "LeftLeg");
                rename(scene, "swap", "RightLeg");
            },
            &[FindingKind::MovedJoint],
        ),
        (
            "another clip",
            |scene| {
                let mut clip = scene.animations[0].clone();
                clip.name = "other".into();
                scene.animations.push(clip);
            },
            &[FindingKind::ExtraClip],
        ),
        (
            "no clip",
            |scene| scene.animations.clear(),
            &[FindingKind::Provenance, FindingKind::MissingClip],
        ),
    ];
    let source = import("cmu_short.bvh");
    for (name, attack, expected) in attacks {
        let mut scene = source.clone();
        scene.convert_units(0.056_444, UpAxis::Y);
        let steps = scene.metadata.steps.clone();
        attack(&mut scene);
        scene.metadata.steps = steps;
        let verified = Verification::of(&source, &glb(&scene)).unwrap();
        assert_eq!(kinds(&verified), expected, "{name}: {:?}", verified.findings);
        assert!(!verified.is_within(f64::INFINITY), "{name}");
    }
}

#[test]
fn a_turn_that_moves_no_joint_is_found() {
    let source = import("z_up_dab.bvh");
    let mut scene = source.clone();
    scene.convert_units(0.0254, UpAxis::Z);
    let verified = Verification::of(&source, &glb(&scene)).unwrap();
    assert!(verified.rotation_error.unwrap() < 1e-6, "{verified:?}");
    let has_children = |id: usize| {
        scene
            .nodes
            .iter()
            .any(|node| node.parent.is_some_and(|parent| parent.index() == id))
    };
    let leaf = (0..scene.nodes.len()).find(|id| !has_children(*id)).unwrap();
    let turn = mocap::glam::Mat4::from_rotation_x(0.1);
    scene.nodes[leaf].transform *= turn;
    let verified = Verification::of(&source, &glb(&scene)).unwrap();
    assert!(verified.max_error < 1e-5, "{verified:?}");
    // A point 3 cm from a joint that rotates by 0.1 about X moves by the chord of its circle.
    let chord = 2.0 * 0.03 * f64::sin(0.05);
    assert!((verified.rotation_error.unwrap() - chord).abs() < 1e-5, "{verified:?}");
    assert!(!verified.is_within(1e-3));
}

#[test]
fn bvh_is_compared_as_its_reader_reads_it() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("out.bvh");
    let mut random = Sample::new();
    for file in ["cmu_short.bvh", "z_up_dab.bvh", "rokoko_dance.bvh", "py_c3d_motion.c3d"] {
        let mut source = PathBuf::from(fixture(file));
        if file.ends_with(".bvh") {
            let text = cut::some_frames(&mut random, &format!("real/{file}"), 100);
            source = folder.path().join(file);
            std::fs::write(&source, text).unwrap();
        }
        let scene = mocap::import(&source).unwrap();
        Exporter::new().overwrite(true).export(&scene, &output).unwrap();
        let verified = Verifier::new().files(&source, &output).unwrap();
        assert!(verified.is_within(1e-4), "{file}: {verified:?}");
        let mut shorter = scene.clone();
        shorter.trim(0.0, 5.0);
        Exporter::new().overwrite(true).export(&shorter, &output).unwrap();
        let verified = Verifier::new().files(&source, &output).unwrap();
        assert!(
            kinds(&verified).contains(&FindingKind::MissingFrames),
            "{file}: {verified:?}"
        );
    }
}

#[test]
fn a_file_of_another_skeleton_is_refused() {
    let error = Verification::of(&import("lecture_Test.bvh"), &glb(&import("cmu_short.bvh"))).unwrap_err();
    assert!(error.to_string().contains("no joint"), "{error}");
}

#[test]
fn a_file_of_no_known_format_is_refused() {
    let error = Verification::of(&import("lecture_Test.bvh"), b"no motion").unwrap_err();
    assert_eq!(error.code(), Code::UnknownFormat);
    // `verify` finds no difference between a file and itself.
    let source = fixture("lecture_Test.bvh");
    assert!(Verifier::new().files(&source, &source).unwrap().is_within(1e-9));
}

#[test]
fn a_still_skeleton_is_compared_at_rest() {
    let source = import("latin1_name_no_motion.bvh");
    let verified = Verification::of(&source, &glb(&source)).unwrap();
    assert_eq!(
        (
            verified.frames,
            verified.joints,
            verified.end_sites,
            verified.max_error < 1e-5
        ),
        (1, 18, 5, true)
    );
    let mut moved = source.clone();
    moved.nodes[3].transform.w_axis += Vec3::X.extend(0.0);
    assert!((Verification::of(&source, &glb(&moved)).unwrap().max_error - 1.0).abs() < 1e-5);
}

#[test]
fn files_are_read_as_the_conversion_read_them() {
    let folder = tempfile::tempdir().unwrap();
    let source = fixture("cmu_short.bvh");
    let importer = Importer::new().root_offset(RootOffset::Add).retime(25.0);
    let scene = importer.import(&source).unwrap();
    for name in ["a b.gltf", "a.glb"] {
        let output = folder.path().join(name);
        Exporter::new().export(&scene, &output).unwrap();
        let verified = Verifier::new().files(&source, &output).unwrap();
        assert_eq!(verified.frames, 75);
        assert!(verified.max_error < 1e-4, "{verified:?}");
    }
    let error = Verifier::new()
        .files(&source, folder.path().join("none.glb"))
        .unwrap_err();
    assert_eq!(error.code().as_str(), "io");
}

mod allowed;
mod of_arrays;
mod sidecar;
mod truth;
mod verdicts;
mod written;
