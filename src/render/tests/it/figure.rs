//! Tests which nodes and links of a figure are drawn.

use mocap::figure::Humanoid;
use mocap::glam::Vec3;
use mocap::render::Clip;
use mocap::scene::{Keys, Node, NodeId};
use mocap_render::internals::figure::{DrawnClip, Side, links, short, shown};

#[test]
fn numbers_are_short() {
    let numbers = [1.5, 2.0, -0.001, 0.0, -1.25, 10.0];
    assert_eq!(numbers.map(short), ["1.5", "2", "0", "0", "-1.25", "10"]);
}

#[test]
fn a_figure_is_not_tied_to_a_node_that_it_leaves() {
    let scene = mocap::import("../../fixtures/real/cmu_12_01_walk.bvh").unwrap();
    let all = links(&scene, &Humanoid::of(&scene)).len();
    // A joint above the hips that does not move.
    let mut moved = scene.clone();
    moved.nodes.insert(
        0,
        Node {
            name: "still".to_owned(),
            ..scene.nodes[0].clone()
        },
    );
    for node in &mut moved.nodes[1..] {
        node.parent = Some(NodeId::new(node.parent.map_or(0, |parent| parent.index() + 1)));
    }
    for channel in &mut moved.animations[0].channels {
        channel.node = channel.node.map(|node| NodeId::new(node.index() + 1));
    }
    assert_eq!(links(&moved, &Humanoid::of(&moved)).len(), all);
    let humanoid = Humanoid::of(&moved);
    assert!(!shown(&moved, &humanoid, &links(&moved, &humanoid))[0]);
    let clip = Clip {
        name: "",
        scene: &moved,
    };
    assert_eq!(DrawnClip::new(clip).root, 1);
    // With its own rotation, the joint is a part of the figure.
    let mut still = moved.animations[0].channels[0].clone();
    still.node_name = "still".to_owned();
    still.node = Some(NodeId(0));
    still.position_keys = Keys::constant(Vec3::ZERO);
    moved.animations[0].channels.insert(0, still);
    assert_eq!(links(&moved, &Humanoid::of(&moved)).len(), all + 1);
}

#[test]
fn sides_are_told_by_the_usual_names() {
    let left = [
        "LeftArm",
        "lThigh",
        "L_Foot",
        "hand.L",
        "mixamorig:LeftToe",
        "LThumb",
        "lhipjoint",
    ];
    let right = ["RightArm", "rShin", "R_Foot", "hand_R", "upperarm_right", "rradius"];
    let middle = [
        "Hips",
        "Lumbar",
        "root",
        "Spine",
        "LowerBack",
        "Neck",
        "",
        "lowerback",
        "radius",
    ];
    assert!(left.iter().all(|name| Side::of(name) == Side::Left));
    assert!(right.iter().all(|name| Side::of(name) == Side::Right));
    assert!(middle.iter().all(|name| Side::of(name) == Side::Middle));
}
