//! Prepares track values for the file. Finds equal and constant values, and normalizes rotations.

use glam::{Quat, Vec3};

use mocap_compress::at_rest::{is_rotation_of_rest, is_translation_of_rest};
use mocap_scene::math::quaternion::unit;
use mocap_scene::scene::Keys;

/// The difference between scales from a program's matrix decomposition: a few roundings of 32-bit floats. In a
/// compressed clip, scales with differences of up to 200 times this value become one scale.
const SCALE_NOISE: f32 = 5e-7;

/// A track value: `N` floats in the file.
pub(super) trait Value<const N: usize>: Copy {
    /// Whether two values give the same transform.
    fn is_same(self, other: Self) -> bool;

    /// Whether a constant value equals the rest pose.
    fn is_of_rest(self, rest: Self) -> bool;

    /// The values for the file; `None` if a value is not finite.
    fn to_arrays(values: &mut dyn Iterator<Item = Self>) -> Option<Vec<[f32; N]>>;

    /// A value from its form in the file.
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
        // Adding zero turns -0 into 0.
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

    /// Unit quaternions, each in the hemisphere of the previous one, because some clients interpolate component by
    /// component.
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

/// The keys, with a new key in the middle between two keys that are half a turn apart and have a frame between them.
/// Such a turn is ambiguous: rounding and the signs of the quaternions would decide its direction. `None` if no key is
/// added.
pub fn with_middles(keys: &Keys<Quat>) -> Option<Keys<Quat>> {
    /// The largest cosine of half the angle between two keys that count as half a turn apart: they are within 0.01
    /// degrees of half a turn.
    const HALF_A_TURN: f32 = 1e-4;
    let ticks = keys.ticks.as_ref()?;
    let is_open = |pair: usize| {
        let has_frames = ticks[pair].floor() + 1.0 < ticks[pair + 1];
        has_frames && keys.values[pair].dot(keys.values[pair + 1]).abs() < HALF_A_TURN
    };
    let middles: Vec<f64> = (0..keys.len().saturating_sub(1))
        .filter(|pair| is_open(*pair))
        .map(|pair| f64::midpoint(ticks[pair], ticks[pair + 1]))
        .collect();
    if middles.is_empty() {
        return None;
    }
    let mut all: Vec<(f64, Quat)> = std::iter::zip(ticks.iter().copied(), keys.values.iter().copied()).collect();
    all.extend(middles.into_iter().filter_map(|tick| Some((tick, keys.sample(tick)?))));
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (ticks, values) = all.into_iter().unzip();
    Some(Keys::at_ticks(values, ticks))
}

/// A rotation of a compressed clip. If its length is 1 except for the rounding of its few decimals, the decimals stay
/// unchanged.
pub(super) fn rounded_unit(rotation: Quat) -> Quat {
    if (rotation.length_squared() - 1.0).abs() < 1e-5 {
        Quat::from_array(rotation.to_array().map(|c| c + 0.0))
    } else {
        unit(rotation).unwrap_or(rotation)
    }
}

/// The scale of a track whose values are equal except for rounding of 32-bit floats.
pub(super) fn nearly_constant_scale(keys: &Keys<Vec3>) -> Option<Vec3> {
    let first = *keys.values.first()?;
    let is_near = |value: &Vec3| value.abs_diff_eq(first, SCALE_NOISE * first.abs().max_element().max(1.0));
    (first.is_finite() && keys.values.iter().all(is_near)).then(|| without_noise(first))
}

/// Replaces scale components that are 1 except for rounding by 1.
pub(super) fn without_noise(scale: Vec3) -> Vec3 {
    Vec3::from_array(
        scale
            .to_array()
            .map(|c| if (c - 1.0).abs() <= SCALE_NOISE { 1.0 } else { c + 0.0 }),
    )
}
