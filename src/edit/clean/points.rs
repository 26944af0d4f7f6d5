//! Smooths the positions of joints in the world, and rotates the joints to reach them.
//!
//! Rotations that are smoothed one by one do not fit together. While a foot stands, the rotations of the leg and the
//! motion of the hips cancel, but their corrections do not. A standing foot and a waiting hand are at rest in the
//! world. So their positions can be smoothed strongly, and the joints above follow them. The rotation of a joint about
//! its own bone does not change.

use glam::{DVec3, Mat3, Quat, Vec3};
use mocap_scene::math::quaternion::exp;
use mocap_scene::pose::{Pose, Trs};
use mocap_scene::scene::NodeId;

use super::noise::{is_noise_of_distance, without_noise};
use super::pace::Bank;
use super::smoother::Positions;
use crate::frames::{Frames, tracks};
use crate::work::Work;

/// Moves the joints of `work`, whose rotations are smoothed, towards their smoothed positions. `noisy` has the frames
/// before the smoothing.
pub(super) fn follow(work: &mut Work<'_>, noisy: &Frames, bank: &Bank, in_most: bool) {
    let Some(carrier) = work.carrier() else { return };
    let carrier = work.frames.nodes()[carrier];
    let nodes: Vec<NodeId> = crate::body::and_below(work.scene, carrier).collect();
    let goals: Vec<Vec<Vec3>> = tracks(noisy, work.scene, &nodes)
        .into_iter()
        .map(|track| smoothed(track, work, bank, in_most))
        .collect();
    let skeleton = Skeleton::new(work, &nodes);
    let mut pose = Pose::rest(work.scene);
    let frames = 0..work.frames.len();
    let [world, joint_length, largest] =
        [work.weights.world, work.weights.joint_length, work.weights.largest_turn].map(|weight| weight as f32);
    let largest = largest.to_radians();
    for frame in frames {
        work.frames.pose(frame, &mut pose);
        let mut positions: Vec<Vec3> = nodes.iter().map(|node| pose.position(*node)).collect();
        let mut turns: Vec<Quat> = nodes
            .iter()
            .map(|node| Trs::from_matrix(pose.node_to_world[node.index()]).rotation)
            .collect();
        let lasting: Vec<Vec3> = (0..nodes.len())
            .map(|index| skeleton.offset(work, frame, index))
            .collect();
        let goals = goals.iter().zip(&positions);
        let goals: Vec<Vec3> = goals.map(|(goal, joint)| joint.lerp(goal[frame], world)).collect();
        positions[0] = goals[0];
        for index in 0..nodes.len() {
            if let Some(parent) = skeleton.parents[index] {
                positions[index] = positions[parent] + turns[parent] * lasting[index];
                if !skeleton.is_held[index] {
                    turns[index] = turns[parent] * skeleton.rest[index];
                    continue;
                }
            }
            let children = skeleton.children[index].iter();
            let pairs: Vec<(Vec3, Vec3)> = children
                .map(|child| (lasting[*child], goals[*child] - positions[index]))
                .collect();
            turns[index] = (turn(turns[index], &pairs, joint_length / work.metres, largest) * turns[index]).normalize();
        }
        skeleton.write(work, frame, &nodes, &positions, &turns, &pose);
    }
}

/// Smooths a track of positions if it has noise.
fn smoothed(track: Vec<Vec3>, work: &Work<'_>, bank: &Bank, in_most: bool) -> Vec<Vec3> {
    let values: Vec<DVec3> = track.iter().map(|position| position.as_dvec3()).collect();
    let is_noise = |noise: f64| is_noise_of_distance(noise * f64::from(work.metres), &work.weights, in_most);
    match without_noise::<Positions>(&values, &work.missing, work.frames.rate, bank, in_most, is_noise) {
        Some((smoothed, _)) => smoothed.into_iter().map(glam::DVec3::as_vec3).collect(),
        None => track,
    }
}

/// The small rotation in the world that brings the bones of a joint, turned by `rotation`, closest to their goals by
/// least squares. A rotation of one radian costs as much as a displacement of `per_radian`. The rotation is at most
/// `largest` radians.
fn turn(rotation: Quat, bones: &[(Vec3, Vec3)], per_radian: f32, largest: f32) -> Quat {
    let mut matrix = Mat3::from_diagonal(Vec3::splat(per_radian * per_radian));
    let mut right = Vec3::ZERO;
    for (offset, goal) in bones {
        let bone = rotation * *offset;
        let square = bone.length_squared();
        let goal = goal.normalize_or_zero() * square.sqrt();
        let outer = Mat3::from_cols(bone * bone.x, bone * bone.y, bone * bone.z);
        matrix += Mat3::from_diagonal(Vec3::splat(square)) - outer;
        right += bone.cross(goal);
    }
    let by = matrix.inverse() * right;
    match by.is_finite() {
        true => exp(by.clamp_length_max(largest)),
        false => Quat::IDENTITY,
    }
}

/// The hierarchy of the nodes below the carrier, by their indices in `nodes`.
struct Skeleton {
    parents: Vec<Option<usize>>,
    children: Vec<Vec<usize>>,
    is_held: Vec<bool>,
    rest: Vec<Quat>,
    offsets: Vec<Vec3>,
    nodes: Vec<NodeId>,
}

impl Skeleton {
    fn new(work: &Work<'_>, nodes: &[NodeId]) -> Self {
        let index_of = |node: NodeId| nodes.binary_search(&node).ok();
        let parent = |node: &NodeId| work.scene.nodes[node.index()].parent.and_then(index_of);
        let parents: Vec<Option<usize>> = nodes.iter().map(parent).collect();
        let mut children = vec![Vec::new(); nodes.len()];
        for (index, parent) in parents.iter().enumerate() {
            if let Some(parent) = parent {
                children[*parent].push(index);
            }
        }
        let rest = |node: &NodeId| Trs::from_matrix(work.scene.nodes[node.index()].transform);
        Self {
            parents,
            children,
            is_held: nodes
                .iter()
                .map(|node| work.frames.nodes().binary_search(node).is_ok())
                .collect(),
            rest: nodes.iter().map(|node| rest(node).rotation).collect(),
            offsets: nodes.iter().map(|node| rest(node).translation).collect(),
            nodes: nodes.to_vec(),
        }
    }

    /// The position of a node relative to its parent.
    fn offset(&self, work: &Work<'_>, frame: usize, index: usize) -> Vec3 {
        let held = work.frames.get(frame, self.nodes[index]);
        held.map_or(self.offsets[index], |trs| trs.translation)
    }

    /// Converts positions and rotations in the world to the local transforms of a frame.
    fn write(
        &self,
        work: &mut Work<'_>,
        frame: usize,
        nodes: &[NodeId],
        positions: &[Vec3],
        turns: &[Quat],
        pose: &Pose,
    ) {
        for (index, node) in nodes.iter().enumerate() {
            let Some(old) = work.frames.get(frame, *node) else {
                continue;
            };
            let (parent, translation) = match self.parents[index] {
                Some(parent) => (turns[parent], old.translation),
                None => {
                    let above = work.scene.nodes[node.index()].parent;
                    let above = above.map_or(glam::Mat4::IDENTITY, |above| pose.node_to_world[above.index()]);
                    let position = above.inverse().transform_point3(positions[index]);
                    (Trs::from_matrix(above).rotation, position)
                }
            };
            let rotation = (parent.inverse() * turns[index]).normalize();
            let rotation = mocap_scene::math::quaternion::in_hemisphere_of(old.rotation, rotation);
            work.frames.set(
                frame,
                *node,
                Trs {
                    translation,
                    rotation,
                    ..old
                },
            );
        }
    }
}
