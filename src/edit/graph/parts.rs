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
    /// The path of its file, as given to the graph.
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

/// A place where a figure can pass from one moment to another. The two clips are blended over one window, from the
/// frame of departure to the frame of arrival.
///
/// The [module](crate::graph) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
#[non_exhaustive]
pub struct GraphTransition {
    /// The clip and the frame of departure.
    pub from: [usize; 2],
    /// The clip and the frame of arrival.
    pub to: [usize; 2],
    /// The distance of the two windows, in metres.
    pub distance: f32,
}
