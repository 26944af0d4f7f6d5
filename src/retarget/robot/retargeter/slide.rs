//! The sliding speed of the source's feet, measured like the robot's feet.

use glam::{DVec3, Quat, Vec3};
use mocap_figure::HumanoidBone as Bone;
use mocap_scene::pose::{Binding, Pose};
use mocap_scene::scene::{Animation, NodeId, Scene, Side};

use super::super::measure::{FootPhase, SoleSpeed};
use super::RobotRetargeter;

/// A sole of the robot on a foot of the source, in the unit of the source.
struct SourceSole {
    ankle: NodeId,
    toes: Option<NodeId>,
    /// Points that move with the ankle, and points that move with the joint of the toes, each relative to its joint.
    points: Vec<Vec3>,
    in_front: Vec<Vec3>,
}

impl SourceSole {
    fn at(&self, pose: &Pose) -> impl Iterator<Item = Vec3> {
        let rotation = |node: NodeId| Quat::from_mat4(&pose.node_to_world[node.index()]).normalize();
        let placed = |node: NodeId, points: &[Vec3]| {
            let (turn, begin) = (rotation(node), pose.position(node));
            points
                .iter()
                .map(move |point| begin + turn * *point)
                .collect::<Vec<_>>()
        };
        let in_front = self.toes.map(|toes| placed(toes, &self.in_front));
        placed(self.ankle, &self.points)
            .into_iter()
            .chain(in_front.unwrap_or_default())
    }
}

impl RobotRetargeter {
    /// The mean speed of the slowest point of a sole while the foot of the source is in contact. The soles are the
    /// robot's soles, scaled by the ratio of the leg lengths, so both bodies are measured at the same points. Points in
    /// front of the toes' joint move with this joint.
    pub(super) fn source_slide(&self, source: &Scene, animation: &Animation, contacts: &[[bool; 2]]) -> Option<f64> {
        if !self.twin.has_legs {
            return None;
        }
        let soles = Side::ALL.map(|side| self.source_sole(side));
        let body = &self.retargeter.source;
        let to_figure = body.axes.inverse();
        let metres = body.metres_per_unit as f32;
        let binding = Binding::new(source, animation);
        let mut pose = Pose::rest(source);
        let mut speed = SoleSpeed::<2>::new(animation.ticks_per_second);
        for (frame, stands) in contacts.iter().enumerate() {
            pose.sample(&binding, animation, frame as f64);
            for (side, sole) in soles.iter().enumerate() {
                let Some(sole) = sole else { continue };
                let points = sole.at(&pose).map(|point| {
                    let point = (metres * (to_figure * point)).as_dvec3();
                    DVec3::new(point.x, point.z, 0.0)
                });
                let before = frame.checked_sub(1).map(|before| contacts[before][side]);
                speed.add(side, points.collect(), FootPhase::new(before, stands[side]));
            }
        }
        speed.mean()
    }

    fn source_sole(&self, side: Side) -> Option<SourceSole> {
        let body = &self.retargeter.source;
        let foot = Bone::LeftFoot.on(side);
        let of_robot = self.twin.bone(foot)?;
        let ankle = body.joint(foot)?;
        let to_source = body.leg / self.retargeter.target.leg;
        let in_ankle = body.frame_to_joint(foot, ankle).inverse();
        let toes_bone = Bone::LeftToes.on(side);
        // The position of the toes' joint, in the frame of the foot.
        let toes = body.joint(toes_bone).map(|toes| {
            let from_ankle = body.rotation(ankle).inverse() * (body.position(toes) - body.position(ankle));
            (toes, in_ankle.inverse() * from_ankle)
        });
        let mut sole = SourceSole {
            ankle,
            toes: toes.map(|(toes, _)| toes),
            points: Vec::new(),
            in_front: Vec::new(),
        };
        for ball in &self.twin.soles[side as usize] {
            let from_ankle = of_robot.link_to_frame * (ball.centre - of_robot.start);
            let from_ankle = to_source * from_ankle.as_vec3();
            match toes {
                Some((toes, begin)) if from_ankle.z > begin.z => {
                    let in_toes = body.frame_to_joint(toes_bone, toes).inverse();
                    sole.in_front.push(in_toes * (from_ankle - begin));
                }
                _ => sole.points.push(in_ankle * from_ankle),
            }
        }
        Some(sole)
    }
}
