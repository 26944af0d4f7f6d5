//! The playback speed of a motion on a robot: as slow as the limits of the joints need.

use std::fmt;
use std::str::FromStr;

use mocap_edit::{Step, StepInput, Warp};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::options::as_text;
use mocap_scene::scene::robot::Robot;
use mocap_scene::scene::{Animation, Scene};

use super::feasibility::Feasibility;
use super::kinematics::Kinematics;
use super::motion::RobotMotion;
use super::solver::Bounds;
use super::speed::{velocities, within_steps};
use super::verdict::OVER_EFFORT_OF_GOOD;

/// The playback speed of a motion on a robot. The frame rate does not change: the path is resampled.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::Importer;
/// use mocap::retarget::robot::report::TimeScale;
/// use mocap::retarget::robot::{RobotOptions, RobotRetargeter};
///
/// let robot = Importer::new().import_robot("fixtures/robots/h1.urdf")?;
/// let walk = mocap::import("fixtures/real/cmu_short.bvh")?;
/// let options = RobotOptions::new().time_scale(TimeScale::Factor(0.5));
/// let (motion, report) = RobotRetargeter::new(&walk, &robot, &options)?.clip(&walk, 0)?;
/// assert_eq!(motion.frames(), 2 * walk.animations[0].frame_count() - 1);
/// assert_eq!(report.time_scale, 0.5);
/// assert_eq!("auto".parse(), Ok(TimeScale::Auto));
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum TimeScale {
    /// As fast as the velocity limits of the robot's file allow, but not faster than the source. If the torques then
    /// exceed the effort limits of the file, a lower speed is chosen, but only if it brings the torques within these
    /// limits.
    Auto,
    /// The speed of the source times this factor. The default is 1.
    Factor(f64),
}

impl Default for TimeScale {
    fn default() -> Self {
        Self::Factor(1.0)
    }
}

as_text!(TimeScale);

impl FromStr for TimeScale {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let factor = text.parse().ok().filter(|factor| is_factor(*factor));
        match (text, factor) {
            ("auto", _) => Ok(Self::Auto),
            (_, Some(factor)) => Ok(Self::Factor(factor)),
            _ => Err("expected auto or a factor above 0".to_owned()),
        }
    }
}

impl fmt::Display for TimeScale {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Auto => f.write_str("auto"),
            Self::Factor(factor) => factor.fmt(f),
        }
    }
}

fn is_factor(factor: f64) -> bool {
    factor.is_finite() && factor > 0.0
}

/// The lowest speed that `auto` chooses, as a fraction of the source's speed. With this speed, a walk takes twenty
/// times as long. The slowest robots need 0.08. If a motion needs less than this constant, the cause is an error in a
/// file or a spike.
const SLOWEST: f64 = 0.05;

/// The lowest speed that `auto` chooses for efforts, as a fraction of the source's speed. At this speed, the forces of
/// inertia are a sixteenth of those at full speed. The remaining load is the weight, which does not decrease with the
/// speed.
const SLOWEST_FOR_EFFORTS: f64 = 0.25;

/// The number of halvings in the search for the speed that efforts allow. The last step is 1 % of the speed.
const HALVINGS: usize = 6;

/// The largest relative excess of a velocity over its limit that is rounding, as a fraction.
const ROUNDING: f64 = 1e-9;

/// The used fraction of a velocity limit in a slower motion. The rest is the rounding of files with 32-bit numbers.
const WITHIN: f64 = 1.0 - 1e-4;

impl TimeScale {
    #[cfg(feature = "schema")]
    const TAKES: &str = "auto (as slow as the limits of the robot need), or a factor of the speed above 0";

    /// # Errors
    /// [`Code::InvalidValue`] for a factor that is not above 0, and for `auto` if the file of the robot has no limits.
    pub(super) fn check(self, robot: &Robot) -> Result<()> {
        let mut joints = robot.moving_joints().into_iter().map(|link| &robot.links[link].joint);
        let has_limit = joints.any(|joint| joint.limits.velocity.or(joint.limits.effort).is_some());
        let message = match self {
            Self::Factor(factor) if !is_factor(factor) => format!("{{time-scale}} must be above 0, got {factor}"),
            Self::Auto if !has_limit => format!(
                "{{time-scale}} auto needs limits of velocity or effort, and the file of {} has none",
                robot.name
            ),
            _ => return Ok(()),
        };
        Err(Diagnostic::new(Code::InvalidValue, message)
            .help("state a factor of the speed, such as 0.8")
            .into())
    }

    /// The factor of velocities while the path is solved; 0 if velocities have no limit.
    pub(super) fn while_solved(self) -> f64 {
        match self {
            Self::Auto => 0.0,
            Self::Factor(factor) => factor,
        }
    }

    /// The motion at this speed; `None` if it is the speed of the source. `dynamics` finds the torques of a motion.
    /// `auto` lets the positions in `ends` lag behind instead of slowing the motion down for them.
    ///
    /// # Errors
    /// [`Code::LimitExceeded`] if the motion would become too long. [`Code::InvalidValue`] if the motion would have
    /// only one frame.
    pub(super) fn apply(
        self,
        kinematics: &Kinematics,
        (source, index): (&Scene, usize),
        motion: &RobotMotion,
        ends: &[usize],
        dynamics: &dyn Fn(&RobotMotion) -> Option<Feasibility>,
    ) -> Result<Option<ScaledMotion>> {
        if self == Self::Factor(1.0) {
            return Ok(None);
        }
        let excesses = excesses(kinematics, motion);
        let mut lagging = Vec::new();
        let (speed, joint) = match self {
            Self::Factor(factor) => {
                let most = motion.frames().saturating_sub(1);
                if most > 0 && factor > most as f64 {
                    let message = format!("{{time-scale}} {factor} leaves one of {} frames", motion.frames());
                    return Err(Diagnostic::new(Code::InvalidValue, message)
                        .help(format!("choose a factor of at most {most}"))
                        .into());
                }
                (factor, None)
            }
            Self::Auto => {
                let (speed, joint) = slow_enough(kinematics, (motion, &excesses), ends, dynamics)?;
                let too_fast = ends.iter().filter(|end| speed * excesses[**end] > 1.0 + ROUNDING);
                lagging.extend(too_fast.copied());
                if joint.is_none() && lagging.is_empty() {
                    return Ok(None);
                }
                (speed, joint)
            }
        };
        Ok(Some(ScaledMotion {
            source: scaled_source(source, index, speed)?,
            motion: resampled(kinematics, (motion, &excesses), speed, &lagging),
            speed,
            joint,
            lagging: lagging.into_iter().map(|end| motion.dof_names[end].clone()).collect(),
        }))
    }
}

/// A motion at another speed.
pub(super) struct ScaledMotion {
    /// The source, of which only the animation of the motion remains, at its index.
    pub(super) source: Scene,
    pub(super) motion: RobotMotion,
    /// The factor of the speed.
    pub(super) speed: f64,
    /// The joint that needs this speed.
    pub(super) joint: Option<String>,
    /// The joints that lag behind at this speed.
    pub(super) lagging: Vec<String>,
}

/// The highest speed at which the joints keep the limits of the robot, without the joints `ends`. Also the joint that
/// needs this speed; `None` if the speed of the source is low enough.
///
/// # Errors
/// [`Code::LimitExceeded`] for a speed below [`SLOWEST`].
fn slow_enough(
    kinematics: &Kinematics,
    (motion, excesses): (&RobotMotion, &[f64]),
    ends: &[usize],
    dynamics: &dyn Fn(&RobotMotion) -> Option<Feasibility>,
) -> Result<(f64, Option<String>)> {
    let positions = (0..excesses.len()).filter(|position| !ends.contains(position));
    let fastest = positions.max_by(|a, b| excesses[*a].total_cmp(&excesses[*b]));
    let (mut speed, mut joint) = (1.0, None);
    if let Some(fastest) = fastest.filter(|fastest| excesses[*fastest] > 1.0 + ROUNDING) {
        speed = WITHIN / excesses[fastest];
        let name = &motion.dof_names[fastest];
        if speed < SLOWEST {
            let message = format!(
                "{name} needs {{time-scale}} {}, and auto stops at {SLOWEST}",
                three_digits(speed)
            );
            return Err(Diagnostic::new(Code::LimitExceeded, message)
                .help("state this factor of the speed, or choose a slower motion")
                .into());
        }
        joint = Some(name.clone());
    }
    let overloaded = |speed: f64| {
        let found = dynamics(&resampled(kinematics, (motion, excesses), speed, ends))?;
        (found.fraction_over_effort? > OVER_EFFORT_OF_GOOD).then_some(found.most_loaded_joint)
    };
    if speed > SLOWEST_FOR_EFFORTS
        && let Some(loaded) = overloaded(speed)
        && overloaded(SLOWEST_FOR_EFFORTS).is_none()
    {
        let (mut low, mut high) = (SLOWEST_FOR_EFFORTS, speed);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            match overloaded(middle) {
                Some(_) => high = middle,
                None => low = middle,
            }
        }
        (speed, joint) = (low, Some(loaded));
    }
    Ok((speed, joint))
}

/// A speed with three significant digits, rounded down.
fn three_digits(speed: f64) -> f64 {
    let unit = 10_f64.powf(2.0 - speed.log10().floor());
    (speed * unit).floor() / unit
}

/// The largest velocity of each position, as a multiple of its limit.
fn excesses(kinematics: &Kinematics, motion: &RobotMotion) -> Vec<f64> {
    let mut largest = vec![0.0; motion.dof_names.len()];
    let limits = velocities(kinematics);
    for frame in 1..motion.frames() {
        let steps = std::iter::zip(motion.dof_of(frame - 1), motion.dof_of(frame));
        for ((largest, limit), (from, to)) in largest.iter_mut().zip(&limits).zip(steps) {
            *largest = f64::max(*largest, (to - from).abs() * motion.fps / limit);
        }
    }
    largest
}

/// Plays a motion at `speed` times its speed. If the velocity of a joint is within its limit at this speed, the steps
/// between the new frames are within the limit too. The steps of positions in `lagging` are within their limits too.
fn resampled(
    kinematics: &Kinematics,
    (motion, excesses): (&RobotMotion, &[f64]),
    speed: f64,
    lagging: &[usize],
) -> RobotMotion {
    let mut scaled = motion.at_speed(speed);
    let (bounds, limits) = (Bounds::of(kinematics), velocities(kinematics));
    let count = scaled.dof_names.len();
    for (position, excess) in excesses.iter().enumerate() {
        let values = scaled.dof_pos.iter().skip(position).step_by(count);
        let within = |value: &f64| value.max(bounds.lower[position]).min(bounds.upper[position]);
        let mut values: Vec<f64> = values.map(within).collect();
        let is_lagging = lagging.contains(&position);
        if is_lagging || excess * speed <= 1.0 + ROUNDING {
            let used = if is_lagging { WITHIN } else { 1.0 - ROUNDING };
            within_steps(&mut values, |_| used * limits[position] / motion.fps);
        }
        for (at, value) in scaled.dof_pos.iter_mut().skip(position).step_by(count).zip(values) {
            *at = value;
        }
    }
    // Joints that follow others.
    let mut pose = kinematics.rest();
    for frame in 0..scaled.frames() {
        scaled.set(frame, kinematics, &mut pose);
        scaled.dof_pos[frame * count..(frame + 1) * count].copy_from_slice(&pose.positions);
    }
    scaled
}

/// A source with one animation at another speed. Only its skeleton, its metadata and this animation remain.
fn scaled_source(source: &Scene, index: usize, speed: f64) -> Result<Scene> {
    let mut animations = vec![Animation::default(); index];
    animations.push(source.animations[index].clone());
    let mut scaled = Scene {
        nodes: source.nodes.clone(),
        animations,
        metadata: source.metadata.clone(),
        ..Scene::default()
    };
    Warp::Speed(speed).apply(&mut scaled, &StepInput::new().animation(index))?;
    Ok(scaled)
}
