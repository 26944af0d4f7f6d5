//! The scene of a robot: a skeleton without a motion.

use mocap_figure::robot_bones::robot_scene;
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::limits::Limits;
use mocap_scene::scene::Scene;
use mocap_scene::scene::report::DataKind;
use mocap_scene::scene::robot::Robot;

use crate::warnings::Warnings;
use crate::{Failure, ReadOptions, Source};

/// Reads a robot as a scene, with the warning that it has no motion.
pub(super) fn read(
    source: &Source<'_>,
    options: &ReadOptions,
    read: impl FnOnce(&Source<'_>, &Limits, &mut Warnings) -> Result<Robot, Failure>,
) -> Result<Scene> {
    let mut warnings = Warnings::default();
    let scene = read(source, &options.limits, &mut warnings).map(|robot| {
        let mut scene = robot_scene(&robot);
        let joints = robot.links.iter().map(|link| &link.joint.limits);
        let limited = joints.filter(|limits| limits.lower.is_finite() || limits.upper.is_finite());
        scene.lose(DataKind::JointLimits, limited.count());
        scene
    });
    if scene.is_ok() {
        warnings.push(Code::NoMotion, || {
            let message = "a robot has no motion: the scene has a skeleton and no animation";
            Diagnostic::new(Code::NoMotion, message).help("mocap robot puts a motion on it")
        });
    }
    warnings.attach_to(scene)
}
