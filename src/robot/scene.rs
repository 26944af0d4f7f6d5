//! A robot as a scene: a node for each link.

use glam::{Mat4, Quat, Vec3};

use super::model::{Placement, Robot};
use super::motion::RobotMotion;
use crate::scene::{Animation, Channel, Keys, Metadata, Node, NodeId, NodeKind, Scene, SourceLines, UpAxis};

impl Robot {
    /// The robot as a scene in metres, +Z up: a node for each link, at rest where every joint is at 0. The links that
    /// are bones of a humanoid are marked.
    pub fn scene(&self) -> Scene {
        let nodes = self.links.iter().map(|link| Node {
            name: link.name.clone(),
            kind: NodeKind::Joint,
            parent: link.parent.map(NodeId::new),
            transform: matrix(&link.joint.link_to_parent(0.0)),
            source: Some(SourceLines {
                name: link.line,
                ..SourceLines::default()
            }),
            ..Node::default()
        });
        let mut scene = Scene {
            nodes: nodes.collect(),
            metadata: Metadata {
                format: self.format,
                metres_per_unit: Some(1.0),
                up: Some(UpAxis::Z),
                ..Metadata::default()
            },
            ..Scene::default()
        };
        for bone in self.bones(None).unwrap_or_default() {
            scene.nodes[bone.link].humanoid_bone = Some(bone.bone);
        }
        scene
    }

    /// A motion as an animation of [`scene`](Self::scene).
    pub fn animation(&self, motion: &RobotMotion) -> Animation {
        let joints = self.moving_joints();
        let channel = |link: usize, places: Vec<Placement>| {
            let mut rotations: Vec<Quat> = places.iter().map(|place| place.rotation.as_quat()).collect();
            for index in 1..rotations.len() {
                if rotations[index].dot(rotations[index - 1]) < 0.0 {
                    rotations[index] = -rotations[index];
                }
            }
            let positions: Vec<Vec3> = places.iter().map(|place| place.translation.as_vec3()).collect();
            let stays = positions.iter().all(|position| *position == positions[0]);
            Channel {
                node_name: self.links[link].name.clone(),
                node: Some(NodeId::new(link)),
                position_keys: match positions.first() {
                    Some(first) if stays => Keys::constant(*first),
                    _ => Keys::every_tick(positions),
                },
                rotation_keys: Keys::every_tick(rotations),
                scaling_keys: Keys::constant(Vec3::ONE),
            }
        };
        let frames = motion.root.len();
        let mut channels = vec![channel(0, motion.root.clone())];
        for (dof, &link) in joints.iter().enumerate().filter(|(_, link)| **link > 0) {
            let joint = &self.links[link].joint;
            let place = |frame: usize| joint.link_to_parent(motion.dof_pos[frame * joints.len() + dof]);
            channels.push(channel(link, (0..frames).map(place).collect()));
        }
        Animation {
            name: motion.name.clone(),
            ticks_per_second: motion.fps,
            duration: frames.saturating_sub(1) as f64,
            channels,
        }
    }
}

fn matrix(place: &Placement) -> Mat4 {
    Mat4::from_rotation_translation(place.rotation.as_quat(), place.translation.as_vec3())
}
