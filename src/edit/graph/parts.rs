//! What a motion graph consists of.

use serde::{Deserialize, Serialize};

/// A clip of a motion graph.
///
/// The [module](crate::graph) has an example.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
#[non_exhaustive]
pub struct GraphClip {
    /// Its file, as it was named.
    pub file: String,
    /// The SHA-256 of the file in hexadecimal digits; empty where it is not known.
    pub sha256: String,
    /// The number of the animation in the file, from 0.
    pub animation: usize,
    /// Its frames at the rate of the graph.
    pub frames: usize,
    /// The first and the last frame of it that belong to the largest strongly connected component, from each of which
    /// every other can be reached.
    pub part: Option<[usize; 2]>,
}

/// A place where a figure can pass from one moment to another. The two are blended for the length of a window, from the
/// frame that it leaves to the frame at which it arrives.
///
/// The [module](crate::graph) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
#[non_exhaustive]
pub struct GraphTransition {
    /// The clip and the frame that it leaves.
    pub from: [usize; 2],
    /// The clip and the frame that it comes to.
    pub to: [usize; 2],
    /// How far the two windows are apart, in metres.
    pub distance: f32,
}
