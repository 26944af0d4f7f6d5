//! The quality of a motion on a robot.

use std::fmt;

use mocap_scene::error::spelled;
use mocap_scene::scene::robot::Robot;
use serde::{Deserialize, Serialize};

use super::collision::{LinkCollision, SelfCollision};
use super::feasibility::Feasibility;
use super::motion::RobotMotion;
use super::scores::{BEYOND, RobotScores, beyond_limit};
use super::verdict::{Criterion, INFEASIBLE, Measures, OVER_EFFORT};
use crate::quality::Verdict;
use crate::quality::{LimbError, RetargetReport};

/// The depth below the floor that counts, in metres.
const BELOW: f64 = 0.01;

/// The largest distance from a limit at which a joint is at the limit, in radians or metres.
const AT_LIMIT: f64 = 1e-9;

/// The largest relative excess of a velocity over its limit that is rounding, as a fraction.
const ROUNDING: f64 = 1e-9;

/// The height of a sole above which a foot in stance floats, in metres.
const FLOATS: f64 = 0.05;

/// The fraction of floating frames above which a report suggests a remedy: the limit of a good motion.
const OFTEN_FLOATING: f64 = 0.02;

/// The smallest number of percent that is printed. A smaller fraction would be rounded to 0 %.
const LEAST_PERCENT: f64 = 0.5;

/// A joint that would exceed its limit.
///
/// The [module](crate::robot) has an example.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ClampedJoint {
    /// The name of the joint.
    pub joint: String,
    /// The fraction of frames in which the joint is at its limit.
    pub fraction: f64,
}

/// The quality of a motion on a robot.
///
/// The [module](crate::robot) has an example.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct RobotReport {
    /// The name of the motion.
    pub clip: String,
    /// The number of frames.
    pub frames: usize,
    /// Frames per second.
    pub fps: f64,
    /// The scale of the robot's root motion, in metres per metre of the source.
    pub scale: f64,
    /// The playback speed, as a factor of the speed of the source.
    pub time_scale: f64,
    /// The joint whose limit of velocity or effort makes `time_scale` smaller than 1; absent if no joint slows the
    /// motion.
    pub slowed_by: Option<String>,
    /// The joints of the head and the hands that are too slow for the motion at the speed `time_scale`, and lag behind.
    pub lagging: Vec<String>,
    /// Arms and legs: the angles between their directions on source and robot.
    pub limbs: Vec<LimbError>,
    /// The mean angle of all limbs and frames, in degrees.
    pub mean_degrees: f64,
    /// The joints that are at a limit, with the fraction of frames.
    pub clamped: Vec<ClampedJoint>,
    /// The number of positions beyond a limit: 0 in every motion that mocap writes.
    pub limit_violations: usize,
    /// The mean sliding speed of the slowest point of a sole while the foot of the source is in contact, in metres per
    /// second. Absent without contacts.
    pub skate: Option<f64>,
    /// The mean sliding speed of the source's feet in contact, measured at the points of the robot's soles, in metres
    /// per second.
    pub source_skate: Option<f64>,
    /// Of the steps between frames with a foot of the source in the air, the fraction in which the robot's sole scrapes
    /// the floor. A sole scrapes if its lowest point is within 5 mm of the floor and faster than 0.3 m/s. Absent
    /// without feet in the air.
    pub fraction_scraping: Option<f64>,
    /// The fraction of frames in which a sole or another link is more than 1 cm below the floor. Links are capsules
    /// within their shapes.
    pub fraction_below_floor: f64,
    /// The largest depth of a sole or another link below the floor, in metres.
    pub deepest: f64,
    /// The fraction of frames in which two links of the robot penetrate each other by more than 1 cm. Links are
    /// capsules within their shapes.
    pub fraction_in_self_collision: f64,
    /// The links that collide, the deepest first.
    pub self_collisions: Vec<LinkCollision>,
    /// The largest velocity of a joint, in radians or metres per second.
    pub max_velocity: f64,
    /// The joint with the largest velocity.
    pub fastest_joint: String,
    /// The fraction of samples in which a joint is faster than the robot's file allows.
    pub fraction_too_fast: f64,
    /// The largest acceleration of a joint, in radians or metres per second squared.
    pub max_acceleration: f64,
    /// The mean roll of thighs and upper arms relative to the source, in degrees. The roll decides the direction in
    /// which knees and elbows bend.
    pub roll_degrees: Option<f64>,
    /// The larger mean angle between source and robot, in degrees: of the line through the hips, or of the line through
    /// the shoulders.
    pub trunk_degrees: Option<f64>,
    /// The fraction of frames after which a joint jumps. A joint jumps if it moves by more than 0.5 rad in 1/30 s,
    /// while the limb of the source rotates by less than half as much.
    pub fraction_of_jumps: f64,
    /// Of the frames in which a foot of the source is in contact, the fraction with the sole more than 5 cm above the
    /// floor. It is 1 if no foot is in contact and the soles always stay higher than 5 cm.
    pub fraction_floating: Option<f64>,
    /// The fraction of frames in which the hips of the source lie. A large fraction may mean a wrong up axis of the
    /// file.
    pub fraction_lying: f64,
    /// The number of solver passes of the motion; 0 for a motion that was only judged. mocap keeps only the first pass
    /// if the second pass would worsen the directions of limbs or the sliding of feet.
    pub passes: u8,
    /// The guessed parts: parts of the robot that its file does not show, and bones of the source whose roll is not
    /// determined.
    pub guessed: Vec<String>,
    /// The parts of the motion that a robot without legs does not perform.
    pub left_out: Vec<String>,
    /// Whether the robot can perform the motion; absent without masses in the robot's file, or with fewer than three
    /// frames.
    pub dynamics: Option<Feasibility>,
    /// The measures of publications; absent for a stream, and for a robot without two legs.
    pub scores: Option<RobotScores>,
    /// The criteria of the verdict, each with its limits. The worst criterion decides.
    pub criteria: Vec<Criterion>,
    /// Whether the motion is good enough to use unchanged: the worst of `criteria`; poor if no limb could be compared.
    pub verdict: Verdict,
}

/// The largest increase of the limbs' mean angle by the second pass, in degrees, as the cost of smoothness.
const FARTHER: f64 = 2.0;

/// The largest increase of the soles' sliding speed by the second pass, in metres per second.
const FASTER: f64 = 0.05;

impl RobotReport {
    /// The reasons why the verdict is not good, the worst first.
    pub(crate) fn reasons(&self) -> Vec<String> {
        let of = |verdict: Verdict| {
            let criteria = self.criteria.iter().filter(move |found| found.verdict == verdict);
            criteria.map(Criterion::finding)
        };
        let is_poor_by_one = of(Verdict::Poor).next().is_some();
        let uncompared = (self.verdict == Verdict::Poor && !is_poor_by_one)
            .then(|| "no limb of both bodies could be compared".to_owned());
        uncompared
            .into_iter()
            .chain(of(Verdict::Poor))
            .chain(of(Verdict::Fair))
            .collect()
    }

    /// The reason why the robot may not be able to perform the motion; `None` if its masses allow the motion.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::Importer;
    /// use mocap::retarget::robot::{RobotOptions, RobotRetargeter};
    ///
    /// let robot = Importer::new().import_robot("fixtures/robots/h1.urdf")?;
    /// let walk = mocap::import("fixtures/real/cmu_short.bvh")?;
    /// let (_, report) = RobotRetargeter::new(&walk, &robot, &RobotOptions::default())?.clip(&walk, 0)?;
    /// let is_feasible = report.dynamics.as_ref().unwrap().fraction_feasible >= 0.95;
    /// assert_eq!(report.why_infeasible().is_none(), is_feasible);
    /// # Ok::<(), mocap::Error>(())
    /// ```
    pub fn why_infeasible(&self) -> Option<String> {
        let Some(dynamics) = &self.dynamics else {
            return Some(
                "not known to be feasible, because inverse dynamics needs masses and at least three frames".to_owned(),
            );
        };
        let is_good = |name: &str| {
            let found = self.criteria.iter().find(|criterion| criterion.name == name);
            found.is_none_or(|criterion| criterion.verdict == Verdict::Good)
        };
        if !is_good(INFEASIBLE) {
            let cause = dynamics
                .main_cause
                .map(|cause| format!(" ({cause})"))
                .unwrap_or_default();
            let share = percent(1.0 - dynamics.fraction_feasible);
            return Some(format!("not feasible in {share} of frames{cause}"));
        }
        (!is_good(OVER_EFFORT)).then(|| {
            let (joint, most) = (&dynamics.most_loaded_joint, dynamics.max_effort);
            format!("the torque of {joint} is {most:.1} times its effort limit")
        })
    }

    /// Whether no joint exceeds its velocity or jumps more often than in `other`, and links do not collide more often.
    pub(super) fn keeps_limits_as(&self, other: &Self) -> bool {
        let broken = |report: &Self| {
            [
                report.fraction_too_fast,
                report.fraction_of_jumps,
                report.fraction_in_self_collision,
            ]
        };
        std::iter::zip(broken(self), broken(other)).all(|(own, other)| own <= other)
    }

    /// Whether limbs or feet are clearly farther from the source's limbs or feet than in `other`.
    pub(super) fn is_worse_than(&self, other: &Self) -> bool {
        let slide = |report: &Self| report.skate.unwrap_or(0.0);
        self.mean_degrees > other.mean_degrees + FARTHER || slide(self) > slide(other) + FASTER
    }
}

impl fmt::Display for RobotReport {
    /// A line for each finding, after the name of the clip.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (clip, verdict) = (&self.clip, self.verdict.as_str());
        let (mean, frames, scale) = (self.mean_degrees, self.frames, self.scale);
        let infeasible = self.why_infeasible().filter(|_| self.dynamics.is_some());
        let infeasible = infeasible.map(|why| format!(", {why}")).unwrap_or_default();
        write!(
            f,
            "{clip}: {verdict}{infeasible}: mean limb error {mean:.1} degrees over {frames} frames; path scaled by \
             {scale:.3}"
        )?;
        if self.time_scale != 1.0 {
            let because = self.slowed_by.as_ref().map(|joint| format!(" because of {joint}"));
            let because = because.unwrap_or_default();
            let changed = if self.time_scale < 1.0 { "slowed" } else { "sped up" };
            write!(f, "\n{clip}: {changed} to {:.3} of its speed{because}", self.time_scale)?;
        }
        if !self.lagging.is_empty() {
            write!(
                f,
                "\n{clip}: slower than the motion, and lagging: {}",
                self.lagging.join(", ")
            )?;
        }
        let of = |is_worst: bool| {
            let not_good = self.criteria.iter().filter(|found| found.verdict != Verdict::Good);
            not_good.filter(move |found| (found.verdict == self.verdict) == is_worst)
        };
        for criterion in of(true) {
            write!(f, "\n{clip}: {verdict} because {}", criterion.finding())?;
        }
        for criterion in of(false) {
            write!(f, "\n{clip}: also, {}", criterion.finding())?;
        }
        if self.fraction_floating.is_some_and(|floating| floating > OFTEN_FLOATING) {
            write!(
                f,
                "\n{clip}: soles are above the floor while feet of the source are in contact: the survey shows \
                 whether the source floats, and the step ground puts the source on the floor"
            )?;
        }
        for part in &self.guessed {
            write!(f, "\n{clip}: guessed: {part}")?;
        }
        for limb in self.limbs.iter().filter(|limb| limb.mean_degrees > 5.0) {
            let (bone, mean, most) = (limb.bone.as_str(), limb.mean_degrees, limb.max_degrees);
            write!(f, "\n{clip}: {bone}: mean error {mean:.1} degrees, {most:.1} at most")?;
        }
        let clamped = self.clamped.iter().filter(|joint| joint.fraction >= 0.01);
        let clamped: Vec<String> = clamped
            .map(|joint| format!("{} in {}", joint.joint, percent(joint.fraction)))
            .collect();
        if !clamped.is_empty() {
            write!(f, "\n{clip}: at a limit: {} of frames", clamped.join(", "))?;
        }
        if let (Some(skate), Some(source)) = (self.skate, self.source_skate) {
            write!(
                f,
                "\n{clip}: feet on the ground slide at {:.1} cm/s on average, feet of the source at {:.1}; links are \
                 at most {:.1} mm below the floor",
                100.0 * skate,
                100.0 * source,
                1000.0 * self.deepest.max(0.0)
            )?;
        }
        if let Some(pair) = self.self_collisions.first() {
            let (share, centimetres) = (percent(self.fraction_in_self_collision), 100.0 * pair.deepest);
            let (link, other) = (&pair.link, &pair.other);
            write!(
                f,
                "\n{clip}: links of the robot collide in {share} of frames, deepest {link} and {other}: \
                 {centimetres:.1} cm"
            )?;
        }
        if self.fraction_too_fast > 0.0 {
            let (percent, help) = (
                100.0 * self.fraction_too_fast,
                spelled("{velocity-limits} limits their velocities, and {time-scale} auto slows the motion"),
            );
            write!(
                f,
                "\n{clip}: joints are faster than the file of the robot allows in {percent:.2} % of samples; {help}"
            )?;
        }
        let (joint, most) = (&self.fastest_joint, self.max_velocity);
        write!(f, "\n{clip}: the fastest joint is {joint}, at {most:.1} rad/s")
    }
}

/// A fraction as text, which is 0 % only if the fraction is 0.
fn percent(fraction: f64) -> String {
    match 100.0 * fraction {
        percent if percent > 0.0 && percent < LEAST_PERCENT => format!("less than {LEAST_PERCENT} %"),
        percent if percent < 100.0 && percent > 100.0 - LEAST_PERCENT => format!("{percent:.1} %"),
        percent => format!("{percent:.0} %"),
    }
}

/// The parts of the motion that a robot with a fixed base or wheels does not perform.
const WITHOUT_LEGS: [&str; 3] = ["legs", "the path over the floor", "turns of the whole body"];

/// The measures of a motion, except the measures of its joints.
pub(super) struct ObservedFrames {
    /// The bones of the robot, compared with the bones of the source.
    pub(super) found: RetargetReport,
    /// The speed of soles in contact.
    pub(super) skate: Option<f64>,
    /// The speed of the source's feet in contact.
    pub(super) source_skate: Option<f64>,
    /// The fraction of steps in the air that scrape the floor.
    pub(super) scraping: Option<f64>,
    /// The height of the lowest sole in each frame.
    pub(super) lowest: Vec<f64>,
    /// The heights of soles while the foot of the source is in contact.
    pub(super) standing: Vec<f64>,
    /// The depth of the deepest link below the floor in each frame.
    pub(super) depths: Vec<f64>,
    pub(super) collisions: SelfCollision,
    pub(super) roll: Option<f64>,
    pub(super) lying: f64,
    /// The angle of the hips' or the shoulders' line.
    pub(super) trunk: Option<f64>,
    pub(super) jumps: f64,
    pub(super) unmeasured_limbs: usize,
    pub(super) guessed: Vec<String>,
    pub(super) dynamics: Option<Feasibility>,
    /// Whether the robot has legs.
    pub(super) has_legs: bool,
}

/// The report of a motion.
pub(super) fn report(robot: &Robot, motion: &RobotMotion, seen: ObservedFrames) -> RobotReport {
    let joints = Joints::new(robot, motion);
    let frames = motion.frames();
    let soles = seen.lowest.iter().map(|height| -height);
    let links = seen.depths.iter().copied().chain(std::iter::repeat(0.0));
    let depths: Vec<f64> = soles.zip(links).map(|(sole, link)| sole.max(link)).collect();
    let below = depths.iter().filter(|depth| **depth > BELOW).count();
    let fraction_below_floor = below as f64 / frames.max(1) as f64;
    let source_skate = seen.source_skate;
    let fraction_floating = floating(&seen.standing, &seen.lowest).filter(|_| seen.has_legs);
    let limbs = &seen.found.limbs;
    let measures = Measures {
        mean_degrees: (!limbs.is_empty()).then_some(seen.found.mean_degrees),
        worst_limb_degrees: limbs.iter().map(|limb| limb.mean_degrees).reduce(f64::max),
        roll_degrees: seen.roll,
        trunk_degrees: seen.trunk,
        jumps: seen.jumps,
        floating: fraction_floating,
        below_floor: fraction_below_floor,
        scraping: seen.scraping,
        more_slide: seen.skate.zip(source_skate).map(|(skate, source)| skate - source),
        lying: seen.lying,
        self_collision: seen.collisions.fraction,
        too_fast: joints.fraction_too_fast,
        beyond_limits: joints.fraction_beyond,
        infeasible: seen.dynamics.as_ref().map(|found| 1.0 - found.fraction_feasible),
        over_effort: seen.dynamics.as_ref().and_then(|found| found.fraction_over_effort),
        unmeasured_limbs: seen.unmeasured_limbs,
        guessed_parts: seen.guessed.len(),
    };
    let (criteria, verdict) = measures.verdict();
    RobotReport {
        clip: motion.name.clone(),
        frames,
        fps: motion.fps,
        scale: seen.found.scale,
        time_scale: 1.0,
        slowed_by: None,
        lagging: Vec::new(),
        mean_degrees: seen.found.mean_degrees,
        limbs: seen.found.limbs,
        clamped: joints.clamped,
        limit_violations: joints.limit_violations,
        skate: seen.skate,
        source_skate,
        fraction_scraping: seen.scraping,
        fraction_below_floor,
        deepest: depths.into_iter().fold(0.0, f64::max),
        fraction_in_self_collision: seen.collisions.fraction,
        self_collisions: seen.collisions.links,
        max_velocity: joints.max_velocity,
        fastest_joint: joints.fastest_joint,
        fraction_too_fast: joints.fraction_too_fast,
        max_acceleration: joints.max_acceleration,
        roll_degrees: seen.roll,
        trunk_degrees: seen.trunk,
        fraction_of_jumps: seen.jumps,
        fraction_floating,
        fraction_lying: seen.lying,
        passes: 1,
        guessed: seen.guessed,
        left_out: match seen.has_legs {
            true => Vec::new(),
            false => WITHOUT_LEGS.map(str::to_owned).to_vec(),
        },
        dynamics: seen.dynamics,
        scores: None,
        criteria,
        verdict,
    }
}

/// Of the frames in which a foot of the source is in contact, the fraction in which its sole floats.
fn floating(standing: &[f64], lowest: &[f64]) -> Option<f64> {
    if standing.is_empty() {
        let lowest = lowest.iter().copied().fold(f64::INFINITY, f64::min);
        return (lowest.is_finite() && lowest > FLOATS).then_some(1.0);
    }
    let floating = standing.iter().filter(|height| **height > FLOATS).count();
    Some(floating as f64 / standing.len() as f64)
}

/// The measures of a motion's joints.
#[derive(Default)]
struct Joints {
    clamped: Vec<ClampedJoint>,
    limit_violations: usize,
    /// The fraction of positions that exceed a limit by more than the rounding of files.
    fraction_beyond: f64,
    max_velocity: f64,
    fastest_joint: String,
    fraction_too_fast: f64,
    max_acceleration: f64,
}

impl Joints {
    fn new(robot: &Robot, motion: &RobotMotion) -> Self {
        let joints = robot.moving_joints();
        let (frames, count) = (motion.frames(), joints.len());
        let mut all = Self::default();
        let (mut too_fast, mut samples, mut beyond) = (0_usize, 0_usize, 0_usize);
        for (dof, &link) in joints.iter().enumerate() {
            let joint = &robot.links[link].joint;
            let limits = &joint.limits;
            let at = |frame: usize| motion.dof_pos[frame * count + dof];
            let (mut held, mut moved) = (0_usize, false);
            for frame in 0..frames {
                let here = at(frame);
                moved |= here != at(0);
                all.limit_violations += usize::from(!(limits.lower..=limits.upper).contains(&here));
                beyond += usize::from(beyond_limit(limits, here) > BEYOND);
                held += usize::from(here - limits.lower <= AT_LIMIT || limits.upper - here <= AT_LIMIT);
                if frame == 0 {
                    continue;
                }
                let velocity = (here - at(frame - 1)) * motion.fps;
                samples += 1;
                too_fast += usize::from(
                    limits
                        .velocity
                        .is_some_and(|most| velocity.abs() > most * (1.0 + ROUNDING)),
                );
                if velocity.abs() > all.max_velocity {
                    all.max_velocity = velocity.abs();
                    all.fastest_joint.clone_from(&joint.name);
                }
                if frame > 1 {
                    let change = (here - 2.0 * at(frame - 1) + at(frame - 2)) * motion.fps * motion.fps;
                    all.max_acceleration = all.max_acceleration.max(change.abs());
                }
            }
            if held > 0 && (moved || frames == 1) {
                all.clamped.push(ClampedJoint {
                    joint: joint.name.clone(),
                    fraction: held as f64 / frames as f64,
                });
            }
        }
        all.clamped.sort_by(|a, b| b.fraction.total_cmp(&a.fraction));
        all.fraction_beyond = beyond as f64 / motion.dof_pos.len().max(1) as f64;
        all.fraction_too_fast = too_fast as f64 / samples.max(1) as f64;
        all
    }
}
