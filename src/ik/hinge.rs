//! Two bones whose middle joint is a hinge, as an elbow or a knee: where the limb is nearly straight, the hinge says to
//! which side it bends.

use glam::{DMat3, DQuat, DVec3, Quat, Vec3};

use super::arc;
use super::two_bone::{NO_DIRECTION, Triangle, direction};

/// The sine of the bend at which the bend that is seen counts as much as the hinge: 3 degrees.
const SEEN: f64 = 0.05;

/// The rotations of two bones in the world, to be applied after those that they have, that bring the end to a goal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HingeRotations {
    pub(crate) upper: Quat,
    /// It contains that of the first bone.
    pub(crate) lower: Quat,
}

/// The normal of the plane in which a limb bends, of unit length: that of its two bones, and the hinge where they are
/// nearly straight. `hinge` is the axis about which the second bone bends from the first, at right angles to it, in the
/// world. A limb that bends to the wrong side is taken for a straight one.
pub(crate) fn plane_normal(joints: [Vec3; 3], hinge: Vec3) -> Vec3 {
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

/// The rotations that bring the end of a limb to `goal`. `normals` are those of the plane in which it bends: as it is,
/// of [`plane_normal`], and as it is to be. Out of reach, the bones are straight towards the goal.
pub(crate) fn hinge_rotations(joints: [Vec3; 3], goal: Vec3, normals: [Vec3; 2]) -> Option<HingeRotations> {
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
    // What is left of rounding goes by the shortest rotation.
    let exact = |rotation: DQuat, from: DVec3, to: DVec3| arc(rotation * from, to, normal) * rotation;
    let (upper, lower) = (exact(upper, first, upper_way), exact(lower, second, lower_way));
    let found = HingeRotations {
        upper: upper.normalize().as_quat(),
        lower: lower.normalize().as_quat(),
    };
    (found.upper.is_finite() && found.lower.is_finite()).then_some(found)
}

/// The axes along a bone, across its plane, and in it.
fn frame(along: DVec3, normal: DVec3) -> Option<DMat3> {
    let along = along.try_normalize()?;
    let normal = normal.reject_from_normalized(along).try_normalize()?;
    Some(DMat3::from_cols(along, normal, along.cross(normal)))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn unit() -> impl Strategy<Value = Vec3> {
        prop::array::uniform3(-1f32..1.0).prop_filter_map("no direction", |toward| Vec3::from(toward).try_normalize())
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2_000))]

        /// Also a limb that is straight, of which only the hinge says how it bends.
        #[test]
        fn a_goal_within_reach_is_reached(
            toward in unit(), other in unit(), goal in unit(), bend in 0f32..2.5, lengths in (0.05f32..2.0, 0.05f32..2.0), fraction in 0f32..=1.0,
        ) {
            let hinge = toward.cross(other);
            prop_assume!(hinge.length() > 0.05);
            let (hinge, (a, b)) = (hinge.normalize(), lengths);
            let middle = toward * a;
            let joints = [Vec3::ZERO, middle, middle + Quat::from_axis_angle(hinge, bend) * toward * b];
            let goal = goal * ((a - b).abs() + fraction * (a + b - (a - b).abs()));
            let old = plane_normal(joints, hinge);
            prop_assert!(old.dot(hinge) > 0.999);
            prop_assume!(old.reject_from_normalized(goal.normalize_or(Vec3::X)).length() > 0.05);
            let found = hinge_rotations(joints, goal, [old, old]).unwrap();
            let knee = found.upper * joints[1];
            let end = knee + found.lower * (joints[2] - joints[1]);
            prop_assert!(end.distance(goal) < 1e-5, "{}", end.distance(goal));
            // The second bone still bends about the hinge, to the right side.
            let bent = knee.cross(end - knee);
            prop_assert!(bent.dot(old.reject_from_normalized(goal.normalize())) > -1e-5, "{bent}");
        }
    }
}
