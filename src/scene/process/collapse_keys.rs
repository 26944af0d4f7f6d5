//! Reduces constant tracks to one key.

use glam::{Quat, Vec3};

use crate::options::setters;
use crate::scene::{Keys, Scene};

/// The largest difference from the first value of a track that counts as equal.
///
/// With 0, the default, numbers must be equal; -0 equals 0, and NaN equals nothing.
///
/// [`Scene::collapse_keys`](crate::Scene::collapse_keys) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct KeyTolerance {
    /// Distance between positions, in the file's unit. Default: 0.
    pub position: f32,
    /// Angle between rotations, in radians. Default: 0. A quaternion and its negative are the same rotation.
    pub rotation: f32,
    /// Distance between scales, which have no unit. Default: 0.
    pub scaling: f32,
}

setters! {
    KeyTolerance {
        position: f32,
        rotation: f32,
        scaling: f32,
    }
}

impl Scene {
    /// Keeps only the first key of every track whose values are all equal within `tolerance`.
    ///
    /// Before: `0: (2, 0, 0)`, `1: (2, 0, 0)`, `2: (2, 0, 0)`. After: `0: (2, 0, 0)`. Every value is compared with the
    /// first, never with its neighbour, so a slowly drifting track keeps its keys. The duration of the animation does
    /// not change.
    ///
    /// A point without a skeleton that is missing in some frames, such as a marker, keeps its position keys.
    ///
    /// Assimp gives this result at zero tolerance. Its accuracy setting is inverted: with any value it collapses only
    /// tracks whose neighbouring keys all differ by more than 1.
    ///
    /// ```
    /// use mocap::glam::Vec3;
    /// use mocap::process::KeyTolerance;
    /// use mocap::scene::{Animation, Channel, Keys, Scene};
    ///
    /// let still = Channel { position_keys: Keys::every_tick(vec![Vec3::ONE; 100]), ..Channel::default() };
    /// let mut scene = Scene {
    ///     animations: vec![Animation { channels: vec![still], ..Animation::default() }],
    ///     ..Scene::default()
    /// };
    /// scene.collapse_keys(KeyTolerance::default());
    /// assert_eq!(scene.animations[0].channels[0].position_keys, Keys::constant(Vec3::ONE));
    /// ```
    pub fn collapse_keys(&mut self, tolerance: KeyTolerance) {
        let has_points = self.has_points();
        let channels = self.animations.iter_mut().flat_map(|animation| {
            let frames = animation.frame_count();
            animation.channels.iter_mut().map(move |channel| (frames, channel))
        });
        for (frames, channel) in channels {
            if !has_points || channel.position_keys.is_seen_throughout(frames) {
                collapse(&mut channel.position_keys, |a, b| {
                    distance(a, b) <= f64::from(tolerance.position)
                });
            }
            collapse(&mut channel.rotation_keys, |a, b| {
                angle(a, b) <= f64::from(tolerance.rotation)
            });
            collapse(&mut channel.scaling_keys, |a, b| {
                distance(a, b) <= f64::from(tolerance.scaling)
            });
        }
    }
}

pub(super) fn collapse<T: Copy>(keys: &mut Keys<T>, equal: impl Fn(T, T) -> bool) {
    if let [first, rest @ ..] = keys.values.as_slice()
        && !rest.is_empty()
        && rest.iter().all(|&value| equal(*first, value))
    {
        *keys = Keys::constant(*first);
    }
}

/// Uses double precision, in which squared differences of single-precision values do not underflow.
fn distance(a: Vec3, b: Vec3) -> f64 {
    a.as_dvec3().distance(b.as_dvec3())
}

/// The angle of the rotation from `a` to `b`, for unit quaternions.
///
/// The chord between them is 2 sin(angle / 4). It is exact for small angles, unlike the arc cosine of their dot
/// product.
fn angle(a: Quat, b: Quat) -> f64 {
    let (a, b) = (a.as_dquat(), b.as_dquat());
    let chord = (a - b).length().min((a + b).length());
    4.0 * (chord / 2.0).asin()
}
