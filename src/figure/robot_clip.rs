//! Converts the motion of a robot to an animation of its links.

use glam::{Quat, Vec3};
use mocap_scene::scene::robot::{Placement, Robot};
use mocap_scene::scene::{Animation, Channel, Keys, NodeId};

use super::ticks::Ticks;

/// An animation of [`robot_scene`](super::robot_bones::robot_scene). For each frame, the arguments have the placement
/// of the base and the positions of the joints. A joint that never moves has one key.
#[doc(hidden)]
pub fn robot_clip(robot: &Robot, name: &str, fps: f64, root: &[Placement], dof_pos: &[f64]) -> Animation {
    let joints = robot.moving_joints();
    let ticks: Vec<f64> = (0..root.len()).map(|frame| frame as f64).collect();
    let at = Ticks::new(&ticks);
    let channel = |link: usize, transforms: Vec<Placement>| {
        let mut rotations: Vec<Quat> = transforms
            .iter()
            .map(|transform| transform.rotation.as_quat())
            .collect();
        for index in 1..rotations.len() {
            if rotations[index].dot(rotations[index - 1]) < 0.0 {
                rotations[index] = -rotations[index];
            }
        }
        let positions: Vec<Vec3> = transforms
            .iter()
            .map(|transform| transform.translation.as_vec3())
            .collect();
        Channel {
            node_name: robot.links[link].name.clone(),
            node: Some(NodeId::new(link)),
            position_keys: at.keys(positions),
            rotation_keys: at.rotation_keys(rotations),
            scaling_keys: Keys::constant(Vec3::ONE),
        }
    };
    let frames = root.len();
    let mut channels = vec![channel(0, root.to_vec())];
    for (dof, &link) in joints.iter().enumerate().filter(|(_, link)| **link > 0) {
        let joint = &robot.links[link].joint;
        let transform = |frame: usize| joint.link_to_parent(dof_pos[frame * joints.len() + dof]);
        channels.push(channel(link, (0..frames).map(transform).collect()));
    }
    Animation {
        name: name.to_owned(),
        ticks_per_second: fps,
        duration: frames.saturating_sub(1) as f64,
        channels,
    }
}
