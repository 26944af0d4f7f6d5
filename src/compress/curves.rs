//! Curves, as FBX has them: a value of one axis with keys of its own and straight lines between them. A rotation is
//! three angles, each a curve.
//!
//! Programs differ in what they make of curves of angles. Most evaluate them; Blender and Assimp compute the rotation
//! at every key of any of the three, and interpolate these rotations. So a joint has, beside its curves, tracks with a
//! key wherever one of its curves has one, and [`measure`](super::measure) follows both.

use std::ops::Range;
use std::sync::Arc;

use glam::{DQuat, DVec3, Quat, Vec3};
use mocap_scene::math::quaternion::nlerp;
use mocap_scene::math::rotation::{euler_rot, to_euler_xyz};
use mocap_scene::scene::RotationOrder;

use super::key_frames::{self, KeyFrames, Refine};

/// How a file states the rotation of a node to its parent.
#[derive(Clone, Copy, Debug)]
#[doc(hidden)]
pub struct EulerAngles {
    #[doc(hidden)]
    pub order: RotationOrder,
    /// The part of the rotation that stands before the angles.
    #[doc(hidden)]
    pub pre_rotation: DQuat,
    /// The angles of the rest pose, in degrees about x, y and z.
    #[doc(hidden)]
    pub rest: DVec3,
}

impl EulerAngles {
    /// Of all angles of a rotation those nearest to `before`.
    fn angles(&self, rotation: DQuat, before: DVec3) -> DVec3 {
        to_euler_xyz(self.pre_rotation.conjugate() * rotation, self.order, before)
    }

    pub(super) fn rotation(&self, angles: DVec3) -> DQuat {
        let [a, b, c] = self.order.axes().map(|axis| angles[axis].to_radians());
        self.pre_rotation * DQuat::from_euler(euler_rot(self.order), a, b, c)
    }
}

/// The values of one axis, with straight lines between the keys.
#[derive(Clone, Debug)]
#[doc(hidden)]
pub struct Curve {
    #[doc(hidden)]
    pub key_frames: Arc<KeyFrames>,
    /// One per key frame.
    #[doc(hidden)]
    pub values: Vec<f32>,
}

impl Curve {
    /// With keys at these frames, in any order.
    fn at(mut frames: KeyFrames, value: impl Fn(usize) -> f64) -> Self {
        frames.sort_unstable();
        Self {
            values: frames.iter().map(|frame| value(*frame as usize) as f32).collect(),
            key_frames: Arc::new(frames),
        }
    }
}

/// The curves of a joint, of x, y and z each; none of what does not move.
#[doc(hidden)]
pub struct JointCurves {
    pub(super) euler: EulerAngles,
    #[doc(hidden)]
    pub translation: Option<[Curve; 3]>,
    /// Angles in degrees.
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

    /// Makes curves that are off by no more than `tolerance`. Returns the frames of all of their keys, and the values
    /// there.
    pub(super) fn reduce_translations(
        &mut self,
        targets: &[Vec3],
        ticks: &[f64],
        tolerance: f32,
    ) -> (KeyFrames, Vec<Vec3>) {
        let values: Vec<DVec3> = targets.iter().map(|target| target.as_dvec3()).collect();
        let error = |frame: usize, value: DVec3| values[frame].distance(value) as f32;
        let (curves, lossy) = reduce(&values, values[0], ticks, tolerance, error);
        let key_frames = union(&curves);
        let keys = key_frames
            .iter()
            .map(|frame| lossy[*frame as usize].as_vec3())
            .collect();
        self.translation = Some(curves);
        (key_frames, keys)
    }

    /// Makes curves of angles such that the `error` of a rotation at a frame is no more than `tolerance`. Returns the
    /// frames of all of their keys, and the rotations there.
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
        let of_angles = |frame: usize, angles: DVec3| error(frame, rotation(angles));
        let (mut curves, lossy) = reduce(&angles, euler.rest, ticks, tolerance, of_angles);
        let rotations: Vec<Quat> = lossy.iter().map(|angles| rotation(*angles)).collect();
        let of_curves = union(&curves);
        let key_frames = with_keys_between(of_curves.clone(), &rotations, ticks, tolerance, error);
        // A curve with many keys gets the new ones, where its line is.
        let most = if curves[0].values.len() > curves[1].values.len() {
            0
        } else {
            1
        };
        let most = if curves[2].values.len() > curves[most].values.len() {
            2
        } else {
            most
        };
        let new = key_frames
            .iter()
            .filter(|frame| of_curves.binary_search(frame).is_err());
        let new: KeyFrames = new.copied().collect();
        if !new.is_empty() {
            let frames = [curves[most].key_frames.as_slice(), &new].concat();
            curves[most] = Curve::at(frames, |frame| lossy[frame][most]);
        }
        let keys = key_frames.iter().map(|frame| rotations[*frame as usize]).collect();
        self.rotation = Some(curves);
        (key_frames, keys)
    }
}

/// Reduces the keys of one axis after another, that with the least range first. Each may be off by as much as those
/// before it leave of the tolerance, which was found by trials to take as few keys as fixed fractions. Returns the
/// curves, and the values of all frames.
pub fn reduce(
    values: &[DVec3],
    rest: DVec3,
    ticks: &[f64],
    tolerance: f32,
    error: impl Fn(usize, DVec3) -> f32,
) -> ([Curve; 3], Vec<DVec3>) {
    let least = values.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let most = values.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    let range = most - least;
    let mut axes = [0, 1, 2];
    axes.sort_by(|a, b| range[*a].total_cmp(&range[*b]));
    let mut lossy = values.to_vec();
    let mut curves: [Curve; 3] = std::array::from_fn(|_| Curve::at(Vec::new(), |_| 0.0));
    for axis in axes {
        let is_within = |lossy: &[DVec3], frame: usize, value: f64| {
            let mut of_frame = lossy[frame];
            of_frame[axis] = value;
            error(frame, of_frame) <= tolerance
        };
        let single = |value: f64| f64::from(value as f32);
        let middle = f64::midpoint(least[axis], most[axis]);
        let mut constants = [rest[axis], middle].into_iter().map(single);
        let is_enough = |value: &f64| (0..values.len()).all(|frame| is_within(&lossy, frame, *value));
        curves[axis] = match constants.find(is_enough) {
            Some(value) => Curve::at(vec![0], |_| value),
            None => {
                let key = |frame: usize| single(values[frame][axis]);
                let key_frames = key_frames::reduce(values.len(), |from, to| {
                    let (a, b) = (key(from), key(to));
                    let mut between = key_frames::between(ticks, from, to);
                    between.all(|(frame, alpha)| is_within(&lossy, frame, a + (b - a) * f64::from(alpha)))
                });
                Curve::at(key_frames, key)
            }
        };
        let Curve { key_frames, values } = &curves[axis];
        let all = std::iter::once(0..lossy.len()).collect::<Vec<_>>();
        key_frames::for_each_frame(key_frames, ticks, &all, |frame, key, alpha| {
            let from = f64::from(values[key]);
            let to = values.get(key + 1).map_or(from, |to| f64::from(*to));
            lossy[frame][axis] = from + (to - from) * f64::from(alpha);
        });
    }
    (curves, lossy)
}

/// Adds keys where the rotations between two of the frames, interpolated, have too large an error, although the angles
/// have not.
fn with_keys_between(
    mut key_frames: KeyFrames,
    rotations: &[Quat],
    ticks: &[f64],
    tolerance: f32,
    error: impl Fn(usize, Quat) -> f32,
) -> KeyFrames {
    let mut changed: Vec<Range<usize>> = std::iter::once(0..rotations.len()).collect();
    let mut errors = vec![0f32; rotations.len()];
    while !changed.is_empty() {
        let at = |key: usize| rotations[key_frames[key] as usize];
        key_frames::for_each_frame(&key_frames, ticks, &changed, |frame, key, alpha| {
            errors[frame] = match alpha > 0.0 {
                true => error(frame, nlerp(at(key), at(key + 1), alpha)),
                false => 0.0,
            };
        });
        (_, changed) = key_frames::refine(&mut key_frames, &errors, tolerance, Refine::Worst);
    }
    key_frames
}

/// The frames at which any of the curves has a key.
pub fn union(curves: &[Curve; 3]) -> KeyFrames {
    let frames = curves.iter().flat_map(|curve| curve.key_frames.iter().copied());
    let mut frames: KeyFrames = frames.collect();
    frames.sort_unstable();
    frames.dedup();
    frames
}
