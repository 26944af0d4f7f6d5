//! What is known of a clip beside its motion: when its feet are at rest, and how far its limbs point from those of
//! another.

use serde::Serialize;

use mocap_edit::report::{ContactPoint, DetectedContacts};
use mocap_figure::LimbAngles;

/// A point of a foot or a hand, and when it is at rest.
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

/// A step of an angle, in degrees.
const STEP: f32 = 0.01;

/// The limbs that are compared. Their block has 16 bits for each frame, limb after limb: the angle in steps.
#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Limbs {
    /// The id of the element that holds the block.
    pub(super) id: String,
    step: f32,
    frames: usize,
    /// The joint that each limb starts from.
    nodes: Vec<usize>,
    /// The bone that each is.
    bones: Vec<&'static str>,
    /// Of all limbs and frames, in degrees.
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
