//! A robot as a scene: a skeleton without motion.

use mocap_figure::robot_bones::robot_scene;
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::limits::Limits;
use mocap_scene::scene::Scene;
use mocap_scene::scene::report::DataKind;
use mocap_scene::scene::robot::{Robot, RobotLink};

use crate::warnings::Warnings;
use crate::{Failure, ReadOptions, Source};

/// Reads a robot as a scene, with a warning that it has no motion.
pub(super) fn read(
    source: &Source<'_>,
    options: &ReadOptions,
    read: impl FnOnce(&Source<'_>, &Limits, &mut Warnings) -> Result<Robot, Failure>,
) -> Result<Scene> {
    let mut warnings = Warnings::default();
    let scene = read(source, &options.limits, &mut warnings).map(|robot| {
        let mut scene = robot_scene(&robot);
        let count = |is_it: &dyn Fn(&RobotLink) -> bool| robot.links.iter().filter(|link| is_it(link)).count();
        let is_limited = |link: &RobotLink| {
            let limits = &link.joint.limits;
            limits.lower.is_finite() || limits.upper.is_finite() || limits.velocity.is_some() || limits.effort.is_some()
        };
        scene.lose(DataKind::JointLimits, count(&is_limited));
        scene.lose(DataKind::CoupledJoints, count(&|link| link.joint.mimic.is_some()));
        scene.lose(DataKind::LinkMasses, count(&|link| link.inertial.is_some()));
        let shapes = robot.links.iter().map(|link| link.shapes.len());
        scene.lose(DataKind::LinkShapes, shapes.sum());
        for loss in &robot.lost {
            scene.lose(loss.kind, loss.count as usize);
        }
        scene
    });
    if scene.is_ok() {
        warnings.push(Code::NoMotion, || {
            let message = "a robot has no motion: the scene has a skeleton and no animation";
            Diagnostic::new(Code::NoMotion, message).help("mocap robot retargets a motion to the robot")
        });
    }
    warnings.attach_to(scene)
}
