//! Stores the values of one part of a node's transform (translation, rotation or scale) in every frame. Copies of a
//! motion share the values with each other and with the animation that was read, until a copy changes them.

use std::sync::Arc;

use glam::{Quat, Vec3};
use mocap_scene::pose::Trs;
use mocap_scene::scene::{Channel, Keys};

use super::constant::{constant_value, is_near, is_same_rotation};

/// A part of a transform: translation, rotation or scale.
pub(super) trait Part: Copy {
    /// Whether both values have the same bits, because a track must not change the sign of a 0.
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

/// The values of a part in all frames: a single value if all frames have the same value, otherwise one value for each
/// frame.
#[derive(Clone)]
pub(super) struct Track<'a, T> {
    /// The keys of the animation that was read; `None` after a value has changed.
    keys: Option<&'a [T]>,
    /// The values, if `keys` is `None`.
    values: Arc<Vec<T>>,
}

impl<T> Default for Track<'_, T> {
    fn default() -> Self {
        Self {
            keys: None,
            values: Arc::default(),
        }
    }
}

impl<'a, T: Part + PartialEq> Track<'a, T> {
    /// Shares the keys of an animation with `frames` frames, if there is one key for each frame and the keys are not
    /// all equal.
    fn of_keys(keys: &'a Keys<T>, frames: usize) -> Self {
        let is_every_frame = keys.ticks.is_none() && keys.values.len() == frames;
        let is_moving = || keys.values.iter().any(|value| *value != keys.values[0]);
        Self {
            keys: (is_every_frame && is_moving()).then_some(&keys.values[..]),
            values: Arc::default(),
        }
    }

    /// Whether the values are still the keys of the animation.
    pub(super) fn is_unchanged(&self) -> bool {
        self.keys.is_some()
    }

    fn values(&self) -> &[T] {
        self.keys.unwrap_or(&self.values)
    }

    fn values_mut(&mut self) -> &mut Vec<T> {
        if let Some(keys) = self.keys.take() {
            self.values = Arc::new(keys.to_vec());
        }
        Arc::make_mut(&mut self.values)
    }

    /// This track without the keys that it shares. An unchanged track becomes empty, and a changed track keeps its
    /// values.
    fn changes(self) -> Track<'static, T> {
        Track {
            keys: self.keys.map(|_| &[][..]),
            values: self.values,
        }
    }

    /// The same track with its own copy of the keys.
    fn owned(mut self) -> Track<'static, T> {
        self.values_mut();
        Track {
            keys: None,
            values: self.values,
        }
    }

    /// Adds the value of the next frame. The track will have `frames` frames.
    fn push(&mut self, frame: usize, value: T, frames: usize) {
        let values = self.values_mut();
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
        match self.values() {
            [only] => *only,
            values => values[frame],
        }
    }

    /// Sets the value of one frame. The track has `frames` frames.
    pub(super) fn set(&mut self, frame: usize, value: T, frames: usize) {
        if self.at(frame).is_same(value) {
            return;
        }
        let values = self.values_mut();
        if let [only] = values.as_slice() {
            let only = *only;
            values.reserve_exact(frames - 1);
            values.resize(frames, only);
        }
        values[frame] = value;
    }

    /// Makes the track constant if [`constant_value`] finds a value.
    fn settle(&mut self, constant: Option<T>, is_near: fn(T, T) -> bool) {
        if !self.is_unchanged()
            && let Some(value) = constant_value(&self.values, constant, is_near)
        {
            self.values = Arc::new(vec![value]);
        }
    }

    /// The values of chosen frames.
    fn picked(&self, chosen: &[usize]) -> Self {
        match self.values() {
            [_] => self.clone(),
            values => Self {
                keys: None,
                values: Arc::new(chosen.iter().map(|frame| values[*frame]).collect()),
            },
        }
    }
}

/// The transform of a node in every frame.
#[derive(Clone, Default)]
pub(super) struct TrsTrack<'a> {
    pub(super) translation: Track<'a, Vec3>,
    pub(super) rotation: Track<'a, Quat>,
    pub(super) scale: Track<'a, Vec3>,
}

impl<'a> TrsTrack<'a> {
    /// The transforms of `frames` frames.
    pub(super) fn new(transforms: impl Iterator<Item = Trs>, frames: usize) -> Self {
        let mut track = Self::default();
        for (frame, trs) in transforms.enumerate() {
            track.push(frame, trs, frames);
        }
        track
    }

    /// Shares the keys of a channel that has a key for every frame. The other parts have no values yet.
    pub(super) fn of_channel(channel: &'a Channel, frames: usize) -> Self {
        Self {
            translation: Track::of_keys(&channel.position_keys, frames),
            rotation: Track::of_keys(&channel.rotation_keys, frames),
            scale: Track::of_keys(&channel.scaling_keys, frames),
        }
    }

    /// The same track with its own copy of the keys.
    pub(super) fn owned(self) -> TrsTrack<'static> {
        TrsTrack {
            translation: self.translation.owned(),
            rotation: self.rotation.owned(),
            scale: self.scale.owned(),
        }
    }

    /// Whether the values of a channel need no sampling: the values are constant, or every frame has a key.
    pub(super) fn has_all_of(&self, channel: &Channel) -> bool {
        (self.translation.is_unchanged() || channel.position_keys.len() < 2)
            && (self.rotation.is_unchanged() || channel.rotation_keys.len() < 2)
            && (self.scale.is_unchanged() || channel.scaling_keys.len() < 2)
    }

    /// The parts that have changed. The other parts count as unchanged and have no value.
    pub(super) fn changes(self) -> TrsTrack<'static> {
        TrsTrack {
            translation: self.translation.changes(),
            rotation: self.rotation.changes(),
            scale: self.scale.changes(),
        }
    }

    /// Adds the transform of the next frame, except for the parts that share all keys of a channel. The track will have
    /// `frames` frames.
    pub(super) fn push(&mut self, frame: usize, trs: Trs, frames: usize) {
        if !self.translation.is_unchanged() {
            self.translation.push(frame, trs.translation, frames);
        }
        if !self.rotation.is_unchanged() {
            self.rotation.push(frame, trs.rotation, frames);
        }
        if !self.scale.is_unchanged() {
            self.scale.push(frame, trs.scale, frames);
        }
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

    /// Sets the transform of one frame. The track has `frames` frames.
    pub(super) fn set(&mut self, frame: usize, trs: Trs, frames: usize) {
        self.translation.set(frame, trs.translation, frames);
        self.rotation.set(frame, trs.rotation, frames);
        self.scale.set(frame, trs.scale, frames);
    }

    /// Makes each part constant if [`constant_value`] finds a value for the part.
    pub(super) fn settle(&mut self, constant: &ConstantParts) {
        self.translation.settle(constant.translation, is_near);
        self.rotation.settle(constant.rotation, is_same_rotation);
        self.scale.settle(constant.scale, is_near);
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

/// The parts of a node's transform that do not change in an animation.
#[derive(Clone, Copy, Default)]
pub(super) struct ConstantParts {
    pub(super) translation: Option<Vec3>,
    pub(super) rotation: Option<Quat>,
    pub(super) scale: Option<Vec3>,
}

impl ConstantParts {
    /// Finds the constant parts of a node's transforms.
    pub(super) fn of(track: &TrsTrack, frames: usize) -> Self {
        if frames == 0 {
            return Self::default();
        }
        let TrsTrack {
            translation,
            rotation,
            scale,
        } = track;
        let is_first = |is_first: &dyn Fn(usize) -> bool| (1..frames).all(is_first);
        Self {
            translation: is_first(&|frame| translation.at(frame) == translation.at(0)).then(|| translation.at(0)),
            rotation: is_first(&|frame| rotation.at(frame) == rotation.at(0)).then(|| rotation.at(0)),
            scale: is_first(&|frame| scale.at(frame) == scale.at(0)).then(|| scale.at(0)),
        }
    }
}
