//! Finds the ticks of a motion's keys, and makes keys at these ticks.

use glam::Quat;
use mocap_scene::scene::{Animation, Keys};

/// The largest distance between quaternions that counts as rounding. It is a rotation of 4e-6 radians, or 4 micrometres
/// at the end of a 1 m arm. The product of the rotations from the root to a finger has a rounding error of up to 2e-6
/// radians.
const ROUNDING: f32 = 2e-6;

/// The whole ticks of an animation, and its end.
pub fn ticks(animation: &Animation) -> Vec<f64> {
    let mut ticks: Vec<f64> = animation.whole_ticks().collect();
    if ticks.last().is_some_and(|last| *last < animation.duration) {
        ticks.push(animation.duration);
    }
    ticks
}

/// The ticks of all keys of an animation.
pub struct Ticks<'a> {
    /// The ticks of the keys; `None` for 0, 1, 2, ...
    written: Option<&'a [f64]>,
}

impl<'a> Ticks<'a> {
    pub fn new(ticks: &'a [f64]) -> Self {
        let is_counted = ticks.iter().enumerate().all(|(index, tick)| *tick == index as f64);
        Self {
            written: (!is_counted).then_some(ticks),
        }
    }

    /// Keys at these ticks; a single key if all values are the same.
    pub fn keys<T: Copy + PartialEq>(&self, mut values: Vec<T>) -> Keys<T> {
        if let Some(&first) = values.first()
            && values.iter().all(|value| *value == first)
        {
            values.truncate(1);
        }
        self.keys_or_one(values)
    }

    /// Rotation keys at these ticks; a single key if all rotations are the same except for rounding.
    pub fn rotation_keys(&self, mut values: Vec<Quat>) -> Keys<Quat> {
        if let Some(&first) = values.first()
            && values.iter().all(|value| (*value - first).length() <= ROUNDING)
        {
            values.truncate(1);
        }
        self.keys_or_one(values)
    }

    fn keys_or_one<T>(&self, values: Vec<T>) -> Keys<T> {
        let written = self.written.filter(|_| values.len() > 1);
        Keys {
            values,
            ticks: written.map(<[f64]>::to_vec),
        }
    }
}
