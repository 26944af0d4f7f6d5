//! Tests how far the fingers of a robot bend.

use mocap::glam::{Mat4, Vec3};
use mocap::scene::{Node, NodeId, Side};
use mocap::{Pose, Scene};
use mocap_retarget::internals::fingers::{FINGER, FingerBend, Fingers, Joint, curl};

/// By hand: bends of 45 and 95 degrees, with ranges of 90, 100 and 90, are half of a fist.
#[test]
fn a_finger_is_bent_as_far_through_its_range() {
    let node = |index: usize| Node {
        name: format!("finger{index}"),
        parent: index.checked_sub(1).map(NodeId::new),
        transform: Mat4::from_translation(Vec3::Y),
        ..Node::default()
    };
    let scene = Scene {
        nodes: (0..5).map(node).collect(),
        ..Scene::default()
    };
    let joints: Vec<FingerBend> = (0..3)
        .map(|index| FingerBend {
            before: NodeId::new(index),
            at: NodeId::new(index + 1),
            after: NodeId::new(index + 2),
            range: FINGER[index].to_radians(),
        })
        .collect();
    let mut pose = Pose::rest(&scene);
    assert!(curl(&joints, &pose) < 1e-3);
    for (index, degrees) in [45.0_f32, 95.0, 0.0].into_iter().enumerate() {
        let turned = Mat4::from_rotation_x(degrees.to_radians());
        pose.node_to_parent[index + 1] = Mat4::from_translation(Vec3::Y) * turned;
    }
    pose.update_world();
    assert!((curl(&joints, &pose) - 0.5).abs() < 1e-3);
    let joint = |position, fastest| Joint {
        position,
        open: 0.1,
        bent: -1.5,
        follows: vec![(Side::Left, 1)],
        fastest,
    };
    let fingers = Fingers {
        joints: vec![joint(0, 3.0), joint(2, 30.0)],
        source: [vec![Vec::new(), joints], Vec::new()],
    };
    let wanted = fingers.wanted(&pose);
    assert!(wanted.iter().all(|at| (at + 0.7).abs() < 2e-3), "{wanted:?}");
    // At 30 frames per second, one joint moves by at most 0.1 and the other by at most 1.
    let mut positions = [0.0, 5.0, 0.0];
    fingers.bend(&wanted, Some(&[0.1, 5.0, 0.1]), 30.0, &mut positions);
    assert!(
        (positions[0] - 0.0).abs() < 1e-9 && positions[1] == 5.0,
        "{positions:?}"
    );
    assert!((positions[2] + 0.7).abs() < 2e-3, "{positions:?}");
}
