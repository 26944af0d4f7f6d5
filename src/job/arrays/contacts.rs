//! Foot contacts: which feet are on the ground.

use glam::Vec3;
use mocap_figure::contacts::{ContactRule, points_of_feet};
use mocap_figure::ground::levels;
use mocap_scene::error::Result;
use mocap_scene::math::velocity::velocities;
use mocap_scene::scene::Scene;

use crate::arrays::frame::Frame;
use crate::arrays::joints::{Selection, pattern};
use crate::arrays::{ArrayOptions, Contacts, unknown_option};

/// The names of feet in a skeleton that is not a humanoid.
const NAMED_FEET: &str = "(?i)foot|toe|ankle";

/// The world positions of the feet in the output.
pub(super) struct Feet {
    thresholds: Option<Contacts>,
    joint_count: usize,
    /// Indices of the feet among the joints.
    pub(super) joints: Vec<usize>,
    /// The number of feet in each group. The feet of a group are consecutive in `joints`, and rest at one level.
    groups: Vec<usize>,
    /// Frames x feet x 3, to be filled.
    pub(super) positions: Vec<f32>,
}

impl Feet {
    pub(super) fn new(
        scene: &Scene,
        frame: &Frame,
        joints: &Selection,
        options: &ArrayOptions,
        frames: usize,
    ) -> Result<Self> {
        let mut groups = Vec::new();
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
            groups = groups_of_feet(scene, frame, joints, thresholds)?;
        }
        let feet = groups.concat();
        Ok(Self {
            thresholds: options.contacts.clone(),
            joint_count: joints.joints.len(),
            groups: groups.iter().map(Vec::len).collect(),
            positions: vec![0.0; frames * feet.len() * 3],
            joints: feet,
        })
    }

    /// The contacts of the feet: frames x joints.
    pub(super) fn contacts(&self, frame: &Frame, frame_rate: f64) -> Option<Vec<bool>> {
        let thresholds = self.thresholds.as_ref()?;
        let rule = ContactRule {
            height: thresholds.height,
            speed: thresholds.speed,
            ..ContactRule::default()
        };
        let metres = frame.metres_per_unit.unwrap_or(1.0) as f32;
        let feet = self.joints.len();
        let speeds = velocities(&self.positions, 3 * feet, frame_rate);
        let speeds: Vec<f32> = points(&speeds).map(|speed| speed.length() * metres).collect();
        let heights: Vec<f32> = points(&self.positions)
            .map(|point| point.dot(frame.up()) * metres)
            .collect();
        let frames = heights.len() / feet.max(1);
        let mut contacts = vec![false; frames * self.joint_count];
        let track = |foot: usize| points(&self.positions).skip(foot).step_by(feet).collect();
        let mut first = 0;
        let of_group = |count: &usize| {
            first += count;
            (first - count..first).map(track).collect()
        };
        let tracks: Vec<Vec<Vec<Vec3>>> = self.groups.iter().map(of_group).collect();
        let levels = levels(&tracks, frame.up(), metres, frame_rate);
        let mut first = 0;
        for (&count, level) in self.groups.iter().zip(levels) {
            let group = first..first + count;
            let rest = level.unwrap_or_default() * metres;
            for foot in group {
                let heights = heights.iter().skip(foot).step_by(feet);
                let speeds = speeds.iter().skip(foot).step_by(feet);
                let samples = heights.zip(speeds);
                let samples = samples.map(|(height, speed)| (f64::from(height - rest), f64::from(*speed)));
                for (frame, rests) in rule.at_rest(samples, frame_rate).into_iter().enumerate() {
                    contacts[frame * self.joint_count + self.joints[foot]] = rests;
                }
            }
            first += count;
        }
        Some(contacts)
    }
}

/// Indices of the feet among the joints, grouped by resting level. With a pattern of the caller, feet are found by
/// name; otherwise the feet are the ankles and balls of the humanoid's feet.
fn groups_of_feet(scene: &Scene, frame: &Frame, joints: &Selection, thresholds: &Contacts) -> Result<Vec<Vec<usize>>> {
    let humanoid = frame.figure.as_ref().map(|figure| &figure.humanoid);
    let humanoid = humanoid.filter(|humanoid| humanoid.found && thresholds.feet.is_none());
    if let Some(humanoid) = humanoid {
        let groups = points_of_feet(scene, humanoid).map(|points| {
            let column_of = |node| joints.nodes.iter().position(|listed| *listed == node);
            points
                .into_iter()
                .filter_map(|(_, node)| column_of(node))
                .collect::<Vec<_>>()
        });
        if groups.iter().all(Vec::is_empty) {
            return Err(unknown_option(
                "no selected joint belongs to a foot",
                "a selection with a joint of a foot",
                format!("{} joints", joints.nodes.len()),
            ));
        }
        return Ok(groups.into());
    }
    let names = thresholds.feet.as_deref().unwrap_or(NAMED_FEET);
    let is_foot = pattern(names)?;
    let named = joints.joints.iter().enumerate();
    let feet: Vec<usize> = named
        .filter(|(_, joint)| is_foot.is_match(&joint.name))
        .map(|(index, _)| index)
        .collect();
    if feet.is_empty() {
        return Err(unknown_option(
            "no selected joint has the name of a foot",
            "a pattern that matches a joint's name",
            format!("{names:?}"),
        ));
    }
    Ok(vec![feet])
}

fn points(values: &[f32]) -> impl Iterator<Item = Vec3> {
    values.chunks_exact(3).map(Vec3::from_slice)
}
