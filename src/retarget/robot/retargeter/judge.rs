//! Measures motions of the robot that any program wrote, against their references.

use glam::DVec3;
use mocap_figure::HumanoidBone as Bone;
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::pose::{Binding, Pose};
use mocap_scene::scene::{Animation, Scene};

use super::super::feasibility::feasibility;
use super::super::measure::standing;
use super::super::motion::RobotMotion;
use super::super::robot_report::RobotReport;
use super::super::scores::{BodyPlaces, RobotScores, scores};
use super::super::source_rotations::SourceRotations;
use super::super::speed::Steps;
use super::RobotRetargeter;

/// The largest relative difference of two equal frame rates, as a fraction.
const SAME_RATE: f64 = 1e-3;

impl RobotRetargeter {
    /// Like [`clip`](Self::clip). Also returns the source at the speed of the motion, if this speed is not the source's
    /// speed.
    pub(crate) fn scaled_clip(
        &mut self,
        source: &Scene,
        index: usize,
    ) -> Result<(RobotMotion, RobotReport, Option<Scene>)> {
        let (motion, mut report) = self.solved(source, index)?;
        let (kinematics, soles) = (&self.kinematics, self.following.soles());
        let dynamics = |motion: &RobotMotion| match self.twin.has_legs {
            true => feasibility(&self.robot, kinematics, &soles, motion),
            false => None,
        };
        let scaled = self
            .options
            .time_scale
            .apply(kinematics, (source, index), &motion, &self.ends(), &dynamics)?;
        let Some(scaled) = scaled else {
            report.scores = self.scores(source, &source.animations[index], &motion, &report);
            return Ok((motion, report, None));
        };
        let found = self.report_of(&scaled.source, &scaled.source.animations[index], &scaled.motion);
        let report = RobotReport {
            passes: report.passes,
            time_scale: scaled.speed,
            slowed_by: scaled.joint,
            lagging: scaled.lagging,
            ..found
        };
        Ok((scaled.motion, report, Some(scaled.source)))
    }

    /// The positions of joints that move only the head or a hand. Without them, the robot keeps its balance and its
    /// path.
    fn ends(&self) -> Vec<usize> {
        let bones = self.twin.bones.iter();
        let bones = bones.filter(|bone| matches!(bone.bone, Bone::Head | Bone::LeftHand | Bone::RightHand));
        let joints = bones.flat_map(|bone| &bone.joints);
        joints
            .filter_map(|joint| self.kinematics.body_of(*joint).0.checked_sub(1))
            .collect()
    }

    /// Measures how well a motion of the robot follows an animation of `source`, by its index. Any program may have
    /// written the motion, and the motion is not changed. Both have the same frame rate and begin at the same time.
    /// Frames that one of the motions lacks are not compared.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::Importer;
    /// use mocap::retarget::robot::{RobotOptions, RobotRetargeter};
    ///
    /// let robot = Importer::new().import_robot("fixtures/robots/h1.urdf")?;
    /// let walk = mocap::import("fixtures/real/cmu_short.bvh")?;
    /// let mut retargeter = RobotRetargeter::new(&walk, &robot, &RobotOptions::default())?;
    /// let (mut motion, own) = retargeter.clip(&walk, 0)?;
    /// motion.root.iter_mut().for_each(|root| root.translation.x += 0.1);
    /// let [own, moved] = [own, retargeter.judge(&walk, 0, &motion)?].map(|report| report.scores.unwrap());
    /// assert!(moved.mpbpe_global > own.mpbpe_global && (moved.mpbpe_local - own.mpbpe_local).abs() < 1e-6);
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Code::NoMotion`] if there is no such animation, or the motions have no frame in common. [`Code::InvalidValue`]
    /// if the frame rates differ, or the joints are not the joints of the robot.
    pub fn judge(&mut self, source: &Scene, index: usize, motion: &RobotMotion) -> Result<RobotReport> {
        let mut animation = Self::animation_of(source, index)?.clone();
        let (own, theirs) = (motion.fps, animation.ticks_per_second);
        if (own - theirs).abs() > SAME_RATE * theirs {
            let message = format!("the motion has {own} frames per second, but its reference has {theirs}");
            return Err(Diagnostic::new(Code::InvalidValue, message)
                .help("resample one of the motions")
                .into());
        }
        if motion.dof_names != self.robot.dof_names() {
            let message = format!("the joints of the motion are not the joints of {}", self.robot.name);
            return Err(Diagnostic::new(Code::InvalidValue, message).into());
        }
        let frames = motion.frames().min(animation.frame_count());
        if frames == 0 {
            return Err(Diagnostic::new(Code::NoMotion, "the two motions have no frame in common").into());
        }
        animation.duration = animation.duration.min((frames - 1) as f64);
        let mut motion = motion.clone();
        motion.keep_first(frames);
        motion.contacts = self.contacts_of(source, &animation);
        let mut report = self.report_of(source, &animation, &motion);
        report.passes = 0;
        Ok(report)
    }

    /// The report of a motion with as many frames as an animation of `source`, and with its scores.
    pub(super) fn report_of(&mut self, source: &Scene, animation: &Animation, motion: &RobotMotion) -> RobotReport {
        let moved = self.retargeter.animation(source, animation);
        let mut goals = Vec::new();
        self.follow(&moved, animation, motion.contacts.clone(), &mut goals);
        let rotations = SourceRotations::new(source, animation, &self.source_bones);
        let steps = Steps::new(&self.kinematics, &self.twin, &goals, rotations, motion.fps);
        let mut report = self.report(source, animation, motion, (&goals, &steps));
        report.scores = self.scores(source, animation, motion, &report);
        report
    }

    /// The scores of a motion with this report; `None` for a robot without legs, whose base is fixed.
    pub(super) fn scores(
        &self,
        source: &Scene,
        animation: &Animation,
        motion: &RobotMotion,
        report: &RobotReport,
    ) -> Option<RobotScores> {
        if !self.twin.has_legs {
            return None;
        }
        let places = match RobotMotion::of_same_robot(&self.robot, source, animation) {
            Some(reference) => self.links(&reference, motion),
            None => self.bones(source, animation, motion),
        };
        let measured = self.measured(motion);
        let heights = standing(&measured.sole_heights(), &motion.contacts);
        let slide = measured.soles();
        Some(RobotScores {
            penetration_duration: report.fraction_below_floor,
            penetration_depth: report.deepest,
            self_collision_duration: report.fraction_in_self_collision,
            self_collision_depth: report.self_collisions.first().map_or(0.0, |pair| pair.deepest),
            ..scores(&self.robot, motion, &places, (&slide, &heights))
        })
    }

    /// The positions of the base and of links with a joint, in two motions of the robot.
    fn links(&self, reference: &RobotMotion, motion: &RobotMotion) -> BodyPlaces {
        let of_motion = |motion: &RobotMotion| {
            let mut pose = self.kinematics.rest();
            let frames = (0..motion.frames()).map(|frame| {
                motion.set(frame, &self.kinematics, &mut pose);
                pose.bodies.iter().map(|body| body.translation).collect()
            });
            frames.collect::<Vec<Vec<DVec3>>>()
        };
        let hands = [Bone::LeftHand, Bone::RightHand].into_iter();
        let hands = hands.filter_map(|bone| Some(self.kinematics.body_of(self.twin.bone(bone)?.link).0));
        BodyPlaces {
            reference: of_motion(reference),
            robot: of_motion(motion),
            base: 0,
            palms: hands.collect(),
        }
    }

    /// The positions of the robot's bones, and of a person with the robot's proportions in the same motion.
    fn bones(&self, source: &Scene, animation: &Animation, motion: &RobotMotion) -> BodyPlaces {
        let moved = self.retargeter.clone().animation(source, animation);
        let twin = &self.twin;
        let tips = twin.tips.iter().copied();
        let points = twin.bones.iter().map(|bone| (bone.node, bone.link, bone.start));
        let points: Vec<_> = points.chain(tips).collect();
        let named = |bones: &[Bone]| {
            let is_one = |index: &usize| {
                let name = &twin.scene.nodes[points[*index].0.index()].name;
                bones.iter().any(|bone| bone.as_str() == name)
            };
            (0..points.len()).filter(is_one).collect::<Vec<usize>>()
        };
        let binding = Binding::new(&twin.scene, &moved);
        let (mut person, mut pose) = (Pose::rest(&twin.scene), self.kinematics.rest());
        let mut places = BodyPlaces {
            reference: Vec::with_capacity(motion.frames()),
            robot: Vec::with_capacity(motion.frames()),
            base: named(&[Bone::Hips]).first().copied().unwrap_or_default(),
            palms: named(&[Bone::LeftHand, Bone::RightHand]),
        };
        for frame in 0..motion.frames() {
            person.sample(&binding, &moved, frame as f64);
            motion.set(frame, &self.kinematics, &mut pose);
            let of_person = points
                .iter()
                .map(|(node, _, _)| twin.figure_to_world * person.position(*node).as_dvec3());
            places.reference.push(of_person.collect());
            let of_robot = points
                .iter()
                .map(|(_, link, point)| self.kinematics.link(&pose, *link).point(*point));
            places.robot.push(of_robot.collect());
        }
        places
    }
}
