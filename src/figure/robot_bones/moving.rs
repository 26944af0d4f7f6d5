//! Makes the scene of a moving robot with the bones of a person.

use std::collections::HashSet;

use glam::{DQuat, Mat4, Quat, Vec3};
use mocap_scene::scene::robot::Robot;
use mocap_scene::scene::{Animation, Channel, Node, NodeId, NodeKind, Scene};

use super::t_pose::RobotTPose;
use super::{RobotBone, robot_bones, robot_scene};

/// The suffix of the name of a bone's node. The node has this suffix after the name of the link if the bone does not
/// begin at the origin of the link.
const BONE: &str = "_bone";

/// The distance, in metres, within which the start of a bone and the origin of its link count as the same point.
/// Rounded axes cause such distances.
const SAME_PLACE: f64 = 1e-6;

/// A scene of a robot with animations of [`robot_scene`]. Its rest pose is the T-pose, and the node of a bone is at the
/// start of the bone. If the bone does not begin at the origin of its link, the link has two nodes: the bone, and the
/// origin, which has the name of the link.
pub fn scene_of_clips(robot: &Robot, clips: Vec<Animation>) -> Scene {
    let mut scene = robot_scene(robot);
    scene.animations = clips;
    if let Ok(bones) = robot_bones(robot, None)
        && let Ok(t_pose) = RobotTPose::new(robot, &bones)
    {
        let begins = begin_at_bones(&mut scene, robot, &bones, &t_pose);
        rest_in_t_pose(&mut scene, robot, &t_pose);
        keep_frames(&mut scene, &begins);
    }
    scene
}

/// For each link, the node that moves with the link in a scene from [`scene_of_clips`] or [`robot_scene`]. `None` if
/// the scene is of another body.
pub fn nodes_of_links(robot: &Robot, scene: &Scene) -> Option<Vec<usize>> {
    let mut nodes: Vec<usize> = Vec::with_capacity(robot.links.len());
    let mut next = 0;
    for link in &robot.links {
        let above = link.parent.map(|parent| nodes[parent]);
        let is_named = |index: usize| scene.nodes.get(index).is_some_and(|node| node.name == link.name);
        let is_bone = |index: usize| {
            let node = scene.nodes.get(index);
            let rest = node.and_then(|node| node.name.strip_prefix(link.name.as_str()));
            rest.is_some_and(|rest| rest.starts_with(BONE))
        };
        // The node at the frame of the base is a child of the base's bone, and so comes after it. For any other link,
        // the node at its frame comes before its bone.
        let (node, taken) = match is_named(next) {
            true if is_bone(next + 1) && !is_of_link(robot, next + 1, scene) => (next + 1, 2),
            true => (next, 1),
            false if is_bone(next) && is_named(next + 1) => (next, 2),
            false => return None,
        };
        if scene.nodes[node].parent.map(NodeId::index) != above {
            return None;
        }
        nodes.push(node);
        next += taken;
    }
    (next == scene.nodes.len()).then_some(nodes)
}

/// Whether a node has the name of a link.
fn is_of_link(robot: &Robot, node: usize, scene: &Scene) -> bool {
    robot.links.iter().any(|link| link.name == scene.nodes[node].name)
}

/// Adds a node at the frame of each link whose bone begins elsewhere, with the name of the link. The node is a sibling
/// of the bone, so that every child of a bone is a joint. The frame of the base is a child of its bone.
fn keep_frames(scene: &mut Scene, begins: &[Vec3]) {
    let mut names: HashSet<String> = scene.nodes.iter().map(|node| node.name.clone()).collect();
    let mut moved: Vec<NodeId> = Vec::with_capacity(begins.len());
    let mut frames: Vec<Option<NodeId>> = Vec::with_capacity(begins.len());
    let mut nodes: Vec<Node> = Vec::with_capacity(begins.len());
    for (mut node, begin) in std::mem::take(&mut scene.nodes).into_iter().zip(begins) {
        node.parent = node.parent.map(|parent| moved[parent.index()]);
        if *begin == Vec3::ZERO {
            moved.push(NodeId::new(nodes.len()));
            frames.push(None);
            nodes.push(node);
            continue;
        }
        let mut frame = Node {
            name: node.name.clone(),
            kind: NodeKind::Joint,
            parent: node.parent,
            transform: node.transform * Mat4::from_translation(-*begin),
            ..Node::default()
        };
        node.name.push_str(BONE);
        while !names.insert(node.name.clone()) {
            node.name.push_str(BONE);
        }
        let here = NodeId::new(nodes.len());
        if frame.parent.is_some() {
            let bone = NodeId::new(nodes.len() + 1);
            moved.push(bone);
            frames.push(Some(here));
            nodes.extend([frame, node]);
        } else {
            frame.parent = Some(here);
            frame.transform = Mat4::from_translation(-*begin);
            moved.push(here);
            frames.push(None);
            nodes.extend([node, frame]);
        }
    }
    scene.nodes = nodes;
    for animation in &mut scene.animations {
        let channels = std::mem::take(&mut animation.channels);
        for mut channel in channels {
            if let Some(link) = channel.node.map(NodeId::index) {
                let frame = frames[link].map(|frame| at_frame(&channel, frame, begins[link]));
                channel.node = Some(moved[link]);
                channel.node_name.clone_from(&scene.nodes[moved[link].index()].name);
                animation.channels.extend(frame);
            }
            animation.channels.push(channel);
        }
    }
}

/// The channel of a link's frame, computed from the channel of a bone that begins elsewhere.
fn at_frame(bone: &Channel, frame: NodeId, begin: Vec3) -> Channel {
    let mut channel = Channel {
        node: Some(frame),
        ..bone.clone()
    };
    let rotations = &bone.rotation_keys.values;
    for (key, position) in channel.position_keys.values.iter_mut().enumerate() {
        *position -= rotation_at(rotations, key) * begin;
    }
    channel
}

/// The rotation at a key. A joint that never moves has one key.
fn rotation_at(rotations: &[Quat], key: usize) -> Quat {
    rotations.get(key).or(rotations.first()).copied().unwrap_or_default()
}

/// Moves the nodes of links that are bones to the starts of their bones. The origin of a link may be anywhere: the
/// origin of a thigh may be 12 cm below the hip. Rotations of links, and other nodes, do not change. Returns the start
/// of each bone in the coordinate frame of its link.
fn begin_at_bones(scene: &mut Scene, robot: &Robot, bones: &[RobotBone], t_pose: &RobotTPose) -> Vec<Vec3> {
    let mut begins = vec![Vec3::ZERO; robot.links.len()];
    for bone in bones {
        // A foot may be a part of its shin, which begins at the knee.
        if scene.nodes[bone.link].humanoid_bone == Some(bone.bone) {
            let start = t_pose.start(bone, bones);
            if start.length() > SAME_PLACE {
                begins[bone.link] = start.as_vec3();
            }
        }
    }
    let above = |node: usize| robot.links[node].parent.map_or(Vec3::ZERO, |parent| begins[parent]);
    for (index, node) in scene.nodes.iter_mut().enumerate() {
        let at = node.transform.transform_point3(begins[index]) - above(index);
        node.transform.w_axis = at.extend(1.0);
    }
    let channels = scene
        .animations
        .iter_mut()
        .flat_map(|animation| &mut animation.channels);
    for channel in channels {
        let Some(index) = channel.node.map(NodeId::index) else {
            continue;
        };
        let positions = &mut channel.position_keys.values;
        let rotations = &channel.rotation_keys.values;
        if begins[index] != Vec3::ZERO && positions.len() == 1 {
            positions.resize(rotations.len(), positions[0]);
        }
        for (key, position) in positions.iter_mut().enumerate() {
            *position += rotation_at(rotations, key) * begins[index] - above(index);
        }
    }
    begins
}

/// Rotates the links of a robot's scene from the rest pose to the T-pose. Links that move with a bone follow it. A
/// reader that treats the scene as a person then finds the rotation of each bone. The links keep their lengths.
fn rest_in_t_pose(scene: &mut Scene, robot: &Robot, t_pose: &RobotTPose) {
    let mut world: Vec<DQuat> = Vec::with_capacity(robot.links.len());
    let mut to_t_pose: Vec<DQuat> = Vec::with_capacity(robot.links.len());
    for (index, link) in robot.links.iter().enumerate() {
        let part = scene.nodes[index]
            .humanoid_bone
            .and_then(|bone| t_pose.parts.get(&bone));
        let above = link.parent.map_or(DQuat::IDENTITY, |parent| to_t_pose[parent]);
        to_t_pose.push(part.map_or(above, |part| part.to_t_pose));
        world.push(to_t_pose[index] * t_pose.zero_pose[index].rotation);
        let parent = link.parent.map_or(DQuat::IDENTITY, |parent| world[parent]);
        let rest = &mut scene.nodes[index].transform;
        let rotation = (parent.inverse() * world[index]).normalize().as_quat();
        *rest = Mat4::from_rotation_translation(rotation, rest.w_axis.truncate());
    }
}
