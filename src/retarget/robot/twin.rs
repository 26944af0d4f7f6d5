//! The twin of a robot: a humanoid with the robot's proportions in the T-pose, with joints that rotate freely.
//!
//! A motion is retargeted to the twin as to any character, with locked feet. The robot then follows the twin as far as
//! its joints allow.

use std::collections::BTreeMap;

use glam::{DQuat, DVec3, Mat4};
use mocap_figure::robot_bones::RobotBone;
use mocap_figure::robot_bones::sole::SoleBall;
use mocap_figure::robot_bones::t_pose::RobotTPose;
use mocap_figure::{Figure, Humanoid};
use mocap_scene::error::Result;
use mocap_scene::scene::robot::Robot;
use mocap_scene::scene::{HumanoidBone as Bone, Metadata, Node, NodeId, NodeKind, Scene, Side, UpAxis};

/// A bone of the twin, with the link that follows it.
#[derive(Clone, Debug)]
pub(super) struct StandInBone {
    pub(super) bone: Bone,
    pub(super) node: NodeId,
    pub(super) link: usize,
    /// The joints between this bone and its parent bone.
    pub(super) joints: Vec<usize>,
    /// The rotation from the link to the figure's axes in the T-pose.
    pub(super) link_to_frame: DQuat,
    /// The start of the bone, in the frame of the link.
    pub(super) start: DVec3,
}

/// A humanoid in the T-pose, +Y up and facing +Z.
#[derive(Clone, Debug)]
pub struct StandIn {
    pub(super) scene: Scene,
    /// The figure of the twin, with all bones known.
    pub(super) figure: Figure,
    pub(super) bones: Vec<StandInBone>,
    /// The ends of forearms without a hand: the node, the link to which the end is fixed, and its position in the frame
    /// of the link.
    pub(super) tips: Vec<(NodeId, usize, DVec3)>,
    /// The rotation from the figure's axes to the robot's world.
    pub(super) figure_to_world: DQuat,
    /// The soles of both feet, in the frame of the link.
    pub(super) soles: [Vec<SoleBall>; 2],
    /// Whether the robot has legs. An upper body, on wheels or fixed, has a twin with legs that no link follows.
    pub(super) has_legs: bool,
    /// The guesses that nothing in the robot's file supports, as text.
    pub(super) guessed: Vec<String>,
}

impl StandIn {
    pub fn new(robot: &Robot, of_robot: &[RobotBone]) -> Result<Self> {
        let t_pose = RobotTPose::new(robot, of_robot)?;
        let found: BTreeMap<Bone, &RobotBone> = of_robot.iter().map(|bone| (bone.bone, bone)).collect();
        let mut scene = Scene {
            metadata: Metadata {
                metres_per_unit: Some(1.0),
                up: Some(UpAxis::Y),
                ..Metadata::default()
            },
            ..Scene::default()
        };
        let lift = DVec3::Y * -t_pose.floor;
        let mut world: Vec<DVec3> = Vec::new();
        let mut push = |scene: &mut Scene, name: &str, parent: Option<NodeId>, at: DVec3| {
            let offset = parent.map_or(at, |parent| at - world[parent.index()]);
            world.push(at);
            scene.nodes.push(Node {
                name: name.to_owned(),
                kind: NodeKind::Joint,
                parent,
                transform: Mat4::from_translation(offset.as_vec3()),
                ..Node::default()
            });
            NodeId::new(scene.nodes.len() - 1)
        };
        let mut nodes: BTreeMap<Bone, NodeId> = BTreeMap::new();
        let mut bones = Vec::new();
        let mut tip_nodes = Vec::new();
        let limb = |side: Side, bones: [Bone; 3]| bones.map(|bone| bone.on(side));
        let arm = [Bone::LeftUpperArm, Bone::LeftLowerArm, Bone::LeftHand];
        let leg_bones = [Bone::LeftUpperLeg, Bone::LeftLowerLeg, Bone::LeftFoot];
        let mut order = vec![vec![Bone::Hips], vec![Bone::Chest], vec![Bone::Head]];
        order.extend(Side::ALL.map(|side| limb(side, arm).to_vec()));
        order.extend(Side::ALL.map(|side| limb(side, leg_bones).to_vec()));
        for chain in order {
            let chest = nodes.get(&Bone::Chest).copied();
            let hips = nodes.get(&Bone::Hips).copied();
            let mut parent = match chain[0].on(Side::Left) {
                Bone::LeftUpperLeg | Bone::Chest => hips,
                _ => chest.or(hips),
            };
            for bone in chain {
                if let Some(tip) = t_pose.tips.iter().find(|tip| tip.bone == bone) {
                    let node = push(&mut scene, bone.as_str(), parent, tip.at + lift);
                    nodes.insert(bone, node);
                    tip_nodes.push((node, tip.link, tip.point));
                    continue;
                }
                let Some(part) = t_pose.parts.get(&bone) else { continue };
                let node = push(&mut scene, bone.as_str(), parent, part.at + lift);
                nodes.insert(bone, node);
                parent = Some(node);
                let Some(found) = found.get(&bone) else { continue };
                bones.push(StandInBone {
                    bone,
                    node,
                    link: found.link,
                    joints: found.joints.clone(),
                    link_to_frame: t_pose.link_to_frame(found),
                    start: t_pose.start(found, of_robot),
                });
            }
        }
        let humanoid = Humanoid::stated(nodes, "the joints of the robot show the bones");
        Ok(Self {
            figure: Figure::with_bones(&scene, humanoid),
            scene,
            bones,
            tips: tip_nodes,
            figure_to_world: t_pose.figure_to_world,
            soles: t_pose.soles,
            has_legs: t_pose.has_legs,
            guessed: t_pose.guessed,
        })
    }

    /// The number of forearms without an end. Their direction cannot be measured.
    pub(super) fn unmeasured_limbs(&self) -> usize {
        let has = |bone: Bone| self.bone(bone).is_some();
        let is_open = |side: Side| {
            let [forearm, hand] = [Bone::LeftLowerArm, Bone::LeftHand].map(|bone| bone.on(side));
            let name = hand.as_str();
            let has_tip = self.tips.iter().any(|tip| self.scene.nodes[tip.0.index()].name == name);
            has(forearm) && !has(hand) && !has_tip
        };
        Side::ALL.into_iter().filter(|side| is_open(*side)).count()
    }

    pub(super) fn bone(&self, bone: Bone) -> Option<&StandInBone> {
        self.bones.iter().find(|found| found.bone == bone)
    }
}
