//! An iterative solver for chains of any number of bones.
//!
//! Without limits the solver is FABRIK (Aristidou and Lasenby, 2011). FABRIK moves positions along the lines between
//! them, so bones keep their lengths and share the bend. It approaches the goal quickly at first, and then slowly. So a
//! last, exact step rotates two parts of the chain as two rigid bones. If these parts cannot reach the goal, the step
//! places one joint after the other. With limits the solver is cyclic coordinate descent. It rotates one joint after
//! the other, so it can clamp the rotation of each joint.

use glam::{DVec3, Vec3};

use super::goal::Goal;
use super::limit::JointLimit;
use super::two_bone::TwoBone;
use crate::math::quaternion::wide_arc;
use crate::options::setters;
use crate::pose::{Pose, Trs};
use crate::scene::NodeId;

/// The options of [`Pose::bend_chain`](crate::Pose::bend_chain).
///
/// [`Pose::bend_chain`](crate::Pose::bend_chain) has an example.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ChainOptions {
    /// The limits, one for each joint from the first. Joints without a limit are free.
    pub limits: Vec<JointLimit>,
    /// The largest accepted distance from the goal, in units of the scene. Default: 1e-4.
    pub tolerance: f32,
    /// The largest number of passes over the chain. Default: 100.
    pub passes: usize,
}

impl Default for ChainOptions {
    fn default() -> Self {
        Self {
            limits: Vec::new(),
            tolerance: 1e-4,
            passes: 100,
        }
    }
}

setters! {
    ChainOptions {
        limits: Vec<JointLimit>,
        tolerance: f32,
        passes: usize,
    }
}

impl ChainOptions {
    /// Moves the positions of a chain, from its first joint to its end, so that the end reaches `goal`. The first joint
    /// stays, and the bones keep their lengths. Returns the remaining distance of the end from the goal.
    ///
    /// Ignores the limits. If the goal is out of reach, the chain points straight at it.
    ///
    /// ```
    /// use mocap::glam::Vec3;
    /// use mocap::ik::ChainOptions;
    ///
    /// let mut tail = [0.0, 1.0, 2.0, 3.0].map(|x| Vec3::new(x, 0.0, 0.0));
    /// assert!(ChainOptions::default().bend_positions(&mut tail, Vec3::new(1.0, 1.0, 0.5)) < 1e-4);
    /// assert!((tail[2].distance(tail[1]) - 1.0).abs() < 1e-6);
    /// ```
    pub fn bend_positions(&self, positions: &mut [Vec3], goal: Vec3) -> f32 {
        let Some(end) = positions.last().copied() else {
            return 0.0;
        };
        let mut points: Vec<DVec3> = positions.iter().map(|point| point.as_dvec3()).collect();
        if goal.is_finite() && points.iter().all(|point| point.is_finite()) {
            fabrik(&mut points, goal.as_dvec3(), f64::from(self.tolerance), self.passes);
            if points.iter().all(|point| point.as_vec3().is_finite()) {
                for (position, point) in positions.iter_mut().zip(&points) {
                    *position = point.as_vec3();
                }
            }
        }
        positions.last().unwrap_or(&end).distance(goal)
    }
}

fn fabrik(points: &mut [DVec3], goal: DVec3, tolerance: f64, passes: usize) {
    let lengths: Vec<f64> = points.windows(2).map(|pair| pair[0].distance(pair[1])).collect();
    let reach: f64 = lengths.iter().sum();
    let (Some(&start), last) = (points.first(), points.len() - 1) else {
        return;
    };
    let to_goal = goal - start;
    if to_goal.length() >= reach {
        let to_goal = to_goal.normalize_or_zero();
        for (index, length) in lengths.iter().enumerate() {
            points[index + 1] = points[index] + to_goal * length;
        }
        return;
    }
    // Points in one line with the goal would stay in the line. So move them aside, alternately, by a tenth of each
    // bone.
    let aside = to_goal.try_normalize().unwrap_or(DVec3::X).any_orthonormal_vector();
    let axis = (points[last] - start).try_normalize().unwrap_or(aside);
    let is_straight = points
        .iter()
        .all(|point| (*point - start).reject_from_normalized(axis).length() < 1e-4 * reach);
    if is_straight && points[last].distance(goal) > tolerance {
        for (index, length) in lengths.iter().enumerate() {
            let sign = if index % 2 == 0 { 0.1 } else { -0.1 };
            points[index + 1] += aside * (sign * length);
        }
    }
    for _ in 0..passes {
        if is_met(points, &lengths, goal, tolerance) || close(points, goal, tolerance) {
            return;
        }
        points[last] = goal;
        for index in (0..last).rev() {
            points[index] =
                points[index + 1] + (points[index] - points[index + 1]).normalize_or(aside) * lengths[index];
        }
        points[0] = start;
        for index in 0..last {
            points[index + 1] =
                points[index] + (points[index + 1] - points[index]).normalize_or(aside) * lengths[index];
        }
    }
    if !close(points, goal, tolerance) && !is_met(points, &lengths, goal, tolerance) {
        place_in_turn(points, &lengths, goal, aside);
    }
}

/// Places one joint after the other, from the first. Each joint stays as near to its position as it can without putting
/// the goal out of reach of the remaining bones. This method is exact where FABRIK converges too slowly: if the goal is
/// almost at the nearest or farthest distance that the bones allow.
fn place_in_turn(points: &mut [DVec3], lengths: &[f64], goal: DVec3, aside: DVec3) {
    for (index, &length) in lengths.iter().enumerate() {
        let (here, next) = (points[index], points[index + 1]);
        let after = &lengths[index + 1..];
        let farthest: f64 = after.iter().sum();
        let longest = after.iter().copied().fold(0.0, f64::max);
        let distance = here.distance(goal);
        let least = (2.0 * longest - farthest).max((distance - length).abs());
        let most = farthest.min(distance + length);
        let left = next.distance(goal).min(most).max(least);
        // The circles about this joint and about the goal meet at this distance along the line from the joint to the
        // goal.
        let towards = (goal - here).normalize_or(aside);
        let along = ((distance * distance + length * length - left * left) / (2.0 * distance)).clamp(-length, length);
        let along = if along.is_nan() { 0.0 } else { along };
        let side = (next - here).reject_from_normalized(towards);
        let side = side.try_normalize().unwrap_or_else(|| towards.any_orthonormal_vector());
        points[index + 1] = here + towards * along + side * (length * length - along * along).max(0.0).sqrt();
    }
}

/// Whether the end is at the goal, and every bone has its original length.
fn is_met(points: &[DVec3], lengths: &[f64], goal: DVec3, tolerance: f64) -> bool {
    let is_kept = |(pair, length): (&[DVec3], &f64)| (pair[0].distance(pair[1]) - length).abs() <= 1e-9 * length;
    points.last().is_some_and(|end| end.distance(goal) <= tolerance) && points.windows(2).zip(lengths).all(is_kept)
}

/// Rotates the chain as two rigid parts: about its start, and about the joint between the parts. This joint is the one
/// that needs the smallest rotation. Returns `false` if no joint allows such a rotation. Also returns `false` if the
/// parts would rotate far, because the bones would then no longer share the bend.
fn close(points: &mut [DVec3], goal: DVec3, tolerance: f64) -> bool {
    /// The largest distance from the goal that this last step closes, as a fraction of the goal's distance from the
    /// start.
    const NEAR: f64 = 0.05;
    let (start, last) = (points[0], points.len() - 1);
    let distance = goal.distance(start);
    if last < 2 || points[last].distance(goal) > NEAR * distance {
        return false;
    }
    let room = |joint: usize| {
        let (a, b) = (points[joint].distance(start), points[joint].distance(points[last]));
        (a + b - distance).min(distance - (a - b).abs())
    };
    let Some(joint) = (1..last).max_by(|a, b| room(*a).total_cmp(&room(*b))) else {
        return false;
    };
    if room(joint) < 0.0 {
        return false;
    }
    // The positions are relative to the start of the chain, so single precision has enough digits.
    let local = |point: DVec3| (point - start).as_vec3();
    let found = TwoBone::solve(
        [Vec3::ZERO, local(points[joint]), local(points[last])],
        local(goal),
        None,
    );
    let (pivot, upper, lower) = (
        points[joint],
        found.upper.as_dquat().normalize(),
        found.lower.as_dquat().normalize(),
    );
    let new_pivot = start + upper * (pivot - start);
    for (index, point) in points.iter_mut().enumerate() {
        *point = match index <= joint {
            true => start + upper * (*point - start),
            false => new_pivot + lower * (*point - pivot),
        };
    }
    points[last].distance(goal) <= tolerance.max(1e-6 * distance)
}

impl Pose {
    /// Rotates the nodes of a chain, each an ancestor of the next, so that the last node reaches `goal`. If the goal
    /// has a rotation, also rotates the last node itself. Returns the remaining distance from the goal's position; 0 if
    /// the goal has no position.
    ///
    /// # Panics
    /// If the pose lacks one of the nodes.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::glam::Vec3;
    /// use mocap::ik::{ChainOptions, Goal, JointLimit};
    /// use mocap::{Pose, scene::NodeId};
    ///
    /// let scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
    /// let mut pose = Pose::at_tick(&scene, 0, 0.0).unwrap();
    /// let arm: Vec<NodeId> = (0..4).map(NodeId::new).collect(); // shoulder, elbow, wrist, and the tip of the hand
    /// // The shoulder is free, the elbow a hinge.
    /// let elbow = JointLimit::Hinge { rest: Default::default(), axis: Vec3::Z, min: -3.0, max: 3.0 };
    /// let options = ChainOptions::new().limits(vec![JointLimit::Free, elbow]).tolerance(1e-3);
    /// let goal = pose.position(arm[0]) + Vec3::new(1.0, 2.0, 0.0);
    /// assert!(pose.bend_chain(&arm, &Goal::at(goal), &options) < 0.01);
    /// # Ok::<(), mocap::Error>(())
    /// ```
    pub fn bend_chain(&mut self, nodes: &[NodeId], goal: &Goal, options: &ChainOptions) -> f32 {
        let Some((&end, joints)) = nodes.split_last() else {
            return 0.0;
        };
        let mut distance = 0.0;
        if let Some(position) = goal.position_from(self.position(end)) {
            if options.limits.iter().all(|limit| *limit == JointLimit::Free) {
                let mut positions: Vec<Vec3> = nodes.iter().map(|node| self.position(*node)).collect();
                options.bend_positions(&mut positions, position);
                for (index, &node) in joints.iter().enumerate() {
                    let from = self.position(nodes[index + 1]) - self.position(node);
                    turn(self, node, from, positions[index + 1] - self.position(node));
                }
            } else {
                for (&node, limit) in joints.iter().zip(&options.limits) {
                    clamp(self, node, limit);
                }
                cyclic_coordinate_descent(self, nodes, position, options);
            }
            distance = self.position(end).distance(position);
        }
        let rotation = Trs::from_matrix(self.node_to_world[end.index()]).rotation;
        if let Some(rotation) = goal.rotation_from(rotation) {
            self.rotate(end, rotation);
        }
        distance
    }
}

fn cyclic_coordinate_descent(pose: &mut Pose, nodes: &[NodeId], goal: Vec3, options: &ChainOptions) {
    let Some((&end, joints)) = nodes.split_last() else {
        return;
    };
    for _ in 0..options.passes {
        for (index, &node) in joints.iter().enumerate().rev() {
            if pose.position(end).distance(goal) <= options.tolerance {
                return;
            }
            let here = pose.position(node);
            let (from, to) = (pose.position(end) - here, goal - here);
            turn(pose, node, from, to);
            if let Some(limit) = options.limits.get(index) {
                clamp(pose, node, limit);
            }
        }
    }
}

/// Rotates `node` so that `from`, a direction in the world, becomes `to`.
fn turn(pose: &mut Pose, node: NodeId, from: Vec3, to: Vec3) {
    let (from, to) = (from.as_dvec3(), to.as_dvec3());
    let axis = from.try_normalize().map_or(DVec3::X, DVec3::any_orthonormal_vector);
    pose.rotate(node, wide_arc(from, to, axis).as_quat());
}

/// Clamps the rotation of `node`, relative to its parent, to `limit`.
fn clamp(pose: &mut Pose, node: NodeId, limit: &JointLimit) {
    if *limit != JointLimit::Free {
        let trs = Trs::from_matrix(pose.node_to_parent[node.index()]);
        let rotation = limit.clamp(trs.rotation);
        pose.node_to_parent[node.index()] = Trs { rotation, ..trs }.matrix();
        pose.update_below(node);
    }
}
