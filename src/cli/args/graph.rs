//! The options of `mocap graph` and `mocap graph walk`.

use std::path::PathBuf;

use clap::Subcommand;
use mocap::job::{
    CharacterTarget, GraphJob, GraphJobOptions, InputOptions, JobTarget, OutputOptions, SourceSpace, WalkJob,
    WalkOptions,
};

use super::write::writing;
use super::{ForceArgs, InsteadArgs, OutputFormat, WeightsArgs};
use crate::batch::inputs::InputArgs;

#[derive(Debug, clap::Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub(crate) struct GraphArgs {
    #[command(subcommand)]
    pub(crate) command: Option<GraphCommand>,
    /// The motion files, folders and wildcards. All motions must have one skeleton; with --character, any humanoids
    #[arg(required = true, value_name = "INPUT")]
    pub(crate) paths: Vec<PathBuf>,
    /// The graph to write: .json, or - for standard output
    #[arg(short, long, value_name = "OUTPUT", required_unless_present = "matrix")]
    pub(crate) output: Option<PathBuf>,
    /// Format of standard output
    #[arg(long, value_name = "FORMAT", value_parser = ["json"])]
    pub(crate) to: Option<String>,
    #[command(flatten)]
    pub(crate) graphing: GraphJobOptions,
    /// Write the distance matrix of two clips, or of one clip with itself: a .png picture or a .npy array. In the
    /// picture, lighter means more similar, and red dots are transitions
    #[arg(long, value_name = "FILE")]
    pub(crate) matrix: Option<PathBuf>,
    /// Print the contents of the graph as JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Print the job of the arguments, for `mocap run` and for programs, and do nothing else
    #[arg(long)]
    pub(crate) print_job: bool,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    #[command(flatten)]
    pub(crate) source: SourceSpace,
    #[command(flatten)]
    pub(crate) read: InputOptions,
    #[command(flatten)]
    pub(crate) inputs: InputArgs,
}

impl GraphArgs {
    /// The job of the arguments.
    pub(crate) fn job(&self) -> GraphJob {
        let mut job = GraphJob::default();
        job.read = self.read.clone();
        job.source.inputs.clone_from(&self.paths);
        job.source.space = self.source.clone();
        job.graph = self.graphing.clone();
        job.matrix.clone_from(&self.matrix);
        job.write.output = self.output.clone().unwrap_or_default();
        job.write.to.clone_from(&self.to);
        job.write.force = self.force.force;
        job
    }
}

#[derive(Debug, Subcommand)]
pub(crate) enum GraphCommand {
    /// Write the motion of a walk through a graph
    Walk(WalkArgs),
}

#[derive(Debug, clap::Args)]
pub(crate) struct WalkArgs {
    /// A graph written by `mocap graph`. The command reads the clips of the graph again
    #[arg(value_name = "INPUT")]
    pub(crate) graph: PathBuf,
    /// The file to write, in any format of mocap formats, or - for standard output
    #[arg(short, long, value_name = "OUTPUT")]
    pub(crate) output: PathBuf,
    /// Format of standard output [default: glb]
    #[arg(long, value_name = "FORMAT")]
    pub(crate) to: Option<OutputFormat>,
    #[command(flatten)]
    pub(crate) walking: WalkOptions,
    /// Retarget the walk to this character: a glTF, VRM, FBX or BVH file
    #[arg(long = "character", alias = "on", value_name = "TARGET")]
    pub(crate) on: Option<PathBuf>,
    /// Print the report as JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    #[command(flatten)]
    weights: WeightsArgs,
    #[command(flatten)]
    pub(crate) write: OutputOptions,
    #[command(flatten)]
    pub(crate) source: SourceSpace,
    #[command(flatten)]
    pub(crate) read: InputOptions,
    #[command(flatten)]
    pub(crate) instead: InsteadArgs,
}

impl WalkArgs {
    /// The job that writes the walk, with an output of the format of `extension`.
    pub(crate) fn job(&self, extension: &str) -> WalkJob {
        let mut job = WalkJob::default();
        job.read = self.read.clone();
        job.source.inputs = vec![self.graph.clone()];
        job.source.space = self.source.clone();
        job.walk = self.walking.clone();
        let character = self.on.as_ref().map(CharacterTarget::new);
        job.target = character.map(JobTarget::Character);
        job.weights = self.weights.weights();
        job.write = writing(&self.write, &self.output, extension, self.force);
        job
    }
}
