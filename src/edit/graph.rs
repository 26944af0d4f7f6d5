//! Builds motion graphs. A motion graph has the frames of many clips as nodes, and transitions between similar frames
//! of these clips. A walk is a path in this graph, along which a figure can move without a visible jump. The method is
//! Kovar, Gleicher and Pighin, "Motion Graphs" (2002); `docs/motion-graphs-algorithm.md` has the formulas.
//!
//! A [`GraphBuilder`] takes clips of one skeleton. It compares all pairs of windows (short runs of frames), and builds
//! a [`MotionGraph`]: the clips, and the transitions between them. It keeps only the largest strongly connected
//! component of the graph, so that a walk never comes to a dead end. A search finds a
//! [`Walk`](crate::graph::report::Walk), which then becomes a motion.
//!
//! ```
//! # std::env::set_current_dir("../..").unwrap();
//! use mocap::graph::{GraphBuilder, GraphOptions};
//!
//! let walk = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
//! let mut builder = GraphBuilder::new(&GraphOptions::new().threshold(0.1))?;
//! builder.add("walk.bvh", &walk)?;
//! let graph = builder.build()?;
//! let walk = builder.network(&graph)?.random(10.0, 1)?; // longer than the clip
//! assert!(walk.pieces.len() > 1 && walk.seconds() >= 10.0);
//! # Ok::<(), mocap::Error>(())
//! ```

mod bend;
pub(crate) mod bound;
mod builder;
pub(crate) mod clouds;
mod component;
pub(crate) mod distance;
mod file;
mod haste;
mod minima;
pub(crate) mod near;
mod network;
mod parts;
mod path;
mod random;
pub mod report;
mod through;
pub(crate) mod walk;

use mocap_scene::error::{Code, Result};
use mocap_scene::limits::{frame_rate, positive};
use mocap_scene::options::setters;
use serde::{Deserialize, Serialize};

#[doc(hidden)]
pub use self::builder::DistanceMatrix;
pub use self::builder::GraphBuilder;
pub use self::network::Network;
use self::parts::{GraphClip, GraphTransition};
pub use self::walk::WalkPath;

/// How [`GraphBuilder`] compares clips.
///
/// The [module](crate::graph) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
#[non_exhaustive]
pub struct GraphOptions {
    /// Frames per second at which clips are compared. Default: 30, as in the paper.
    pub rate: f64,
    /// The length of the compared windows, in seconds. A transition has the same length. Default: 1/3.
    pub window: f64,
    /// The largest distance between two windows that get a transition, in metres. Default: 0.06.
    pub threshold: f64,
    /// Whether to keep also the transitions that are not in the largest strongly connected component. Default: `false`.
    pub whole: bool,
}

setters! {
    GraphOptions {
        rate: f64,
        window: f64,
        threshold: f64,
        whole: bool,
    }
}

impl Default for GraphOptions {
    fn default() -> Self {
        Self {
            rate: 30.0,
            window: 1.0 / 3.0,
            threshold: 0.06,
            whole: false,
        }
    }
}

/// The largest number of frames in a window: 33 seconds at 30 frames per second, longer than any transition.
const LONGEST_WINDOW: f64 = 1000.0;

impl GraphOptions {
    /// The number of frames in a window.
    #[doc(hidden)]
    pub fn frames(&self) -> usize {
        (self.window * self.rate).round() as usize
    }

    fn check(&self) -> Result<()> {
        frame_rate(Code::InvalidValue, self.rate)?;
        positive(Code::InvalidValue, "window", self.window)?;
        positive(Code::InvalidValue, "threshold", self.threshold)?;
        let frames = self.window * self.rate;
        if (2.0..=LONGEST_WINDOW).contains(&frames.round()) {
            return Ok(());
        }
        let message = format!("a window must have 2 to {LONGEST_WINDOW} frames, got {frames:.1}");
        Err(mocap_scene::error::Diagnostic::new(Code::InvalidValue, message).into())
    }
}

/// Clips, and transitions between their similar frames.
///
/// The [module](crate::graph) has an example.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
#[non_exhaustive]
pub struct MotionGraph {
    /// The version of the schema of the file: [`MotionGraph::VERSION`].
    pub motion_graph: u32,
    /// The options with which the clips were compared.
    pub options: GraphOptions,
    /// The file of the character to which all clips were retargeted before the comparison, and its SHA-256 in
    /// hexadecimal digits. `None` if the clips share one skeleton.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub body: Option<(String, String)>,
    /// The joints whose positions are compared, each with its weight. The sum of the weights is 1. The weight of a
    /// frame decreases linearly from the middle of a window to its edges.
    pub points: Vec<(String, f32)>,
    /// The clips, in the order in which they were added.
    pub clips: Vec<GraphClip>,
    /// The transitions, in the order of the frames at which they leave a clip.
    pub transitions: Vec<GraphTransition>,
}
