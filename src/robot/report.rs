//! How well a motion sits on a robot.

use serde::{Deserialize, Serialize};

use super::collision::{LinkCollision, SelfCollision};
use super::motion::RobotMotion;
use crate::retarget::{LimbError, RetargetReport, Verdict};
use crate::scene::robot::Robot;

/// The depth below the floor that counts, in metres.
const BELOW: f64 = 0.01;

/// A joint within this of its limit is at it, in radians or metres.
const AT_LIMIT: f64 = 1e-9;

/// What a motion may do and be good: the mean angle of its limbs in degrees, the fraction of frames with a sole below
/// the floor, how much faster than in the source feet on the ground may slide, in metres a second.
const GOOD_DEGREES: f64 = 5.0;
const FAIR_DEGREES: f64 = 10.0;
const MOST_BELOW: f64 = 0.01;
const MORE_SKATE: f64 = 0.005;

/// A joint that would go beyond its limit.
///
/// The [module](crate::robot) has an example.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ClampedJoint {
    /// Its name.
    pub joint: String,
    /// The fraction of frames in which it is at its limit.
    pub share: f64,
}

/// How well a motion sits on a robot.
///
/// The [module](crate::robot) has an example.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct RobotReport {
    /// The name of the motion.
    pub clip: String,
    /// Frames.
    pub frames: usize,
    /// Frames per second.
    pub fps: f64,
    /// How many times as long the steps of the robot are, both in metres.
    pub scale: f64,
    /// Arms and legs: the angles between their directions on both.
    pub limbs: Vec<LimbError>,
    /// The mean of all limbs and frames, in degrees.
    pub mean_degrees: f64,
    /// Joints that are at a limit, and how often.
    pub clamped: Vec<ClampedJoint>,
    /// Positions beyond a limit: always 0.
    pub limit_violations: usize,
    /// The mean speed over the ground of the slowest point of a sole while the foot of the source stands, in metres a
    /// second; absent where none stands.
    pub skate: Option<f64>,
    /// The mean speed of the slowest joint of a foot that stands in the source.
    pub source_skate: Option<f64>,
    /// The fraction of frames in which a sole is more than 1 cm below the floor.
    pub share_below_floor: f64,
    /// How far below the floor a sole is at most, in metres.
    pub deepest: f64,
    /// The fraction of frames in which two links of the robot penetrate each other by more than 1 cm, by capsules
    /// within their shapes.
    pub share_in_self_collision: f64,
    /// Which links, the deepest first.
    pub self_collisions: Vec<LinkCollision>,
    /// The largest velocity of a joint, in radians or metres a second, and which joint it is.
    pub max_velocity: f64,
    /// The joint.
    pub fastest_joint: String,
    /// The fraction of samples in which a joint is faster than the robot's file allows.
    pub share_too_fast: f64,
    /// The largest acceleration of a joint, in radians or metres a second squared.
    pub max_acceleration: f64,
    /// Whether the motion is good enough to use unchanged: good where limbs are within 5 degrees in the mean, feet
    /// slide at most 0.5 cm/s more than in the source, a sole is more than 1 cm below the floor in at most 1 % of
    /// frames, and joints are within their velocities; fair where limbs are within 10 degrees; else poor.
    pub verdict: Verdict,
}

/// The report of a motion; `found` compares its bones with those of the source, `heights` are those of the soles,
/// and `skate` is the speed of soles that stand.
pub(super) fn report(
    robot: &Robot,
    motion: &RobotMotion,
    found: RetargetReport,
    skate: Option<f64>,
    heights: &[[f64; 2]],
    collisions: SelfCollision,
) -> RobotReport {
    let joints = robot.moving_joints();
    let (frames, count) = (motion.frames(), joints.len());
    let (mut clamped, mut limit_violations) = (Vec::new(), 0);
    let (mut max_velocity, mut fastest_joint, mut max_acceleration) = (0.0, String::new(), 0.0_f64);
    let (mut too_fast, mut samples) = (0_usize, 0_usize);
    for (dof, &link) in joints.iter().enumerate() {
        let joint = &robot.links[link].joint;
        let limits = &joint.limits;
        let at = |frame: usize| motion.dof_pos[frame * count + dof];
        let (mut held, mut moved) = (0_usize, false);
        for frame in 0..frames {
            let here = at(frame);
            moved |= here != at(0);
            limit_violations += usize::from(!(limits.lower..=limits.upper).contains(&here));
            held += usize::from(here - limits.lower <= AT_LIMIT || limits.upper - here <= AT_LIMIT);
            if frame > 0 {
                let velocity = (here - at(frame - 1)) * motion.fps;
                samples += 1;
                too_fast += usize::from(limits.velocity.is_some_and(|most| velocity.abs() > most * (1.0 + 1e-9)));
                if velocity.abs() > max_velocity {
                    max_velocity = velocity.abs();
                    fastest_joint.clone_from(&joint.name);
                }
                if frame > 1 {
                    let change = (here - 2.0 * at(frame - 1) + at(frame - 2)) * motion.fps * motion.fps;
                    max_acceleration = max_acceleration.max(change.abs());
                }
            }
        }
        if held > 0 && (moved || frames == 1) {
            clamped.push(ClampedJoint {
                joint: joint.name.clone(),
                share: held as f64 / frames as f64,
            });
        }
    }
    clamped.sort_by(|a, b| b.share.total_cmp(&a.share));
    let lowest = |heights: &[f64; 2]| heights[0].min(heights[1]);
    let below = heights.iter().filter(|heights| lowest(heights) < -BELOW).count();
    let deepest = heights.iter().map(lowest).fold(0.0_f64, f64::min);
    let feet = found.feet.filter(|feet| feet.contact_frames > 0);
    let share = |part: usize, whole: usize| part as f64 / whole.max(1) as f64;
    let share_below_floor = share(below, frames);
    let share_too_fast = share(too_fast, samples);
    let source_skate = feet.map(|feet| feet.source.skate);
    let slides = skate
        .zip(source_skate)
        .is_some_and(|(skate, source)| skate > source + MORE_SKATE);
    let verdict = match found.mean_degrees {
        mean if mean > FAIR_DEGREES || found.limbs.is_empty() => Verdict::Poor,
        mean if mean > GOOD_DEGREES || slides || share_below_floor > MOST_BELOW || share_too_fast > 0.0 => {
            Verdict::Fair
        }
        _ => Verdict::Good,
    };
    RobotReport {
        clip: motion.name.clone(),
        frames,
        fps: motion.fps,
        scale: found.scale,
        mean_degrees: found.mean_degrees,
        limbs: found.limbs,
        clamped,
        limit_violations,
        skate,
        source_skate,
        share_below_floor,
        deepest: -deepest,
        share_in_self_collision: collisions.share,
        self_collisions: collisions.links,
        max_velocity,
        fastest_joint,
        share_too_fast,
        max_acceleration,
        verdict,
    }
}
