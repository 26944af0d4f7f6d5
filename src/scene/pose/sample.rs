//! Samples the keys of one track, and the three tracks of a channel.

use glam::{FloatExt, Mat4, Quat, Vec3};

use super::flat::of_flat;
use crate::scene::{Channel, Keys};

/// A transform as translation, rotation and scale. glTF and most engines store the transform of a node in this form.
///
/// [`Binding`](crate::Binding) has an example.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trs {
    /// Translation relative to the parent, in the file's unit.
    pub translation: Vec3,
    /// Rotation relative to the parent.
    pub rotation: Quat,
    /// Scale along the node's own axes.
    pub scale: Vec3,
}

impl Trs {
    /// The identity.
    pub const IDENTITY: Self = Self {
        translation: Vec3::ZERO,
        rotation: Quat::IDENTITY,
        scale: Vec3::ONE,
    };

    /// Decomposes `matrix`. Shear is lost. If axes have no length, the other axes complete the rotation.
    pub fn from_matrix(matrix: Mat4) -> Self {
        // Double precision: for axes with shear, the rounding error of single precision would decide between two
        // rotations.
        let wide = matrix.as_dmat4();
        let (mut scale, mut rotation, _) = wide.to_scale_rotation_translation();
        if !rotation.is_finite() {
            (scale, rotation) = of_flat(&wide);
        }
        Self {
            translation: matrix.w_axis.truncate(),
            rotation: rotation.normalize().as_quat(),
            scale: scale.as_vec3(),
        }
    }

    /// Translation x rotation x scale, as one matrix for column vectors.
    #[inline]
    pub fn matrix(&self) -> Mat4 {
        Mat4::from_scale_rotation_translation(self.scale, self.rotation, self.translation)
    }
}

impl Default for Trs {
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl Channel {
    /// The transform relative to the parent at `tick`. A track without keys has the component of `rest`.
    ///
    /// A program with its own nodes needs only this method:
    ///
    /// ```
    /// use mocap::glam::{Mat4, Vec3};
    /// use mocap::Trs;
    /// use mocap::scene::{Channel, Keys};
    ///
    /// struct MyNode { name: String, matrix: Mat4 }
    ///
    /// let mut nodes = vec![MyNode { name: "hip".into(), matrix: Mat4::IDENTITY }];
    /// let channels = vec![Channel {
    ///     node_name: "hip".into(),
    ///     position_keys: Keys::every_tick(vec![Vec3::ZERO, Vec3::X]),
    ///     ..Channel::default()
    /// }];
    /// for channel in &channels {
    ///     if let Some(node) = nodes.iter_mut().find(|node| node.name == channel.node_name) {
    ///         node.matrix = channel.sample(0.25, Trs::IDENTITY).matrix();
    ///     }
    /// }
    /// assert_eq!(nodes[0].matrix, Mat4::from_translation(Vec3::new(0.25, 0.0, 0.0)));
    /// ```
    pub fn sample(&self, tick: f64, rest: Trs) -> Trs {
        let all = Moving {
            position: true,
            rotation: true,
            scaling: true,
        };
        self.sample_moving(Moment::new(tick), all, rest)
    }

    /// Whether all tracks lack keys, so that the channel has no effect.
    pub(super) fn is_empty(&self) -> bool {
        self.position_keys.is_empty() && self.rotation_keys.is_empty() && self.scaling_keys.is_empty()
    }

    /// The transform at a moment. The components in `moving` are sampled from their tracks; the other components come
    /// from `still`.
    #[inline]
    pub(super) fn sample_moving(&self, moment: Moment, moving: Moving, still: Trs) -> Trs {
        let mut trs = still;
        if moving.position {
            trs.translation = sample(&self.position_keys, moment, Vec3::lerp).unwrap_or(still.translation);
        }
        if moving.rotation {
            trs.rotation = sample(&self.rotation_keys, moment, Quat::slerp).unwrap_or(still.rotation);
        }
        if moving.scaling {
            trs.scale = sample(&self.scaling_keys, moment, Vec3::lerp).unwrap_or(still.scale);
        }
        trs
    }
}

/// The tracks of a channel that change between ticks, and so must be sampled.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moving {
    pub(super) position: bool,
    rotation: bool,
    scaling: bool,
}

impl Moving {
    pub(super) fn of(channel: &Channel) -> Self {
        Self {
            position: channel.position_keys.len() > 1,
            rotation: channel.rotation_keys.len() > 1,
            scaling: channel.scaling_keys.len() > 1,
        }
    }
}

impl Keys<Vec3> {
    /// The value at `tick`, interpolated linearly between the two keys around it. Before the first key, it is the value
    /// of the first key; after the last key, the value of the last key. A NaN tick counts as tick 0. `None` if there
    /// are no keys.
    pub fn sample(&self, tick: f64) -> Option<Vec3> {
        sample(self, Moment::new(tick), Vec3::lerp)
    }
}

impl Keys<f32> {
    /// The value at `tick`, interpolated linearly between the two keys around it. Before the first key, it is the value
    /// of the first key; after the last key, the value of the last key. A NaN tick counts as tick 0. `None` if there
    /// are no keys.
    pub fn sample(&self, tick: f64) -> Option<f32> {
        sample(self, Moment::new(tick), f32::lerp)
    }
}

impl Keys<Quat> {
    /// The value at `tick`, by slerp on the shorter arc between the two keys around it. Before the first key, it is the
    /// value of the first key; after the last key, the value of the last key. A NaN tick counts as tick 0. `None` if
    /// there are no keys.
    pub fn sample(&self, tick: f64) -> Option<Quat> {
        sample(self, Moment::new(tick), Quat::slerp)
    }
}

/// A tick, split into a whole tick and a fraction once for all tracks with a key at every tick.
#[derive(Clone, Copy)]
pub(super) struct Moment {
    tick: f64,
    /// The last whole tick at or before `tick`; 0 if `tick` is negative.
    index: usize,
    /// The fraction from that tick to the next whole tick, from 0 to 1.
    fraction: f32,
}

impl Moment {
    pub(super) fn new(tick: f64) -> Self {
        let tick = if tick.is_nan() { 0.0 } else { tick };
        let from_start = tick.max(0.0);
        Self {
            tick,
            // The cast saturates, so that a tick beyond all keys becomes an index beyond all keys.
            index: from_start as usize,
            fraction: from_start.fract() as f32,
        }
    }
}

#[inline]
fn sample<T: Copy>(keys: &Keys<T>, moment: Moment, mix: impl Fn(T, T, f32) -> T) -> Option<T> {
    let values = keys.values.as_slice();
    let (index, fraction) = match &keys.ticks {
        None => (moment.index, moment.fraction),
        Some(ticks) => locate(ticks, moment.tick),
    };
    match values.get(index..) {
        Some([from, to, ..]) if fraction > 0.0 => Some(mix(*from, *to, fraction)),
        Some([from, ..]) => Some(*from),
        _ => values.last().copied(),
    }
}

/// The index of the last key at or before `tick`, or 0 if there is none. Also the fraction of the way from that key to
/// the next, from 0 to 1.
fn locate(ticks: &[f64], tick: f64) -> (usize, f32) {
    let after = ticks.partition_point(|&key| key <= tick);
    let from = after.saturating_sub(1);
    let fraction = match ticks.get(from..=after) {
        Some([before, next]) => (tick - before) / (next - before),
        _ => 0.0,
    };
    (from, fraction as f32)
}
