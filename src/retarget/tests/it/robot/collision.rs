//! Tests which links collide.

use mocap::retarget::robot::RobotMotion;
use mocap::scene::robot::Placement;
use mocap_retarget::internals::{Collisions, Kinematics};

/// Two arms that point forward, and a tail that touches them from below with all joints at 0.
const ROBOT: &str = r#"<mujoco><compiler angle="degree"/><worldbody><body name="base">
    <geom type="box" size="0.35 0.35 0.1"/>
    <body name="left" pos="0 0.3 0"><joint name="l" axis="0 0 1"/>
      <geom type="capsule" fromto="0 0 0 0.4 0 0" size="0.05"/></body>
    <body name="right" pos="0 -0.3 0"><joint name="r" axis="0 0 1"/>
      <geom type="capsule" fromto="0 0 0 0.4 0 0" size="0.05"/></body>
    <body name="mount" pos="0 0 -0.2"><joint name="m" axis="0 0 1"/>
      <body name="tail"><joint name="t" axis="0 1 0"/>
        <geom type="box" size="0.5 0.5 0.16"/></body></body>
    </body></worldbody></mujoco>"#;

#[test]
fn links_that_collide_are_found_but_neighbours_and_those_that_touch_at_rest_are_not() {
    let robot = mocap::Importer::new()
        .read_robot(ROBOT.as_bytes(), "robot.xml")
        .unwrap();
    let kinematics = Kinematics::new(&robot);
    let collisions = Collisions::new(&robot, &kinematics);
    let names = |pair: &[usize; 2]| pair.map(|body| collisions.names[body].as_str());
    let pairs: Vec<_> = collisions.pairs.iter().map(names).collect();
    assert_eq!(pairs, [["left", "right"]]);
    // Three poses of the arms, which are 0.4 m long and 0.6 m apart: ahead, across each other, and tip to tip at 0.06
    // m.
    let tips = (0.54_f64 / 0.8).acos();
    let across = std::f64::consts::FRAC_PI_2;
    let dof_pos = [
        [0.0; 4],
        [-across, across, 0.0, 0.0],
        [tips - across, across - tips, 0.0, 0.0],
        [0.0; 4],
    ];
    let mut motion = RobotMotion::default();
    motion.fps = 30.0;
    motion.root = vec![Placement::IDENTITY; dof_pos.len()];
    motion.dof_pos = dof_pos.concat();
    motion.dof_names = robot.dof_names();
    motion.contacts = vec![[false; 2]; dof_pos.len()];
    let found = collisions.measure(&kinematics, &motion);
    assert_eq!(found.fraction, 0.5);
    let [pair] = &found.links[..] else { panic!("{found:?}") };
    assert_eq!(
        (pair.link.as_str(), pair.other.as_str(), pair.fraction),
        ("left", "right", 0.5)
    );
    assert!((pair.deepest - 0.1).abs() < 1e-9, "{pair:?}");
    motion.dof_pos.copy_within(8..12, 4);
    let pair = &collisions.measure(&kinematics, &motion).links[0];
    assert!((pair.deepest - 0.04).abs() < 1e-9, "{pair:?}");
}
