//! Scaled rigs as BVH: position channels store the effect of scales. Also the node at which the hierarchy begins.

use mocap::bvh::BvhOptions;
use mocap::glam::{Mat4, Quat, Vec3};
use mocap::scene::{Animation, Channel, Keys, Node, NodeId, NodeKind};
use mocap::{Importer, Pose, Scene};

/// The written text, and the scene read from it.
fn written(scene: &Scene) -> (String, Scene) {
    let options = BvhOptions::default();
    assert_eq!(options.scale_warning(scene).unwrap(), None);
    let bytes = options.write(scene).unwrap();
    let read = Importer::new().read(&bytes, "written.bvh").unwrap();
    (String::from_utf8(bytes).unwrap(), read)
}

fn place(scene: &Scene, tick: f64, name: &str) -> Vec3 {
    let node = scene.nodes.iter().position(|node| node.name == name).unwrap();
    Pose::at_tick(scene, 0, tick).unwrap().position(NodeId::new(node))
}

/// `j1` is scaled by (1, 2, 1) at 0.5 s and by 2 at 1 s. `j2` is rotated by 60 and 90 degrees about +Z. Joints are one
/// unit apart.
#[test]
fn joints_below_a_scale_that_changes_are_in_their_places() {
    let scene = mocap::import("../../fixtures/made/anim_scale.gltf").unwrap();
    let (_, read) = written(&scene);
    let second = read.animations[0].ticks_per_second;
    for (seconds, expected) in [
        (0.0, Vec3::new(0.0, 4.0, 0.0)),
        (0.5, Vec3::new(-(0.75_f32.sqrt()), 5.0, 0.0)),
        (1.0, Vec3::new(-2.0, 4.0, 0.0)),
    ] {
        let found = place(&read, seconds * second, "j3");
        assert!(found.abs_diff_eq(expected, 1e-4), "{seconds} s: {found}, {expected}");
    }
}

/// A hand below an arm whose scale across is 2. The elbow rotates by a quarter turn about +Z. So the vector (1, 0, 0)
/// below it points along +Y, which is scaled.
#[test]
fn a_constant_scale_that_differs_from_axis_to_axis_keeps_joints_in_their_places() {
    let mut scene = Scene::default();
    let names = ["Shoulder", "Elbow", "Hand"];
    for (index, name) in names.into_iter().enumerate() {
        let scale = if index == 0 {
            Vec3::new(1.0, 2.0, 2.0)
        } else {
            Vec3::ONE
        };
        scene.nodes.push(Node {
            name: name.to_owned(),
            kind: NodeKind::Joint,
            parent: index.checked_sub(1).map(NodeId::new),
            transform: Mat4::from_scale_rotation_translation(scale, Quat::IDENTITY, Vec3::X),
            ..Node::default()
        });
    }
    let turns = Keys::every_tick(vec![Quat::IDENTITY, Quat::from_rotation_z(std::f32::consts::FRAC_PI_2)]);
    scene.animations.push(Animation {
        name: "Bend".to_owned(),
        ticks_per_second: 10.0,
        duration: 1.0,
        channels: vec![Channel {
            node_name: "Elbow".to_owned(),
            node: Some(NodeId::new(1)),
            position_keys: Keys::constant(Vec3::X),
            rotation_keys: turns,
            scaling_keys: Keys::constant(Vec3::ONE),
        }],
    });
    let (_, read) = written(&scene);
    for (tick, expected) in [(0.0, Vec3::new(3.0, 0.0, 0.0)), (1.0, Vec3::new(2.0, 2.0, 0.0))] {
        let found = place(&read, tick, "Hand");
        assert!(found.abs_diff_eq(expected, 1e-5), "{tick}: {found}");
    }
}

/// A still armature is above the hips, with a mesh beside the hips.
#[test]
fn the_hips_are_the_root_below_groups_that_do_not_move() {
    let mut scene = Scene::default();
    let group = Mat4::from_scale_rotation_translation(
        Vec3::splat(0.01),
        Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2),
        Vec3::new(1.0, 0.0, 0.0),
    );
    let nodes = [
        ("Scene", NodeKind::Group, None, Mat4::IDENTITY),
        ("Armature", NodeKind::Group, Some(0), group),
        ("Body", NodeKind::Group, Some(1), Mat4::IDENTITY),
        (
            "Hips",
            NodeKind::Joint,
            Some(1),
            Mat4::from_translation(Vec3::new(0.0, 0.0, 90.0)),
        ),
        (
            "Spine",
            NodeKind::Joint,
            Some(3),
            Mat4::from_translation(Vec3::new(0.0, 0.0, 20.0)),
        ),
    ];
    for (name, kind, parent, transform) in nodes {
        scene.nodes.push(Node {
            name: name.to_owned(),
            kind,
            parent: parent.map(NodeId::new),
            transform,
            ..Node::default()
        });
    }
    let channel = |node: usize, position: Vec<Vec3>, rotation: Vec<Quat>| Channel {
        node_name: scene.nodes[node].name.clone(),
        node: Some(NodeId::new(node)),
        position_keys: Keys::every_tick(position),
        rotation_keys: Keys::every_tick(rotation),
        scaling_keys: Keys::default(),
    };
    let high = Vec3::new(0.0, 0.0, 90.0);
    // The root moves along -Y of the armature, which is +Z of the world, and rotates by a quarter turn about its +X.
    let turns = vec![Quat::IDENTITY, Quat::from_rotation_x(std::f32::consts::FRAC_PI_2)];
    let channels = vec![channel(3, vec![high, high - 50.0 * Vec3::Y], turns)];
    scene.animations.push(Animation {
        name: "Step".to_owned(),
        ticks_per_second: 10.0,
        duration: 1.0,
        channels,
    });
    let is_root = |scene: &Scene, moved: Vec3| {
        let (text, read) = written(scene);
        assert!(text.starts_with("HIERARCHY\nROOT Hips\n"), "{text}");
        assert!(!text.contains("Body") && !text.contains("Armature"));
        for (tick, name, expected) in [
            (0.0, "Hips", Vec3::new(1.0, 0.9, 0.0)),
            (0.0, "Spine", Vec3::new(1.0, 1.1, 0.0)),
            (1.0, "Hips", Vec3::new(1.0, 0.9, 0.5)),
            // After the quarter turn, its +Z is -Y of the armature.
            (1.0, "Spine", Vec3::new(1.0, 0.9, 0.7)),
        ] {
            let found = place(&read, tick, name);
            assert!(found.abs_diff_eq(expected + moved, 1e-5), "{name} at {tick}: {found}");
        }
    };
    is_root(&scene, Vec3::ZERO);
    // FBX also has keys of groups. Here their position differs from the rest pose.
    let turn = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
    let mut keyed = scene.clone();
    keyed.animations[0].channels.insert(
        0,
        Channel {
            node_name: "Armature".to_owned(),
            node: Some(NodeId::new(1)),
            position_keys: Keys::every_tick(vec![Vec3::new(1.0, 0.25, 0.0); 2]),
            rotation_keys: Keys::constant(turn),
            scaling_keys: Keys::constant(Vec3::splat(0.01)),
        },
    );
    is_root(&keyed, Vec3::Y * 0.25);
    // A group that moves is itself the root.
    keyed.animations[0].channels[0].position_keys = Keys::every_tick(vec![Vec3::ZERO, Vec3::X]);
    let text = BvhOptions::default().write(&keyed).unwrap();
    assert!(text.starts_with(b"HIERARCHY\nROOT Armature\n"));
}
