//! Tests which joints a channel drives.

use std::collections::HashMap;
use std::f64::consts::PI;

use mocap::glam::{Mat4, Quat, Vec3};
use mocap::scene::{Animation, Channel, Keys, Node, NodeId, NodeKind};
use mocap::{Binding, OutOfRange, Pose, Scene};

fn node(name: &str, kind: NodeKind, parent: Option<u32>, offset: Vec3) -> Node {
    Node {
        name: name.into(),
        kind,
        parent: parent.map(NodeId),
        transform: Mat4::from_translation(offset),
        ..Node::default()
    }
}

/// A channel of a BVH joint with rotation channels only. It has one position key, its OFFSET.
fn channel(node_name: &str, offset: Vec3) -> Channel {
    Channel {
        node_name: node_name.into(),
        position_keys: Keys::constant(offset),
        rotation_keys: Keys::every_tick(vec![Quat::IDENTITY, Quat::from_rotation_z(1.0)]),
        scaling_keys: Keys::constant(Vec3::ONE),
        ..Channel::default()
    }
}

fn clip(channels: Vec<Channel>) -> Animation {
    Animation {
        duration: 1.0,
        channels,
        ..Animation::default()
    }
}

/// hip - spine - spine - (end site "spine"), and a tail as a child of the hip.
fn scene() -> Scene {
    Scene {
        nodes: vec![
            node("hip", NodeKind::Joint, None, Vec3::Y),
            node("spine", NodeKind::Joint, Some(0), Vec3::Y),
            node("spine", NodeKind::Joint, Some(1), Vec3::Y * 2.0),
            node("spine", NodeKind::EndSite, Some(2), Vec3::Y * 3.0),
            node("tail", NodeKind::Joint, Some(0), Vec3::X),
        ],
        ..Scene::default()
    }
}

fn driven(binding: &Binding, animation: &Animation) -> Vec<(u32, Vec3)> {
    let mut driven = Vec::new();
    binding.sample(animation, 0.0, |node, trs| driven.push((node.0, trs.translation)));
    driven
}

#[test]
fn channels_of_one_name_drive_the_joints_of_that_name_in_turn() {
    let [a, b, c] = [1.0, 2.0, 3.0].map(Vec3::splat);
    let animation = clip(vec![channel("spine", a), channel("hip", b), channel("spine", c)]);
    let binding = Binding::new(&scene(), &animation);
    assert_eq!(driven(&binding, &animation), [(1, a), (0, b), (2, c)]);
    assert_eq!(binding.channels_without_node, [0usize; 0]);
    assert_eq!(binding.joints_without_channel, [NodeId(4)]);
}

#[test]
fn a_channel_too_many_is_reported_and_end_sites_are_left_alone() {
    let mut animation = clip(vec![channel("spine", Vec3::ONE); 3]);
    animation.channels.insert(0, channel("wing", Vec3::ONE));
    let binding = Binding::new(&scene(), &animation);
    assert_eq!(driven(&binding, &animation), [(1, Vec3::ONE), (2, Vec3::ONE)]);
    assert_eq!(binding.channels_without_node, [0, 3]);
    assert_eq!(binding.joints_without_channel, [NodeId(0), NodeId(4)]);
}

#[test]
fn a_channel_that_knows_its_node_leaves_the_others_of_its_name_to_those_that_do_not() {
    let [a, b, c] = [1.0, 2.0, 3.0].map(Vec3::splat);
    let mut animation = clip(vec![channel("spine", a), channel("spine", b), channel("spine", c)]);
    animation.channels[0].node = Some(NodeId(2));
    // No name identifies this end site.
    animation.channels[1].node = Some(NodeId(3));
    let binding = Binding::new(&scene(), &animation);
    assert_eq!(driven(&binding, &animation), [(2, a), (3, b), (1, c)]);
    // Ids of another scene must not be used as ids of this scene.
    for stale in [NodeId(0), NodeId(9)] {
        animation.channels[0].node = Some(stale);
        let binding = Binding::new(&scene(), &animation);
        assert_eq!(driven(&binding, &animation), [(1, a), (3, b), (2, c)], "{stale:?}");
    }
    // Another skeleton has other ids.
    let binding = Binding::onto(&scene(), &animation, |name| name);
    assert_eq!(driven(&binding, &animation)[0].0, 1);
}

#[test]
fn another_skeleton_keeps_its_proportions_and_takes_the_root_motion() {
    let mut animation = clip(vec![
        channel("Hips", Vec3::splat(9.0)),
        channel("Spine", Vec3::splat(9.0)),
        channel("Tail", Vec3::splat(9.0)),
        channel("Head", Vec3::splat(9.0)),
    ]);
    // The tail really moves, so this is motion, not proportion.
    animation.channels[2].position_keys = Keys::every_tick(vec![Vec3::Z, Vec3::X]);
    let names = HashMap::from([("Hips", "hip"), ("Spine", "spine"), ("Tail", "tail")]);
    let binding = Binding::onto(&scene(), &animation, |name| names.get(name).copied().unwrap_or(name));
    assert_eq!(
        driven(&binding, &animation),
        [(0, Vec3::splat(9.0)), (1, Vec3::Y), (4, Vec3::Z)]
    );
    assert_eq!(binding.channels_without_node, [3]);
    assert_eq!(binding.joints_without_channel, [NodeId(2)]);

    // A map may also produce new names.
    let binding = Binding::onto(&scene(), &animation, str::to_lowercase);
    assert_eq!(driven(&binding, &animation), [(1, Vec3::Y), (4, Vec3::Z)]);
}

#[test]
fn a_joint_under_a_group_is_a_root() {
    let scene = Scene {
        nodes: vec![
            node("file", NodeKind::Group, None, Vec3::ZERO),
            node("hip", NodeKind::Joint, Some(0), Vec3::Y),
        ],
        ..Scene::default()
    };
    let animation = clip(vec![channel("hip", Vec3::X)]);
    let binding = Binding::onto(&scene, &animation, |name| name);
    assert_eq!(driven(&binding, &animation), [(1, Vec3::X)]);
    assert_eq!(binding.joints_without_channel, []);
}

#[test]
fn tracks_without_keys_leave_the_rest_transform_alone() {
    // This matrix is sheared, so no translation, rotation and scale can express it.
    let sheared = Mat4::from_cols_array(&[
        1.0, 0.0, 0.0, 0.0, 0.5, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0,
    ]);
    let mut scene = scene();
    scene.nodes[4].transform = sheared;
    let mut animation = clip(vec![channel("hip", Vec3::X), channel("tail", Vec3::X)]);
    animation.channels[0].position_keys = Keys::default();
    animation.channels[1] = Channel {
        node_name: "tail".into(),
        ..Channel::default()
    };
    let binding = Binding::new(&scene, &animation);
    assert_eq!(binding.joints_without_channel, [NodeId(1), NodeId(2)]);
    let mut pose = Pose::rest(&scene);
    pose.sample(&binding, &animation, 1.0);
    let turned = Mat4::from_translation(Vec3::Y) * Mat4::from_rotation_z(1.0);
    assert!(pose.node_to_parent[0].abs_diff_eq(turned, 1e-6));
    assert_eq!(pose.node_to_parent[4], sheared);
}

#[test]
fn a_binding_of_something_else_does_no_harm() {
    let animation = clip(vec![channel("hip", Vec3::X), channel("tail", Vec3::X)]);
    let binding = Binding::new(&scene(), &animation);
    let mut shorter = animation.clone();
    shorter.channels.truncate(1);
    let mut pose = Pose::rest(&Scene {
        nodes: scene().nodes[..1].to_vec(),
        ..Scene::default()
    });
    pose.sample(&binding, &shorter, 0.0);
    pose.sample(&binding, &animation, 0.0);
    assert_eq!(pose.node_to_parent, [Mat4::from_translation(Vec3::X)]);
}

#[test]
fn ticks_out_of_range_clamp_or_loop() {
    let animation = Animation {
        duration: 2.0,
        channels: vec![Channel {
            position_keys: Keys::every_tick(vec![Vec3::ZERO, Vec3::X, Vec3::X * 2.0]),
            ..channel("hip", Vec3::ZERO)
        }],
        ..Animation::default()
    };
    let clamping = Binding::new(&scene(), &animation);
    let looping = clamping.clone().out_of_range(OutOfRange::Loop);
    let x = |binding: &Binding, tick| {
        let mut x = f32::NAN;
        binding.sample(&animation, tick, |_, trs| x = trs.translation.x);
        x
    };
    for (tick, clamped, looped) in [
        (0.0, 0.0, 0.0),
        (2.0, 2.0, 2.0),
        (2.5, 2.0, 0.5),
        (5.25, 2.0, 1.25),
        (-0.5, 0.0, 1.5),
        (f64::NAN, 0.0, 0.0),
        (f64::INFINITY, 2.0, 0.0),
        (f64::NEG_INFINITY, 0.0, 0.0),
    ] {
        assert_eq!((x(&clamping, tick), x(&looping, tick)), (clamped, looped), "{tick}");
    }
}

#[test]
fn an_animation_without_length_stands_at_tick_0() {
    for out_of_range in [OutOfRange::Clamp, OutOfRange::Loop] {
        for duration in [0.0, -1.0, f64::NAN, f64::NEG_INFINITY] {
            assert_eq!(out_of_range.resolve(PI, duration), 0.0);
        }
    }
}
