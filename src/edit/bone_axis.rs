//! Rotates the coordinate frame of each joint so that one axis points along the bone.

use std::fmt;

use glam::Quat;
use mocap_figure::convert::{AlongBone, Conversion};
use mocap_scene::error::Result;
use mocap_scene::math::directions::rotation_of;
use mocap_scene::pose::Pose;
use mocap_scene::scene::Scene;
use serde::Serialize;

use super::frames_report::converted;
use super::quantity::degrees;
use super::step::step;
use super::{Step, StepInput, StepKey, ValueKind};

step! {
    /// Turns the coordinate frame of every joint in the rest pose. One axis then points to the next joint, and another
    /// is the axis about which the joint bends. The positions of the joints do not change, neither in the rest pose nor
    /// in the motion.
    ///
    /// If a joint has several children, the axis points to the next bone of the figure, or otherwise to the middle of
    /// the children. If a joint has no child, the axis has the direction of the axis of the parent. A joint without a
    /// bone takes the bending axis of its parent. BVH stores no rotations of the rest pose, so this step does not
    /// change a BVH output.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::Pose;
    /// use mocap::edit::{BoneAxis, Step, StepInput};
    /// use mocap::scene::NodeId;
    ///
    /// let mut scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
    /// BoneAxis::new().apply(&mut scene, &StepInput::new())?;
    /// let rest = Pose::rest(&scene);
    /// let to_elbow = rest.position(NodeId(1)) - rest.position(NodeId(0));
    /// let y = rest.node_to_world[0].y_axis.truncate();
    /// assert!(y.angle_between(to_elbow) < 1e-3);
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Code::Unrepresentable`](mocap_scene::Code::Unrepresentable) if a joint has a non-uniform scale;
    /// [`Code::NoMotion`](mocap_scene::Code::NoMotion) if the scene lacks the animation.
    BoneAxis {
        /// The axis that points along the bone. Default: +Y.
        axis: AlongBone = AlongBone::default(), ValueKind::OneOf(&["y", "x"]);
    }
}

impl Step for BoneAxis {
    const NAME: &'static str = "bone-axis";
    const HELP: &'static str = "rotate the joint axes so that one axis points along the bone at rest";
    const KEYS: &'static [StepKey] = Self::OPTIONS;
    const TAKES_BONES: bool = true;
    const IS_OF_SKELETON: bool = true;
    type Report = BoneAxisReport;

    fn change(&self, scene: &mut Scene, input: &StepInput<'_>) -> Result<BoneAxisReport> {
        let frames = |scene: &Scene| -> Vec<Quat> { Pose::rest(scene).node_to_world.iter().map(rotation_of).collect() };
        let before = frames(scene);
        converted(scene, input, Conversion::new().bone_axis(Some(self.axis)))?;
        let angles = before.iter().zip(frames(scene));
        let angles = angles.map(|(before, now)| before.angle_between(now).to_degrees());
        Ok(BoneAxisReport {
            axis: self.axis,
            largest_rotation: angles.fold(0.0, f32::max),
        })
    }

    /// Does nothing, because the conversion that this step calls has already recorded the step.
    fn record(&self, _: &mut Scene, _: &StepInput<'_>) {}
}

/// The report of a step: [`BoneAxis`] has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct BoneAxisReport {
    /// The axis that now points along the bones.
    pub axis: AlongBone,
    /// The largest rotation of a joint's coordinate frame, in degrees.
    pub largest_rotation: f32,
}

impl fmt::Display for BoneAxisReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let axis = match self.axis {
            AlongBone::Y => "+Y",
            AlongBone::X => "+X",
        };
        let by = degrees(self.largest_rotation);
        write!(
            f,
            "{axis} of every joint points along its bone; joint axes are rotated by {by} at most, and no joint moves"
        )
    }
}
