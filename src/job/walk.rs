//! The goal of a walk over a motion graph. A walk is a path from clip to clip: its motion need not be walking.

use std::path::Path;

use mocap_edit::graph::report::Walk;
use mocap_edit::graph::{MotionGraph, Network};
use mocap_scene::error::{Code, Diagnostic, Result};
use serde::{Deserialize, Serialize};

use super::{is_default, refuse};

/// The goal of a walk over a motion graph: a duration, a path, or a list of clips.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::job::Job;
///
/// let job = Job::from_json(r#"{
///     "source": {"inputs": ["fixtures/real/cmu_12_01_walk.bvh"]},
///     "graph": {},
///     "walk": {"seconds": 6},
///     "write": {"output": "long.bvh"}
/// }"#)?;
/// let (written, report) = job.make(&[])?;
/// assert!(written.into_bytes()?.starts_with(b"HIERARCHY"));
/// assert_eq!(report.walk.unwrap().frames, 721); // 6 s at 120 Hz
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, rename_all = "kebab-case", deny_unknown_fields)]
#[cfg_attr(
    feature = "clap",
    derive(clap::Args),
    command(group(clap::ArgGroup::new("aim").required(true).multiple(false)))
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct WalkOptions {
    /// Walk for this number of seconds, and prefer rarely visited frames
    #[cfg_attr(feature = "clap", arg(long, value_name = "SECONDS", group = "aim"))]
    #[serde(skip_serializing_if = "is_default")]
    pub seconds: Option<f64>,
    /// Walk along a path over the ground, through these points in metres: x and z if +Y is up, x and y if +Z is up
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "X/Z+...", group = "aim", value_parser = parse_path, allow_hyphen_values = true)
    )]
    #[serde(skip_serializing_if = "is_default")]
    // On a command line, all points are one value.
    pub path: Option<std::vec::Vec<[f64; 2]>>,
    /// Walk through these clips in this order, by the cheapest transitions. CLIP@SECONDS is a time in a clip
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "CLIP[@SECONDS]", group = "aim", num_args = 2..)
    )]
    #[serde(skip_serializing_if = "is_default")]
    pub through: Vec<String>,
    /// Random seed of a walk of a given duration: another seed gives another walk
    #[cfg_attr(feature = "clap", arg(long, value_name = "N", default_value_t = WalkOptions::default().seed))]
    pub seed: u64,
}

impl Default for WalkOptions {
    fn default() -> Self {
        Self {
            seconds: None,
            path: None,
            through: Vec::new(),
            seed: 1,
        }
    }
}

/// Parses the points of a path, in the syntax of the path of the step warp, without times.
#[cfg(feature = "clap")]
fn parse_path(text: &str) -> Result<Vec<[f64; 2]>, String> {
    let point = |text: &str| {
        let (first, second) = text.split_once('/')?;
        Some([first.parse().ok()?, second.parse().ok()?])
    };
    let points: Option<Vec<_>> = text.split('+').map(point).collect();
    points.ok_or_else(|| "it must be points M/M+... such as 0/0+2/0+2/3".to_owned())
}

impl WalkOptions {
    /// Searches the requested walk.
    pub(super) fn search(&self, network: &Network<'_>, graph: &MotionGraph) -> Result<Walk> {
        match (self.seconds, &self.path, self.through.is_empty()) {
            (Some(seconds), None, true) => network.random(seconds, self.seed),
            (None, Some(path), true) => network.along(path),
            (None, None, false) => {
                let clips = self.through.iter().map(|named| moment(graph, named));
                network.through(&clips.collect::<Result<Vec<_>>>()?)
            }
            _ => refuse(
                "a walk needs exactly one of seconds, path and through",
                "name one of them",
            ),
        }
    }
}

/// Parses CLIP[@SECONDS]: a clip of a graph, and a time in the clip.
fn moment(graph: &MotionGraph, named: &str) -> Result<(usize, Option<f64>)> {
    let at = named
        .rsplit_once('@')
        .and_then(|(clip, seconds)| Some((clip, Some(seconds.parse().ok()?))));
    let (clip, seconds) = at.unwrap_or((named, None));
    Ok((clip_named(graph, clip)?, seconds))
}

/// The most clips that a message lists.
const NAMED: usize = 20;

/// The clip of a graph with this path or file name.
fn clip_named(graph: &MotionGraph, named: &str) -> Result<usize> {
    let is_path = |file: &str| file == named;
    let is_name = |file: &str| Path::new(file).file_name().is_some_and(|name| name == named);
    let is_stem = |file: &str| Path::new(file).file_stem().is_some_and(|stem| stem == named);
    let tests: [&dyn Fn(&str) -> bool; 3] = [&is_path, &is_name, &is_stem];
    for is_it in tests {
        let mut found = graph.clips.iter().enumerate().filter(|(_, clip)| is_it(&clip.file));
        match (found.next(), found.next()) {
            (Some((index, _)), None) => return Ok(index),
            (Some(_), Some(_)) => {
                let message = format!("through: several clips of the graph have the name {named}");
                return refuse(&message, "use the clip's path in the graph");
            }
            _ => {}
        }
    }
    let names: Vec<&str> = graph.clips.iter().map(|clip| clip.file.as_str()).take(NAMED).collect();
    let message = format!("through: the graph has no clip {named}; it has {}", names.join(", "));
    Err(Diagnostic::new(Code::InvalidValue, message).into())
}
