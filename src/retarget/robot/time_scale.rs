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
    /// As fast as the velocities of the robot's file allow, but not faster than the source. Slower if the torques are
    /// then within the efforts of the file.
    Auto,
    /// This factor of the speed of the source. The default is 1.
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

/// The lowest speed that `auto` chooses, as a fraction of the source's speed. The report shows the joints that would
/// need a lower speed.
const SLOWEST: f64 = 0.1;

/// The lowest speed that `auto` chooses for efforts, as a fraction of the source's speed. Forces of inertia are then a
/// sixteenth, and slower does not help.
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
    ///
    /// # Errors
    /// [`Code::LimitExceeded`] if the motion would be far longer.
    pub(super) fn apply(
        self,
        kinematics: &Kinematics,
        (source, index): (&Scene, usize),
        motion: &RobotMotion,
        dynamics: &dyn Fn(&RobotMotion) -> Option<Feasibility>,
    ) -> Result<Option<ScaledMotion>> {
        let (speed, joint) = match self {
            Self::Factor(1.0) => return Ok(None),
            Self::Factor(factor) => (factor, None),
            Self::Auto => match slow_enough(kinematics, motion, dynamics) {
                Some((speed, joint)) => (speed, Some(joint)),
                None => return Ok(None),
            },
        };
        Ok(Some(ScaledMotion {
            source: scaled_source(source, index, speed)?,
            motion: resampled(kinematics, motion, speed),
            speed,
            joint,
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
}

/// The highest speed within the limits of the robot, and the joint that needs it; `None` for the speed of the source.
fn slow_enough(
    kinematics: &Kinematics,
    motion: &RobotMotion,
    dynamics: &dyn Fn(&RobotMotion) -> Option<Feasibility>,
) -> Option<(f64, String)> {
    let excesses = excesses(kinematics, motion);
    let fastest = (0..excesses.len()).max_by(|a, b| excesses[*a].total_cmp(&excesses[*b]))?;
    let (mut speed, mut joint) = (1.0, None);
    if excesses[fastest] > 1.0 + ROUNDING {
        speed = (WITHIN / excesses[fastest]).max(SLOWEST);
        joint = Some(motion.dof_names[fastest].clone());
    }
    let overloaded = |speed: f64| {
        let found = dynamics(&resampled(kinematics, motion, speed))?;
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
    Some((speed, joint?))
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
/// between the new frames are within the limit too.
fn resampled(kinematics: &Kinematics, motion: &RobotMotion, speed: f64) -> RobotMotion {
    let mut scaled = motion.at_speed(speed);
    let (bounds, limits) = (Bounds::of(kinematics), velocities(kinematics));
    let count = scaled.dof_names.len();
    for (position, excess) in excesses(kinematics, motion).into_iter().enumerate() {
        let values = scaled.dof_pos.iter().skip(position).step_by(count);
        let within = |value: &f64| value.max(bounds.lower[position]).min(bounds.upper[position]);
        let mut values: Vec<f64> = values.map(within).collect();
        if excess * speed <= 1.0 + ROUNDING {
            within_steps(&mut values, |_| limits[position] / motion.fps);
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
