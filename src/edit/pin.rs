//! Pins a hand, a foot or the tip of a chain to its target: another joint or a point.

use std::fmt;
use std::ops::Range;

use glam::Vec3;
use mocap_figure::contacts::ContactRule;
use mocap_figure::convert::TimeRange;
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::limits::{not_negative, positive};
use mocap_scene::math::velocity::velocities;
use mocap_scene::pose::Pose;
use mocap_scene::scene::Scene;
use serde::Serialize;

use super::chain::Chain;
use super::frames::Frames;
use super::held::{LimbReport, hold};
use super::limb::Limb;
use super::quantity::{centimetres, counted};
use super::step::step;
use super::target::{ReachTarget, TargetJoint};
use super::window::Window;
use super::{Step, StepInput, StepKey, ValueKind};

step! {
    /// Holds a hand or a foot at the object that it touches, the target. During a contact, the limb keeps its mean
    /// position in the coordinate frame of the target. The target may move and rotate. If the limb is too short to
    /// reach this position, it comes as near as possible. A contact is the given range. Without a range, it is every
    /// time during which the limb is near the target and slow relative to the target. The bones turn as in
    /// [`reach`](crate::Reach). Nothing else changes. For feet on the floor, use [`foot-lock`](crate::FootLock), which
    /// lets a foot roll.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::edit::{Limb, Pin, ReachTarget, Step, StepInput};
    ///
    /// let mut scene = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
    /// let hips = ReachTarget::Node("hips".to_owned());
    /// let pin = Pin::new().limb(Limb::LeftHand).to(Some(hips)).range(Some("1..1.5".parse().unwrap()));
    /// let report = pin.apply(&mut scene, &StepInput::new())?;
    /// assert_eq!((report.contacts.len(), report.slide_after < 1e-4), (1, true));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// The errors of [`Reach`](crate::Reach), except that the target may be absent. [`Code::InvalidValue`] also if both
    /// the target and the range are absent.
    Pin {
        /// The limb. Default: the right hand.
        limb: Limb = Limb::default(), ValueKind::OneOf(Limb::NAMES);
        /// The target that the limb touches: a point of the world in metres, or the name of a node. Default: the mean
        /// position of the limb in `range`, which must then be given.
        to: Option<ReachTarget> = None, ValueKind::Target;
        /// For a skeleton without known limbs: the first joint of the chain that moves. It replaces `limb`. Default:
        /// none.
        start: Option<String> = None, ValueKind::Name;
        /// The joint that touches the target. It is the wrist, the ankle or a joint below. With `start`, it is a joint
        /// below `start`. Default: the wrist or the ankle; with `start`, the only end effector below `start`.
        tip: Option<String> = None, ValueKind::Name;
        /// The time range of the contact. Default: the step finds the contacts by `distance` and `speed`.
        range: Option<TimeRange> = None, ValueKind::TimeRange;
        /// If the step finds the contacts: the largest distance between `tip` and the origin of the target, in metres.
        /// Default: 0.3, because joints are inside the body.
        distance: f64 = 0.3, ValueKind::Metres;
        /// If the step finds the contacts: the largest speed of `tip` relative to the target, in metres per second.
        /// Default: 0.25.
        speed: f64 = 0.25, ValueKind::MetresPerSecond;
        /// Duration of the movement to the target before a contact, and of the movement back after it, in seconds.
        /// Default: 0.2.
        blend: f64 = 0.2, ValueKind::Seconds;
    }
}

impl Step for Pin {
    const NAME: &'static str = "pin";
    const HELP: &'static str = "keep a hand, a foot or the tip of a chain at its contact point";
    const KEYS: &'static [StepKey] = Self::OPTIONS;
    const TAKES_BONES: bool = true;
    type Report = PinReport;

    fn change(&self, scene: &mut Scene, input: &StepInput<'_>) -> Result<PinReport> {
        Frames::new(scene, input.animation, &[])?.require_nodes()?;
        let mut chain = Chain::new(scene, input, self.limb, [self.start.as_deref(), self.tip.as_deref()])?;
        self.check()?;
        let target = match &self.to {
            Some(to) => chain.find(scene, to)?,
            None => TargetJoint::Point(Vec3::ZERO),
        };
        let mut frames = Frames::new(scene, input.animation, &chain.joints)?;
        chain.see_hinge(scene, &frames);
        let metres = chain.metres_per_unit as f32;
        let mut report = PinReport::default();
        let touching = || PinnedFrame::new(scene, &frames, &chain, target, 0..frames.len(), metres);
        for window in self.windows(scene, input.animation, &frames, touching)? {
            let inside = window.first..window.last + 1;
            let was = PinnedFrame::new(scene, &frames, &chain, target, inside.clone(), metres);
            let changed = window.frames(frames.len()).map(|(frame, _)| frame);
            let middle = within_reach(was.mean(), scene, &frames, &chain, target, changed);
            let goal = |pose: &Pose| target.to_world(pose).transform_point3(middle);
            let before = frames.clone();
            let held = hold(scene, &mut frames, &chain, &window, goal);
            let is = PinnedFrame::new(scene, &frames, &chain, target, inside, metres);
            // Skips this contact: the limb is too short, and would slide more than before.
            if self.range.is_none() && is.slide() > was.slide() {
                frames = before;
                report.left += 1;
                continue;
            }
            report.slide_before += was.slide();
            report.slide_after += is.slide();
            report.limb.append(&held);
            report.contacts.push([window.first, window.last]);
        }
        frames.write(scene, input.animation, &chain.joints, &[]);
        Ok(report)
    }
}

impl Pin {
    fn check(&self) -> Result<()> {
        positive(Code::InvalidValue, "distance", self.distance)?;
        positive(Code::InvalidValue, "speed", self.speed)?;
        not_negative(Code::InvalidValue, "blend", self.blend)?;
        match (&self.to, self.range) {
            (None, None) => {
                let message = "pin needs a target (to=NAME or to=0.3/1.2/0.5) or a time range (range=1..2)";
                Err(Diagnostic::new(Code::InvalidValue, message).into())
            }
            _ => Ok(()),
        }
    }

    /// The ranges of frames in which the limb touches the target: the given range, or the contacts that are found.
    fn windows(
        &self,
        scene: &Scene,
        animation: usize,
        frames: &Frames,
        touching: impl FnOnce() -> PinnedFrame,
    ) -> Result<Vec<Window>> {
        if let Some(range) = self.range {
            let window = Window::new(&scene.animations[animation], frames, range, [self.blend; 2])?;
            return Ok(vec![window]);
        }
        let rule = ContactRule {
            height: self.distance,
            speed: self.speed,
            ..ContactRule::default()
        };
        let touches = rule.at_rest(touching().samples(frames.rate), frames.rate);
        Ok(Window::of_runs(&touches, self.blend * frames.rate))
    }
}

/// The point near `wanted` that the limb can reach in all of `of_frames`, in the coordinate frame of the target. In
/// each frame, the reachable points are in a ball. Balls are convex, so repeated projections onto them converge to a
/// common point if there is one (Bregman 1965).
fn within_reach(
    wanted: Vec3,
    scene: &Scene,
    frames: &Frames,
    chain: &Chain,
    target: TargetJoint,
    of_frames: impl Iterator<Item = usize>,
) -> Vec3 {
    /// The largest number of rounds, each of which projects the point onto the balls of all frames.
    const ROUNDS: usize = 200;
    /// The largest reach as a fraction of the length of the limb, so that it is never stretched fully.
    const STRETCHED: f32 = 0.9999;
    let mut pose = Pose::rest(scene);
    let balls: Vec<(Vec3, f32)> = of_frames
        .map(|frame| {
            frames.pose(frame, &mut pose);
            let (centre, radius) = chain.reach(&pose);
            (
                target.to_world(&pose).inverse().transform_point3(centre),
                radius * STRETCHED,
            )
        })
        .filter(|(centre, _)| centre.is_finite())
        .collect();
    let mut at = wanted;
    for _ in 0..ROUNDS {
        let before = at;
        for (centre, radius) in &balls {
            at = *centre + (at - *centre).clamp_length_max(*radius);
        }
        if at == before {
            break;
        }
    }
    at
}

/// The positions of the tip in the coordinate frame of the target, in units of the scene, one for each frame.
struct PinnedFrame {
    at: Vec<Vec3>,
    metres: f32,
}

impl PinnedFrame {
    fn new(
        scene: &Scene,
        frames: &Frames,
        chain: &Chain,
        target: TargetJoint,
        of_frames: Range<usize>,
        metres: f32,
    ) -> Self {
        let mut pose = Pose::rest(scene);
        let at = of_frames.map(|frame| {
            frames.pose(frame, &mut pose);
            let at = target
                .to_world(&pose)
                .inverse()
                .transform_point3(pose.position(chain.tip));
            if at.is_finite() { at } else { Vec3::ZERO }
        });
        Self {
            at: at.collect(),
            metres,
        }
    }

    /// The distance from the target in metres and the speed in m/s, for each frame.
    fn samples(&self, rate: f64) -> impl Iterator<Item = (f64, f64)> {
        let flat: Vec<f32> = self.at.iter().flat_map(|at| (*at * self.metres).to_array()).collect();
        let speeds = velocities(&flat, 3, rate);
        let speeds: Vec<f32> = speeds
            .chunks_exact(3)
            .map(|speed| Vec3::from_slice(speed).length())
            .collect();
        let distances = self.at.iter().map(|at| at.length() * self.metres);
        distances
            .zip(speeds)
            .map(|(distance, speed)| (distance.into(), speed.into()))
    }

    fn mean(&self) -> Vec3 {
        self.at.iter().sum::<Vec3>() / self.at.len().max(1) as f32
    }

    /// The distance that the tip slides relative to the target, in metres: the sum of its movements from frame to
    /// frame.
    fn slide(&self) -> f32 {
        let steps = self.at.windows(2).map(|pair| pair[0].distance(pair[1]));
        steps.sum::<f32>() * self.metres
    }
}

/// The report of [`Pin`]. Lengths are in metres.
///
/// [`Pin`](crate::Pin) has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct PinReport {
    /// The first and the last frame of each contact.
    pub contacts: Vec<[usize; 2]>,
    /// The number of contacts that the step found but did not pin, because the limb is too short and would slide more.
    pub left: usize,
    /// The distance that the limb slides relative to its target in the contacts, before the step.
    pub slide_before: f32,
    /// The distance that the limb slides relative to its target in the contacts, after the step.
    pub slide_after: f32,
    /// The accuracy with which the limb reached its goals.
    #[serde(flatten)]
    pub limb: LimbReport,
}

impl fmt::Display for PinReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.contacts.is_empty() && self.left > 0 {
            return write!(
                f,
                "{} not pinned: the limb is too short to reach the target",
                counted(self.left, "contact")
            );
        }
        if self.contacts.is_empty() {
            return f.write_str(
                "no contact found: the limb is never slow near the target; give a time range, range=1..2, or a larger \
                 distance",
            );
        }
        let of = |[first, last]: &[usize; 2]| format!("{first} to {last}");
        let contacts: Vec<String> = self.contacts.iter().take(8).map(of).collect();
        let more = match self.contacts.len() {
            count @ 9.. => format!(" and {} more", count - 8),
            _ => String::new(),
        };
        write!(
            f,
            "contacts in frames {}{more}; slide {}, now {}; {}",
            contacts.join(", "),
            centimetres(self.slide_before),
            centimetres(self.slide_after),
            self.limb
        )?;
        match self.left {
            0 => Ok(()),
            left => write!(
                f,
                "; {} not pinned, because the limb is too short to reach the target",
                counted(left, "contact")
            ),
        }
    }
}
