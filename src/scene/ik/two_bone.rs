//! An exact solver for two bones, such as an arm or a leg, by the law of cosines.

use glam::{DVec3, Quat, Vec3};

use super::goal::Goal;
use crate::math::quaternion::wide_arc;
use crate::pose::{Pose, Trs};
use crate::scene::NodeId;

/// The fraction of a bone's length below which a direction is undefined: the rounding of single precision.
pub(super) const NO_DIRECTION: f64 = 1e-6;

/// The rotations of two bones that reach a goal.
///
/// [`Pose::bend_limb`](crate::Pose::bend_limb) has an example.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct TwoBone {
    /// The world rotation of the first bone, to apply after its present rotation.
    pub upper: Quat,
    /// The world rotation of the second bone, to apply after its present rotation. It includes the rotation of the
    /// first bone.
    pub lower: Quat,
    /// The new position of the joint between the bones.
    pub middle: Vec3,
    /// The new position of the end of the second bone.
    pub end: Vec3,
    /// The distance of the end from the goal. Within reach it is 0, except for rounding.
    pub distance: f32,
}

impl TwoBone {
    /// The rotations that bring the end of two bones to `goal`. `joints` are the positions of the first joint, of the
    /// joint between the bones, and of the end.
    ///
    /// If the goal is out of reach, the bones point straight at it. If the goal is nearer than the bones can fold, they
    /// fold as far as possible. The bending plane rotates with the direction of the end, by the smallest rotation, so
    /// that no bone twists. With the position `pole`, the middle joint bends towards the pole.
    ///
    /// ```
    /// use mocap::glam::Vec3;
    /// use mocap::ik::TwoBone;
    ///
    /// let leg = [Vec3::Y, Vec3::new(0.0, 0.5, 0.1), Vec3::ZERO];
    /// let found = TwoBone::solve(leg, Vec3::new(0.2, 0.3, 0.0), None);
    /// let end = leg[0] + found.upper * (leg[1] - leg[0]) + found.lower * (leg[2] - leg[1]);
    /// assert!(end.distance(Vec3::new(0.2, 0.3, 0.0)) < 1e-6);
    /// ```
    pub fn solve(joints: [Vec3; 3], goal: Vec3, pole: Option<Vec3>) -> TwoBone {
        let still = TwoBone {
            upper: Quat::IDENTITY,
            lower: Quat::IDENTITY,
            middle: joints[1],
            end: joints[2],
            distance: joints[2].distance(goal),
        };
        let [start, middle, end] = joints.map(Vec3::as_dvec3);
        let goal = goal.as_dvec3();
        let (first, second) = (middle - start, end - middle);
        let (a, b) = (first.length(), second.length());
        if !((a + b).is_finite() && a + b > 0.0 && goal.is_finite()) {
            return still;
        }
        let nothing = NO_DIRECTION * (a + b);
        // The directions from the first joint to the end, and from the first joint to the goal.
        let old = direction(end - start, nothing)
            .or_else(|| direction(first, 0.0))
            .or_else(|| direction(second, 0.0))
            .unwrap_or(DVec3::X);
        let to_goal = goal - start;
        let new = direction(to_goal, nothing).unwrap_or(old);
        // `along` is the distance of the middle joint along the line to the goal; `aside` is its distance from this
        // line.
        let Triangle { reach, along, aside } = Triangle::new(a, b, to_goal.length());

        let mut turn = wide_arc(old, new, old.any_orthonormal_vector());
        let bend_now = direction(first.reject_from_normalized(old), nothing).map(|bend| turn * bend);
        let to_pole = pole
            .map(|pole| pole.as_dvec3() - start)
            .filter(|offset| offset.is_finite());
        let to_pole = to_pole.and_then(|offset| direction(offset.reject_from_normalized(new), nothing));
        if let (Some(from), Some(to)) = (bend_now, to_pole) {
            turn = wide_arc(from, to, new) * turn;
        }
        let bend = to_pole.or(bend_now).unwrap_or_else(|| new.any_orthonormal_vector());
        // `bend` must be exactly perpendicular to `new`, or the bones would not keep their lengths.
        let bend = bend.reject_from_normalized(new).normalize();
        let normal = new.cross(bend);

        let upper_way = new * along + bend * aside;
        let lower_way = new * reach - upper_way;
        let upper = wide_arc(turn * first, upper_way, normal) * turn;
        let lower = wide_arc(turn * second, lower_way, normal) * turn;
        let (middle, end) = (start + upper_way, start + new * reach);
        let found = TwoBone {
            upper: upper.normalize().as_quat(),
            lower: lower.normalize().as_quat(),
            middle: middle.as_vec3(),
            end: end.as_vec3(),
            distance: end.distance(goal) as f32,
        };
        let is_finite = found.upper.is_finite() && found.lower.is_finite() && found.middle.is_finite();
        if is_finite { found } else { still }
    }
}

/// The triangle of two bones and the line from their start to their end, by the law of cosines.
pub(super) struct Triangle {
    /// The length of the line: the requested distance, or the nearest that the bones allow.
    pub(super) reach: f64,
    /// The position of the middle joint along the line.
    pub(super) along: f64,
    /// The distance of the middle joint from the line.
    pub(super) aside: f64,
}

impl Triangle {
    /// `a` and `b` are the lengths of the bones.
    pub(super) fn new(a: f64, b: f64, distance: f64) -> Self {
        let reach = distance.clamp((a - b).abs(), a + b);
        let along = match reach > NO_DIRECTION * (a + b) {
            true => ((reach * reach + a * a - b * b) / (2.0 * reach)).clamp(-a, a),
            false => 0.0,
        };
        let aside = (a * a - along * along).max(0.0).sqrt();
        Self { reach, along, aside }
    }
}

pub(super) fn direction(vector: DVec3, nothing: f64) -> Option<DVec3> {
    (vector.length() > nothing).then(|| vector.try_normalize()).flatten()
}

impl Pose {
    /// Rotates the joints `limb[0]` and `limb[1]` so that their descendant `limb[2]` reaches `goal`. If the goal has a
    /// rotation, also rotates `limb[2]` itself. Returns the remaining distance from the goal's position; 0 if the goal
    /// has no position.
    ///
    /// Nodes between the three, such as twist joints, move along. `pole` and goals out of reach work as in
    /// [`TwoBone::solve`](crate::ik::TwoBone::solve).
    ///
    /// # Panics
    /// If the pose lacks one of the nodes.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::glam::Vec3;
    /// use mocap::ik::Goal;
    /// use mocap::{Pose, scene::NodeId};
    ///
    /// let scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
    /// let mut pose = Pose::at_tick(&scene, 0, 0.0).unwrap();
    /// let arm = [0, 1, 2].map(NodeId::new); // shoulder, elbow, wrist
    /// let goal = pose.position(arm[0]) + Vec3::new(1.0, 1.0, 0.5);
    /// assert!(pose.bend_limb(arm, &Goal::at(goal), None) < 1e-5);
    /// # Ok::<(), mocap::Error>(())
    /// ```
    pub fn bend_limb(&mut self, limb: [NodeId; 3], goal: &Goal, pole: Option<Vec3>) -> f32 {
        self.bend_by(limb, goal, |joints, position| {
            let found = TwoBone::solve(joints, position, pole);
            Some([found.upper, found.lower])
        })
    }

    /// Bends a limb as [`Pose::bend_limb`] does. `solve` returns the world rotations of the two bones from the
    /// positions of the joints and of the goal.
    pub(super) fn bend_by(
        &mut self,
        limb: [NodeId; 3],
        goal: &Goal,
        solve: impl Fn([Vec3; 3], Vec3) -> Option<[Quat; 2]>,
    ) -> f32 {
        let [start, middle, end] = limb;
        let mut distance = 0.0;
        if let Some(position) = goal.position_from(self.position(end)) {
            let joints = limb.map(|joint| self.position(joint));
            if let Some([upper, lower]) = solve(joints, position) {
                self.rotate(start, upper);
                self.rotate(middle, (lower.as_dquat() * upper.as_dquat().inverse()).as_quat());
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
