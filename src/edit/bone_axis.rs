//! Turns the frames of joints along their bones.

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
    /// Turns the frame of every joint at rest so that one of its axes points to the next joint, and another is the
    /// bending axis. Nothing moves, neither at rest nor in motion.
    ///
    /// A joint with several children points to the next bone of the figure, else to the middle of its children; one
    /// without a child points where its parent points. Joints that are no bone bend as the joint above. BVH has no
    /// rotations at rest, and is the same file with this step as without.
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
    /// [`Code::Unrepresentable`](mocap_scene::Code::Unrepresentable) where a joint is scaled otherwise along one axis
    /// than along another; [`Code::NoMotion`](mocap_scene::Code::NoMotion) without this animation.
    BoneAxis {
        /// The axis that points along the bone. Default: +Y.
        axis: AlongBone = AlongBone::default(), ValueKind::OneOf(&["y", "x"]);
    }
}

impl Step for BoneAxis {
    const NAME: &'static str = "bone-axis";
    const HELP: &'static str = "turn the frames of joints along their bones at rest";
    const KEYS: &'static [StepKey] = Self::OPTIONS;
    const TAKES_BONES: bool = true;
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

    /// Records nothing, because the conversion that this step calls records the change.
    fn record(&self, _: &mut Scene, _: &StepInput<'_>) {}
}

/// What a step changed: [`BoneAxis`] has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct BoneAxisReport {
    /// The axis along the bones.
    pub axis: AlongBone,
    /// The largest rotation of a frame, in degrees.
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
            "{axis} of every joint points along its bone; frames are rotated by {by} at most, and nothing moves"
        )
    }
}
