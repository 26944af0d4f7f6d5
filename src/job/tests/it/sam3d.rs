//! Tests of reading outputs of SAM 3D Body, compared with joints that NumPy computes in the axes of the root
//! (`tools/arrays/make_mhr.py`).

use std::fs;

use mocap::arrays::{BodyArrays, BodyLayout};
use mocap::figure::Humanoid;
use mocap::glam::{Vec3, Vec4};
use mocap::scene::joint_tables::mhr;
use mocap::scene::{HumanoidBone, NodeId, Topic, UpAxis};
use mocap::{Clips, Code, Importer, Pose, Scene};

const BODY: &str = "../../fixtures/arrays/sam3d_body.npz";
const TAKE: &str = "../../fixtures/arrays/sam3d_take.npz";

/// The largest distance of a joint from NumPy's position, in metres.
const NEAR: f32 = 1e-3;

/// The largest distance of a joint in a frame from NumPy's position, relative to the root and in its axes.
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
    // The face of a take does not move, so it is dropped.
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
    // The rest pose is a T-pose: the arms point sideways, and the fingers continue them.
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
    // A frame with NaN is interpolated.
    for frame in [0, 1, 3, 4] {
        let farthest = farthest(&scene, f64::from(frame));
        assert!(farthest < NEAR, "{farthest} in {frame}");
    }
    // The camera looks down by 20 degrees, and the person in this frame leans a little.
    let root = scene.nodes.iter().position(|node| node.name == "root").unwrap();
    let pose = Pose::at_tick(&scene, 0, 0.0).unwrap();
    let up = pose.node_to_world[root] * Vec4::Y;
    assert!(up.y > 20_f32.to_radians().cos(), "{up}");
    let up = scene.metadata.assumptions.iter().find(|found| found.topic == Topic::Up);
    assert!(up.is_some() && scene.metadata.up == Some(UpAxis::Y));
    // The person moves from left to right by 20 cm per frame.
    let last = Pose::at_tick(&scene, 0, 4.0).unwrap();
    let moved = last.position(NodeId::new(root)) - pose.position(NodeId::new(root));
    assert!((moved.length() - 0.8).abs() < NEAR, "{moved}");
}

/// `--to mhr` writes the joints of the estimator, twist helpers and face too, not only the bones of the body.
#[test]
fn a_body_of_the_rig_is_written_as_it_was_read() {
    let folder = tempfile::tempdir().unwrap();
    for (file, frames) in [(BODY, 1), (TAKE, 5)] {
        let mut scene = Importer::new().retime(25.0).import(file).unwrap();
        // A file of one frame is read with all joints, also with the face joints that the scene of a take lacks. These
        // face joints have lost the expression of the face, which opens the jaw by less than 2 mm here.
        for (frames, near) in [(frames, NEAR), (1, 2.0 * NEAR)] {
            scene.trim(0.0, (frames - 1) as f64);
            let written = folder.path().join("again.npz");
            let bytes = BodyArrays::new(&scene).unwrap().write(BodyLayout::Mhr).unwrap();
            fs::write(&written, bytes).unwrap();
            let again = mocap::import(&written).unwrap();
            assert_eq!(again.animations[0].frame_count(), frames);
            let farthest = farthest(&again, 0.0);
            assert!(farthest < near, "{file}: {farthest}");
        }
    }
}

/// The up direction that the vertices below a foot show, relative to the axes of the root.
#[test]
fn a_sole_is_where_its_vertices_are() {
    let scene = mocap::import(BODY).unwrap();
    let expected = fs::read_to_string("../../fixtures/arrays/expected_soles.json").unwrap();
    let expected: [[f32; 3]; 2] = serde_json::from_str(&expected).unwrap();
    let pose = Pose::at_tick(&scene, 0, 0.0).unwrap();
    let humanoid = Humanoid::of(&scene);
    let turn = |bone: HumanoidBone| {
        let joint = humanoid.joint(bone).unwrap();
        pose.node_to_world[joint.index()].to_scale_rotation_translation().1
    };
    let to_root = turn(HumanoidBone::Hips).inverse();
    // The left foot stands. The right foot hangs and bends.
    for (bones, up) in [
        ([HumanoidBone::LeftFoot, HumanoidBone::LeftToes], expected[0]),
        ([HumanoidBone::RightFoot, HumanoidBone::RightToes], expected[1]),
    ] {
        for bone in bones {
            let angle = (to_root * turn(bone) * Vec3::Y)
                .angle_between(Vec3::from(up))
                .to_degrees();
            assert!(angle < 15.0, "{bone:?}: {angle}");
        }
    }
}

/// The rotations of the left hand in the file contradict its positions.
#[test]
fn a_hand_that_contradicts_its_positions_is_said() {
    let scene = mocap::import(BODY).unwrap();
    let messages: Vec<&str> = scene.warnings.iter().map(|warning| warning.message.as_str()).collect();
    assert!(
        matches!(messages[..], [hand] if hand.contains("the left hand") && hand.contains("1 of 1 frames")),
        "{messages:?}"
    );
}

/// The steps of the root over the ground from frame to frame, in metres.
fn steps(scene: &Scene) -> Vec<f32> {
    let root = scene.nodes.iter().position(|node| node.name == "root").unwrap();
    let frames = scene.animations[0].frame_count();
    let place = |frame: usize| {
        let pose = Pose::at_tick(scene, 0, frame as f64).unwrap();
        pose.position(NodeId::new(root))
    };
    (1..frames)
        .map(|frame| place(frame).distance(place(frame - 1)))
        .collect()
}

/// Two persons walk past each other, each by 40 cm per frame. They are in lists whose order changes. The second person
/// is missing in one frame, and both are missing in another. In a second file, the first axis of the arrays counts the
/// persons.
#[test]
fn persons_who_cross_are_followed() {
    for (file, clip, frames, gap) in [
        ("sam3d_persons.npz", Clips::All, 8, "1 of 8"),
        ("sam3d_persons.npz", Clips::Name("person_0".to_owned()), 8, "2 of 8"),
        ("sam3d_persons.npz", Clips::Name("person_1".to_owned()), 8, "1 of 8"),
        ("sam3d_stack.npz", Clips::Name("person_0".to_owned()), 8, "1 of 8"),
        ("sam3d_stack.npz", Clips::Name("person_1".to_owned()), 8, "2 of 8"),
    ] {
        let path = format!("../../fixtures/arrays/{file}");
        let scene = Importer::new().retime(25.0).clips(clip.clone()).import(path).unwrap();
        assert_eq!(scene.animations[0].frame_count(), frames, "{file} {clip:?}");
        for step in steps(&scene) {
            assert!((step - 0.4).abs() < 0.01, "{file} {clip:?}: {step}");
        }
        let found = |code: Code| {
            let mut of_code = scene.warnings.iter().filter(|warning| warning.code == code);
            of_code
                .any(|warning| warning.message.contains(gap) || warning.message.contains("1 other person is left out"))
        };
        assert!(found(Code::Gap) && found(Code::NotCarriedOver), "{:?}", scene.warnings);
    }
    let unknown = Importer::new().retime(25.0).clips(Clips::Name("person_7".to_owned()));
    let error = unknown.import("../../fixtures/arrays/sam3d_persons.npz").unwrap_err();
    assert_eq!(error.code(), Code::InvalidValue);
}

/// Numbers in file names order the files of a folder and show missing frames. A person has a separate number.
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
    // The same body occurs twice in a frame, so the persons cannot be distinguished.
    assert_eq!(codes, [Code::NotCarriedOver, Code::Gap, Code::NotCarriedOver]);
    fs::copy(TAKE, folder.path().join("shot2_11.npz")).unwrap();
    let error = Importer::new().retime(30.0).import(folder.path()).unwrap_err();
    assert!(
        error.to_string().contains("shot2_11.npz") && error.code() == Code::RowLength,
        "{error}"
    );
}

/// A file of keypoints alone is solved by their names, and stands upright.
#[test]
fn keypoints_are_solved() {
    let scene = mocap::import("../../fixtures/arrays/sam3d_keypoints.npz").unwrap();
    let pose = Pose::at_tick(&scene, 0, 0.0).unwrap();
    let humanoid = Humanoid::of(&scene);
    let height = |bone: HumanoidBone| pose.position(humanoid.joint(bone).unwrap()).y;
    let ankle = height(HumanoidBone::LeftFoot);
    assert!(height(HumanoidBone::Head) - height(HumanoidBone::Hips) > 0.5);
    assert!(height(HumanoidBone::Hips) - ankle > 0.6, "{ankle}");
    assert!(scene.warnings.iter().all(|warning| warning.code != Code::NotHumanoid));
}

/// The number of a person may have no word before it. The number with the most values is the frame number.
#[test]
fn the_number_of_the_frame_is_the_one_with_the_most_values() {
    let folder = tempfile::tempdir().unwrap();
    for frame in 7..10 {
        for person in 0..2 {
            fs::copy(BODY, folder.path().join(format!("img_{frame:05}_{person}.npz"))).unwrap();
        }
    }
    let scene = Importer::new().retime(30.0).import(folder.path()).unwrap();
    assert_eq!(scene.animations[0].frame_count(), 3);
}

/// Clips in a folder are separate motions. Frames in the folder of a motion are not read without the motion.
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
