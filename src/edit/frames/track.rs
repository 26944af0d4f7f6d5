//! The values of one part of a node in every frame, which copies of a motion share until one of them changes.

use std::sync::Arc;

use glam::{Quat, Vec3};
use mocap_scene::pose::Trs;

/// A part of a transform.
pub(super) trait Part: Copy {
    /// Whether both have the same bits: a track must not change a sign of 0.
    fn is_same(self, other: Self) -> bool;
}

impl Part for Vec3 {
    fn is_same(self, other: Self) -> bool {
        self.to_array().map(f32::to_bits) == other.to_array().map(f32::to_bits)
    }
}

impl Part for Quat {
    fn is_same(self, other: Self) -> bool {
        self.to_array().map(f32::to_bits) == other.to_array().map(f32::to_bits)
    }
}

/// One value where all frames have it, else one for each frame.
#[derive(Clone)]
pub(super) struct Track<T> {
    values: Arc<Vec<T>>,
}

impl<T> Default for Track<T> {
    fn default() -> Self {
        Self { values: Arc::default() }
    }
}

impl<T: Part> Track<T> {
    /// Adds the value of the next frame of `frames` frames.
    pub(super) fn push(&mut self, frame: usize, value: T, frames: usize) {
        let values = Arc::make_mut(&mut self.values);
        match values.as_slice() {
            [only] if frame > 0 && only.is_same(value) => {}
            [only] if frame > 0 => {
                let only = *only;
                values.reserve_exact(frames.max(frame + 1) - 1);
                values.resize(frame, only);
                values.push(value);
            }
            _ => values.push(value),
        }
    }

    #[inline]
    pub(super) fn at(&self, frame: usize) -> T {
        match self.values.as_slice() {
            [only] => *only,
            values => values[frame],
        }
    }

    /// Sets the value of one of `frames` frames.
    pub(super) fn set(&mut self, frame: usize, value: T, frames: usize) {
        if self.at(frame).is_same(value) {
            return;
        }
        let values = Arc::make_mut(&mut self.values);
        if let [only] = values.as_slice() {
            let only = *only;
            values.reserve_exact(frames - 1);
            values.resize(frames, only);
        }
        values[frame] = value;
    }

    /// The values of chosen frames of this track.
    pub(super) fn picked(&self, chosen: &[usize]) -> Self {
        match self.values.len() {
            1 => self.clone(),
            _ => Self {
                values: Arc::new(chosen.iter().map(|frame| self.values[*frame]).collect()),
            },
        }
    }
}

/// The transform of a node in every frame.
#[derive(Clone)]
pub(super) struct TrsTrack {
    pub(super) translation: Track<Vec3>,
    pub(super) rotation: Track<Quat>,
    pub(super) scale: Track<Vec3>,
}

impl TrsTrack {
    /// The transforms of `frames` frames.
    pub(super) fn new(transforms: impl Iterator<Item = Trs>, frames: usize) -> Self {
        let mut track = Self {
            translation: Track::default(),
            rotation: Track::default(),
            scale: Track::default(),
        };
        for (frame, trs) in transforms.enumerate() {
            track.push(frame, trs, frames);
        }
        track
    }

    /// Adds the transform of the next frame of `frames` frames.
    pub(super) fn push(&mut self, frame: usize, trs: Trs, frames: usize) {
        self.translation.push(frame, trs.translation, frames);
        self.rotation.push(frame, trs.rotation, frames);
        self.scale.push(frame, trs.scale, frames);
    }

    /// The transform of a frame.
    #[inline]
    pub(super) fn at(&self, frame: usize) -> Trs {
        Trs {
            translation: self.translation.at(frame),
            rotation: self.rotation.at(frame),
            scale: self.scale.at(frame),
        }
    }

    /// Sets the transform of one of `frames` frames.
    pub(super) fn set(&mut self, frame: usize, trs: Trs, frames: usize) {
        self.translation.set(frame, trs.translation, frames);
        self.rotation.set(frame, trs.rotation, frames);
        self.scale.set(frame, trs.scale, frames);
    }

    /// The transforms of chosen frames.
    pub(super) fn picked(&self, chosen: &[usize]) -> Self {
        Self {
            translation: self.translation.picked(chosen),
            rotation: self.rotation.picked(chosen),
            scale: self.scale.picked(chosen),
        }
    }
}
