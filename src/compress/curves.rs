//! Curves as in FBX: the values of one axis with separate keys and straight lines between them. A rotation is three
//! angles, each with a curve.
//!
//! Programs interpret the three curves of a rotation differently. Most evaluate each curve. Blender, Assimp and
//! three.js compute the rotation at every key of any of the three curves, and interpolate these rotations. For a
//! position, three.js repeats the last value of an axis that has no key at a time. So mocap puts the keys of all moving
//! axes at the same frames. A joint has both the curves and tracks with the same keys, and [`measure`](super::measure)
//! evaluates both.

use std::sync::Arc;

use glam::{DQuat, DVec3, Quat, Vec3};
use mocap_scene::math::quaternion::nlerp;
use mocap_scene::math::rotation::{euler_rot, to_euler_xyz};
use mocap_scene::scene::RotationOrder;

use super::key_frames::{self, KeyFrames};

/// The smallest angle in degrees between two keys at which three.js adds keys of its own, and omits the second key.
const LARGEST_SPAN: f64 = 180.0;

/// The form in which a file states the rotation of a node relative to its parent.
#[derive(Clone, Copy, Debug)]
#[doc(hidden)]
pub struct EulerAngles {
    #[doc(hidden)]
    pub order: RotationOrder,
    /// The constant rotation by which the rotation of the angles is multiplied from the left.
    #[doc(hidden)]
    pub pre_rotation: DQuat,
    /// The angles of the rest pose, in degrees about x, y and z.
    #[doc(hidden)]
    pub rest: DVec3,
}

impl EulerAngles {
    /// The angles of `rotation`, in degrees. Of all equivalent angles, the result is nearest to the angles `before`.
    fn angles(&self, rotation: DQuat, before: DVec3) -> DVec3 {
        to_euler_xyz(self.pre_rotation.conjugate() * rotation, self.order, before)
    }

    pub(super) fn rotation(&self, angles: DVec3) -> DQuat {
        let [a, b, c] = self.order.axes().map(|axis| angles[axis].to_radians());
        self.pre_rotation * DQuat::from_euler(euler_rot(self.order), a, b, c)
    }
}

/// The values of one axis, with linear interpolation between the keys.
#[derive(Clone, Debug)]
#[doc(hidden)]
pub struct Curve {
    #[doc(hidden)]
    pub key_frames: Arc<KeyFrames>,
    /// One value per key frame.
    #[doc(hidden)]
    pub values: Vec<f32>,
}

/// The curves of a joint for x, y and z; none for constant tracks.
#[doc(hidden)]
pub struct JointCurves {
    pub(super) euler: EulerAngles,
    #[doc(hidden)]
    pub translation: Option<[Curve; 3]>,
    /// The curves of the three angles, in degrees.
    #[doc(hidden)]
    pub rotation: Option<[Curve; 3]>,
}

impl JointCurves {
    pub(super) fn new(euler: EulerAngles) -> Self {
        Self {
            euler,
            translation: None,
            rotation: None,
        }
    }

    /// Makes curves with an error of at most `tolerance`. Returns the frames of all keys, and the values at these
    /// frames.
    pub(super) fn reduce_translations(
        &mut self,
        targets: &[Vec3],
        ticks: &[f64],
        tolerance: f32,
    ) -> (KeyFrames, Vec<Vec3>) {
        let values: Vec<DVec3> = targets.iter().map(|target| target.as_dvec3()).collect();
        let is_within = |frame: usize, value: DVec3| values[frame].distance(value) as f32 <= tolerance;
        let curves = reduce(&values, values[0], ticks, is_within, |_, _| true);
        let key_frames = key_frames_of(&curves);
        let keys = key_frames.iter().enumerate();
        let keys = keys.map(|(key, _)| curve_values(&curves, key).as_vec3()).collect();
        self.translation = Some(curves);
        (key_frames, keys)
    }

    /// Makes angle curves with an `error` of at most `tolerance` at every frame. Returns the frames of all keys, and
    /// the rotations at these frames.
    pub(super) fn reduce_rotations(
        &mut self,
        targets: impl Iterator<Item = Quat>,
        ticks: &[f64],
        tolerance: f32,
        error: impl Fn(usize, Quat) -> f32,
    ) -> (KeyFrames, Vec<Quat>) {
        let euler = self.euler;
        let mut before = euler.rest;
        let angles = targets.map(|target| {
            before = euler.angles(target.as_dquat(), before);
            before
        });
        let angles: Vec<DVec3> = angles.collect();
        let rotation = |angles: DVec3| -> Quat { euler.rotation(angles).as_quat() };
        let is_within = |frame: usize, angles: DVec3| error(frame, rotation(angles)) <= tolerance;
        let fits_arc = |from: (usize, DVec3), to: (usize, DVec3)| {
            let ends = [from.1, to.1].map(rotation);
            let mut between = key_frames::between(ticks, from.0, to.0);
            (to.1 - from.1).abs().max_element() < LARGEST_SPAN
                && between.all(|(frame, alpha)| error(frame, nlerp(ends[0], ends[1], alpha)) <= tolerance)
        };
        let curves = reduce(&angles, euler.rest, ticks, is_within, fits_arc);
        let key_frames = key_frames_of(&curves);
        let keys = key_frames.iter().enumerate();
        let keys = keys.map(|(key, _)| rotation(curve_values(&curves, key))).collect();
        self.rotation = Some(curves);
        (key_frames, keys)
    }
}

/// Reduces the keys of three axes. An axis has one key if its rest value, or the middle of its range, is a good enough
/// constant. The other axes have keys at the same frames. `is_within` checks the values at a frame. `fits` checks the
/// frames between two keys in addition to the lines between them.
pub fn reduce(
    values: &[DVec3],
    rest: DVec3,
    ticks: &[f64],
    is_within: impl Fn(usize, DVec3) -> bool,
    fits: impl Fn((usize, DVec3), (usize, DVec3)) -> bool,
) -> [Curve; 3] {
    let least = values.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let most = values.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    let range = most - least;
    let single = |value: f64| f64::from(value as f32);
    let mut axes = [0, 1, 2];
    axes.sort_by(|a, b| range[*a].total_cmp(&range[*b]));
    let mut keys: Vec<DVec3> = values
        .iter()
        .map(|value| DVec3::from_array(value.to_array().map(single)))
        .collect();
    let mut stays = [false; 3];
    for axis in axes {
        let middle = f64::midpoint(least[axis], most[axis]);
        let with = |key: DVec3, value: f64| {
            let mut key = key;
            key[axis] = value;
            key
        };
        let is_enough = |value: &f64| (0..keys.len()).all(|frame| is_within(frame, with(keys[frame], *value)));
        let constant = [rest[axis], middle].map(single).into_iter().find(is_enough);
        if let Some(value) = constant {
            stays[axis] = true;
            keys.iter_mut().for_each(|key| key[axis] = value);
        }
    }
    let key_frames = match stays {
        [true, true, true] => vec![0],
        _ => key_frames::reduce(values.len(), |from, to| {
            let (a, b) = (keys[from], keys[to]);
            let mut between = key_frames::between(ticks, from, to);
            between.all(|(frame, alpha)| is_within(frame, a + (b - a) * f64::from(alpha))) && fits((from, a), (to, b))
        }),
    };
    let (once, key_frames) = (Arc::new(vec![0]), Arc::new(key_frames));
    std::array::from_fn(|axis| {
        let key_frames = Arc::clone(if stays[axis] { &once } else { &key_frames });
        let values = key_frames.iter().map(|frame| keys[*frame as usize][axis] as f32);
        Curve {
            values: values.collect(),
            key_frames,
        }
    })
}

/// The key frames of the moving axes.
fn key_frames_of(curves: &[Curve; 3]) -> KeyFrames {
    let most = curves.iter().max_by_key(|curve| curve.values.len());
    most.map_or_else(Vec::new, |curve| curve.key_frames.to_vec())
}

/// The values at a key of the moving axes.
fn curve_values(curves: &[Curve; 3], key: usize) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|axis| {
        let values = &curves[axis].values;
        f64::from(*values.get(key).unwrap_or(&values[0]))
    }))
}
