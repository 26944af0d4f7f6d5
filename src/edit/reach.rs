//! Brings a hand, a foot or the tip of a chain to a point, a joint or a prop.

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
    /// Brings a hand or a foot to a target in a range of a motion: the wrist or the ankle, or a joint below it. The
    /// limb stays at the target during the range. It moves to the target before the range, and back after it. Two bones
    /// turn by the law of cosines, about the axis about which the limb bends in the motion. A hand turns with its
    /// forearm, a foot keeps its rotation in the world. Nothing else changes.
    ///
    /// With `start` it brings the tip of a chain of any skeleton to the target, by FABRIK: all joints from `start` to
    /// `tip` share the bend.
    ///
    /// A target beyond the length of the limb is not reached: the limb is straight towards it, and the report says what
    /// is left.
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
    /// - [`Code::NoMotion`] without this animation
    /// - [`Code::InvalidValue`] without a target, for a name that no node has, and for a target that moves with the
    ///   limb
    /// - [`Code::InvalidValue`] for a part that the motion does not have, a `start` that several chains have, and a
    ///   number that is not finite
    Reach {
        /// The limb. Default: the right hand.
        limb: Limb = Limb::default(), ValueKind::OneOf(Limb::NAMES);
        /// The target. It must be given.
        to: Option<ReachTarget> = None, ValueKind::Target;
        /// The point to reach, from the origin of the target in metres along its axes. Default: the origin.
        offset: [f64; 3] = [0.0; 3], ValueKind::Point;
        /// The first joint of a chain of any skeleton, instead of a limb. Default: none.
        start: Option<String> = None, ValueKind::Name;
        /// The joint that moves to the target, at or below the hand or the foot, or below `start`. Default: the wrist
        /// or the ankle, or the only end effector below `start`.
        tip: Option<String> = None, ValueKind::Name;
        /// The range in which the limb is at the target. Default: the whole motion.
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
            let message = "reach takes a target: to=0.3/1.2/0.5 in metres, or to=NAME of a joint, a bone or a node";
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

/// What [`Reach`] did.
///
/// [`Reach`](crate::Reach) has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ReachReport {
    /// The first and the last frame in which the limb should be at the target.
    pub range: [usize; 2],
    /// How well the limb reached its goals.
    #[serde(flatten)]
    pub limb: LimbReport,
}

impl fmt::Display for ReachReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [first, last] = self.range;
        write!(f, "frames {first} to {last}: {}", self.limb)
    }
}
