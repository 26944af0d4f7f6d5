//! Rotates neck and head so that the figure looks at a target.

use std::fmt;

use glam::{Quat, Vec3};
use mocap_figure::HumanoidBone as Bone;
use mocap_figure::body::Body;
use mocap_figure::convert::TimeRange;
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::limits::not_negative;
use mocap_scene::math::directions::{arc, rotation_of};
use mocap_scene::math::quaternion::in_hemisphere_of;
use mocap_scene::pose::{Pose, Trs};
use mocap_scene::scene::{NodeId, Scene};
use serde::Serialize;

use super::body::body_of;
use super::frames::Frames;
use super::inertia::ease;
use super::quantity::{centimetres, degrees};
use super::step::step;
use super::target::{ReachTarget, TargetJoint};
use super::window::Window;
use super::{Step, StepInput, StepKey, ValueKind};

step! {
    /// Turns neck and head so that, during a time range, the figure looks at a target. The line of sight then goes
    /// through the target. This line points forward from the middle between the eyes, or from the head joint if the
    /// skeleton has no eyes. The neck takes a fraction of the rotation, and the head takes the remaining rotation. If
    /// the target is farther to the side than `limit`, the figure no longer looks exactly at the target: the head stops
    /// at most 15 degrees after the limit. The figure does not look at a target behind its back. The step adds at most
    /// 400 degrees of rotation per second. If the target moves faster, the turn starts earlier and ends later.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::edit::{LookAt, ReachTarget, Step, StepInput};
    ///
    /// let mut scene = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
    /// let look = LookAt::new().at(Some(ReachTarget::Point([1.0, 1.5, 9.0])));
    /// let report = look.apply(&mut scene, &StepInput::new())?;
    /// // The file begins with a T-pose: the head needs some frames to turn from there.
    /// assert!(report.beyond < 12);
    /// assert!(report.farthest < 0.001);
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// - [`Code::NotHumanoid`] if the skeleton is no humanoid or has no head
    /// - [`Code::NoMotion`] if the scene lacks the animation
    /// - [`Code::InvalidValue`] for the target and the range as in [`Reach`](crate::Reach), for a fraction that is not
    ///   from 0 to 1, and for a negative limit
    LookAt {
        /// The target: a point of the world in metres, or the name of a node. It must be given.
        at: Option<ReachTarget> = None, ValueKind::Target;
        /// The fraction of the rotation that the neck takes. Default: 0.4.
        neck: f64 = 0.4, ValueKind::Fraction;
        /// The angle between the direction that the trunk faces and the direction to the target, in degrees. Up to this
        /// angle, the figure looks exactly at the target. Default: 80.
        limit: f64 = 80.0, ValueKind::Degrees;
        /// The time range during which the figure looks at the target. Default: the whole motion.
        range: TimeRange = TimeRange::default(), ValueKind::TimeRange;
        /// Duration of the turn to the target before the range, in seconds. Default: 0.4.
        ease_in: f64 = 0.4, ValueKind::Seconds;
        /// Duration of the turn back after the range, in seconds. Default: 0.4.
        ease_out: f64 = 0.4, ValueKind::Seconds;
    }
}

/// The head turns at most this angle farther than the limit, in radians.
const BEYOND: f32 = 0.26;

/// Two angles between the direction that the trunk faces and the direction to the target, in radians. Between them (120
/// and 160 degrees), the figure gradually stops looking.
const BEHIND: [f32; 2] = [2.094, 2.793];

/// The largest speed of the rotation that is added to the motion, in radians per second: 400 degrees. A turn to the
/// side by 90 degrees in 0.4 s has this speed in its middle.
const FASTEST: f32 = 6.98;

/// The smallest angle by which a slowed rotation visibly misses the target, in radians: a tenth of a degree.
const BEHIND_TIME: f32 = 0.0017;

/// The number of rotations towards the target. Each rotation also moves the eyes, so the next rotation corrects an
/// error that is about a tenth as large.
const ROUNDS: usize = 8;

impl Step for LookAt {
    const NAME: &'static str = "look-at";
    const HELP: &'static str = "turn neck and head to a point, a joint or a node";
    const KEYS: &'static [StepKey] = Self::OPTIONS;
    const TAKES_BONES: bool = true;
    type Report = LookAtReport;

    fn change(&self, scene: &mut Scene, input: &StepInput<'_>) -> Result<LookAtReport> {
        Frames::new(scene, input.animation, &[])?.require_nodes()?;
        let body = body_of(scene, input.bones())?;
        let refuse = |message: String| Err(Diagnostic::new(Code::InvalidValue, message).into());
        let Some(at) = &self.at else {
            return refuse(
                "look-at needs a target: at=0.3/1.2/5 in metres, or at=NAME of a joint, a bone or a node".into(),
            );
        };
        if !(0.0..=1.0).contains(&self.neck) {
            return refuse(format!("neck must be a fraction from 0 to 1, got {}", self.neck));
        }
        not_negative(Code::InvalidValue, "limit", self.limit)?;
        let gaze = Gaze::new(&body)?;
        let target = at.find(scene, |bone| body.joint(bone), body.metres_per_unit, &gaze.joints())?;
        let mut frames = Frames::new(scene, input.animation, &gaze.joints())?;
        let animation = &scene.animations[input.animation];
        let window = Window::new(animation, &frames, self.range, [self.ease_in, self.ease_out])?;
        let report = self.look(scene, &mut frames, &gaze, target, &window, body.metres_per_unit as f32);
        frames.write(scene, input.animation, &gaze.joints(), &[]);
        Ok(report)
    }
}

impl LookAt {
    fn look(
        &self,
        scene: &Scene,
        frames: &mut Frames,
        gaze: &Gaze,
        target: TargetJoint,
        window: &Window,
        metres: f32,
    ) -> LookAtReport {
        let mut report = LookAtReport {
            range: [window.first, window.last],
            ..LookAtReport::default()
        };
        let mut pose = Pose::rest(scene);
        let (neck, limit) = (self.neck as f32, self.limit.to_radians() as f32);
        let joints = gaze.joints();
        // For each joint and frame, the rotation that is added to the motion.
        let mut turns: Vec<Vec<Quat>> = vec![vec![Quat::IDENTITY; frames.len()]; joints.len()];
        let mut is_beyond = vec![false; frames.len()];
        for (frame, weight) in window.frames(frames.len()) {
            frames.pose(frame, &mut pose);
            let at = target.to_world(&pose).w_axis.truncate();
            let seen = gaze.turn(&mut pose, at, neck, limit);
            is_beyond[frame] = seen.is_beyond;
            for (turns, node) in turns.iter_mut().zip(&joints) {
                let Some(old) = frames.get(frame, *node) else { continue };
                let new = Trs::from_matrix(pose.node_to_parent[node.index()]).rotation.normalize();
                let turn = in_hemisphere_of(Quat::IDENTITY, old.rotation.inverse() * new);
                turns[frame] = Quat::IDENTITY.slerp(turn, weight * seen.weight).normalize();
            }
        }
        let step = FASTEST / frames.rate as f32;
        let parts = match joints.len() {
            2 => vec![neck, 1.0 - neck],
            _ => vec![1.0],
        };
        for (turns, part) in turns.iter_mut().zip(parts) {
            for (frame, by) in slow_down(turns, part * step).into_iter().enumerate() {
                is_beyond[frame] |= by > BEHIND_TIME;
            }
        }
        for frame in 0..frames.len() {
            frames.pose(frame, &mut pose);
            let before = gaze.direction(&pose);
            let at = target.to_world(&pose).w_axis.truncate();
            for (turns, node) in turns.iter().zip(&joints) {
                let Some(old) = frames.get(frame, *node).filter(|_| turns[frame] != Quat::IDENTITY) else {
                    continue;
                };
                let rotation = (old.rotation * turns[frame]).normalize();
                frames.set(frame, *node, Trs { rotation, ..old });
            }
            frames.pose(frame, &mut pose);
            let turned = before.angle_between(gaze.direction(&pose)).to_degrees();
            report.turned = report.turned.max(turned);
            if (window.first..=window.last).contains(&frame) {
                report.frames += 1;
                let to = at - gaze.eyes(&pose);
                let direction = gaze.direction(&pose).normalize_or_zero();
                if is_beyond[frame] {
                    report.beyond += 1;
                    let angle = to.angle_between(direction).to_degrees();
                    report.largest_angle = report.largest_angle.max(angle);
                } else {
                    // The distance is not computed from the angle, because the cosine of a small angle is too coarse.
                    report.farthest = report.farthest.max(to.cross(direction).length() * metres);
                }
            }
        }
        report
    }
}

/// Limits the rotation from frame to frame to `step`. The result is the mean of a sequence that lags and a sequence
/// that leads. Returns the change of each rotation, in radians.
fn slow_down(turns: &mut [Quat], step: f32) -> Vec<f32> {
    let towards = |from: Quat, to: Quat| {
        let angle = from.angle_between(to);
        if angle > step {
            from.slerp(in_hemisphere_of(from, to), step / angle)
        } else {
            to
        }
    };
    let follow = |turns: &mut dyn Iterator<Item = Quat>| {
        let mut last = None;
        let followed = turns.map(|turn| {
            let next = last.map_or(turn, |last| towards(last, turn));
            last = Some(next);
            next
        });
        followed.collect::<Vec<Quat>>()
    };
    let late = follow(&mut turns.iter().copied());
    let early = follow(&mut turns.iter().rev().copied());
    let pairs = std::iter::zip(late, early.into_iter().rev());
    let slowed = std::iter::zip(turns, pairs).map(|(turn, (late, early))| {
        if (late, early) == (*turn, *turn) {
            return 0.0;
        }
        let new = late.slerp(in_hemisphere_of(late, early), 0.5).normalize();
        std::mem::replace(turn, new).angle_between(new)
    });
    slowed.collect()
}

/// The joints that aim the gaze of a figure.
struct Gaze {
    neck: Option<NodeId>,
    head: NodeId,
    /// The forward direction in the coordinate frame of the head.
    forward: Vec3,
    eyes: Vec<NodeId>,
    /// The joint of the trunk that carries the neck, and the forward direction in the coordinate frame of this joint.
    trunk: (NodeId, Vec3),
}

/// The result for the target in one frame.
struct GazeSample {
    /// The fraction of the rotation that is applied.
    weight: f32,
    /// Whether the target is beyond the limit.
    is_beyond: bool,
}

impl Gaze {
    fn new(body: &Body) -> Result<Self> {
        let Some(head) = body.joint(Bone::Head) else {
            return Err(Diagnostic::new(Code::NotHumanoid, "no joint has the bone head").into());
        };
        let forward = |bone: Bone, joint: NodeId| body.frame_to_joint(bone, joint).inverse() * Vec3::Z;
        let trunk = [Bone::UpperChest, Bone::Chest, Bone::Spine, Bone::Hips]
            .into_iter()
            .find_map(|bone| {
                let joint = body.joint(bone).filter(|joint| body.depends_on(head, *joint))?;
                Some((joint, forward(bone, joint)))
            });
        let eyes = [Bone::LeftEye, Bone::RightEye]
            .into_iter()
            .filter_map(|bone| body.joint(bone));
        let eyes: Vec<NodeId> = eyes.filter(|eye| body.depends_on(*eye, head)).collect();
        Ok(Self {
            neck: body.joint(Bone::Neck).filter(|neck| body.depends_on(head, *neck)),
            head,
            forward: forward(Bone::Head, head),
            eyes: if eyes.len() == 2 { eyes } else { Vec::new() },
            trunk: trunk.unwrap_or((body.hips, forward(Bone::Hips, body.hips))),
        })
    }

    fn joints(&self) -> Vec<NodeId> {
        self.neck.into_iter().chain([self.head]).collect()
    }

    /// The point between the eyes, or the joint of the head.
    fn eyes(&self, pose: &Pose) -> Vec3 {
        match self.eyes[..] {
            [left, right] => 0.5 * (pose.position(left) + pose.position(right)),
            _ => pose.position(self.head),
        }
    }

    fn direction(&self, pose: &Pose) -> Vec3 {
        rotation_of(&pose.node_to_world[self.head.index()]) * self.forward
    }

    /// Rotates neck and head towards a target.
    fn turn(&self, pose: &mut Pose, at: Vec3, neck: f32, limit: f32) -> GazeSample {
        let (trunk, forward) = self.trunk;
        let faces = rotation_of(&pose.node_to_world[trunk.index()]) * forward;
        let to = at - self.eyes(pose);
        let angle = faces.angle_between(to);
        if !angle.is_finite() {
            return GazeSample {
                weight: 0.0,
                is_beyond: true,
            };
        }
        let mut is_beyond = false;
        for round in 0..ROUNDS {
            let to = at - self.eyes(pose);
            let whole = faces.angle_between(to);
            let wanted = if whole > limit {
                is_beyond = true;
                let follows = limit + BEYOND * ((whole - limit) / BEYOND).tanh();
                Quat::IDENTITY.slerp(arc(faces, to), follows / whole) * faces
            } else {
                to
            };
            let turn = arc(self.direction(pose), wanted);
            if let (0, Some(joint)) = (round, self.neck) {
                pose.rotate(joint, Quat::IDENTITY.slerp(turn, neck));
                let rest = arc(self.direction(pose), wanted);
                pose.rotate(self.head, rest);
            } else {
                pose.rotate(self.head, turn);
            }
        }
        let behind = ((angle - BEHIND[0]) / (BEHIND[1] - BEHIND[0])).clamp(0.0, 1.0);
        GazeSample {
            weight: 1.0 - ease(behind),
            is_beyond,
        }
    }
}

/// The report of [`LookAt`].
///
/// [`LookAt`](crate::LookAt) has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct LookAtReport {
    /// The first and the last frame in which the figure should look at the target.
    pub range: [usize; 2],
    /// The number of frames in `range`.
    pub frames: usize,
    /// The number of frames in `range` in which the target is beyond the limit or moves too fast.
    pub beyond: usize,
    /// The largest angle between the line of sight and the target in the frames of `beyond`, in degrees.
    pub largest_angle: f32,
    /// The largest distance of the line of sight from the target in the frames that are not in `beyond`, in metres.
    pub farthest: f32,
    /// The largest angle by which the step turned the line of sight, in degrees.
    pub turned: f32,
}

impl fmt::Display for LookAtReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [first, last] = self.range;
        write!(f, "frames {first} to {last}: ")?;
        match self.beyond {
            0 => write!(
                f,
                "the figure looks at the target within {}",
                centimetres(self.farthest)
            )?,
            beyond => {
                let angle = degrees(self.largest_angle);
                write!(
                    f,
                    "the target is beyond the limit in {beyond} of {} frames, by {angle} at most",
                    self.frames
                )?;
            }
        }
        write!(f, "; turned by {} at most", degrees(self.turned))
    }
}
