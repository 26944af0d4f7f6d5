//! Samples the keys of one track, and the three tracks of one channel.

use glam::{FloatExt, Mat4, Quat, Vec3};

use super::flat::of_flat;
use crate::scene::{Channel, Keys};

/// A transform in its three components, as glTF and most engines store the transform of a node.
///
/// [`Binding`](crate::Binding) has an example.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trs {
    /// Translation to the parent, in the file's unit.
    pub translation: Vec3,
    /// Rotation to the parent.
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

    /// Decomposes `matrix`. Shear is lost; axes without a length complete a rotation with the others.
    pub fn from_matrix(matrix: Mat4) -> Self {
        // In double precision: of axes that shear, rounding would choose between two rotations.
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

    /// Translation x rotation x scale, as one matrix that maps column vectors.
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
    /// The transform to the parent at `tick`. A track without keys has the component of `rest`.
    ///
    /// A program with its own nodes needs only this:
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

    /// Whether no track has a key, so that the channel has no effect.
    pub(super) fn is_empty(&self) -> bool {
        self.position_keys.is_empty() && self.rotation_keys.is_empty() && self.scaling_keys.is_empty()
    }

    /// The transform whose `moving` components come from their tracks and the others from `still`.
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

/// Which tracks of a channel have to be sampled, because their value changes between ticks.
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
    /// The value at `tick`, interpolated linearly between the two keys around it. Before the first key it is the first
    /// value, after the last key the last; a NaN tick counts as tick 0. `None` if there is no key.
    pub fn sample(&self, tick: f64) -> Option<Vec3> {
        sample(self, Moment::new(tick), Vec3::lerp)
    }
}

impl Keys<f32> {
    /// The value at `tick`, interpolated linearly between the two keys around it. Before the first key it is the first
    /// value, after the last key the last; a NaN tick counts as tick 0. `None` if there is no key.
    pub fn sample(&self, tick: f64) -> Option<f32> {
        sample(self, Moment::new(tick), f32::lerp)
    }
}

impl Keys<Quat> {
    /// The value at `tick`, by slerp on the shorter arc between the two keys around it. Before the first key it is the
    /// first value, after the last key the last; a NaN tick counts as tick 0. `None` if there is no key.
    pub fn sample(&self, tick: f64) -> Option<Quat> {
        sample(self, Moment::new(tick), Quat::slerp)
    }
}

/// A tick, split once for all tracks that have a key at every tick.
#[derive(Clone, Copy)]
pub(super) struct Moment {
    tick: f64,
    /// The last whole tick that is not after `tick`; 0 for what comes before 0.
    index: usize,
    /// How far `tick` is from there to the next whole tick, in 0 to 1.
    fraction: f32,
}

impl Moment {
    pub(super) fn new(tick: f64) -> Self {
        let tick = if tick.is_nan() { 0.0 } else { tick };
        let from_start = tick.max(0.0);
        Self {
            tick,
            // The cast saturates, so that a tick beyond all keys is an index beyond all keys.
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

/// The index of the last key that is not after `tick` (or of the first key), and how far `tick` is from there to the
/// next key, in 0 to 1.
fn locate(ticks: &[f64], tick: f64) -> (usize, f32) {
    let after = ticks.partition_point(|&key| key <= tick);
    let from = after.saturating_sub(1);
    let fraction = match ticks.get(from..=after) {
        Some([before, next]) => (tick - before) / (next - before),
        _ => 0.0,
    };
    (from, fraction as f32)
}

#[cfg(test)]
mod tests {
    use std::f32::consts::{FRAC_1_SQRT_2, PI};

    use proptest::prelude::*;

    use super::*;

    /// Written out here rather than taken from glam, as the keys of a file are.
    fn about_z(degrees: f64) -> Quat {
        let (sin, cos) = (degrees.to_radians() / 2.0).sin_cos();
        Quat::from_xyzw(0.0, 0.0, sin as f32, cos as f32)
    }

    #[test]
    fn a_track_without_keys_has_no_value() {
        assert_eq!(Keys::<Vec3>::default().sample(1.0), None);
        let no_ticks = Keys::<Quat> {
            values: Vec::new(),
            ticks: Some(Vec::new()),
        };
        assert_eq!(no_ticks.sample(1.0), None);
    }

    #[test]
    fn one_key_holds_for_all_time() {
        let keys = Keys::constant(Vec3::X);
        let late_key = Keys {
            values: vec![Vec3::X],
            ticks: Some(vec![7.0]),
        };
        for tick in [f64::NEG_INFINITY, -1.0, 0.0, 0.5, 7.0, 1e300, f64::INFINITY, f64::NAN] {
            assert_eq!(keys.sample(tick), Some(Vec3::X), "{tick}");
            assert_eq!(late_key.sample(tick), Some(Vec3::X), "{tick}");
        }
    }

    #[test]
    fn ticks_beyond_the_keys_take_the_nearest() {
        let keys = Keys::every_tick(vec![Vec3::X, Vec3::Y, Vec3::Z]);
        let spaced = Keys {
            values: keys.values.clone(),
            ticks: Some(vec![1.0, 4.0, 5.0]),
        };
        for keys in [keys, spaced] {
            for before in [f64::NEG_INFINITY, -0.5, 0.0, f64::NAN] {
                assert_eq!(keys.sample(before), Some(Vec3::X), "{before}");
            }
            for after in [5.0, 5.5, f64::INFINITY] {
                assert_eq!(keys.sample(after), Some(Vec3::Z), "{after}");
            }
        }
    }

    #[test]
    fn positions_move_on_a_line_between_keys() {
        let keys = Keys {
            values: vec![Vec3::ZERO, Vec3::new(4.0, 8.0, -16.0)],
            ticks: Some(vec![10.0, 14.0]),
        };
        assert_eq!(keys.sample(11.0), Some(Vec3::new(1.0, 2.0, -4.0)));
        assert_eq!(keys.sample(13.0), Some(Vec3::new(3.0, 6.0, -12.0)));
    }

    #[test]
    fn rotations_turn_evenly() {
        let keys = Keys::every_tick(vec![about_z(10.0), about_z(130.0)]);
        for (tick, degrees) in [(0.25, 40.0), (0.5, 70.0), (0.75, 100.0)] {
            let turned = keys.sample(tick).unwrap();
            assert!(turned.abs_diff_eq(about_z(degrees), 1e-6), "{tick}: {turned}");
        }
    }

    #[test]
    fn rotations_take_the_shorter_way() {
        // From 10 to 350 degrees it is 20 degrees backwards, not 340 forwards; and a negated quaternion is an equal
        // rotation.
        for end in [about_z(350.0), -about_z(350.0)] {
            let middle = Keys::every_tick(vec![about_z(10.0), end]).sample(0.5).unwrap();
            assert!(middle.abs_diff_eq(Quat::IDENTITY, 1e-6), "{middle}");
        }
        let same = Keys::every_tick(vec![about_z(70.0), -about_z(70.0)]);
        assert!(same.sample(0.5).unwrap().abs_diff_eq(about_z(70.0), 1e-6));
    }

    #[test]
    fn small_and_half_turns_stay_rotations() {
        for degrees in [1e-4, 0.01, 0.05, 0.1, 1.0, 179.99, 180.0] {
            let keys = Keys::every_tick(vec![about_z(0.0), about_z(degrees)]);
            for eighth in 1..8 {
                let tick = f64::from(eighth) / 8.0;
                let turned = keys.sample(tick).unwrap();
                assert!((turned.length() - 1.0).abs() < 1e-6, "{degrees} at {tick}: {turned}");
                assert!(
                    turned.abs_diff_eq(about_z(degrees * tick), 1e-6),
                    "{degrees} at {tick}: {turned}"
                );
            }
        }
    }

    #[test]
    fn ticks_and_values_of_different_number_do_no_harm() {
        for (values, ticks) in [(1, 3), (3, 1), (2, 0), (0, 2)] {
            let keys = Keys {
                values: vec![Vec3::ONE; values],
                ticks: Some((0..ticks).map(f64::from).collect()),
            };
            for tick in [-1.0, 0.0, 0.5, 1.5, 9.0] {
                assert_eq!(keys.sample(tick), (values > 0).then_some(Vec3::ONE));
            }
        }
    }

    #[test]
    fn a_channel_takes_what_it_lacks_from_the_rest_transform() {
        let channel = Channel {
            rotation_keys: Keys::constant(about_z(90.0)),
            ..Channel::default()
        };
        let rest = Trs {
            translation: Vec3::new(1.0, 2.0, 3.0),
            rotation: about_z(30.0),
            scale: Vec3::splat(2.0),
        };
        let expected = Trs {
            rotation: about_z(90.0),
            ..rest
        };
        assert_eq!(channel.sample(3.0, rest), expected);
        assert_eq!(Channel::default().sample(3.0, rest), rest);
    }

    #[test]
    fn the_matrix_scales_first_and_moves_last() {
        let trs = Trs {
            translation: Vec3::new(10.0, 20.0, 30.0),
            rotation: about_z(90.0),
            scale: Vec3::new(2.0, 3.0, 4.0),
        };
        // x is scaled to 2 and rotated onto y; y is scaled to 3 and rotated onto -x.
        let point = trs.matrix().transform_point3(Vec3::ONE);
        assert!(point.abs_diff_eq(Vec3::new(7.0, 22.0, 34.0), 1e-5), "{point}");
    }

    #[test]
    fn a_matrix_comes_apart_into_its_components() {
        let matrix = Mat4::from_cols_array(&[
            0.0, 2.0, 0.0, 0.0, -3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 4.0, 0.0, 5.0, 6.0, 7.0, 1.0,
        ]);
        let trs = Trs::from_matrix(matrix);
        assert_eq!(trs.translation, Vec3::new(5.0, 6.0, 7.0));
        assert_eq!(trs.scale, Vec3::new(2.0, 3.0, 4.0));
        assert!(
            trs.rotation
                .abs_diff_eq(Quat::from_xyzw(0.0, 0.0, FRAC_1_SQRT_2, FRAC_1_SQRT_2), 1e-6)
        );

        let flat = Trs::from_matrix(Mat4::from_scale(Vec3::new(1.0, 0.0, 1.0)));
        assert_eq!(flat.rotation, Quat::IDENTITY);
    }

    fn vectors() -> impl Strategy<Value = Vec<Vec3>> {
        let vector = prop::array::uniform3(-1e3f32..1e3).prop_map(Vec3::from);
        prop::collection::vec(vector, 1..20)
    }

    fn rotations() -> impl Strategy<Value = Vec<Quat>> {
        let rotation = (prop::array::uniform3(-1f32..1.0), -PI..PI).prop_filter_map("no axis", |(axis, angle)| {
            let axis = Vec3::from(axis).try_normalize()?;
            Some(Quat::from_axis_angle(axis, angle))
        });
        prop::collection::vec(rotation, 1..20)
    }

    proptest! {
        #[test]
        fn at_whole_ticks_the_keys_come_back(positions in vectors(), rotations in rotations()) {
            let position_keys = Keys::every_tick(positions.clone());
            let rotation_keys = Keys::every_tick(rotations.clone());
            for (tick, position) in positions.iter().enumerate() {
                prop_assert_eq!(position_keys.sample(tick as f64), Some(*position));
            }
            for (tick, rotation) in rotations.iter().enumerate() {
                prop_assert_eq!(rotation_keys.sample(tick as f64), Some(*rotation));
            }
        }

        #[test]
        fn at_its_tick_each_key_comes_back(
            values in rotations(), gaps in prop::collection::vec(1e-3f64..1e3, 20), start in -10f64..10.0,
        ) {
            let ticks = gaps.iter().scan(start, |tick, gap| { *tick += gap; Some(*tick) });
            let keys = Keys { ticks: Some(ticks.take(values.len()).collect()), values };
            for (index, value) in keys.values.iter().enumerate() {
                prop_assert_eq!(keys.sample(keys.tick(index)), Some(*value));
            }
        }

        #[test]
        fn written_ticks_mean_what_counted_ticks_mean(values in rotations(), tick in -2f64..22.0) {
            let written = Keys { ticks: Some((0..values.len()).map(|tick| tick as f64).collect()), values };
            let counted = Keys::every_tick(written.values.clone());
            prop_assert_eq!(written.sample(tick), counted.sample(tick));
        }

        #[test]
        fn between_two_keys_a_rotation_is_between_them(values in rotations(), tick in 0f64..18.0) {
            prop_assume!(values.len() > 1);
            let tick = tick % (values.len() - 1) as f64;
            let (from, to) = (values[tick as usize], values[tick as usize + 1]);
            let turned = Keys::every_tick(values).sample(tick).unwrap();
            // An angle comes from an arc cosine here, which near 1 tells angles below 1e-3 apart no more.
            let (found, expected) = (from.angle_between(turned), tick.fract() as f32 * from.angle_between(to));
            prop_assert!((found - expected).abs() < 2e-3, "{found} of {expected}");
            prop_assert!((turned.length() - 1.0).abs() < 1e-5);
        }
    }
}
