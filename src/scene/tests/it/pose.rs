//! Poses of the arm of a lecture, and scales that cause shear.

mod binding;
mod chain;
mod sample;
mod skin;

use mocap::glam::{Mat4, Quat, Vec3};
use mocap::scene::{Animation, Channel, Keys, Node, NodeId, NodeKind};
use mocap::{Binding, OutOfRange, Pose, Scene, Trs, Updater};

/// The skeleton and the motion of the lecture's example: shoulder, elbow, wrist and its end site, on the x axis.
///
/// ```text
/// Shoulder --2-- Elbow --1.5-- Wrist --0.5-- EndSite_Wrist
/// ```
///
/// In frame n (from 0) the shoulder is at (0.1 (n + 1), 0.02 n, 0). The joints are rotated about z by 5, 10 and 8
/// degrees times n + 1.
fn lecture() -> Scene {
    let offsets = [0.0, 2.0, 1.5, 0.5].map(|x| Vec3::new(x, 0.0, 0.0));
    let names = ["Shoulder", "Elbow", "Wrist", "EndSite_Wrist"];
    let node = |index: usize| Node {
        name: names[index].into(),
        kind: if index == 3 { NodeKind::EndSite } else { NodeKind::Joint },
        parent: index.checked_sub(1).map(NodeId::new),
        transform: Mat4::from_translation(offsets[index]),
        ..Node::default()
    };
    let channel = |(index, degrees): (usize, f32)| Channel {
        node_name: names[index].into(),
        node: None,
        position_keys: Keys::constant(offsets[index]),
        rotation_keys: Keys::every_tick(
            (1u8..=10)
                .map(|frame| Quat::from_rotation_z((degrees * f32::from(frame)).to_radians()))
                .collect(),
        ),
        scaling_keys: Keys::constant(Vec3::ONE),
    };
    let mut channels: Vec<_> = [5.0, 10.0, 8.0].into_iter().enumerate().map(channel).collect();
    channels[0].position_keys = Keys::every_tick(
        (0u8..10)
            .map(f32::from)
            .map(|frame| Vec3::new(0.1 * (frame + 1.0), 0.02 * frame, 0.0))
            .collect(),
    );
    Scene {
        nodes: (0..4).map(node).collect(),
        animations: vec![Animation {
            ticks_per_second: 10.0,
            duration: 9.0,
            channels,
            ..Animation::default()
        }],
        ..Scene::default()
    }
}

/// A vector of `length` in the direction `degrees`, in the plane of the lecture's arm.
fn step(length: f64, degrees: f64) -> Vec3 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    Vec3::new((length * cos) as f32, (length * sin) as f32, 0.0)
}

/// The positions of the arm's nodes for the shoulder position `shoulder`, with each joint rotated by its angle.
fn arm(shoulder: Vec3, [first, second, third]: [f64; 3]) -> [Vec3; 4] {
    let elbow = shoulder + step(2.0, first);
    let wrist = elbow + step(1.5, first + second);
    let tip = wrist + step(0.5, first + second + third);
    [shoulder, elbow, wrist, tip]
}

fn assert_positions(pose: &Pose, expected: [Vec3; 4]) {
    for (index, expected) in expected.into_iter().enumerate() {
        let found = pose.position(NodeId::new(index));
        assert!(
            found.abs_diff_eq(expected, 1e-6),
            "node {index}: {found}, not {expected}"
        );
    }
}

#[test]
fn at_rest_the_offsets_add_up() {
    let pose = Pose::rest(&lecture());
    assert_positions(&pose, [0.0, 2.0, 3.5, 4.0].map(|x| Vec3::new(x, 0.0, 0.0)));
}

#[test]
fn at_tick_9_the_arm_stands_where_the_lecture_puts_it() {
    let pose = Pose::at_tick(&lecture(), 0, 9.0).unwrap();
    assert_positions(&pose, arm(Vec3::new(1.0, 0.18, 0.0), [50.0, 100.0, 80.0]));
}

#[test]
fn every_tick_and_what_lies_between_follows_the_chain() {
    let scene = lecture();
    let animation = &scene.animations[0];
    let binding = Binding::new(&scene, animation);
    let mut pose = Pose::rest(&scene);
    for quarter in 0..=36 {
        // All angles and both coordinates of the shoulder grow by equal amounts from frame to frame.
        let tick = f64::from(quarter) / 4.0;
        pose.sample(&binding, animation, tick);
        let shoulder = Vec3::new((0.1 * (tick + 1.0)) as f32, (0.02 * tick) as f32, 0.0);
        assert_positions(
            &pose,
            arm(shoulder, [5.0, 10.0, 8.0].map(|degrees| degrees * (tick + 1.0))),
        );
    }
}

#[test]
fn a_point_on_a_node_moves_with_it() {
    let pose = Pose::at_tick(&lecture(), 0, 9.0).unwrap();
    let [_, _, wrist, _] = arm(Vec3::new(1.0, 0.18, 0.0), [50.0, 100.0, 80.0]);
    // The wrist's x axis points at 230 degrees, its y axis at 320.
    let expected = wrist + step(3.0, 230.0) + step(4.0, 320.0) + Vec3::Z;
    let found = pose.point_to_world(NodeId(2), Vec3::new(3.0, 4.0, 1.0));
    assert!(found.abs_diff_eq(expected, 2e-6), "{found}, not {expected}");
}

#[test]
fn the_scene_is_driven_to_the_same_pose() {
    let mut scene = lecture();
    let expected = Pose::at_tick(&scene, 0, 3.5).unwrap();
    let mut pose = Pose::rest(&scene);
    assert!(scene.update_node_matrices(0, 3.5));
    pose.copy_from(&scene);
    assert_eq!(pose, expected);
    assert_eq!(Pose::rest(&scene), expected);
}

#[test]
fn an_animation_that_is_not_there_changes_nothing() {
    let mut scene = lecture();
    assert!(!scene.update_node_matrices(1, 3.0));
    assert_eq!(scene, lecture());
    assert!(Updater::new(&scene, 1).is_none());
    assert!(Pose::at_tick(&scene, 1, 3.0).is_none());
}

#[test]
fn an_updater_clamps_or_loops() {
    let mut scene = lecture();
    let updater = Updater::new(&scene, 0).unwrap();
    let shoulder = |scene: &Scene| scene.nodes[0].transform.w_axis.x;
    updater.update(&mut scene, 12.0);
    assert_eq!(shoulder(&scene), 1.0);
    updater.out_of_range(OutOfRange::Loop).update(&mut scene, 12.0);
    assert_eq!(shoulder(&scene), 0.1 * 4.0);
}

#[test]
fn a_chain_of_scales_and_rotations_shears() {
    // The root doubles x; its child is rotated by 45 degrees about z. A square on the child becomes a rhombus.
    let scene = Scene {
        nodes: vec![
            Node {
                transform: Mat4::from_scale(Vec3::new(2.0, 1.0, 1.0)),
                ..Node::default()
            },
            Node {
                parent: Some(NodeId(0)),
                transform: Mat4::from_rotation_z(std::f32::consts::FRAC_PI_4),
                ..Node::default()
            },
        ],
        ..Scene::default()
    };
    let pose = Pose::rest(&scene);
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let (x, y) = (
        pose.point_to_world(NodeId(1), Vec3::X),
        pose.point_to_world(NodeId(1), Vec3::Y),
    );
    assert!(x.abs_diff_eq(Vec3::new(2.0 * half, half, 0.0), 1e-6), "{x}");
    assert!(y.abs_diff_eq(Vec3::new(-2.0 * half, half, 0.0), 1e-6), "{y}");
    // The axes have a dot product of -1.5, so they are not at right angles. No translation, rotation and scale give
    // this matrix.
    assert!((x.dot(y) + 1.5).abs() < 1e-6);
    let without_shear = Trs::from_matrix(pose.node_to_world[1]).matrix();
    assert!(!without_shear.abs_diff_eq(pose.node_to_world[1], 0.1));
}

#[test]
fn a_tree_has_an_end_for_each_branch() {
    // 0 group ─ 1 hip ┬ 2 spine ─ 3 end site
    //                 ├ 4 leg   ─ 5 foot (nothing below)
    //                 └ 6 tail (nothing below)
    let parents = [None, Some(0), Some(1), Some(2), Some(1), Some(4), Some(1)];
    let mut nodes: Vec<_> = parents
        .map(|parent| Node {
            parent: parent.map(NodeId),
            ..Node::default()
        })
        .into();
    nodes[0].kind = NodeKind::Group;
    nodes[3].kind = NodeKind::EndSite;
    let scene = Scene {
        nodes,
        ..Scene::default()
    };
    assert_eq!(scene.end_effectors().collect::<Vec<_>>(), [3, 5, 6].map(NodeId));
    assert_eq!(Scene::default().end_effectors().count(), 0);
}
