//! Two seconds of a walk, and motions on robots.

use mocap::glam::Vec3;
use mocap::retarget::robot::report::RobotReport;
use mocap::retarget::robot::{Robot, RobotMotion, RobotOptions, RobotRetargeter, robot_scene};
use mocap::scene::Animation;
use mocap::{Binding, Pose, Scene};

/// Two seconds of a walk at 30 frames per second.
pub(crate) fn walk() -> Scene {
    let mut source = mocap::import("../../fixtures/real/cmu_12_01_walk.bvh").unwrap();
    let conversion = mocap::Conversion::new().first_frame(mocap::convert::FirstFrame::DropRestPose);
    conversion
        .frame_rate(30.0)
        .trim(None, mocap::convert::Moment::Seconds(2.0))
        .apply(&mut source)
        .unwrap();
    source
}

pub(crate) fn on(robot: &Robot, source: &Scene) -> (RobotMotion, RobotReport) {
    let mut retargeter = RobotRetargeter::new(source, robot, &RobotOptions::default()).unwrap();
    retargeter.clip(source, 0).unwrap()
}

/// Points of a link in the world in every frame, by the poses of the animation.
pub(crate) fn points(robot: &Robot, motion: &RobotMotion, link: &str, points: &[Vec3]) -> Vec<Vec<Vec3>> {
    let (scene, animation): (Scene, Animation) = (robot_scene(robot), motion.to_animation(robot));
    let node = scene.nodes.iter().position(|node| node.name == link).unwrap();
    let binding = Binding::new(&scene, &animation);
    let mut pose = Pose::rest(&scene);
    let at = |frame: usize| {
        pose.sample(&binding, &animation, frame as f64);
        points
            .iter()
            .map(|point| pose.node_to_world[node].transform_point3(*point))
            .collect()
    };
    (0..motion.frames()).map(at).collect()
}
