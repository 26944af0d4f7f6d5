//! Joints in object space, the space of the root's parent. Errors are measured there.

use std::ops::Range;

use glam::{Quat, Vec3};
use mocap_scene::math::quaternion::nlerp;

use super::clip::{RotationTrack, Track, TranslationTrack};
use super::key_frames;

/// One joint in object space at every frame.
#[derive(Clone, Default)]
pub struct ObjectSpaceTrack {
    /// Positions in metres.
    pub positions: Vec<Vec3>,
    pub rotations: Vec<Quat>,
}

impl ObjectSpaceTrack {
    pub(super) fn with_capacity(frames: usize) -> Self {
        Self {
            positions: Vec::with_capacity(frames),
            rotations: Vec::with_capacity(frames),
        }
    }

    /// A joint at the origin in all frames.
    pub(super) fn at_origin(frames: usize) -> Self {
        Self {
            positions: vec![Vec3::ZERO; frames],
            rotations: vec![Quat::IDENTITY; frames],
        }
    }

    /// The position of a point attached to `parent`, at `offset` in the parent's axes, in metres.
    #[inline]
    pub(super) fn position(parent: Option<&Self>, frame: usize, offset: Vec3) -> Vec3 {
        parent.map_or(offset, |parent| {
            parent.positions[frame] + parent.rotations[frame] * offset
        })
    }

    /// The positions of a point attached to this joint, at `offset` in its axes, at some frames.
    #[inline]
    pub(super) fn attached(&self, offset: Vec3, frames: Range<usize>) -> impl Iterator<Item = Vec3> {
        std::iter::zip(&self.positions[frames.clone()], &self.rotations[frames])
            .map(move |(position, rotation)| *position + *rotation * offset)
    }

    /// The rotation of a joint, given its rotation relative to `parent`.
    #[inline]
    pub(super) fn rotation(parent: Option<&Self>, frame: usize, local: Quat) -> Quat {
        parent
            .map_or(local, |parent| parent.rotations[frame] * local)
            .normalize()
    }
}

/// Decodes a translation track with a unit of length `scale` into object-space positions, for some ranges of frames.
pub(super) fn decode_translations(
    track: &TranslationTrack,
    scale: f32,
    ticks: &[f64],
    ranges: &[Range<usize>],
    parent: Option<&ObjectSpaceTrack>,
    positions: &mut [Vec3],
) {
    match track {
        Track::Constant(value) => {
            let offset = *value * scale;
            for frames in ranges {
                let positions = &mut positions[frames.clone()];
                match parent {
                    None => positions.fill(offset),
                    Some(parent) => {
                        let attached = parent.attached(offset, frames.clone());
                        std::iter::zip(positions, attached).for_each(|(position, attached)| *position = attached);
                    }
                }
            }
        }
        Track::Animated { key_frames, keys, .. } => {
            key_frames::for_each_frame(key_frames, ticks, ranges, |frame, key, alpha| {
                let local = match keys.get(key + 1) {
                    Some(next) if alpha > 0.0 => keys[key].value.lerp(next.value, alpha),
                    _ => keys[key].value,
                };
                positions[frame] = ObjectSpaceTrack::position(parent, frame, local * scale);
            });
        }
    }
}

/// Decodes a rotation track into object-space rotations, for some ranges of frames.
pub(super) fn decode_rotations(
    track: &RotationTrack,
    ticks: &[f64],
    ranges: &[Range<usize>],
    parent: Option<&ObjectSpaceTrack>,
    rotations: &mut [Quat],
) {
    match track {
        Track::Constant(local) => {
            for frame in ranges.iter().cloned().flatten() {
                rotations[frame] = match parent {
                    None => *local,
                    Some(_) => ObjectSpaceTrack::rotation(parent, frame, *local),
                };
            }
        }
        Track::Animated { key_frames, keys, .. } => {
            key_frames::for_each_frame(key_frames, ticks, ranges, |frame, key, alpha| {
                let local = match keys.get(key + 1) {
                    Some(next) if alpha > 0.0 => nlerp(keys[key].value, next.value, alpha),
                    _ => keys[key].value,
                };
                rotations[frame] = ObjectSpaceTrack::rotation(parent, frame, local);
            });
        }
    }
}
