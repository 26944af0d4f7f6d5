//! The scene of a moving robot with the bones of a person.

use glam::{DQuat, Mat4, Vec3};
use mocap_scene::scene::robot::Robot;
use mocap_scene::scene::{Animation, NodeId, Scene};

use super::t_pose::RobotTPose;
use super::{RobotBone, robot_bones, robot_scene};

/// A robot with an animation of [`robot_scene`]: at rest in its T-pose, with the nodes of bones where these begin.
pub fn scene_of_clip(robot: &Robot, clip: Option<Animation>) -> Scene {
    let mut scene = robot_scene(robot);
    scene.animations.extend(clip);
    if let Ok(bones) = robot_bones(robot, None)
        && let Ok(t_pose) = RobotTPose::new(robot, &bones)
    {
        begin_at_bones(&mut scene, robot, &bones, &t_pose);
        rest_in_t_pose(&mut scene, robot, &t_pose);
    }
    scene
}

/// Moves the nodes of links that are bones to where their bones begin. The frame of a link may be anywhere: that of a
/// thigh is 12 cm below the hip. How links are turned, and where the others are, stays.
fn begin_at_bones(scene: &mut Scene, robot: &Robot, bones: &[RobotBone], t_pose: &RobotTPose) {
    let mut begins = vec![Vec3::ZERO; robot.links.len()];
    for bone in bones {
        // A foot may be a part of its shin, which begins at the knee.
        if scene.nodes[bone.link].humanoid_bone == Some(bone.bone) {
            begins[bone.link] = t_pose.start(bone, bones).as_vec3();
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
        for (position, rotation) in positions.iter_mut().zip(rotations) {
            *position += *rotation * begins[index] - above(index);
        }
    }
}

/// Rotates the links of a robot's scene at rest to its T-pose. Links that move with a bone follow it. So whoever takes
/// the scene for a person finds which way each bone is turned. The links keep their lengths.
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
