//! Data about a clip in addition to its motion: the ground contacts of its feet, and the angles between its limbs and
//! the limbs of another clip.

use serde::Serialize;

use mocap_edit::report::{ContactPoint, DetectedContacts};
use mocap_figure::LimbAngles;

/// A point of a foot or a hand, and its contact intervals.
#[derive(Serialize)]
pub(super) struct Contact {
    node: usize,
    bone: &'static str,
    /// The first and the last frame of each contact.
    intervals: Vec<[usize; 2]>,
}

impl Contact {
    pub(super) fn all(found: &DetectedContacts) -> Vec<Self> {
        let contact = |point: &ContactPoint| Self {
            node: point.node.index(),
            bone: point.bone.as_str(),
            intervals: point.intervals(),
        };
        found.points.iter().map(contact).collect()
    }
}

/// The step of an angle, in degrees.
const STEP: f32 = 0.01;

/// The compared limbs. Their block has the angles in steps, as numbers of 16 bits: all frames of the first limb, then
/// all frames of the next limb.
#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Limbs {
    /// The id of the element with the block.
    pub(super) id: String,
    step: f32,
    frames: usize,
    /// The joint at the start of each limb.
    nodes: Vec<usize>,
    /// The bone of each limb.
    bones: Vec<&'static str>,
    /// The mean angle over all limbs and frames, in degrees.
    mean: f64,
    largest: f64,
}

impl Limbs {
    pub(super) fn new(angles: &[LimbAngles], id: String) -> Self {
        let all = || {
            angles
                .iter()
                .flat_map(|limb| &limb.degrees)
                .map(|degrees| f64::from(*degrees))
        };
        Self {
            id,
            step: STEP,
            frames: angles.first().map_or(0, |limb| limb.degrees.len()),
            nodes: angles.iter().map(|limb| limb.node.index()).collect(),
            bones: angles.iter().map(|limb| limb.bone.as_str()).collect(),
            mean: all().sum::<f64>() / all().count().max(1) as f64,
            largest: all().fold(0.0, f64::max),
        }
    }
}

pub(super) fn bytes_of(angles: &[LimbAngles]) -> Vec<u8> {
    let all = angles.iter().flat_map(|limb| &limb.degrees);
    all.flat_map(|degrees| ((degrees / STEP).round() as u16).to_le_bytes())
        .collect()
}
