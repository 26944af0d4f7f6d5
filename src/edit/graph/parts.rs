//! The parts of a motion graph.

use serde::{Deserialize, Serialize};

/// A clip of a motion graph.
///
/// The [module](crate::graph) has an example.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
#[non_exhaustive]
pub struct GraphClip {
    /// The path of the file of the clip, as the user gave it.
    pub file: String,
    /// The SHA-256 of the file in hexadecimal digits; empty if unknown.
    pub sha256: String,
    /// The number of the animation in the file, from 0.
    pub animation: usize,
    /// The number of frames at the rate of the graph.
    pub frames: usize,
    /// The first and the last frame that belong to the largest strongly connected component, in which every frame can
    /// be reached from every other frame. `None` if no frame of the clip belongs to it.
    pub part: Option<[usize; 2]>,
}

/// A transition between two clips, or within one clip. Over one window, the motion is blended from the clip that the
/// figure leaves to the clip that it enters.
///
/// The [module](crate::graph) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
#[non_exhaustive]
pub struct GraphTransition {
    /// The index of the clip that the figure leaves, and the frame at which the blend starts.
    pub from: [usize; 2],
    /// The index of the clip that the figure enters, and the frame at which the blend ends.
    pub to: [usize; 2],
    /// The distance of the two windows, in metres.
    pub distance: f32,
}
