//! The options of `mocap graph` and `mocap graph walk`.

use std::path::PathBuf;
use std::str::FromStr;

use clap::Subcommand;
use mocap::files::ReplacePolicy;
use mocap::graph::GraphOptions;
use mocap::job::{Job, Length, Onto, OntoBody, Reading, SourceMap, SourceSpace};

use super::job::sources;
use super::{ForceArgs, InputArgs, OutputFormat, WriteArgs};

#[derive(Debug, clap::Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub(crate) struct GraphArgs {
    #[command(subcommand)]
    pub(crate) command: Option<GraphCommand>,
    /// The motion files, folders and wildcards, all of one skeleton, or of humanoids with --on
    #[arg(required = true, value_name = "PATH")]
    pub(crate) paths: Vec<PathBuf>,
    /// The graph to write: .json, or - for standard output
    #[arg(short, long, value_name = "FILE", required_unless_present = "matrix")]
    pub(crate) output: Option<PathBuf>,
    /// Format of standard output
    #[arg(long, value_name = "FORMAT", value_parser = ["json"])]
    pub(crate) to: Option<String>,
    /// Write the distances of all moments of two clips, or of one clip to itself: a picture, .png, in which what is
    /// lighter is more alike and red dots are transitions, or an array, .npy
    #[arg(long, value_name = "FILE")]
    pub(crate) matrix: Option<PathBuf>,
    /// Frames per second at which clips are compared
    #[arg(long, value_name = "RATE", default_value_t = GraphOptions::default().rate)]
    rate: f64,
    /// The length of the window that is compared, and of a transition, in seconds
    #[arg(long, value_name = "SECONDS", default_value_t = GraphOptions::default().window)]
    window: f64,
    /// The largest distance at which a figure may pass from one moment to another: of its joints in the mean, in metres
    /// or with a unit, such as 6cm
    #[arg(long, value_name = "LENGTH", default_value = "6cm")]
    threshold: Length,
    /// Put all clips on this body before they are compared, as mocap retarget does: for clips of several skeletons. Any
    /// motion file, glTF, VRM or FBX file of a humanoid
    #[arg(long, value_name = "FILE")]
    pub(crate) on: Option<PathBuf>,
    /// Keep the transitions too that lead out of the largest strongly connected component, or into it from outside
    #[arg(long)]
    whole: bool,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    #[command(flatten)]
    pub(crate) source: SourceSpace,
    #[command(flatten)]
    pub(crate) read: Reading,
    #[command(flatten)]
    pub(crate) inputs: InputArgs,
}

impl GraphArgs {
    pub(crate) fn options(&self) -> GraphOptions {
        GraphOptions::new()
            .rate(self.rate)
            .window(self.window)
            .threshold(self.threshold.to_metres())
            .whole(self.whole)
    }
}

#[derive(Debug, Subcommand)]
pub(crate) enum GraphCommand {
    /// Write a motion that walks over a graph
    Walk(WalkArgs),
}

#[derive(Debug, clap::Args)]
pub(crate) struct WalkArgs {
    /// The graph that mocap graph wrote; the clips that it names are read
    pub(crate) graph: PathBuf,
    /// The file to write, in any format of mocap formats, or - for standard output
    #[arg(short, long, value_name = "OUT")]
    pub(crate) output: PathBuf,
    /// Format of standard output [default: glb]
    #[arg(long, value_name = "FORMAT")]
    pub(crate) to: Option<OutputFormat>,
    #[command(flatten)]
    pub(crate) aim: AimArgs,
    /// The number that the walk of --seconds depends on: another gives another walk
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) seed: u64,
    /// Put the walk on this character: a glTF, VRM, FBX or BVH file
    #[arg(long, value_name = "FILE")]
    pub(crate) on: Option<PathBuf>,
    /// Print what was made as JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    #[command(flatten)]
    pub(crate) write: WriteArgs,
    #[command(flatten)]
    pub(crate) source: SourceSpace,
    #[command(flatten)]
    pub(crate) read: Reading,
}

/// Where a walk goes.
#[derive(Debug, clap::Args)]
#[group(required = true, multiple = false)]
pub(crate) struct AimArgs {
    /// Walk for so long, where it was seldom
    #[arg(long, value_name = "SECONDS")]
    pub(crate) seconds: Option<f64>,
    /// Walk along a path over the ground, through these points in metres: x and z where +Y is up, x and y where +Z is
    #[arg(long, value_name = "M/M+...", value_parser = parse_path, allow_hyphen_values = true)]
    pub(crate) path: Option<PathArg>,
    /// Walk through these clips in this order, by the cheapest transitions; CLIP@SECONDS is a moment of a clip
    #[arg(long, value_name = "CLIP[@SECONDS]", num_args = 2..)]
    pub(crate) through: Option<Vec<ThroughArg>>,
}

/// The points of a path.
#[derive(Clone, Debug)]
pub(crate) struct PathArg(pub(crate) Vec<[f64; 2]>);

/// As the step warp of mocap edit has a path, without times.
fn parse_path(text: &str) -> Result<PathArg, String> {
    let point = |text: &str| {
        let (first, second) = text.split_once('/')?;
        Some([first.parse().ok()?, second.parse().ok()?])
    };
    let points: Option<Vec<_>> = text.split('+').map(point).collect();
    points
        .map(PathArg)
        .ok_or_else(|| "it must be points M/M+... such as 0/0+2/0+2/3".to_owned())
}

/// A clip of a graph, and a time in it.
#[derive(Clone, Debug)]
pub(crate) struct ThroughArg {
    pub(crate) file: String,
    pub(crate) seconds: Option<f64>,
}

impl FromStr for ThroughArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let at = text
            .rsplit_once('@')
            .and_then(|(file, seconds)| Some((file, seconds.parse().ok()?)));
        Ok(match at {
            Some((file, seconds)) => Self {
                file: file.to_owned(),
                seconds: Some(seconds),
            },
            None => Self {
                file: text.to_owned(),
                seconds: None,
            },
        })
    }
}

impl WalkArgs {
    /// The job that writes the walk, with an output of the format of `extension`.
    pub(crate) fn job(&self, extension: &str) -> Job {
        let mut job = Job::new();
        job.read = self.read.clone();
        job.source = sources(std::slice::from_ref(&self.graph), &self.source, &SourceMap::default());
        job.onto = self.on.as_ref().map(|file| Onto::Character(OntoBody::new(file)));
        self.write.fill(&mut job.write, &self.output, extension);
        job.write.force = self.force.force;
        job
    }

    /// Which files the output may replace: neither the graph nor a clip, nor the body of the graph.
    pub(crate) fn policy(&self, clips: &[PathBuf]) -> ReplacePolicy {
        let inputs = std::iter::once(&self.graph).chain(clips).chain(&self.on);
        ReplacePolicy::new(inputs).force(self.force.force)
    }
}
