//! Units, trim, frame rate, rest pose and root motion, compared with the text of real files and with closed forms.

use std::f64::consts::FRAC_PI_2;

use crate::kinematics::{Capture, Root};
use mocap::glam::{DVec3, Mat4, Quat, Vec3};

use mocap::scene::{Channel, Keys, Node, NodeId, NodeKind, UpAxis};
use mocap::{Importer, Limits, Pose, Scene, SkeletonMesh};

fn read(file: &str) -> (Scene, Capture) {
    let bytes = std::fs::read(format!("../../fixtures/real/{file}")).unwrap();
    let scene = Importer::new()
        .skeleton_mesh(SkeletonMesh::Skinned)
        .read(&bytes, file)
        .unwrap();
    (scene, Capture::parse(&bytes))
}

/// The position of every node at `tick`.
fn positions(scene: &Scene, tick: f64) -> Vec<DVec3> {
    let pose = Pose::at_tick(scene, 0, tick).unwrap();
    (0..scene.nodes.len())
        .map(|index| pose.position(NodeId::new(index)).as_dvec3())
        .collect()
}

/// The position of every node in `frame`, by the text of the file.
fn truth(capture: &Capture, frame: usize) -> Vec<DVec3> {
    capture
        .placements(frame, Root::Replace)
        .iter()
        .map(|placement| DVec3::from(placement.position))
        .collect()
}

#[track_caller]
fn assert_close(ours: &[DVec3], theirs: &[DVec3], tolerance: f64) {
    assert_eq!(ours.len(), theirs.len());
    for (index, (a, b)) in ours.iter().zip(theirs).enumerate() {
        assert!(a.distance(*b) <= tolerance, "node {index}: {a} is not {b}");
    }
}

/// The positions to which the bones move the vertices at `tick`.
fn skinned(scene: &Scene, tick: f64) -> Vec<DVec3> {
    let pose = Pose::at_tick(scene, 0, tick).unwrap();
    let mesh = &scene.meshes[0];
    let mut moved = vec![Vec3::ZERO; mesh.vertices.len()];
    for bone in &mesh.bones {
        let matrix = pose.node_to_world[bone.node.index()] * bone.offset_matrix;
        for tie in &bone.weights {
            let vertex = tie.vertex_id as usize;
            moved[vertex] += tie.weight * matrix.transform_point3(mesh.vertices[vertex]);
        }
    }
    moved.into_iter().map(Vec3::as_dvec3).collect()
}

#[test]
fn units_and_axes_move_every_node_and_vertex_alike() {
    let (mut scene, capture) = read("z_up_dab.bvh");
    let metres = |point: &DVec3| DVec3::new(point.x, point.z, -point.y) * 0.0254;
    let vertices: Vec<_> = skinned(&scene, 100.0).iter().map(metres).collect();
    scene.convert_units(0.0254, UpAxis::Z);
    for frame in [0, 100, 338] {
        let expected: Vec<_> = truth(&capture, frame).iter().map(metres).collect();
        assert_close(&positions(&scene, frame as f64), &expected, 1e-5);
    }
    assert_close(&skinned(&scene, 100.0), &vertices, 1e-5);
    assert_eq!(scene.validate(), []);

    // The rest pose is rotated too: a joint that was above another is still above it.
    let rest = Pose::rest(&scene);
    let rest_of_file = capture.rest();
    for (index, placement) in rest_of_file.iter().enumerate() {
        let expected = metres(&DVec3::from(placement.position));
        assert!(rest.position(NodeId::new(index)).as_dvec3().distance(expected) < 1e-5);
    }
}

#[test]
fn a_group_turns_for_the_roots_below_it() {
    let text =
        b"HIERARCHY ROOT a { OFFSET 0 0 0 CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation } \
                 ROOT b { OFFSET 0 0 0 CHANNELS 3 Xposition Yposition Zposition } \
                 MOTION Frames: 1 Frame Time: 1 1 2 3 0 0 0 4 5 6";
    let mut scene = Importer::new().read(text, "two.bvh").unwrap();
    scene.convert_units(2.0, UpAxis::Z);
    let expected = [DVec3::ZERO, DVec3::new(2.0, 6.0, -4.0), DVec3::new(8.0, 12.0, -10.0)];
    assert_close(&positions(&scene, 0.0), &expected, 1e-6);
}

#[test]
fn trim_keeps_the_frames_between_both_included() {
    let (mut scene, capture) = read("cmu_short.bvh");
    scene.trim(10.0, 20.0);
    assert_eq!(scene.animations[0].duration, 10.0);
    for frame in 0..=10 {
        assert_close(&positions(&scene, frame as f64), &truth(&capture, frame + 10), 1e-4);
    }
    assert!(
        scene.animations[0]
            .channels
            .iter()
            .all(|channel| matches!(channel.rotation_keys.len(), 1 | 11))
    );
    assert!(
        scene.animations[0]
            .channels
            .iter()
            .all(|channel| channel.rotation_keys.ticks.is_none())
    );
    assert_eq!(scene.validate(), []);
}

#[test]
fn trim_between_frames_makes_keys_there() {
    let mut scene = read("lecture_Test.bvh").0;
    let before = positions(&scene, 2.25);
    scene.trim(2.25, 4.0);
    assert_close(&positions(&scene, 0.0), &before, 1e-6);
    let keys = &scene.animations[0].channels[0].position_keys;
    assert_eq!(keys.ticks.as_deref(), Some(&[0.0, 0.75, 1.75][..]));
}

#[test]
fn trim_beyond_the_ends_leaves_what_is_there() {
    let (scene, _) = read("lecture_Test.bvh");
    let mut trimmed = scene.clone();
    trimmed.trim(-5.0, f64::INFINITY);
    assert_eq!(trimmed.animations, scene.animations);
    trimmed.trim(20.0, 3.0);
    assert_eq!(trimmed.animations[0].frame_count(), 1);
    assert_close(&positions(&trimmed, 0.0), &positions(&scene, 9.0), 0.0);
}

#[test]
fn a_quarter_of_the_frames_stands_where_every_fourth_frame_does() {
    let (mut scene, capture) = read("perception_neuron_moving_positions.bvh");
    let rate = scene.animations[0].ticks_per_second;
    scene.resample(rate / 4.0, &Limits::default()).unwrap();
    assert_eq!(scene.animations[0].frame_count(), 421 / 4 + 1);
    for frame in [0, 1, 50, 105] {
        assert_close(&positions(&scene, frame as f64), &truth(&capture, frame * 4), 1e-3);
    }
    assert_eq!(scene.validate(), []);
}

/// The file's frame time is .0083333, which means 1/120. So every frame at 30 frames per second is a frame of the file,
/// up to the last.
#[test]
fn a_rounded_frame_time_puts_no_frame_between_two() {
    let (mut scene, capture) = read("cmu_12_01_walk.bvh");
    let unchanged = scene.clone();
    // 521 frames without the T-pose, so that the number of the last frame is a multiple of four.
    scene.trim(1.0, 521.0);
    scene.resample(30.0, &Limits::default()).unwrap();
    let animation = &scene.animations[0];
    assert_eq!((animation.frame_count(), animation.ticks_per_second), (131, 30.0));
    for (channel, before) in animation.channels.iter().zip(&unchanged.animations[0].channels) {
        for (key, rotation) in channel.rotation_keys.values.iter().enumerate() {
            let expected = before.rotation_keys.sample(1.0 + 4.0 * key as f64);
            assert_eq!(Some(*rotation), expected, "{} {key}", channel.node_name);
        }
    }
    assert_close(&positions(&scene, 130.0), &truth(&capture, 521), 1e-4);
}

#[test]
fn rotations_between_frames_are_on_the_arc() {
    let mut scene = read("lecture_Test.bvh").0;
    let animation = &mut scene.animations[0];
    animation.duration = 1.0;
    for channel in &mut animation.channels {
        channel.position_keys = Keys::constant(Vec3::ZERO);
        channel.rotation_keys = Keys::every_tick(vec![Quat::IDENTITY, Quat::from_rotation_y(1.0)]);
    }
    scene.resample(40.0, &Limits::default()).unwrap();
    let keys = &scene.animations[0].channels[1].rotation_keys;
    assert_eq!(keys.len(), 5);
    for (key, rotation) in keys.values.iter().enumerate() {
        assert!(rotation.abs_diff_eq(Quat::from_rotation_y(key as f32 * 0.25), 1e-6));
    }
}

/// CMU's T-pose comes before the motion. No pose between the T-pose and the motion may occur, and both must remain.
#[test]
fn a_cut_is_not_smeared() {
    let (mut scene, capture) = read("cmu_short.bvh");
    scene.resample(90.0, &Limits::default()).unwrap();
    let animation = &scene.animations[0];
    let ticks = animation.channels[0].rotation_keys.ticks.as_ref().unwrap();
    // Frame 1 of the file, at 120.0005 frames per second, is at three quarters of a frame at 90 frames per second.
    assert_eq!(ticks[0], 0.0);
    assert!((ticks[1] - 0.75).abs() < 1e-5, "{}", ticks[1]);
    assert_eq!(ticks[2..4], [1.0, 2.0]);
    assert_close(&positions(&scene, 0.0), &truth(&capture, 0), 1e-5);
    assert_close(&positions(&scene, ticks[1]), &truth(&capture, 1), 1e-4);
}

#[test]
fn the_rest_pose_can_be_a_frame_and_the_mesh_is_bound_there() {
    let (mut scene, capture) = read("cmu_short.bvh");
    let vertices = skinned(&scene, 30.0);
    scene.set_rest_pose_at(7.0);
    let rest = Pose::rest(&scene);
    for (index, expected) in truth(&capture, 7).into_iter().enumerate() {
        assert!(rest.position(NodeId::new(index)).as_dvec3().distance(expected) < 1e-4);
    }
    for bone in &scene.meshes[0].bones {
        let bound = rest.node_to_world[bone.node.index()] * bone.offset_matrix;
        assert!(bound.abs_diff_eq(Mat4::IDENTITY, 1e-4), "{}", bone.name);
    }
    assert_close(&positions(&scene, 30.0), &truth(&capture, 30), 1e-4);
    assert_close(&skinned(&scene, 30.0), &vertices, 1e-4);
    assert_eq!(scene.validate(), []);
}

#[test]
fn in_place_takes_away_the_way_over_the_ground_alone() {
    let (mut scene, capture) = read("cmu_12_01_walk.bvh");
    scene.put_in_place();
    let start = truth(&capture, 0)[0];
    for frame in [0, 200, 523] {
        let expected = truth(&capture, frame);
        let way = DVec3::new(expected[0].x - start.x, 0.0, expected[0].z - start.z);
        let expected: Vec<_> = expected.iter().map(|position| *position - way).collect();
        assert_close(&positions(&scene, frame as f64), &expected, 1e-4);
    }
}

#[test]
fn root_motion_moves_nothing_in_the_world() {
    let (mut scene, capture) = read("cmu_12_01_walk.bvh");
    let vertices = skinned(&scene, 200.0);
    scene.extract_root_motion();
    assert_eq!(
        (scene.nodes[0].name.as_str(), scene.nodes[1].name.as_str()),
        ("Root", "Hips")
    );
    assert_eq!(scene.validate(), []);
    assert_close(&skinned(&scene, 200.0), &vertices, 1e-4);
    for frame in [0, 200, 523] {
        let ours = positions(&scene, frame as f64);
        let expected = truth(&capture, frame);
        assert_close(&ours[1..], &expected, 1e-4);
        assert_eq!(ours[0].y, 0.0, "the root is on the ground");
        assert!(
            (ours[0] - expected[0]).with_y(0.0).length() < 1e-5,
            "the root is below the hips"
        );
    }
    let root = &scene.animations[0].channels[0];
    assert!(
        root.rotation_keys
            .values
            .iter()
            .all(|rotation| rotation.x == 0.0 && rotation.z == 0.0)
    );
    // The remaining rotation of the hips has no heading: the twist about Y is removed.
    let hips = &scene.animations[0].channels[1];
    assert!(hips.rotation_keys.values.iter().all(|rotation| rotation.y.abs() < 1e-6));
    assert!(
        hips.position_keys
            .values
            .iter()
            .all(|position| position.x == 0.0 && position.z == 0.0)
    );
}

#[test]
fn the_heading_of_a_turn_is_the_turn() {
    let mut scene = read("lecture_Test.bvh").0;
    scene.animations[0].channels[0].rotation_keys = Keys::constant(Quat::from_rotation_y(FRAC_PI_2 as f32));
    scene.nodes[3].name = "Root".into();
    scene.extract_root_motion();
    assert_eq!(scene.nodes[0].name, "Root_2");
    assert_eq!(scene.nodes[0].kind, NodeKind::Joint);
    let [root, shoulder] = [0, 1].map(|channel| {
        let keys = &scene.animations[0].channels[channel].rotation_keys;
        assert_eq!(keys.len(), 1, "what was constant is constant");
        keys.values[0]
    });
    assert!(root.abs_diff_eq(Quat::from_rotation_y(FRAC_PI_2 as f32), 1e-6));
    assert!(shoulder.abs_diff_eq(Quat::IDENTITY, 1e-6));
}

/// A walk below a constant root joint, as some programs write it. The root is rotated, and scaled by a half. Beside the
/// hips, a target of inverse kinematics follows the left foot.
fn walk_below_a_still_root() -> (Scene, Capture) {
    let (mut scene, capture) = read("cmu_12_01_walk.bvh");
    scene.insert_root_above(NodeId::new(0));
    let turn = Quat::from_rotation_x(-FRAC_PI_2 as f32);
    let root = Mat4::from_scale_rotation_translation(Vec3::splat(0.5), turn, Vec3::new(5.0, 0.0, 7.0));
    scene.nodes[0].transform = root;
    let inverse = root.inverse();
    let foot = scene.nodes.iter().position(|node| node.name == "LeftFoot").unwrap() - 1;
    let animation = &mut scene.animations[0];
    let hips = &mut animation.channels[0];
    for value in &mut hips.position_keys.values {
        *value = inverse.transform_point3(*value);
    }
    for value in &mut hips.rotation_keys.values {
        *value = turn.inverse() * *value;
    }
    hips.scaling_keys = Keys::constant(Vec3::splat(2.0));
    let frames = animation.frame_count();
    let follows = (0..frames).map(|frame| inverse.transform_point3(truth(&capture, frame)[foot].as_vec3()));
    let goal = Channel {
        node_name: "ik_foot_l".into(),
        position_keys: Keys::every_tick(follows.collect()),
        rotation_keys: Keys::constant(Quat::IDENTITY),
        ..Channel::default()
    };
    animation.channels.push(goal);
    scene.nodes.push(Node {
        name: "ik_foot_l".into(),
        parent: Some(NodeId::new(0)),
        ..Node::default()
    });
    (scene, capture)
}

/// The joints of the file, and the target at the left foot.
fn with_goal(scene: &Scene, capture: &Capture, frame: usize) -> Vec<DVec3> {
    let mut expected = truth(capture, frame);
    let foot = scene.nodes.iter().position(|node| node.name == "LeftFoot").unwrap();
    let hips = scene.nodes.iter().position(|node| node.name == "Hips").unwrap();
    expected.push(expected[foot - hips]);
    expected
}

#[test]
fn in_place_holds_what_travels_below_a_still_root() {
    let (mut scene, capture) = walk_below_a_still_root();
    let start = truth(&capture, 0)[0];
    scene.put_in_place();
    for frame in [0, 200, 523] {
        let expected = with_goal(&scene, &capture, frame);
        let way = (expected[0] - start).with_y(0.0);
        let expected: Vec<_> = expected.iter().map(|position| *position - way).collect();
        assert_close(&positions(&scene, frame as f64)[1..], &expected, 1e-4);
    }
}

#[test]
fn root_motion_is_above_a_still_root() {
    let (mut scene, capture) = walk_below_a_still_root();
    scene.extract_root_motion();
    assert_eq!((&*scene.nodes[0].name, &*scene.nodes[1].name), ("Root_2", "Root"));
    for frame in [0, 200, 523] {
        let ours = positions(&scene, frame as f64);
        let expected = with_goal(&scene, &capture, frame);
        assert_close(&ours[2..], &expected, 1e-4);
        assert!(ours[0].distance(expected[0].with_y(0.0)) < 1e-4, "below the hips");
    }
}

#[test]
fn a_spine_that_shifts_above_hips_that_stay_is_no_root() {
    let (mut scene, _) = read("cmu_12_01_walk.bvh");
    let hips = &mut scene.animations[0].channels[0];
    hips.position_keys = Keys::constant(Vec3::Y);
    hips.rotation_keys = Keys::constant(Quat::IDENTITY);
    let spine = scene.animations[0]
        .channels
        .iter()
        .position(|channel| channel.node_name == "LowerBack")
        .unwrap();
    let shifts = (0..524).map(|frame| Vec3::X * (frame as f32).sin());
    scene.animations[0].channels[spine].position_keys = Keys::every_tick(shifts.collect());
    let before = positions(&scene, 100.0);
    scene.put_in_place();
    assert_eq!(positions(&scene, 100.0), before);
}

/// One clip is changed while the others are aside, with their weights of morph targets.
#[test]
fn one_clip_is_changed_among_others() {
    let (mut scene, _) = read("lecture_Test.bvh");
    let clip = scene.animations[0].clone();
    scene.animations = ["a", "b", "c"]
        .map(|name| mocap::scene::Animation {
            name: name.to_owned(),
            ..clip.clone()
        })
        .to_vec();
    let targets = [vec![], vec![0.25], vec![0.5, 0.75], vec![0.1, 0.2, 0.3]];
    scene.meshes[0].morph_targets = targets
        .iter()
        .map(|weights| mocap::scene::MorphTarget {
            weight_keys: weights.iter().map(|weight| Keys::constant(*weight)).collect(),
            ..mocap::scene::MorphTarget::default()
        })
        .collect();
    let before = scene.clone();
    scene.change_clip(1, |scene| {
        assert_eq!((scene.animations.len(), scene.animations[0].name.as_str()), (1, "b"));
        let found: Vec<_> = scene.meshes[0]
            .morph_targets
            .iter()
            .map(|target| &target.weight_keys)
            .collect();
        assert_eq!(found[..2], [&vec![], &vec![]]);
        assert_eq!(found[2..], [&vec![Keys::constant(0.75)], &vec![Keys::constant(0.2)]]);
        scene.trim(2.0, 5.0);
    });
    assert_eq!(
        (&scene.meshes, &scene.animations[0]),
        (&before.meshes, &before.animations[0])
    );
    assert_eq!(scene.animations[2], before.animations[2]);
    assert_eq!((scene.animations[1].duration, scene.animations[0].duration), (3.0, 9.0));
    use mocap::scene::report::AppliedStep;
    let steps = vec![AppliedStep::Trim { first: 2.0, last: 5.0 }];
    assert_eq!(
        scene.metadata.steps.last(),
        Some(&AppliedStep::OfClip { index: 1, steps })
    );
}

/// A shorter clip gets no frames after its own end.
#[test]
fn a_part_ends_where_each_clip_ends() {
    let (mut scene, _) = read("lecture_Test.bvh");
    let mut short = scene.animations[0].clone();
    short.duration = 4.0;
    for channel in &mut short.channels {
        channel.position_keys.values.truncate(5);
        channel.rotation_keys.values.truncate(5);
    }
    scene.animations.push(short);
    scene.trim(1.0, f64::INFINITY);
    let durations: Vec<f64> = scene.animations.iter().map(|clip| clip.duration).collect();
    assert_eq!(durations, [8.0, 3.0]);
    assert_eq!(scene.validate(), []);
}
