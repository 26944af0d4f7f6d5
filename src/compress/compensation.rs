//! Error compensation: encodes each joint relative to the parent that a reader decodes (the *lossy* parent), not
//! relative to the parent in the raw clip.
//!
//! Errors accumulate along a chain: a hand has the errors of all its ancestors. So the target of a joint is the
//! rotation, relative to the lossy parent, that puts the joint's children at their positions in the raw clip. The
//! position of the joint itself keeps a small error. At the end of a chain, the error is hardly more than the error of
//! the last joint.
//!
//! N. Frechette calls this in-place correction: "Animation Compression: Error Compensation",
//! <https://nfrechette.github.io/2016/12/22/anim_compression_error_compensation/>

use glam::{Quat, Vec3};
use mocap_scene::math::quaternion::{in_hemisphere_of, mean};
use mocap_scene::math::soa::single::{LANES, Lanes, Quaternions, Vectors};

use super::error_metric::{LeverArms, small_rotation_vector};
use super::key_frames;
use super::object_space::ObjectSpaceTrack;
use super::quantize::{QuantizedRotation, RotationFormat};

/// A joint and its lossy parent, for the computation of targets.
pub struct Compensation<'a> {
    pub arms: &'a LeverArms,
    pub raw: &'a ObjectSpaceTrack,
    /// The decoded positions in object space. They follow from the parent and the translation.
    pub lossy_positions: &'a [Vec3],
    pub lossy_parent: Option<&'a ObjectSpaceTrack>,
}

/// The target of a joint's rotation at one frame.
pub struct Target {
    /// The best rotation relative to the lossy parent.
    pub(super) rotation: Quat,
    /// The rotation from the axes of the lossy parent to the axes of the raw joint. Its product with a rotation
    /// relative to the lossy parent is the rotation error of the joint.
    parent_to_raw: Quat,
    /// The vector from the correct to the decoded position, in the joint's own axes.
    position_error: Vec3,
    /// The remaining rotation error (axis times angle) of the best rotation.
    rotation_error: Vec3,
}

impl Target {
    /// The error in metres that remains if the joint has this `rotation` relative to its lossy parent.
    pub(super) fn error(&self, arms: &LeverArms, rotation: Quat) -> f32 {
        arms.error(self.position_error, self.parent_to_raw * rotation)
    }

    /// The smallest change that brings the error of a rotation to `goal`. `off` is the difference between the rotation
    /// and the best rotation. The change and `off` are rotation vectors in the axes of the joint. If the error is at
    /// most `largest`, no change is needed, and the result is `None`.
    #[inline]
    pub(super) fn correction(&self, arms: &LeverArms, off: Vec3, largest: f32, goal: f32) -> Option<Vec3> {
        arms.correction(self.position_error, self.rotation_error + off, largest, goal)
    }
}

/// The targets at several frames: see [`Target`].
pub(super) struct Targets {
    pub(super) rotation: Quaternions,
    pub(super) parent_to_raw: Quaternions,
    pub(super) position_error: Vectors,
}

impl Targets {
    fn at(&self, lane: usize) -> Target {
        let rotation = Quat::from_array(self.rotation.lane(lane));
        let parent_to_raw = Quat::from_array(self.parent_to_raw.lane(lane));
        Target {
            rotation,
            parent_to_raw,
            position_error: Vec3::from_array(self.position_error.lane(lane)),
            rotation_error: small_rotation_vector(parent_to_raw * rotation),
        }
    }

    /// The largest error in metres that remains with `keys`. There is one key for each frame.
    #[inline(always)]
    pub(super) fn largest_error(&self, arms: &LeverArms, keys: &[QuantizedRotation]) -> f32 {
        let values = Quaternions::of(|lane| keys[lane.min(keys.len() - 1)].value.to_array());
        let error = self.parent_to_raw * values;
        let error = error.xyz() * Lanes::all(2.0).negated_where_negative(error.w);
        let squares = arms.squared_errors(self.position_error, error);
        let mut largest = 0f32;
        for square in squares.0 {
            largest = largest.max(square);
        }
        largest.sqrt()
    }
}

impl Compensation<'_> {
    /// The targets at `frames`, at most as many as there are lanes. If there are fewer frames, the last target fills
    /// the other lanes.
    #[inline(always)]
    pub(super) fn targets(&self, frames: &[u32]) -> Targets {
        let to_raw = rotations_at(&self.raw.rotations, frames).conjugate();
        let position_error = positions_at(self.lossy_positions, frames) - positions_at(&self.raw.positions, frames);
        let position_error = to_raw * position_error;
        let parent_to_raw = match self.lossy_parent {
            None => to_raw,
            Some(parent) => to_raw * rotations_at(&parent.rotations, frames),
        };
        let [x, y, z] = self.arms.counter_rotation;
        let half = Lanes::all(0.5);
        let counter_rotation = Quaternions {
            x: Vectors::all(x).dot(position_error) * half,
            y: Vectors::all(y).dot(position_error) * half,
            z: Vectors::all(z).dot(position_error) * half,
            w: Lanes::ONE,
        };
        Targets {
            rotation: (parent_to_raw.conjugate() * counter_rotation).normalize(),
            parent_to_raw,
            position_error,
        }
    }

    /// The targets at any number of frames, in order.
    fn each_target(&self, frames: &[u32]) -> impl Iterator<Item = Target> {
        frames.chunks(LANES).flat_map(|frames| {
            let targets = self.targets(frames);
            (0..frames.len()).map(move |lane| targets.at(lane))
        })
    }

    pub fn all_targets(&self) -> Vec<Target> {
        self.each_target(&key_frames::every_frame(self.lossy_positions.len()))
            .collect()
    }

    /// The mean of all targets as a constant rotation, if its error is within `tolerance` at every frame.
    pub(super) fn constant_rotation(&self, tolerance: f32) -> Option<Quat> {
        let last = self.lossy_positions.len().checked_sub(1)?;
        // For most joints, three frames suffice to see that they rotate too much.
        let three: Vec<Target> = self.each_target(&[0, last.div_ceil(2) as u32, last as u32]).collect();
        let first = three[0].rotation;
        let add = |sum: Quat, target: &Target| sum + in_hemisphere_of(first, target.rotation);
        let guess = three.iter().fold(first * 0.0, add).normalize();
        if three
            .iter()
            .any(|target| target.error(self.arms, guess) > 2.0 * tolerance)
        {
            return None;
        }
        let targets = self.all_targets();
        let rotations: Vec<Quat> = targets.iter().map(|target| target.rotation).collect();
        let mean = mean(&rotations)?;
        let fits = targets.iter().all(|target| target.error(self.arms, mean) <= tolerance);
        fits.then_some(mean)
    }

    /// The stored rotations nearest to the targets at the key frames.
    pub(super) fn quantize(&self, format: RotationFormat, key_frames: &[u32]) -> Vec<QuantizedRotation> {
        let mut keys: Vec<QuantizedRotation> = Vec::with_capacity(key_frames.len());
        for target in self.each_target(key_frames) {
            let key = format.quantize(target.rotation, keys.last());
            keys.push(key);
        }
        keys
    }

    /// The stored rotations nearest to the targets at `frames`. `previous` has the key before each frame.
    pub(super) fn quantize_after(
        &self,
        format: RotationFormat,
        frames: &[u32],
        previous: &[QuantizedRotation],
    ) -> Vec<QuantizedRotation> {
        let quantize = |(target, previous): (Target, _)| format.quantize(target.rotation, Some(previous));
        std::iter::zip(self.each_target(frames), previous)
            .map(quantize)
            .collect()
    }
}

// These are functions, because a closure that is not inlined is compiled without wide vectors.

#[inline(always)]
fn positions_at(all: &[Vec3], frames: &[u32]) -> Vectors {
    Vectors::of(|lane| all[frame_of(lane, frames)].to_array())
}

#[inline(always)]
fn rotations_at(all: &[Quat], frames: &[u32]) -> Quaternions {
    Quaternions::of(|lane| all[frame_of(lane, frames)].to_array())
}

/// The frame in a lane. Excess lanes repeat the last frame.
#[inline(always)]
fn frame_of(lane: usize, frames: &[u32]) -> usize {
    frames[lane.min(frames.len() - 1)] as usize
}

/// The translation relative to the lossy parent, in units of length `scale`, that puts a joint at its position in the
/// raw clip.
pub(super) fn target_translation(
    raw: &ObjectSpaceTrack,
    scale: f32,
    lossy_parent: Option<&ObjectSpaceTrack>,
    frame: usize,
) -> Vec3 {
    lossy_parent.map_or(raw.positions[frame], |parent| {
        let offset = raw.positions[frame] - parent.positions[frame];
        parent.rotations[frame].conjugate() * offset / scale
    })
}
