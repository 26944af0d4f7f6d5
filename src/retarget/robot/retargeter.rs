//! Retargets the motion of a humanoid to a robot.

pub(crate) mod balance;
mod judge;
mod own;
mod slide;
mod soles;
mod stream;

use glam::DQuat;
use mocap_edit::FootLockWeights;
use mocap_edit::report::DetectedContacts;
use mocap_figure::robot_bones::{RobotMap, robot_bones};
use mocap_figure::{Figure, Humanoid};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::options::setters;
use mocap_scene::pose::{Binding, Pose};
use mocap_scene::scene::robot::{Placement, Robot};
use mocap_scene::scene::{Animation, Scene, Side};

use self::balance::Balance;
pub(super) use self::own::own_motion;
pub use self::stream::RobotStream;
use super::branches::{Branches, Free};
use super::collision::{Collisions, guessed_shapes};
use super::feasibility::feasibility;
use super::fingers::Fingers;
use super::floor::Floor;
use super::following::{FootState, SolverGoals};
use super::kinematics::{Kinematics, RobotPose};
use super::measure::{Measured, standing};
use super::motion::{RobotMotion, rate};
use super::robot_report::{self, ObservedFrames, RobotReport};
use super::solver::{Bounds, Solver};
use super::source_rotations::SourceRotations;
use super::speed::Steps;
use super::swing::{clearances, most_clearance, speeds};
use super::terms::{Goals, Terms};
use super::time_scale::TimeScale;
use super::twin::StandIn;
use super::weights::Weights;
use super::window::{Bound, Windows};
use crate::{PoseRetargeter, Scale};
use mocap_figure::LimbAngles;

/// The options of a [`RobotRetargeter`].
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::Importer;
/// use mocap::figure::HumanoidBone;
/// use mocap::retarget::Scale;
/// use mocap::retarget::robot::{RobotMap, RobotOptions, robot_bones};
///
/// let robot = Importer::new().import_robot("fixtures/robots/h1.urdf")?;
/// let bones = robot_bones(&robot, None)?;
/// let knee = bones.iter().find(|bone| bone.bone == HumanoidBone::LeftLowerLeg).unwrap();
/// assert_eq!(robot.links[knee.link].name, "left_knee_link");
/// // Steps as long as the person's steps, and a torso that does not count as a bone.
/// let map = RobotMap::from([(HumanoidBone::Chest, None)]);
/// let options = RobotOptions::new().scale(Scale::None).map(map).velocity_limits(true);
/// assert!(options.lock_feet);
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct RobotOptions {
    /// The scale of the robot's root motion. Default: the ratio of the leg lengths.
    pub scale: Scale,
    /// The joint of each bone of the source. Default: [`Humanoid::of`](mocap_figure::Humanoid::of) finds the bones.
    pub source: Option<Humanoid>,
    /// The links of bones, if the guess is wrong.
    pub map: RobotMap,
    /// Whether joints also keep within the velocities of the robot's file. Default: `false`.
    pub velocity_limits: bool,
    /// Whether feet are locked to the ground while the source's feet are in contact. Default: `true`.
    pub lock_feet: bool,
    /// The number of solver passes. 1 solves frame by frame. 2 then solves all frames of a window together. Joints then
    /// move smoothly, within the velocities of the robot's file, and without jumps. Default: 2.
    pub passes: u8,
    /// The height of the floor. Default: under the feet in stance.
    pub floor: Floor,
    /// The playback speed. Default: the speed of the source.
    pub time_scale: TimeScale,
    /// The weights of the solver.
    pub weights: Weights,
    /// The weights of the foot lock before the robot follows the feet.
    pub foot_lock: FootLockWeights,
}

impl Default for RobotOptions {
    fn default() -> Self {
        Self {
            scale: Scale::Auto,
            source: None,
            map: RobotMap::new(),
            velocity_limits: false,
            lock_feet: true,
            passes: 2,
            floor: Floor::Auto,
            time_scale: TimeScale::default(),
            weights: Weights::default(),
            foot_lock: FootLockWeights::default(),
        }
    }
}

setters! {
    RobotOptions {
        scale: Scale,
        source: Option<Humanoid>,
        map: RobotMap,
        velocity_limits: bool,
        lock_feet: bool,
        passes: u8,
        floor: Floor,
        time_scale: TimeScale,
        weights: Weights,
        foot_lock: FootLockWeights,
    }
}

/// The number of solver steps for the first frame, which has no previous frame.
pub(super) const FIRST_STEPS: usize = 120;

/// The largest number of solver steps for each further frame, which starts from the previous frame.
pub(super) const STEPS: usize = 8;

/// Retargets the motions of one source to a robot.
///
/// The [module](crate::robot) has an example.
#[derive(Clone, Debug)]
pub struct RobotRetargeter {
    pub(super) robot: Robot,
    pub(super) twin: StandIn,
    pub(super) options: RobotOptions,
    pub(super) source_bones: Humanoid,
    pub(super) retargeter: PoseRetargeter,
    pub(super) kinematics: Kinematics,
    pub(super) collisions: Collisions,
    solver: Solver,
    pub(super) following: SolverGoals,
    pub(super) branches: Branches,
    pub(super) fingers: Fingers,
    pub(super) windows: Windows,
    /// The heading of the source in each frame, for a robot with a fixed base.
    pub(super) headings: Vec<DQuat>,
}

impl RobotRetargeter {
    /// Prepares to retarget motions of the skeleton of `source` to `robot`. The animations of `source` show the height
    /// of its floor.
    ///
    /// # Errors
    /// [`Code::NotHumanoid`] if the source or the robot is not a humanoid. [`Code::InvalidValue`] for a weight that is
    /// out of its range, and for a time scale that the robot cannot have.
    pub fn new(source: &Scene, robot: &Robot, options: &RobotOptions) -> Result<Self> {
        let weights = &options.weights;
        weights.check()?;
        options.time_scale.check(robot)?;
        let bones = robot_bones(robot, Some(&options.map))?;
        let twin = StandIn::new(robot, &bones)?;
        let bones = options.source.clone().unwrap_or_else(|| Humanoid::of(source));
        let figure = Figure::with_bones(source, bones.clone());
        let retargeter =
            PoseRetargeter::with_figures((source, figure), (&twin.scene, twin.figure.clone()), options.scale)?;
        let retargeter = retargeter.with_foot_lock(options.foot_lock);
        let kinematics = Kinematics::new(robot);
        let following = SolverGoals::new(robot, &kinematics, &twin, weights);
        let terms = Terms::new(&kinematics, &following.goals);
        Ok(Self {
            branches: Branches::new(&kinematics, &twin, weights),
            fingers: Fingers::new(robot, &kinematics, &twin, source, &bones),
            windows: Windows::new(terms.clone(), weights),
            solver: Solver::new(terms, weights.hold),
            collisions: Collisions::new(robot, &kinematics),
            robot: robot.clone(),
            options: options.clone(),
            source_bones: bones,
            twin,
            retargeter,
            kinematics,
            following,
            headings: Vec::new(),
        })
    }

    /// Retargets an animation of `source`, by its index, to the robot, and reports its quality.
    ///
    /// # Errors
    /// [`Code::NoMotion`] if there is no such animation. [`Code::LimitExceeded`] if the time scale makes the motion far
    /// longer.
    pub fn clip(&mut self, source: &Scene, index: usize) -> Result<(RobotMotion, RobotReport)> {
        let (motion, report, _) = self.scaled_clip(source, index)?;
        Ok((motion, report))
    }

    fn animation_of(source: &Scene, index: usize) -> Result<&Animation> {
        source.animations.get(index).ok_or_else(|| {
            let message = format!(
                "there is no animation {index}: the source has {}",
                source.animations.len()
            );
            Diagnostic::new(Code::NoMotion, message).into()
        })
    }

    fn solved(&mut self, source: &Scene, index: usize) -> Result<(RobotMotion, RobotReport)> {
        let animation = Self::animation_of(source, index)?;
        let moved = self.retargeter.animation(source, animation);
        let mut held = moved;
        if self.options.lock_feet && self.twin.has_legs {
            self.retargeter.lock_feet(source, index, &self.twin.scene, &mut held)?;
        }
        let contacts = self.contacts_of(source, animation);
        let mut goals = Vec::new();
        let mut motion = self.follow(&held, animation, contacts, &mut goals);
        if let Some(mut given) = self.own_motion(source, animation) {
            given.contacts = motion.contacts;
            let rotations = SourceRotations::new(source, animation, &self.source_bones);
            let steps = Steps::new(&self.kinematics, &self.twin, &goals, rotations, given.fps)
                .later_at(self.options.time_scale.while_solved());
            return Ok(self.judged(source, animation, given, &goals, &steps));
        }
        // With velocity limits, the limits of a frame depend on the previous frame.
        if !self.options.velocity_limits {
            let free = Free {
                goals: &goals,
                bounds: &self.limits(),
                from: 0,
                ahead: 0,
            };
            self.branches.choose(&self.kinematics, &free, &mut motion);
        }
        self.fingers.apply(&self.kinematics, source, animation, &mut motion);
        let rotations = SourceRotations::new(source, animation, &self.source_bones);
        let steps = Steps::new(&self.kinematics, &self.twin, &goals, rotations, motion.fps)
            .later_at(self.options.time_scale.while_solved());
        if self.options.passes < 2 {
            return Ok(self.judged(source, animation, motion, &goals, &steps));
        }
        let mut refined = motion.clone();
        let first = self.judged(source, animation, motion, &goals, &steps);
        self.second_pass(&mut goals, &steps, &mut refined);
        let second = self.judged(source, animation, refined.clone(), &goals, &steps);
        let mut second = self.balanced(
            source,
            animation,
            &mut Balance {
                goals: &mut goals,
                steps: &steps,
                motion: refined,
            },
            second,
        );
        second.1.passes = 2;
        Ok(
            if second.1.is_worse_than(&first.1) && first.1.keeps_limits_as(&second.1) {
                first
            } else {
                second
            },
        )
    }

    /// The angles between the limbs of the last motion and the limbs of its source, frame by frame.
    pub(crate) fn limb_angles(&self, source: &Scene, animation: &Animation, motion: &RobotMotion) -> Vec<LimbAngles> {
        self.measured(motion).limb_angles(&self.retargeter, source, animation)
    }

    /// A motion on its floor, with its report.
    pub(super) fn judged(
        &self,
        source: &Scene,
        animation: &Animation,
        mut motion: RobotMotion,
        goals: &[Goals],
        steps: &Steps,
    ) -> (RobotMotion, RobotReport) {
        match self.following.stand {
            // Removes the solver's error of micrometres.
            Some(stand) => motion.root.fill(stand),
            None => {
                let raised = self.raised(&motion);
                for (root, raised) in motion.root.iter_mut().zip(raised) {
                    root.translation.z += raised;
                }
            }
        }
        let report = self.report(source, animation, &motion, (goals, steps));
        (motion, report)
    }

    /// The report of a motion.
    fn report(
        &self,
        source: &Scene,
        animation: &Animation,
        motion: &RobotMotion,
        (goals, steps): (&[Goals], &Steps),
    ) -> RobotReport {
        let measured = self.measured(motion);
        let as_twin = measured.as_twin();
        let mut found = self.retargeter.measure(source, animation, &self.twin.scene, &as_twin);
        if !self.twin.has_legs {
            found.leave_out_legs();
        }
        let of_source = found.guessed.iter();
        let of_source = of_source.map(|guess| format!("{} of the source: {}", guess.bone.as_str(), guess.reason));
        let of_robot = self.twin.guessed.iter().cloned().chain(guessed_shapes(&self.robot));
        let guessed = of_robot.chain(of_source).collect();
        let (heights, soles) = (measured.sole_heights(), measured.soles());
        let collisions = self.collisions.measure(&self.kinematics, motion);
        let (roll, lying) = measured.roll(&self.following, goals);
        let seen = ObservedFrames {
            found,
            skate: soles.mean(),
            scraping: soles.fraction_scraping().filter(|_| self.twin.has_legs),
            source_skate: self.source_slide(source, animation, &motion.contacts),
            standing: standing(&heights, &motion.contacts),
            lowest: heights.iter().map(|[left, right]| left.min(*right)).collect(),
            depths: match self.twin.has_legs {
                true => measured.depths(&self.collisions),
                false => Vec::new(),
            },
            collisions,
            roll,
            lying,
            jumps: steps.fraction_of_jumps(&self.kinematics, motion),
            trunk: self
                .retargeter
                .trunk_degrees(source, animation, (&self.twin.scene, &as_twin), self.twin.has_legs),
            unmeasured_limbs: self.twin.unmeasured_limbs(),
            guessed,
            // The load of an upper body's wheels is not known.
            dynamics: match self.twin.has_legs {
                true => feasibility(&self.robot, &self.kinematics, &self.following.soles(), motion),
                false => None,
            },
            has_legs: self.twin.has_legs,
        };
        robot_report::report(&self.robot, motion, seen)
    }

    /// Solves the frames of each window together, in the second pass.
    fn second_pass(&mut self, goals: &mut [Goals], steps: &Steps, motion: &mut RobotMotion) {
        self.following.loosen(goals, &motion.contacts, motion.fps);
        // A body with thicker knees or a thicker seat than the source rests higher.
        if self.twin.has_legs && self.options.floor != Floor::Keep {
            let raised = self.measured(motion).raised_by_links(&self.collisions);
            for (frame, raised) in raised.into_iter().enumerate().filter(|(_, raised)| *raised > 0.0) {
                self.following.raise(&mut goals[frame], raised);
                motion.root[frame].translation.z += raised;
            }
        }
        self.smooth(goals, steps, motion);
    }

    /// Solves the frames of each window together for these goals.
    fn smooth(&mut self, goals: &[Goals], steps: &Steps, motion: &mut RobotMotion) {
        let bound = Bound {
            goals,
            limits: &self.limits(),
            steps,
            soles: &self.following.soles(),
            collisions: &self.collisions,
        };
        self.windows.smooth(&self.kinematics, &bound, motion);
    }

    /// The robot in each frame of a motion of the twin. Sets `goals` to the goals of each frame.
    fn follow(
        &mut self,
        held: &Animation,
        animation: &Animation,
        contacts: Vec<[bool; 2]>,
        goals: &mut Vec<Goals>,
    ) -> RobotMotion {
        let frames = animation.frame_count();
        let binding = Binding::new(&self.twin.scene, held);
        let mut twin = Pose::rest(&self.twin.scene);
        let soles = self.sole_points(held, frames);
        let drops = self.drops(&soles, animation.ticks_per_second, &contacts);
        let mut motion = RobotMotion {
            name: animation.name.clone(),
            fps: rate(animation.ticks_per_second),
            root: Vec::with_capacity(frames),
            dof_pos: Vec::with_capacity(frames * (self.kinematics.bodies.len() - 1)),
            dof_names: self.robot.dof_names(),
            contacts,
            hind_contacts: Vec::new(),
        };
        let mut followed = FrameState::new(&self.kinematics);
        self.headings.clear();
        let clearances = match self.options.lock_feet {
            true => clearances(
                &motion.contacts,
                &speeds(&soles, motion.fps),
                motion.fps,
                most_clearance(&self.twin),
            ),
            false => vec![[0.0; 2]; frames],
        };
        for (frame, drop) in drops.into_iter().enumerate() {
            twin.sample(&binding, held, frame as f64);
            let contacts = motion.contacts[frame];
            self.following.goals.clearances = clearances[frame];
            self.next(&mut followed, &twin, drop, contacts, animation.ticks_per_second);
            self.headings.push(self.following.heading);
            goals.push(self.following.goals.clone());
            let pose = &followed.pose;
            motion.root.push(continued(pose.root, motion.root.last()));
            motion.dof_pos.extend(&pose.positions);
        }
        self.following.goals.clearances = [0.0; 2];
        motion
    }

    /// Follows the twin to its next frame, lowered by `drop`.
    pub(super) fn next(&mut self, followed: &mut FrameState, twin: &Pose, drop: f64, contacts: [bool; 2], fps: f64) {
        self.following.aim(twin, drop);
        let returned = self.following.returned(fps);
        for (side, stand) in followed.stands.iter_mut().enumerate() {
            let stood = followed.contacts.is_some_and(|before| before[side]);
            let is_held = self.options.lock_feet && contacts[side] && stood;
            self.following.hold(side, stand, is_held, returned);
        }
        let limits = self.limits();
        let (bounds, steps) = match followed.contacts {
            None => {
                self.begin(&mut followed.pose);
                (limits, FIRST_STEPS)
            }
            Some(_) => (self.reachable(&limits, &followed.pose, fps), STEPS),
        };
        let (goals, pose) = (&self.following.goals, &mut followed.pose);
        self.solver.solve(&self.kinematics, goals, &bounds, pose, steps);
        for (side, stand) in followed.stands.iter_mut().enumerate() {
            self.following.keep(side, stand, &followed.pose);
        }
        followed.contacts = Some(contacts);
    }

    pub(super) fn limits(&self) -> Bounds {
        Bounds::of(&self.kinematics)
    }

    /// The limits, narrowed to the positions that joints can reach until the next frame.
    fn reachable(&self, limits: &Bounds, pose: &RobotPose, fps: f64) -> Bounds {
        let mut bounds = limits.clone();
        if !self.options.velocity_limits {
            return bounds;
        }
        let speed = self.options.time_scale.while_solved();
        for (index, body) in self.kinematics.bodies[1..].iter().enumerate() {
            if let Some(velocity) = body.limits.velocity {
                let (at, most) = (pose.positions[index], velocity / (fps * speed));
                bounds.lower[index] = bounds.lower[index].max(at - most);
                bounds.upper[index] = bounds.upper[index].min(at + most);
            }
        }
        bounds
    }

    fn measured<'a>(&'a self, motion: &'a RobotMotion) -> Measured<'a> {
        Measured {
            kinematics: &self.kinematics,
            twin: &self.twin,
            motion,
            headings: &self.headings,
        }
    }
}

/// For each frame, whether the left and the right foot are in contact.
pub(super) fn feet_at_rest(found: &DetectedContacts, frames: usize) -> Vec<[bool; 2]> {
    let rests = |side: Side, frame: usize| {
        let mut points = found.points.iter().filter(|point| point.bone.side() == Some(side));
        points.any(|point| point.at_rest.get(frame) == Some(&true))
    };
    (0..frames)
        .map(|frame| Side::ALL.map(|side| rests(side, frame)))
        .collect()
}

/// The robot and its feet in the last followed frame.
#[derive(Clone, Debug)]
pub(super) struct FrameState {
    pub(super) pose: RobotPose,
    stands: [FootState; 2],
    /// The feet in contact; `None` before the first frame.
    #[doc(hidden)]
    pub contacts: Option<[bool; 2]>,
}

impl FrameState {
    pub(super) fn new(kinematics: &Kinematics) -> Self {
        Self {
            pose: kinematics.rest(),
            stands: Default::default(),
            contacts: None,
        }
    }
}

/// The same placement with its rotation on the shorter arc from the previous frame.
pub(super) fn continued(root: Placement, before: Option<&Placement>) -> Placement {
    let turned_away = before.is_some_and(|before| before.rotation.dot(root.rotation) < 0.0);
    Placement {
        rotation: if turned_away { -root.rotation } else { root.rotation },
        ..root
    }
}
