//! Foot contacts: which feet are on the ground.

use glam::Vec3;

use crate::arrays::frame::Frame;
use crate::arrays::joints::{Selection, pattern};
use crate::arrays::velocities::velocities;
use crate::arrays::{ArrayOptions, Contacts, unknown_option};
use crate::error::Result;

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
        let frames = heights.len() / self.joints.len().max(1);
        let ground = ground(&heights, self.joints.len());
        let mut contacts = vec![false; frames * self.joint_count];
        for (index, (height, speed)) in heights.iter().zip(points(&speeds)).enumerate() {
            let is_low = f64::from(height - ground) * metres <= thresholds.height;
            let is_slow = f64::from(speed.length()) * metres <= thresholds.speed;
            let (frame, foot) = (index / self.joints.len(), self.joints[index % self.joints.len()]);
            contacts[frame * self.joint_count + foot] = is_low && is_slow;
        }
        Some(contacts)
    }
}

/// The fifth percentile of the height of the lowest foot. The minimum would be that of a rest pose in the first frame,
/// in which CMU's files have the hips at the origin and the feet far below.
fn ground(heights: &[f32], feet: usize) -> f32 {
    let lowest = |frame: &[f32]| frame.iter().copied().fold(f32::INFINITY, f32::min);
    let mut lowest: Vec<f32> = heights.chunks(feet.max(1)).map(lowest).collect();
    lowest.sort_by(f32::total_cmp);
    lowest.get(lowest.len().saturating_sub(1) / 20).copied().unwrap_or(0.0)
}

fn points(values: &[f32]) -> impl Iterator<Item = Vec3> {
    values.chunks_exact(3).map(Vec3::from_slice)
}
