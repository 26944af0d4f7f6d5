//! Brings a hand, a foot or the tip of a chain to a target: a point, or a node such as a joint or a prop.

use std::fmt;

use mocap_figure::convert::TimeRange;
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::scene::Scene;
use serde::Serialize;

use super::chain::Chain;
use super::frames::Frames;
use super::held::{LimbReport, hold};
use super::limb::Limb;
use super::step::step;
use super::target::ReachTarget;
use super::window::Window;
use super::{Step, StepInput, StepKey, ValueKind};

step! {
    /// Brings a hand or a foot to a target during a time range. The wrist, the ankle or the joint `tip` reaches the
    /// target. The limb moves to the target before the range, stays there during the range, and moves back after the
    /// range. The upper and the lower bone of the limb turn. The elbow or the knee bends about the same axis as in the
    /// rest of the motion. A hand turns with its forearm, but a foot keeps its rotation in the world. Nothing else
    /// changes.
    ///
    /// The law of cosines gives the angles of the two bones. With `start`, the step brings the tip of a chain of joints
    /// to the target, for any skeleton. The method is then FABRIK, in which all joints from `start` to `tip` share the
    /// bend.
    ///
    /// If the target is beyond the length of the limb, the limb points straight at it, and the report has the remaining
    /// distance.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::edit::{Limb, Reach, ReachTarget, Step, StepInput};
    ///
    /// let mut scene = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
    /// let head = ReachTarget::Node("head".to_owned());
    /// let reach = Reach::new().limb(Limb::LeftHand).to(Some(head)).range("1..2".parse().unwrap());
    /// let report = reach.apply(&mut scene, &StepInput::new())?;
    /// assert_eq!((report.limb.frames, report.limb.out_of_reach), (121, 0));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// - [`Code::NotHumanoid`] without `start`, also if a joint of the limb is missing
    /// - [`Code::NoMotion`] if the scene lacks the animation
    /// - [`Code::InvalidValue`] without a target, for a name that no node has, and for a target that moves with the
    ///   limb
    /// - [`Code::InvalidValue`] for a range outside the motion, for a `start` with several end effectors below, and for
    ///   a number that is not finite
    Reach {
        /// The limb. Default: the right hand.
        limb: Limb = Limb::default(), ValueKind::OneOf(Limb::NAMES);
        /// The target: a point of the world in metres, or the name of a node. It must be given.
        to: Option<ReachTarget> = None, ValueKind::Target;
        /// The position of the point to reach, in the coordinate frame of the target, in metres. Default: the origin of
        /// the target.
        offset: [f64; 3] = [0.0; 3], ValueKind::Point;
        /// For a skeleton without known limbs: the first joint of the chain that moves. It replaces `limb`. Default:
        /// none.
        start: Option<String> = None, ValueKind::Name;
        /// The joint that comes to the target. It is the wrist, the ankle or a joint below. With `start`, it is a joint
        /// below `start`. Default: the wrist or the ankle; with `start`, the only end effector below `start`.
        tip: Option<String> = None, ValueKind::Name;
        /// The time range during which the limb is at the target. Default: the whole motion.
        range: TimeRange = TimeRange::default(), ValueKind::TimeRange;
        /// Duration of the movement to the target before the range, in seconds. Default: 0.4.
        ease_in: f64 = 0.4, ValueKind::Seconds;
        /// Duration of the movement back after the range, in seconds. Default: 0.4.
        ease_out: f64 = 0.4, ValueKind::Seconds;
    }
}

impl Step for Reach {
    const NAME: &'static str = "reach";
    const HELP: &'static str = "bring a hand, a foot or the tip of a chain to a point, a joint or a node";
    const KEYS: &'static [StepKey] = Self::OPTIONS;
    const TAKES_BONES: bool = true;
    type Report = ReachReport;

    fn change(&self, scene: &mut Scene, input: &StepInput<'_>) -> Result<ReachReport> {
        Frames::new(scene, input.animation, &[])?.require_nodes()?;
        let mut chain = Chain::new(scene, input, self.limb, [self.start.as_deref(), self.tip.as_deref()])?;
        let Some(to) = &self.to else {
            let message = "reach needs a target: to=0.3/1.2/0.5 in metres, or to=NAME of a joint, a bone or a node";
            return Err(Diagnostic::new(Code::InvalidValue, message).into());
        };
        let target = chain.find(scene, to)?;
        let offset = target.offset(self.offset, chain.metres_per_unit)?;
        let mut frames = Frames::new(scene, input.animation, &chain.joints)?;
        let animation = &scene.animations[input.animation];
        let window = Window::new(animation, &frames, self.range, [self.ease_in, self.ease_out])?;
        chain.see_hinge(scene, &frames);
        let goal = |pose: &mocap_scene::pose::Pose| target.to_world(pose).transform_point3(offset);
        let report = hold(scene, &mut frames, &chain, &window, goal);
        frames.write(scene, input.animation, &chain.joints, &[]);
        Ok(ReachReport {
            range: [window.first, window.last],
            limb: report,
        })
    }
}

/// The report of [`Reach`].
///
/// [`Reach`](crate::Reach) has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ReachReport {
    /// The first and the last frame in which the limb should be at the target.
    pub range: [usize; 2],
    /// The accuracy with which the limb reached its goals.
    #[serde(flatten)]
    pub limb: LimbReport,
}

impl fmt::Display for ReachReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [first, last] = self.range;
        write!(f, "frames {first} to {last}: {}", self.limb)
    }
}
