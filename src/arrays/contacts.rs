//! Foot contacts: which feet are on the ground.

use glam::Vec3;

use crate::arrays::frame::Frame;
use crate::arrays::joints::{Selection, pattern};
use crate::arrays::{ArrayOptions, Contacts, unknown_option};
use crate::edit::{Thresholds, level, low_and_slow};
use crate::error::Result;
use crate::math::velocity::velocities;

/// The positions of the feet in the world of the output.
pub(super) struct Feet {
    thresholds: Option<Contacts>,
    joint_count: usize,
    /// Indices of the feet among the joints.
    pub(super) joints: Vec<usize>,
    /// Frames x feet x 3, to be filled.
    pub(super) positions: Vec<f32>,
}

impl Feet {
    pub(super) fn new(joints: &Selection, options: &ArrayOptions, frames: usize) -> Result<Self> {
        let mut feet = Vec::new();
        if let Some(thresholds) = &options.contacts {
            for value in [thresholds.height, thresholds.speed] {
                if !(value.is_finite() && value >= 0.0) {
                    let message = "a threshold for contacts must be finite and not negative";
                    return Err(unknown_option(
                        message,
                        "a number that is not negative",
                        value.to_string(),
                    ));
                }
            }
            let is_foot = pattern(&thresholds.feet)?;
            let named = joints.joints.iter().enumerate();
            feet.extend(
                named
                    .filter(|(_, joint)| is_foot.is_match(&joint.name))
                    .map(|(index, _)| index),
            );
            if feet.is_empty() {
                return Err(unknown_option(
                    "no selected joint has the name of a foot",
                    "a pattern that matches a joint's name",
                    format!("{:?}", thresholds.feet),
                ));
            }
        }
        Ok(Self {
            thresholds: options.contacts.clone(),
            joint_count: joints.joints.len(),
            positions: vec![0.0; frames * feet.len() * 3],
            joints: feet,
        })
    }

    /// Frames x joints.
    pub(super) fn contacts(&self, frame: &Frame, frame_rate: f64) -> Option<Vec<bool>> {
        let thresholds = self.thresholds.as_ref()?;
        let metres = frame.metres_per_unit.unwrap_or(1.0);
        let speeds = velocities(&self.positions, 3 * self.joints.len(), frame_rate);
        let heights: Vec<f32> = points(&self.positions).map(|point| frame.height(point)).collect();
        let feet = self.joints.len();
        let frames = heights.len() / feet.max(1);
        let ground = level(&heights, feet);
        let thresholds = Thresholds {
            height: thresholds.height,
            speed: thresholds.speed,
            release: 1.0,
        };
        let heights = heights.iter().map(|height| f64::from(height - ground) * metres);
        let speeds = points(&speeds).map(|speed| f64::from(speed.length()) * metres);
        let samples: Vec<(f64, f64)> = heights.zip(speeds).collect();
        let mut contacts = vec![false; frames * self.joint_count];
        for (foot, &joint) in self.joints.iter().enumerate() {
            let of_foot = samples.iter().skip(foot).step_by(feet).copied();
            for (frame, rests) in low_and_slow(of_foot, thresholds).into_iter().enumerate() {
                contacts[frame * self.joint_count + joint] = rests;
            }
        }
        Some(contacts)
    }
}

fn points(values: &[f32]) -> impl Iterator<Item = Vec3> {
    values.chunks_exact(3).map(Vec3::from_slice)
}
