//! The report of a motion on a robot with four legs.

use glam::DVec3;
use mocap_figure::animal::AnimalTrack;
use mocap_scene::math::quaternion::rotation_vector;
use mocap_scene::scene::HumanoidBone as Bone;

use super::{QuadrupedRetargeter, lowest};
use crate::quality::{LimbError, RetargetReport};
use crate::robot::collision::guessed_shapes;
use crate::robot::feasibility::feasibility;
use crate::robot::measure::{FootPhase, SoleSpeed, standing};
use crate::robot::motion::RobotMotion;
use crate::robot::robot_report::{self, ObservedFrames, RobotReport};
use crate::robot::speed::{EXPLAINED, JUMP, WINDOW};

/// The parts of the motion that a robot with four legs does not perform.
const LEFT_OUT: &str = "neck, head, tail and bends of the spine";

impl QuadrupedRetargeter {
    /// The report of a motion. `steps` is the factor of its steps relative to the source.
    pub(super) fn report(&self, track: &AnimalTrack, motion: &RobotMotion, steps: f64) -> RobotReport {
        let legs = &self.legs.legs;
        let mut limbs: Vec<LimbError> = Vec::new();
        let mut speed = SoleSpeed::<4>::new(motion.fps);
        let frames = motion.frames().max(1) as f64;
        self.poses(motion, |frame, pose| {
            let stands = |frame: usize, index: usize| track.contacts[frame][index];
            let mut at = 0;
            let mut add = |bone: Bone, is: DVec3, was: DVec3| {
                let angle = is.angle_between(was).to_degrees();
                if frame == 0 {
                    limbs.push(LimbError {
                        bone,
                        mean_degrees: 0.0,
                        max_degrees: 0.0,
                        tick: 0.0,
                    });
                }
                let limb = &mut limbs[at];
                limb.mean_degrees += angle / frames;
                if angle > limb.max_degrees {
                    (limb.max_degrees, limb.tick) = (angle, frame as f64);
                }
                at += 1;
            };
            for (index, leg) in legs.iter().enumerate() {
                for (bone, is, was) in leg.directions(pose, &track.frames[frame], index) {
                    add(bone, is, was);
                }
                let points = leg.sole.iter().map(|ball| ball.bottom(&pose.bodies[leg.body()]));
                let before = frame.checked_sub(1).map(|before| stands(before, index));
                speed.add(index, points.collect(), FootPhase::new(before, stands(frame, index)));
            }
        });
        let heights = self.heights(motion);
        let guessed = legs.iter().filter(|leg| !leg.is_shown).map(|leg| {
            let link = self.robot.moving_joints()[leg.body() - 1];
            format!("the sole of {}, which has no shape", self.robot.links[link].name)
        });
        let lying = track
            .frames
            .iter()
            .filter(|frame| (frame.rotation * DVec3::Z).z < 0.5)
            .count();
        let mut report = robot_report::report(
            &self.robot,
            motion,
            ObservedFrames {
                found: RetargetReport::of_limbs(motion.name.clone(), motion.frames(), steps, limbs),
                source_skate: track.skate(motion.fps),
                skate: speed.mean(),
                scraping: speed.fraction_scraping(),
                lowest: heights.iter().map(lowest).collect(),
                depths: Vec::new(),
                standing: standing(&heights, &track.contacts),
                collisions: self.collisions.measure(&self.kinematics, motion),
                roll: None,
                trunk: None,
                lying: lying as f64 / frames,
                jumps: self.fraction_of_jumps(track, motion),
                unmeasured_limbs: 0,
                guessed: guessed.chain(guessed_shapes(&self.robot)).collect(),
                dynamics: feasibility(&self.robot, &self.kinematics, &self.soles(), motion),
                has_legs: true,
            },
        );
        report.left_out = vec![LEFT_OUT.to_owned()];
        report
    }

    /// The fraction of frames after which a joint of a leg jumps without a cause in the source.
    fn fraction_of_jumps(&self, track: &AnimalTrack, motion: &RobotMotion) -> f64 {
        let window = (WINDOW * motion.fps).round().max(1.0) as usize;
        let frames = motion.frames().saturating_sub(window);
        let jumps = |frame: usize| {
            let (from, to) = (&track.frames[frame], &track.frames[frame + window]);
            let turned = rotation_vector(to.rotation * from.rotation.inverse()).length();
            self.legs.legs.iter().enumerate().any(|(index, leg)| {
                let bones = from.bones(index).into_iter().zip(to.bones(index));
                let [back, ahead] = [from, to].map(|frame| frame.rotation.inverse());
                let angles = bones.map(|(before, after)| (back * before).angle_between(ahead * after));
                let source = angles.fold(turned, f64::max);
                leg.bodies.iter().any(|body| {
                    let moved = (motion.dof_of(frame + window)[body - 1] - motion.dof_of(frame)[body - 1]).abs();
                    moved > JUMP && source < EXPLAINED * moved
                })
            })
        };
        (0..frames).filter(|frame| jumps(*frame)).count() as f64 / frames.max(1) as f64
    }
}
