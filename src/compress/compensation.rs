//! Error compensation: each joint is encoded for the parent that a reader has, not for the parent of the raw clip.
//!
//! Errors add up along a chain: a hand is off by the errors of all joints above it. So the target of a joint is its
//! rotation to the lossy parent that puts its children in their positions of the raw clip. The joint itself is a little
//! off. What remains at the end of a chain is hardly more than the error of its last joint.
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

/// A joint below its lossy parent.
pub struct Compensation<'a> {
    pub arms: &'a LeverArms,
    pub raw: &'a ObjectSpaceTrack,
    /// Where a reader has the joint in object space: follows from its parent and its translation.
    pub lossy_positions: &'a [Vec3],
    pub lossy_parent: Option<&'a ObjectSpaceTrack>,
}

/// The target of a joint's rotation at one frame.
pub struct Target {
    /// The best rotation to the lossy parent.
    pub(super) rotation: Quat,
    /// From the axes of the lossy parent to those of the raw joint: from a rotation to the lossy parent to the rotation
    /// error of the joint.
    parent_to_raw: Quat,
    /// From where the joint should be to where it is, in its own axes.
    position_error: Vec3,
    /// The rotation error, axis times angle, that the best rotation leaves.
    rotation_error: Vec3,
}

impl Target {
    /// The error that a rotation to the lossy parent leaves.
    pub(super) fn error(&self, arms: &LeverArms, rotation: Quat) -> f32 {
        arms.error(self.position_error, self.parent_to_raw * rotation)
    }

    /// The least change of a rotation that is `off` the best one and brings the error to `goal`. Both are axis times
    /// angle in the axes of the joint. `None` if the error is no larger than `largest`.
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

    /// The largest error that `keys` leave, one for each frame.
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
    /// The targets at as many frames as there are lanes, or fewer: then the last one is repeated.
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

    /// The targets at any number of frames, one after the other.
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

    /// One rotation whose error is within `tolerance` at every frame, if the mean of all targets is one.
    pub(super) fn constant_rotation(&self, tolerance: f32) -> Option<Quat> {
        let last = self.lossy_positions.len().checked_sub(1)?;
        // Most joints rotate so much that three frames show it.
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

    /// The stored rotations nearest to the targets.
    pub(super) fn quantize(&self, format: RotationFormat, key_frames: &[u32]) -> Vec<QuantizedRotation> {
        let mut keys: Vec<QuantizedRotation> = Vec::with_capacity(key_frames.len());
        for target in self.each_target(key_frames) {
            let key = format.quantize(target.rotation, keys.last());
            keys.push(key);
        }
        keys
    }

    /// As [`Self::quantize`], for frames each of which has a key before it already.
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

// Functions, for a closure that is not inlined is compiled for every processor, without wide vectors.

#[inline(always)]
fn positions_at(all: &[Vec3], frames: &[u32]) -> Vectors {
    Vectors::of(|lane| all[frame_of(lane, frames)].to_array())
}

#[inline(always)]
fn rotations_at(all: &[Quat], frames: &[u32]) -> Quaternions {
    Quaternions::of(|lane| all[frame_of(lane, frames)].to_array())
}

/// The frame in a lane; the last one in the lanes beyond.
#[inline(always)]
fn frame_of(lane: usize, frames: &[u32]) -> usize {
    frames[lane.min(frames.len() - 1)] as usize
}

/// The translation to the lossy parent, in units of the length `scale`, that puts a joint where the raw clip has it.
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
