//! Retargets a motion to a robot as it arrives.

use std::collections::VecDeque;

use mocap_edit::LiveContacts;
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::pose::Pose;
use mocap_scene::scene::Scene;

use super::branches::Free;
use super::floor::{Floor, standing_height};
use super::given::Given;
use super::measure::LIFT;
use super::motion::RobotMotion;
use super::retargeter::{FrameState, RobotRetargeter, continued};
use super::robot_report::RobotReport;
use super::source_rotations::SourceRotations;
use super::speed::Steps;
use super::terms::Goals;
use super::window::Bound;

/// The length of the window that the second pass solves again with each new frame, in seconds.
const WINDOW: f64 = 0.5;

/// The delay after which a frame is followed, in seconds. The later frames show whether its feet come to rest.
const AHEAD: f64 = 0.1;

/// The time for which returned frames are kept, in seconds. It is the reach of smoothing and of lifts.
const KEPT: f64 = 0.25;

/// The time between searches for another branch of a limb with a large error, in seconds.
const LOOKED: f64 = 0.1;

/// The time over which the feet show the height of the floor, in seconds.
const FLOOR_SEEN: f64 = 4.0;

/// The time in which the robot is lowered to the floor, in seconds.
const DROP: f64 = 0.3;

/// The range of frame rates of a stream, in Hz.
const RATES: std::ops::RangeInclusive<f64> = 1.0..=1000.0;

/// Retargets the motion of one source to a robot as it arrives: poses in, poses of the robot out,
/// [`delay`](Self::delay) seconds later.
///
/// It works like [`RobotRetargeter::clip`], with a window of 0.5 s. Joints keep their limits of position and velocity.
/// Feet in stance keep their place, and soles are above the floor. A limb with a large error is solved again from other
/// starting angles. [`report`](Self::report) covers the last 30 s. [`RobotStream`](super::RobotStream) returns each
/// pose at once, without future frames.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::retarget::robot::{RobotOptions, RobotRetargeter};
/// use mocap::{Binding, Importer, Pose};
///
/// let robot = Importer::new().import_robot("fixtures/robots/h1.urdf")?;
/// let walk = mocap::import("fixtures/real/cmu_short.bvh")?;
/// let retargeter = RobotRetargeter::new(&walk, &robot, &RobotOptions::default())?;
/// let mut stream = retargeter.stream(&walk, 60.0)?;
/// assert!((stream.delay() - 0.6).abs() < 1e-9);
///
/// let (animation, mut pose) = (&walk.animations[0], Pose::rest(&walk));
/// let binding = Binding::new(&walk, animation);
/// let mut frames = 0;
/// for tick in 0..50 {
///     pose.sample(&binding, animation, f64::from(tick));
///     frames += stream.push(&pose).map_or(0, |motion| motion.frames());
/// }
/// assert_eq!(frames, 50 - 36); // 36 frames are 0.6 s
/// frames += stream.finish().frames();
/// assert_eq!(frames, 50);
/// assert_eq!(stream.report().unwrap().frames, 50);
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct SmoothRobotStream {
    retargeter: RobotRetargeter,
    fps: f64,
    /// The number of frames of the window, and of the delay before a frame is followed.
    window: usize,
    ahead: usize,
    /// The last received pose of the twin. Then the poses that are not followed yet, with the wanted positions of
    /// fingers.
    twin: Pose,
    waiting: VecDeque<(Pose, Vec<f64>)>,
    feet: LiveContacts,
    followed: FrameState,
    /// The lowering of the robot.
    drop: f64,
    recent: FrameWindow,
    given: Given,
    /// The number of frames since the last search for other branches.
    looked: usize,
}

/// The kept frames.
#[derive(Clone, Debug)]
struct FrameWindow {
    goals: Vec<Goals>,
    rotations: SourceRotations,
    /// The frames after the first pass, and their current state.
    first: RobotMotion,
    motion: RobotMotion,
    /// The number of frames that were returned.
    given: usize,
}

impl RobotRetargeter {
    /// Starts a stream of poses of `source`, the scene from which the retargeter was made, at this frame rate.
    ///
    /// # Errors
    /// [`Code::InvalidValue`] for a rate that is not from 1 to 1000.
    pub fn stream(self, source: &Scene, fps: f64) -> Result<SmoothRobotStream> {
        if !RATES.contains(&fps) {
            let message = format!("the rate of a stream must be from 1 to 1000 frames per second, got {fps}");
            return Err(Diagnostic::new(Code::InvalidValue, message).into());
        }
        let frames = |seconds: f64| (seconds * fps).round() as usize;
        let figure = self.retargeter.source_figure().clone();
        let empty = RobotMotion {
            fps,
            dof_names: self.robot.dof_names(),
            name: source
                .animations
                .first()
                .map(|animation| animation.name.clone())
                .unwrap_or_default(),
            ..RobotMotion::default()
        };
        let rotations = SourceRotations::empty(&self.source_bones);
        Ok(SmoothRobotStream {
            fps,
            given: Given::new(source, empty.clone(), rotations.clone()),
            looked: 0,
            window: if self.options.passes < 2 { 0 } else { frames(WINDOW) },
            ahead: frames(AHEAD),
            twin: Pose::rest(&self.twin.scene),
            waiting: VecDeque::new(),
            feet: LiveContacts::new(source, figure, fps, FLOOR_SEEN),
            followed: FrameState::new(&self.kinematics),
            drop: if self.options.floor == Floor::Zero {
                -self.retargeter.source_floor()
            } else {
                0.0
            },
            recent: FrameWindow {
                goals: Vec::new(),
                rotations,
                motion: empty.clone(),
                first: empty,
                given: 0,
            },
            retargeter: self,
        })
    }
}

impl SmoothRobotStream {
    /// The delay of a returned frame, in seconds.
    pub fn delay(&self) -> f64 {
        (self.window + self.ahead) as f64 / self.fps
    }

    /// The names of the joints, in the order of the positions of a frame.
    pub fn dof_names(&self) -> &[String] {
        &self.recent.motion.dof_names
    }

    /// Receives the next pose of the source, and returns the frame that is due; `None` at first.
    pub fn push(&mut self, source: &Pose) -> Option<RobotMotion> {
        self.retargeter.retargeter.pose(source, &mut self.twin);
        let fingers = self.retargeter.fingers.wanted(source);
        self.waiting.push_back((self.twin.clone(), fingers));
        self.feet.push(source);
        self.recent.rotations.push(source);
        self.given.push(source);
        if self.waiting.len() <= self.ahead {
            return None;
        }
        self.follow();
        self.smooth();
        let is_due = self.recent.motion.frames() > self.recent.given + self.window;
        is_due.then(|| {
            let given = self.give(1);
            self.forget();
            given
        })
    }

    /// Returns the remaining frames, at the end of a stream. Later poses continue from there.
    pub fn finish(&mut self) -> RobotMotion {
        while !self.waiting.is_empty() {
            self.follow();
        }
        self.smooth();
        let left = self.recent.motion.frames() - self.recent.given;
        let given = self.give(left);
        self.forget();
        given
    }

    /// The report of the frames that were returned in the last 30 s, of which at most 3600 are kept. `None` before the
    /// first frame.
    pub fn report(&self) -> Option<RobotReport> {
        let Given {
            motion,
            goals,
            rotations,
            skeleton,
            ..
        } = &self.given;
        if motion.frames() == 0 {
            return None;
        }
        let retargeter = &self.retargeter;
        let (kinematics, twin) = (&retargeter.kinematics, &retargeter.twin);
        let steps = Steps::new(kinematics, twin, goals, rotations.clone(), self.fps);
        let source = self.given.source();
        let (_, mut report) = retargeter.judged(skeleton, &source, motion.clone(), goals, &steps);
        report.passes = if self.window == 0 { 1 } else { 2 };
        Some(report)
    }

    /// The first pass for the pose that has waited longest.
    fn follow(&mut self) {
        let contacts = self.feet.at(self.waiting.len() - 1);
        let Some((twin, fingers)) = self.waiting.pop_front() else {
            return;
        };
        self.come_down(&twin, contacts);
        self.retargeter
            .next(&mut self.followed, &twin, self.drop, contacts, self.fps);
        let recent = &mut self.recent;
        recent.goals.push(self.retargeter.following.goals.clone());
        self.retargeter.headings.push(self.retargeter.following.heading);
        let pose = &mut self.followed.pose;
        let before = recent
            .motion
            .frames()
            .checked_sub(1)
            .map(|frame| recent.motion.dof_of(frame));
        let own = &self.retargeter.fingers;
        own.bend(&fingers, before, self.fps, &mut pose.positions);
        self.retargeter.kinematics.update(pose);
        for motion in [&mut recent.first, &mut recent.motion] {
            motion.root.push(continued(pose.root, motion.root.last()));
            motion.dof_pos.extend(&pose.positions);
            motion.contacts.push(contacts);
        }
        self.looked += 1;
        if self.window > 0 && self.looked as f64 >= LOOKED * self.fps {
            self.looked = 0;
            self.choose();
        }
    }

    /// Chooses a better branch for a limb with a large error, in the frames that were not returned yet.
    fn choose(&mut self) {
        let recent = &mut self.recent;
        let limits = self.retargeter.limits();
        let free = Free {
            goals: &recent.goals,
            bounds: &limits,
            from: recent.given,
            ahead: self.window,
        };
        let kinematics = &self.retargeter.kinematics;
        let changed = self.retargeter.branches.choose(kinematics, &free, &mut recent.first);
        if changed.is_empty() {
            return;
        }
        let joints = recent.first.dof_names.len();
        for frame in recent.given..recent.first.frames() {
            for &position in &changed {
                let at = frame * joints + position;
                recent.motion.dof_pos[at] = recent.first.dof_pos[at];
            }
        }
        let last = recent.first.frames() - 1;
        let pose = &mut self.followed.pose;
        pose.positions.copy_from_slice(recent.first.dof_of(last));
        kinematics.update(pose);
    }

    /// Lowers the robot gradually if feet in contact are above the floor.
    fn come_down(&mut self, twin: &Pose, contacts: [bool; 2]) {
        let options = &self.retargeter.options;
        if options.floor != Floor::Auto || !options.lock_feet {
            return;
        }
        self.retargeter.following.aim(twin, 0.0);
        let heights = self.retargeter.following.heights();
        if let Some(height) = standing_height(&heights, contacts) {
            let is_first = self.recent.goals.is_empty();
            let nearer = if is_first {
                1.0
            } else {
                1.0 - (-1.0 / (DROP * self.fps)).exp()
            };
            self.drop += nearer * (height - self.drop);
        }
    }

    /// The second pass for the frames that were not returned yet.
    fn smooth(&mut self) {
        let (retargeter, recent) = (&mut self.retargeter, &mut self.recent);
        if self.window == 0 || recent.given == recent.motion.frames() {
            return;
        }
        let mut goals = recent.goals.clone();
        retargeter
            .following
            .loosen(&mut goals, &recent.motion.contacts, self.fps);
        let steps = Steps::new(
            &retargeter.kinematics,
            &retargeter.twin,
            &goals,
            recent.rotations.clone(),
            self.fps,
        );
        let limits = retargeter.limits();
        let bound = Bound {
            goals: &goals,
            limits: &limits,
            steps: &steps,
            soles: &retargeter.following.soles(),
            collisions: &retargeter.collisions,
        };
        let (first, motion) = (&recent.first, &mut recent.motion);
        retargeter
            .windows
            .slide(&retargeter.kinematics, &bound, first, motion, recent.given);
    }

    /// Returns the next frames, above the floor.
    fn give(&mut self, count: usize) -> RobotMotion {
        let motion = &self.recent.motion;
        let frames = self.recent.given..self.recent.given + count;
        let frames_given = frames.clone();
        let joints = motion.dof_names.len();
        let mut given = RobotMotion {
            root: motion.root[frames.clone()].to_vec(),
            dof_pos: motion.dof_pos[frames.start * joints..frames.end * joints].to_vec(),
            contacts: motion.contacts[frames.clone()].to_vec(),
            hind_contacts: Vec::new(),
            dof_names: motion.dof_names.clone(),
            name: motion.name.clone(),
            fps: self.fps,
        };
        match self.retargeter.following.stand {
            Some(stand) => given.root.fill(stand),
            None => {
                let raised = self.retargeter.raised(motion);
                for (root, raised) in given.root.iter_mut().zip(&raised[frames]) {
                    root.translation.z += raised;
                }
            }
        }
        let forgotten = self.given.add(&given, &self.recent.goals[frames_given]);
        self.retargeter.headings.drain(..forgotten);
        self.recent.given += count;
        given
    }

    /// Drops the frames that no later frame needs.
    fn forget(&mut self) {
        let recent = &mut self.recent;
        let kept = (KEPT.max(LIFT) * self.fps).ceil() as usize + 3;
        let count = recent.given.saturating_sub(kept);
        recent.given -= count;
        recent.goals.drain(..count);
        recent.rotations.forget(count);
        recent.first.forget(count);
        recent.motion.forget(count);
    }
}
