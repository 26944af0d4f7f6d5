//! Scores a motion of a robot against its reference, by the measures of publications. `docs/scores.md` defines them.

use std::fmt;

use glam::DVec3;
use mocap_scene::scene::robot::{JointLimits, Robot};
use serde::{Deserialize, Serialize};

use super::measure::SoleSpeed;
use super::motion::RobotMotion;

/// The largest height of a sole that keeps a contact, in metres: the height up to which the sole carries in inverse
/// dynamics.
const KEPT: f64 = 0.02;

/// The excess over a limit that violates the limit, in radians or metres: the rounding of files.
pub(super) const BEYOND: f64 = 1e-4;

/// The scores of a motion of a robot against its reference. `docs/scores.md` has the definitions and their sources.
///
/// The [module](crate::robot) has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct RobotScores {
    /// The number of compared bodies. They are the base and links with a joint if the reference is a motion of the same
    /// robot, and else the bones of the robot.
    pub bodies: usize,
    /// The mean per-body position error in the world, in metres.
    pub mpbpe_global: f64,
    /// The mean per-body position error relative to the base, in metres.
    pub mpbpe_local: f64,
    /// The mean position error of the hands relative to the base, in metres; absent for a robot without hands.
    pub palm_error: Option<f64>,
    /// The mean speed of the slowest point of a sole while the foot of the reference is in contact, in metres per
    /// second; absent without contacts.
    pub foot_sliding: Option<f64>,
    /// The fraction of frames with a foot of the reference in contact in which the slowest point of the sole is faster
    /// than 0.1 m/s.
    pub foot_skating_duration: Option<f64>,
    /// The largest speed of the slowest point of a sole in contact, in metres per second.
    pub foot_skating_velocity: Option<f64>,
    /// Of the frames in which a foot of the reference is in contact, the fraction with the sole at most 2 cm above the
    /// floor.
    pub contact_preservation: Option<f64>,
    /// The fraction of frames in which a sole or a link is more than 1 cm below the floor.
    pub penetration_duration: f64,
    /// The largest depth below the floor, in metres.
    pub penetration_depth: f64,
    /// The fraction of frames in which two links penetrate each other by more than 1 cm.
    pub self_collision_duration: f64,
    /// The largest depth of the penetration of two links, in metres.
    pub self_collision_depth: f64,
    /// The mean absolute jerk of the joints, in rad/s³ or m/s³.
    pub joint_jerk: f64,
    /// The fraction of positions of joints beyond a limit of the robot's file.
    pub limit_violation: f64,
    /// The fraction of positions of joints at a limit or beyond it.
    pub at_limit: f64,
}

impl fmt::Display for RobotScores {
    /// A line for each group of scores.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (bodies, millimetres) = (self.bodies, |metres: f64| format!("{:.1} mm", 1000.0 * metres));
        let percent = |fraction: f64| format!("{:.1} %", 100.0 * fraction);
        let (global, local) = (millimetres(self.mpbpe_global), millimetres(self.mpbpe_local));
        write!(f, "MPBPE {global} global, {local} local, of {bodies} bodies")?;
        if let Some(palms) = self.palm_error {
            write!(f, "; palms {}", millimetres(palms))?;
        }
        if let (Some(speed), Some(share), Some(fastest), Some(kept)) = (
            self.foot_sliding,
            self.foot_skating_duration,
            self.foot_skating_velocity,
            self.contact_preservation,
        ) {
            let (speed, fastest) = (100.0 * speed, 100.0 * fastest);
            let (share, kept) = (percent(share), percent(kept));
            write!(
                f,
                "\nfoot sliding {speed:.2} cm/s, at most {fastest:.1}; skating in {share} of contacts; {kept} of contacts kept"
            )?;
        }
        let (floor, deep) = (percent(self.penetration_duration), millimetres(self.penetration_depth));
        let (own, into) = (
            percent(self.self_collision_duration),
            millimetres(self.self_collision_depth),
        );
        write!(
            f,
            "\npenetration in {floor} of frames, at most {deep}; self-collision in {own}, at most {into}"
        )?;
        let (beyond, at) = (percent(self.limit_violation), percent(self.at_limit));
        write!(
            f,
            "\nmean joint jerk {:.0} rad/s3; {beyond} of positions beyond a limit, {at} at one",
            self.joint_jerk
        )
    }
}

/// The positions of the bodies of the reference and of the robot in each frame, in metres.
pub(super) struct BodyPlaces {
    pub(super) reference: Vec<Vec<DVec3>>,
    pub(super) robot: Vec<Vec<DVec3>>,
    /// The index of the base, and of the hands.
    pub(super) base: usize,
    pub(super) palms: Vec<usize>,
}

impl BodyPlaces {
    /// The mean distance of these bodies, in the world or relative to the base.
    fn error(&self, bodies: &[usize], is_local: bool) -> f64 {
        let frames = std::iter::zip(&self.reference, &self.robot);
        let distances = frames.flat_map(|(reference, robot)| {
            let apart = match is_local {
                true => robot[self.base] - reference[self.base],
                false => DVec3::ZERO,
            };
            bodies
                .iter()
                .map(move |body| (robot[*body] - reference[*body] - apart).length())
        });
        let (sum, count) = distances.fold((0.0, 0_usize), |(sum, count), distance| (sum + distance, count + 1));
        sum / count.max(1) as f64
    }
}

/// The scores of a motion, without penetrations. `standing` are the heights of soles in contact.
pub(super) fn scores(
    robot: &Robot,
    motion: &RobotMotion,
    places: &BodyPlaces,
    (speed, standing): (&SoleSpeed<2>, &[f64]),
) -> RobotScores {
    let all: Vec<usize> = (0..places.robot.first().map_or(0, Vec::len)).collect();
    let samples = motion.dof_pos.len().max(1) as f64;
    let kept = standing.iter().filter(|height| **height <= KEPT).count();
    let joints = Joints::new(robot, motion);
    RobotScores {
        bodies: all.len(),
        mpbpe_global: places.error(&all, false),
        mpbpe_local: places.error(&all, true),
        palm_error: (!places.palms.is_empty()).then(|| places.error(&places.palms, true)),
        foot_sliding: speed.mean(),
        foot_skating_duration: speed.fraction_skating(),
        foot_skating_velocity: speed.mean().map(|_| speed.fastest()),
        contact_preservation: (!standing.is_empty()).then(|| kept as f64 / standing.len() as f64),
        joint_jerk: joints.jerk,
        limit_violation: joints.beyond as f64 / samples,
        at_limit: joints.at_limit as f64 / samples,
        ..RobotScores::default()
    }
}

/// The excess of a position over the limit of its joint; below 0 within the limits.
pub(super) fn beyond_limit(limits: &JointLimits, position: f64) -> f64 {
    (limits.lower - position).max(position - limits.upper)
}

/// The positions of joints against their limits, and the mean of their absolute third differences.
#[derive(Default)]
struct Joints {
    jerk: f64,
    beyond: usize,
    at_limit: usize,
}

impl Joints {
    fn new(robot: &Robot, motion: &RobotMotion) -> Self {
        let joints = robot.moving_joints();
        let (frames, count) = (motion.frames(), joints.len());
        let mut found = Self::default();
        let (mut sum, mut samples) = (0.0, 0_usize);
        for (dof, &link) in joints.iter().enumerate() {
            let limits = &robot.links[link].joint.limits;
            let at = |frame: usize| motion.dof_pos[frame * count + dof];
            for frame in 0..frames {
                let beyond = beyond_limit(limits, at(frame));
                found.beyond += usize::from(beyond > BEYOND);
                found.at_limit += usize::from(beyond > -BEYOND);
                if frame > 2 {
                    let third = at(frame) - 3.0 * at(frame - 1) + 3.0 * at(frame - 2) - at(frame - 3);
                    sum += third.abs() * motion.fps.powi(3);
                    samples += 1;
                }
            }
        }
        found.jerk = sum / samples.max(1) as f64;
        found
    }
}
