//! Outputs of SAM 3D Body, read: against the joints that NumPy has in the axes of the root
//! (`tools/arrays/make_mhr.py`).

use std::fs;

use mocap::figure::Humanoid;
use mocap::glam::{Vec3, Vec4};
use mocap::scene::joint_tables::mhr;
use mocap::scene::{HumanoidBone, NodeId, Topic, UpAxis};
use mocap::{Code, Importer, Pose, Scene};

const BODY: &str = "../../fixtures/arrays/sam3d_body.npz";
const TAKE: &str = "../../fixtures/arrays/sam3d_take.npz";

/// Metres that a joint may be from where NumPy has it.
const NEAR: f32 = 1e-3;

/// The largest distance of a joint in a frame from where NumPy has it, from the root and in its axes.
fn farthest(scene: &Scene, tick: f64) -> f32 {
    let expected = fs::read_to_string("../../fixtures/arrays/expected_mhr.json").unwrap();
    let expected: Vec<[f32; 3]> = serde_json::from_str(&expected).unwrap();
    let pose = Pose::at_tick(scene, 0, tick).unwrap();
    let node = |name: &str| scene.nodes.iter().position(|node| node.name == name);
    let to_root = pose.node_to_world[node("root").unwrap()].inverse();
    let (mut farthest, mut found) = (0_f32, 0);
    for (joint, place) in mhr().iter().zip(expected) {
        if let Some(index) = node(&joint.name) {
            let own = to_root.transform_point3(pose.position(NodeId::new(index)));
            farthest = farthest.max(own.distance(Vec3::from(place)));
            found += 1;
        }
    }
    // The face of a take does not move, and is left out.
    assert!(found >= 110, "{found} joints");
    farthest
}

#[test]
fn a_frame_is_read_with_its_hands_and_stands_upright() {
    let scene = mocap::import(BODY).unwrap();
    assert!(farthest(&scene, 0.0) < NEAR);
    let pose = Pose::at_tick(&scene, 0, 0.0).unwrap();
    let humanoid = Humanoid::of(&scene);
    let at = |bone: HumanoidBone| pose.position(humanoid.joint(bone).unwrap());
    let feet = at(HumanoidBone::LeftToes).min(at(HumanoidBone::RightToes));
    assert!((0.0..0.15).contains(&feet.y), "{feet}");
    assert!(at(HumanoidBone::Head).y > 1.2);
    // The rest pose is a T-pose: arms to the sides, and fingers on.
    let rest = Pose::rest(&scene);
    let arm = rest.position(humanoid.joint(HumanoidBone::LeftMiddleDistal).unwrap())
        - rest.position(humanoid.joint(HumanoidBone::LeftUpperArm).unwrap());
    assert!(arm.normalize().x > 0.99, "{arm}");
}

#[test]
fn a_take_keeps_its_lengths_and_is_levelled() {
    let error = mocap::import(TAKE).unwrap_err();
    assert_eq!(error.code(), Code::FrameTime);
    let scene = Importer::new().retime(25.0).import(TAKE).unwrap();
    assert_eq!(scene.animations[0].ticks_per_second, 25.0);
    assert_eq!(scene.animations[0].frame_count(), 5);
    assert_eq!(
        scene
            .warnings
            .iter()
            .filter(|warning| warning.code == Code::Gap)
            .count(),
        1
    );
    // The frame that is not finite is interpolated.
    for frame in [0, 1, 3, 4] {
        let farthest = farthest(&scene, f64::from(frame));
        assert!(farthest < NEAR, "{farthest} in {frame}");
    }
    // The camera looks down by 20 degrees; the person of the frame leans a little.
    let root = scene.nodes.iter().position(|node| node.name == "root").unwrap();
    let pose = Pose::at_tick(&scene, 0, 0.0).unwrap();
    let up = pose.node_to_world[root] * Vec4::Y;
    assert!(up.y > 20_f32.to_radians().cos(), "{up}");
    let up = scene.metadata.assumptions.iter().find(|found| found.topic == Topic::Up);
    assert!(up.is_some() && scene.metadata.up == Some(UpAxis::Y));
    // From left to right by 20 cm a frame.
    let last = Pose::at_tick(&scene, 0, 4.0).unwrap();
    let moved = last.position(NodeId::new(root)) - pose.position(NodeId::new(root));
    assert!((moved.length() - 0.8).abs() < NEAR, "{moved}");
}

/// Numbers order the files of a folder, and say which frames are missing; a person has a number of its own.
#[test]
fn a_folder_of_frames_is_one_take() {
    let folder = tempfile::tempdir().unwrap();
    for name in [
        "shot2_9_subj0.npz",
        "shot2_10_subj0.npz",
        "shot2_10_subj1.npz",
        "shot2_12_subj0.npz",
    ] {
        fs::copy(BODY, folder.path().join(name)).unwrap();
    }
    fs::write(folder.path().join("notes.txt"), "no frame").unwrap();
    let error = mocap::import(folder.path()).unwrap_err();
    assert_eq!(error.code(), Code::FrameTime);
    let scene = Importer::new().retime(30.0).import(folder.path()).unwrap();
    assert_eq!(scene.animations[0].frame_count(), 4);
    assert!(farthest(&scene, 0.0) < NEAR && farthest(&scene, 3.0) < NEAR);
    let codes: Vec<Code> = scene.warnings.iter().map(|warning| warning.code).collect();
    // The same body twice in a frame: who is who cannot be told.
    assert_eq!(codes, [Code::NotCarriedOver, Code::Gap]);
    fs::copy(TAKE, folder.path().join("shot2_11.npz")).unwrap();
    let error = Importer::new().retime(30.0).import(folder.path()).unwrap_err();
    assert!(
        error.to_string().contains("shot2_11.npz") && error.code() == Code::RowLength,
        "{error}"
    );
}

/// Clips in a folder are motions, each of its own, and frames beside a motion are not read without it.
#[test]
fn a_folder_of_clips_is_no_take() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["walk_1.npz", "walk_2.npz"] {
        fs::copy(TAKE, folder.path().join(name)).unwrap();
    }
    assert!(Importer::is_of_many(folder.path()));
    let frames = tempfile::tempdir().unwrap();
    fs::copy(BODY, frames.path().join("shot_1.npz")).unwrap();
    fs::write(frames.path().join("shot_2.npz"), "broken").unwrap();
    assert!(!Importer::is_of_many(frames.path()));
    fs::remove_file(frames.path().join("shot_2.npz")).unwrap();
    fs::write(frames.path().join("walk.bvh"), "HIERARCHY").unwrap();
    let error = Importer::new().retime(30.0).import(frames.path()).unwrap_err();
    assert!(error.to_string().contains("1 other motion: walk.bvh"), "{error}");
}
