//! Two bones with a hinge between them, such as an elbow or a knee. If the limb is nearly straight, the hinge
//! determines the side to which it bends.

use glam::{DMat3, DQuat, DVec3, Quat, Vec3};

use super::goal::Goal;
use super::two_bone::{NO_DIRECTION, Triangle, direction};
use crate::math::directions::rotation_of;
use crate::math::quaternion::wide_arc;
use crate::pose::Pose;
use crate::scene::NodeId;

/// The sine of the bend at which the visible bend and the hinge have equal weight: 3 degrees.
const SEEN: f64 = 0.05;

/// The largest weight of a hinge against the visible bend. A bend is measured as the distance of the middle joint from
/// the line between the ends, in lengths of the first bone. The constant is the measure of a bend of 2.3 degrees. A
/// joint that is bent backwards by more than this angle stays bent backwards.
pub const MOST_OF_HINGE: f64 = 0.02;

/// World rotations of two bones that bring the end to a goal, to apply after the present rotations of the bones.
#[derive(Clone, Copy, Debug)]
#[doc(hidden)]
pub struct HingeRotations {
    #[doc(hidden)]
    pub upper: Quat,
    /// The rotation of the second bone, which includes the rotation of the first.
    #[doc(hidden)]
    pub lower: Quat,
}

/// The unit normal of the plane in which a limb bends. It is the normal of the two bones or, if these are nearly
/// straight, the hinge. `hinge` is the axis in the world about which the second bone bends relative to the first. This
/// axis is at right angles to the first bone. A limb that bends to the wrong side counts as straight.
#[doc(hidden)]
pub fn plane_normal(joints: [Vec3; 3], hinge: Vec3) -> Vec3 {
    let [start, middle, end] = joints.map(Vec3::as_dvec3);
    let (first, second) = (middle - start, end - middle);
    let upper = first.normalize_or_zero();
    let seen = upper.cross(second.normalize_or_zero());
    let hinge = hinge.as_dvec3().reject_from(upper.try_normalize().unwrap_or(DVec3::X));
    let Some(hinge) = hinge.try_normalize() else {
        let normal = seen.try_normalize();
        return normal.unwrap_or_else(|| upper.any_orthonormal_vector()).as_vec3();
    };
    let to_the_right_side = seen - hinge * seen.dot(hinge).min(0.0);
    (to_the_right_side + SEEN * hinge).normalize().as_vec3()
}

/// The rotations that bring the end of a limb to `goal`. `normals` are the current normal of the bending plane, from
/// [`plane_normal`], and the wanted one. If the goal is out of reach, the bones point straight at it.
#[doc(hidden)]
pub fn hinge_rotations(joints: [Vec3; 3], goal: Vec3, normals: [Vec3; 2]) -> Option<HingeRotations> {
    let [start, middle, end] = joints.map(Vec3::as_dvec3);
    let (first, second) = (middle - start, end - middle);
    let (a, b) = (first.length(), second.length());
    let nothing = NO_DIRECTION * (a + b);
    if !(a.min(b) > nothing && goal.is_finite()) {
        return None;
    }
    let to_goal = goal.as_dvec3() - start;
    let new = direction(to_goal, nothing).or_else(|| direction(end - start, nothing))?;
    let normal = direction(normals[1].as_dvec3().reject_from_normalized(new), 0.0)?;
    let Triangle { reach, along, aside } = Triangle::new(a, b, to_goal.length());
    let upper_way = new * along + new.cross(normal) * aside;
    let lower_way = new * reach - upper_way;
    let turn = |from: DVec3, to: DVec3| {
        let about = normals[0].as_dvec3();
        Some(frame(to, normal)? * frame(from, about)?.transpose())
    };
    let rotation = |from: DVec3, to: DVec3| Some(DQuat::from_mat3(&turn(from, to)?).normalize());
    let (upper, lower) = (rotation(first, upper_way)?, rotation(second, lower_way)?);
    // The shortest rotation removes the remaining rounding error.
    let exact = |rotation: DQuat, from: DVec3, to: DVec3| wide_arc(rotation * from, to, normal) * rotation;
    let (upper, lower) = (exact(upper, first, upper_way), exact(lower, second, lower_way));
    let found = HingeRotations {
        upper: upper.normalize().as_quat(),
        lower: lower.normalize().as_quat(),
    };
    (found.upper.is_finite() && found.lower.is_finite()).then_some(found)
}

/// The axis about which a limb is bent in a pose, in the axes of its first joint. Its length is the sine of the bend.
#[doc(hidden)]
pub fn seen_hinge(pose: &Pose, limb: [NodeId; 3]) -> Vec3 {
    let [start, middle, end] = limb.map(|node| pose.position(node));
    let (upper, lower) = ((middle - start).normalize_or_zero(), (end - middle).normalize_or_zero());
    rotation_of(&pose.node_to_world[limb[0].index()]).inverse() * upper.cross(lower)
}

/// The rotations that bring the end of a limb to `goal`. The bending plane rotates with the direction of the end, by
/// the smallest rotation. If the limb is nearly straight and has to bend more, noise decides the plane. So the hinge
/// gets a weight: the increase of the middle joint's distance from the line between the ends, up to [`MOST_OF_HINGE`].
/// `hinge` is as in [`plane_normal`].
#[doc(hidden)]
pub fn bend_about_hinge(joints: [Vec3; 3], goal: Vec3, hinge: Vec3) -> Option<HingeRotations> {
    let [start, middle, end] = joints.map(Vec3::as_dvec3);
    let (first, second) = (middle - start, end - middle);
    let (a, b) = (first.length(), second.length());
    let nothing = NO_DIRECTION * (a + b);
    let to_goal = goal.as_dvec3() - start;
    let old = direction(end - start, nothing).or_else(|| direction(first, nothing))?;
    let new = direction(to_goal, nothing).unwrap_or(old);
    let aside = |distance: f64| Triangle::new(a, b, distance).aside;
    let more = aside(to_goal.length()) - aside(end.distance(start));
    let hinge = hinge.as_dvec3().reject_from_normalized(old).normalize_or_zero();
    let seen = first.cross(old);
    let normal = (seen + more.clamp(0.0, MOST_OF_HINGE * a) * hinge).try_normalize()?;
    let turned = wide_arc(old, new, normal) * normal;
    hinge_rotations(joints, goal, [normal.as_vec3(), turned.as_vec3()])
}

impl Pose {
    /// Bends a limb as [`Pose::bend_limb`] does, for a limb with a hinge at the middle joint. The hinge axis is in the
    /// axes of the first joint.
    #[doc(hidden)]
    pub fn bend_hinged_limb(&mut self, limb: [NodeId; 3], goal: &Goal, hinge: Vec3) -> f32 {
        let hinge = rotation_of(&self.node_to_world[limb[0].index()]) * hinge;
        self.bend_by(limb, goal, |joints, position| {
            let found = bend_about_hinge(joints, position, hinge)?;
            Some([found.upper, found.lower])
        })
    }
}

/// Three axes: along a bone, normal to the bending plane, and the third at right angles to both.
fn frame(along: DVec3, normal: DVec3) -> Option<DMat3> {
    let along = along.try_normalize()?;
    let normal = normal.reject_from_normalized(along).try_normalize()?;
    Some(DMat3::from_cols(along, normal, along.cross(normal)))
}
