//! Options for building a motion graph.

use std::fmt;
use std::path::PathBuf;

use mocap_edit::graph::{GraphOptions, MotionGraph};
use mocap_scene::report::counted;
use serde::{Deserialize, Serialize};

use super::is_default;
use super::text::Length;

/// Options for comparing the frames of motions.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::job::Job;
///
/// let job = Job::from_json(r#"{
///     "source": {"inputs": ["fixtures/real/cmu_12_01_walk.bvh"]},
///     "graph": {"threshold": "5cm"}
/// }"#)?;
/// let graph = job.run()?.graph.unwrap();
/// assert!(graph.transitions > 10 && graph.kept_seconds > 1.0);
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, rename_all = "kebab-case", deny_unknown_fields)]
#[cfg_attr(feature = "clap", derive(clap::Args))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct GraphJobOptions {
    /// Frames per second at which clips are compared
    #[cfg_attr(feature = "clap", arg(long, value_name = "RATE", default_value_t = GraphOptions::default().rate))]
    pub rate: f64,
    /// Length in seconds of the compared window, and of a transition [default: 1/3]
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "SECONDS", default_value_t = GraphOptions::default().window, hide_default_value = true)
    )]
    pub window: f64,
    /// Largest distance for a transition between two frames, as a mean over the joints, such as 6cm
    #[cfg_attr(feature = "clap", arg(long, value_name = "LENGTH", default_value_t = GraphJobOptions::default().threshold))]
    pub threshold: Length,
    /// Retarget all clips to this body before the comparison, as mocap retarget does, for clips of several skeletons.
    /// Any motion, glTF, VRM or FBX file of a humanoid
    #[cfg_attr(feature = "clap", arg(long = "character", alias = "on", value_name = "TARGET"))]
    #[serde(skip_serializing_if = "is_default")]
    pub on: Option<PathBuf>,
    /// Also keep transitions into and out of the largest strongly connected component
    #[cfg_attr(feature = "clap", arg(long))]
    #[serde(skip_serializing_if = "is_default")]
    pub whole: bool,
}

impl Default for GraphJobOptions {
    fn default() -> Self {
        let options = GraphOptions::default();
        Self {
            rate: options.rate,
            window: options.window,
            threshold: Length::metres(options.threshold),
            on: None,
            whole: options.whole,
        }
    }
}

impl GraphJobOptions {
    pub(super) fn options(&self) -> GraphOptions {
        GraphOptions::new()
            .rate(self.rate)
            .window(self.window)
            .threshold(self.threshold.to_metres())
            .whole(self.whole)
    }
}

/// The size of a motion graph, and the kept parts of its clips.
///
/// [`GraphJobOptions`] has an example.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct GraphReport {
    /// The clips.
    pub clips: usize,
    /// The transitions.
    pub transitions: usize,
    /// The total length of all clips, in seconds.
    pub seconds: f64,
    /// The total length of the kept parts in seconds: from each part a walk reaches all other kept parts.
    pub kept_seconds: f64,
    /// The files of clips without a kept part.
    pub left_out: Vec<String>,
}

impl fmt::Display for GraphReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (transitions, clips) = (counted(self.transitions, "transition"), counted(self.clips, "clip"));
        write!(
            f,
            "{transitions} among {clips}; {:.1} of {:.1} s kept: from each kept frame, a walk can reach every other \
             kept frame",
            self.kept_seconds, self.seconds
        )
    }
}

impl GraphReport {
    /// Summarises a graph.
    pub fn of(graph: &MotionGraph) -> Self {
        let seconds = |frames: usize| frames as f64 / graph.options.rate;
        let parts = graph.clips.iter().filter_map(|clip| clip.part);
        let left_out = graph.clips.iter().filter(|clip| clip.part.is_none());
        Self {
            clips: graph.clips.len(),
            transitions: graph.transitions.len(),
            seconds: seconds(graph.clips.iter().map(|clip| clip.frames).sum()),
            kept_seconds: seconds(parts.map(|[first, last]| last - first + 1).sum()),
            left_out: left_out.map(|clip| clip.file.clone()).collect(),
        }
    }
}
