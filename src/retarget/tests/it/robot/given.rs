//! Tests how many of its returned frames a stream keeps.

use mocap::figure::Humanoid;
use mocap::retarget::robot::RobotMotion;
use mocap::scene::Node;
use mocap::scene::robot::Placement;
use mocap::{Pose, Scene};
use mocap_retarget::internals::{Given, Goals, SourceRotations};

#[test]
fn half_a_minute_is_kept() {
    let scene = Scene {
        nodes: vec![Node::default()],
        ..Scene::default()
    };
    let frame = |at: f64| {
        let mut motion = RobotMotion::default();
        motion.fps = 10.0;
        motion.root = vec![Placement::IDENTITY];
        motion.dof_pos = vec![at];
        motion.dof_names = vec!["joint".to_owned()];
        motion.contacts = vec![[false; 2]];
        motion
    };
    let mut empty = frame(0.0);
    empty.forget(1);
    let mut given = Given::new(&scene, empty, SourceRotations::empty(&Humanoid::of(&scene)));
    let mut pose = Pose::rest(&scene);
    for at in 0..400_u16 {
        pose.node_to_parent[0].w_axis.x = f32::from(at);
        given.push(&pose);
        if at >= 5 {
            given.add(&frame(f64::from(at - 5)), &[Goals::default()]);
        }
    }
    assert_eq!(given.motion.frames(), 300);
    assert_eq!(given.motion.dof_pos[0], 95.0);
    let positions = &given.source().channels[0].position_keys.values;
    assert_eq!((positions.len(), positions[0].x, positions[299].x), (300, 95.0, 394.0));
}
