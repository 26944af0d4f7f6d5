//! The values of tracks: equal ones, constant ones, and rotations as unit quaternions.

use glam::{Quat, Vec3};

use crate::compress::at_rest::{is_rotation_of_rest, is_translation_of_rest};
use crate::scene::Keys;

/// The difference between scales that programs make where they take a matrix apart: a few roundings of 32-bit floats. A
/// compressed clip has one scale at all frames anyway, up to 200 times this.
const SCALE_NOISE: f32 = 5e-7;

/// A value of a track: `N` floats in the file.
pub(super) trait Value<const N: usize>: Copy {
    /// Whether two values give the same transform.
    fn is_same(self, other: Self) -> bool;

    /// Whether a value that stays constant is that of the rest pose.
    fn is_of_rest(self, rest: Self) -> bool;

    /// The values for the file; `None` if one is not finite.
    fn to_arrays(values: &mut dyn Iterator<Item = Self>) -> Option<Vec<[f32; N]>>;

    /// A value in the units of the file.
    fn from(array: [f32; N]) -> Self;
}

impl Value<3> for Vec3 {
    fn is_same(self, other: Self) -> bool {
        self == other
    }

    fn is_of_rest(self, rest: Self) -> bool {
        is_translation_of_rest(self, rest)
    }

    fn to_arrays(values: &mut dyn Iterator<Item = Self>) -> Option<Vec<[f32; 3]>> {
        // Adding zero makes -0 a plain 0.
        values
            .map(|value| value.is_finite().then(|| (value + Vec3::ZERO).to_array()))
            .collect()
    }

    fn from(array: [f32; 3]) -> Self {
        Self::from_array(array)
    }
}

impl Value<4> for Quat {
    fn is_same(self, other: Self) -> bool {
        self == other || self == -other
    }

    fn is_of_rest(self, rest: Self) -> bool {
        is_rotation_of_rest(self, rest)
    }

    /// Unit quaternions, each in the hemisphere of the one before: some clients blend component by component.
    fn to_arrays(values: &mut dyn Iterator<Item = Self>) -> Option<Vec<[f32; 4]>> {
        let mut previous = None;
        let continuous = values.map(|value| {
            let rotation = unit(value)?;
            let turned = previous.is_some_and(|previous| rotation.dot(previous) < 0.0);
            let rotation = if turned { -rotation } else { rotation };
            previous = Some(rotation);
            Some(rotation.to_array())
        });
        continuous.collect()
    }

    fn from(array: [f32; 4]) -> Self {
        Self::from_array(array)
    }
}

pub(super) fn is_constant<T: Value<N>, const N: usize>(keys: &Keys<T>) -> bool {
    keys.values.windows(2).all(|pair| pair[0].is_same(pair[1]))
}

/// A rotation of a compressed clip with its few decimals, where its length is 1 but for their rounding.
pub(super) fn rounded_unit(rotation: Quat) -> Quat {
    if (rotation.length_squared() - 1.0).abs() < 1e-5 {
        Quat::from_array(rotation.to_array().map(|c| c + 0.0))
    } else {
        unit(rotation).unwrap_or(rotation)
    }
}

/// The one scale of a track whose values are all equal but for the rounding of 32-bit floats.
pub(super) fn nearly_constant_scale(keys: &Keys<Vec3>) -> Option<Vec3> {
    let first = *keys.values.first()?;
    let is_near = |value: &Vec3| value.abs_diff_eq(first, SCALE_NOISE * first.abs().max_element().max(1.0));
    (first.is_finite() && keys.values.iter().all(is_near)).then(|| without_noise(first))
}

/// A scale with 1 instead of what is 1 but for rounding.
pub(super) fn without_noise(scale: Vec3) -> Vec3 {
    Vec3::from_array(
        scale
            .to_array()
            .map(|c| if (c - 1.0).abs() <= SCALE_NOISE { 1.0 } else { c + 0.0 }),
    )
}

/// `rotation` normalised in double precision and rounded once, without minus zeros; `None` if it is not a rotation.
pub(super) fn unit(rotation: Quat) -> Option<Quat> {
    let rotation = rotation.as_dquat();
    let length = rotation.length();
    (length.is_finite() && length > 0.0)
        .then(|| Quat::from_array((rotation / length).to_array().map(|c| c as f32 + 0.0)))
}
