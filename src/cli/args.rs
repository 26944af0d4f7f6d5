//! The commands and options of the command line.

mod arrays;
mod batch;
mod change;
mod clean;
mod edit;
mod given;
mod graph;
pub(crate) mod guides;
pub(crate) mod help;
mod job;
pub(crate) mod live;
mod onto;
mod output;
mod own;
pub(crate) mod parse;
mod pictures;
mod pose;
mod retarget;
mod robot;
mod run;
mod search;
mod suggest;
mod survey;
mod write;

use std::path::PathBuf;

use clap::{Parser, Subcommand, ValueEnum};
use mocap::edit::{EditStep, Smooth};
use mocap::job::{InputOptions, Length, OutputOptions, SourceMap, SourceSpace};

use crate::batch::inputs::InputArgs;
use crate::batch::spread::SpreadArgs;
use crate::build_info;

pub(crate) use self::arrays::{AnglesArgs, FkArgs, GaitArgs, SeriesArgs};
#[cfg(feature = "parquet")]
pub(crate) use self::arrays::{ArraysArgs, PackArgs, PackFormatArg, TableArg};
pub(crate) use self::batch::{BatchArgs, MergeManifestArgs};
pub(crate) use self::change::{ChangeArgs, WeightsArgs};
pub(crate) use self::clean::CleanArgs;
pub(crate) use self::edit::EditArgs;
pub(crate) use self::given::ArgumentSources;
pub(crate) use self::graph::{GraphArgs, GraphCommand, WalkArgs};
pub(crate) use self::live::{BridgeArgs, ListenAddress, PlayArgs, RecordArgs};
pub(crate) use self::output::ForceArgs;
pub(crate) use self::own::OwnArgs;
pub(crate) use self::pictures::{GifArgs, PictureArgs, PlotArgs, SheetArgs, ViewArgs};
pub(crate) use self::pose::{ChainArgs, PoseArgs};
pub(crate) use self::retarget::RetargetArgs;
pub(crate) use self::robot::RobotArgs;
pub(crate) use self::run::{InsteadArgs, RunArgs};
pub(crate) use self::search::{FindArgs, IndexArgs, MatchArgs};
pub(crate) use self::survey::SurveyArgs;
pub(crate) use self::write::{OutputFormat, refuse_options};

/// The meaning of the exit codes, in every command. `src/cli/tests/it/exit_codes.rs` tests it.
const EXIT_CODES: &str = "\
Exit codes:
  0  done
  1  a file is at fault: it cannot be read or written, is broken, has no motion where one is
     needed, would be replaced, or fails --verify, --max-angle, --require or
     --fail-on
  2  the arguments are at fault: an unknown option, a wrong value, or a clip, joint or frame that
     the file does not have
  3  some of many files failed";

/// Convert, clean, edit, retarget, view and verify motion capture files.
#[derive(Debug, Parser)]
#[command(name = "mocap", version, long_version = build_info::long(), arg_required_else_help = true)]
pub struct Args {
    /// Print only warnings and errors: no notes, no progress, no summary
    #[arg(short, long, global = true)]
    pub(crate) quiet: bool,
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Convert motion files: to glTF, VRM animation, FBX, BVH, packed clips or arrays
    Convert(ConvertArgs),
    /// Retarget motions to the skeleton of a glTF, VRM, FBX or BVH file
    Retarget(RetargetArgs),
    /// Retarget human motion to a robot of URDF or MJCF, within its joint limits
    Robot(RobotArgs),
    /// Change a motion: foot lock, mirror, smooth, loop, join, blend, warp
    Edit(EditArgs),
    /// Clean motion from video estimators, sensors and generators: time, flips, noise, floor, contacts
    Clean(CleanArgs),
    /// Build motion graphs: find transitions between clips, and walk along them
    Graph(GraphArgs),
    /// Solve rotations from the markers of C3D and TRC files, or from joint positions with --joint-set
    Solve(SolveArgs),
    /// Summarise a file
    Info(InfoArgs),
    /// Write positions and rotations of all joints in all frames as arrays
    Fk(FkArgs),
    /// Write joint angles in the conventions of biomechanics, for OpenSim or as a table
    Angles(AnglesArgs),
    /// Print gait parameters: heel strikes, toe offs, cadence, step lengths; or the gaits of an animal
    Gait(GaitArgs),
    /// Write ground reaction forces from the force plates of a C3D file, for OpenSim or as a table
    Forces(SeriesArgs),
    /// Write the analog channels of a C3D file, such as electromyograms, for OpenSim or as a table
    Analog(SeriesArgs),
    /// Write many motions as arrays into Parquet files
    #[cfg(feature = "parquet")]
    Pack(PackArgs),
    /// Write many motions as arrays into Parquet files: not available in this build
    #[cfg(not(feature = "parquet"))]
    #[command(disable_help_flag = true)]
    Pack {
        #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
        any: Vec<std::ffi::OsString>,
    },
    /// Print the node matrices at a tick
    Pose(PoseArgs),
    /// Print each matrix from the root to a joint, T = J0 L1 J1 L2 ..., and transform a point
    Chain(ChainArgs),
    /// Print the unit, the axes, the rest pose, and the joint of each humanoid bone
    Skeleton(SkeletonArgs),
    /// Report errors and warnings of files
    Check(CheckArgs),
    /// Survey a dataset: defects, near-duplicates, a diverse subset
    Survey(SurveyArgs),
    /// Build a search database from the frames of many motions
    Index(IndexArgs),
    /// Search a database for the frames most similar to a clip or a pose, on any skeleton
    Find(FindArgs),
    /// Move a character along a path by motion matching with the frames of a database
    Match(MatchArgs),
    /// Print a scene as text, in the layout of a computer graphics course
    Dump(DumpArgs),
    /// Compare a written file with its source: the position of every joint in every frame
    Verify(VerifyArgs),
    /// Score a motion of a robot against its reference, by the measures of research papers
    Score(ScoreArgs),
    /// Record motion that a program sends over the VMC protocol, until Ctrl-C
    Record(RecordArgs),
    /// Send a humanoid's motion over the VMC protocol in real time
    Play(PlayArgs),
    /// Retarget a live VMC stream to a character or a robot, and send the result
    Bridge(BridgeArgs),
    /// Write an HTML page that plays the motion, and open it
    View(ViewArgs),
    /// Draw poses over time, one row per file
    Sheet(SheetArgs),
    /// Render a motion as an animated GIF or PNG
    Gif(GifArgs),
    /// Draw curves of a joint's position and angles
    Plot(PlotArgs),
    /// List the formats that can be read and written
    Formats(FormatsArgs),
    /// Print missing features of this build and machine, and the commands that need them
    Doctor(DoctorArgs),
    /// Run the job of a JSON file, as --print-job of convert, edit, clean, solve, retarget, robot, survey and graph
    /// prints it
    Run(RunArgs),
    /// Merge the manifests of a run's shards
    MergeManifest(MergeManifestArgs),
    /// Print the completions of a shell
    Completions(CompletionsArgs),
    /// Print the manual page of a command
    Man(ManArgs),
    /// Serve agents over the Model Context Protocol on standard input and output, within one folder
    Mcp(McpArgs),
}

impl Command {
    /// Whether a command ends without Ctrl-C.
    pub(crate) fn ends_by_itself(&self) -> bool {
        !matches!(self, Self::Mcp(_) | Self::Record(_) | Self::Play(_) | Self::Bridge(_))
    }
}

#[derive(Debug, clap::Args)]
pub(crate) struct ConvertArgs {
    /// The motion file, then the OUTPUT [default: the input's name with the extension .glb]; - is standard input or
    /// output, in the format of --to. With -o: any number of motion files, folders and wildcards
    #[arg(required = true, value_name = "INPUT")]
    pub(crate) paths: Vec<PathBuf>,
    /// Compare the written file with its source, as `mocap verify` does
    #[arg(long)]
    pub(crate) verify: bool,
    /// Print the report as JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    #[command(flatten)]
    pub(crate) write: OutputOptions,
    #[command(flatten)]
    pub(crate) change: ChangeArgs,
    #[command(flatten)]
    pub(crate) weights: WeightsArgs,
    /// Steps between reading and writing.
    #[arg(skip)]
    pub(crate) steps: Vec<EditStep>,
    #[command(flatten)]
    pub(crate) source: SourceSpace,
    #[command(flatten)]
    pub(crate) map: SourceMap,
    #[command(flatten)]
    pub(crate) read: InputOptions,
    #[command(flatten)]
    pub(crate) batch: BatchArgs,
    #[command(flatten)]
    pub(crate) instead: InsteadArgs,
}

#[derive(Debug, clap::Args)]
pub(crate) struct SolveArgs {
    /// The former name of --joint-set
    #[arg(long, hide = true, value_name = "SET|FILE", conflicts_with_all = ["joint-set", "markers"])]
    joints: Option<String>,
    /// Smooth the whole solved motion with a Butterworth filter, forwards and backwards, at this cut-off frequency in
    /// Hz [without a number: 6]
    #[arg(long, value_name = "HZ", num_args = 0..=1, default_missing_value = "6", require_equals = true)]
    smooth: Option<f64>,
    #[command(flatten)]
    pub(crate) convert: ConvertArgs,
}

impl SolveArgs {
    /// Passes the joint set to the reader; without a joint set, the reader solves from markers.
    pub(crate) fn settle(&mut self) {
        let Self {
            joints,
            smooth,
            convert,
        } = self;
        convert.steps = smooth
            .map(|cut_off| Smooth::new().cut_off(cut_off).into())
            .into_iter()
            .collect();
        if joints.is_some() {
            convert.read.joints = joints.take();
        }
        if convert.read.joints.is_none() {
            convert.read.markers.get_or_insert_with(|| "auto".to_owned());
        }
        convert.settle();
    }
}

impl ConvertArgs {
    /// Treats `-o take.glb` as the output of one file, as other commands do.
    pub(crate) fn settle(&mut self) {
        let file = self.batch.take_file(&self.paths);
        self.paths.extend(file);
    }
}

/// The tolerance of `verify`.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Verifying")]
pub(crate) struct ToleranceArgs {
    /// Largest allowed distance of a joint from its position in the source, such as 1mm; beyond it, the exit code is 1
    #[arg(long, value_name = "LENGTH", default_value = "1mm")]
    pub(crate) max_error: Length,
}

#[derive(Debug, clap::Args)]
pub(crate) struct VerifyArgs {
    /// The motion file
    #[arg(value_name = "INPUT")]
    pub(crate) source: PathBuf,
    /// The file made from INPUT: any readable format, or the .npz or .csv of `mocap fk`
    #[arg(value_name = "OUTPUT")]
    pub(crate) output: PathBuf,
    /// A second motion that `mocap edit` joined, blended or layered with the source; repeatable
    #[arg(long, value_name = "FILE")]
    pub(crate) with: Vec<PathBuf>,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) tolerance: ToleranceArgs,
    #[command(flatten)]
    pub(crate) weights: WeightsArgs,
    #[command(flatten)]
    pub(crate) read: InputOptions,
}

#[derive(Debug, clap::Args)]
pub(crate) struct ScoreArgs {
    /// The reference: a motion of a person, or of a robot that --body names
    #[arg(value_name = "INPUT")]
    pub(crate) source: PathBuf,
    /// The robot's motion that follows the reference, made by any program, in any readable layout
    #[arg(value_name = "OUTPUT")]
    pub(crate) output: PathBuf,
    /// The robot that moves: a .urdf file, or a MuJoCo .xml file
    #[arg(long, value_name = "TARGET")]
    pub(crate) robot: PathBuf,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) space: SourceSpace,
    #[command(flatten)]
    pub(crate) map: SourceMap,
    #[command(flatten)]
    pub(crate) read: InputOptions,
}

#[derive(Debug, clap::Args)]
pub(crate) struct InfoArgs {
    /// The motion file; - is standard input
    #[arg(value_name = "INPUT")]
    pub(crate) file: PathBuf,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) read: InputOptions,
}

#[derive(Debug, clap::Args)]
pub(crate) struct SkeletonArgs {
    /// The motion file; - is standard input
    #[arg(value_name = "INPUT")]
    pub(crate) file: PathBuf,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Explain the bone of each joint: scores of lengths, names and shape, and the second choice
    #[arg(long)]
    pub(crate) explain: bool,
    #[command(flatten)]
    pub(crate) source: SourceSpace,
    #[command(flatten)]
    pub(crate) map: SourceMap,
    #[command(flatten)]
    pub(crate) read: InputOptions,
}

#[derive(Debug, clap::Args)]
pub(crate) struct FormatsArgs {
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, clap::Args)]
pub(crate) struct DoctorArgs {
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, clap::Args)]
pub(crate) struct CompletionsArgs {
    /// The shell
    pub(crate) shell: clap_complete::Shell,
    /// Print the completions as a JSON string
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, clap::Args)]
pub(crate) struct ManArgs {
    /// The command [default: the page of mocap]
    pub(crate) command: Vec<String>,
    /// Write the pages of all commands into this folder
    #[arg(short, long, value_name = "OUTPUT", conflicts_with = "command")]
    pub(crate) output: Option<PathBuf>,
    /// Print the page as a JSON string; with -o, the file names of the pages
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, clap::Args)]
pub(crate) struct McpArgs {
    /// The folder whose files may be read and written. Paths in calls are relative to the folder. The server opens no
    /// file outside it, and replaces only files that the session has written
    #[arg(long, value_name = "FOLDER")]
    pub(crate) root: PathBuf,
    /// End a call that takes longer than this number of seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 600, value_parser = clap::value_parser!(u64).range(1..=MOST_SECONDS))]
    pub(crate) time_limit: u64,
    /// Run one call of a server. The server starts itself with this option.
    #[arg(long, hide = true)]
    pub(crate) call: bool,
}

/// The longest time limit: a year.
const MOST_SECONDS: u64 = 31_536_000;

#[derive(Debug, clap::Args)]
pub(crate) struct CheckArgs {
    /// The motion files, folders and wildcards
    #[arg(required = true, value_name = "INPUT")]
    pub(crate) paths: Vec<PathBuf>,
    /// Print JSON, one object per file
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) read: InputOptions,
    #[command(flatten)]
    pub(crate) inputs: InputArgs,
    #[command(flatten)]
    pub(crate) spread: SpreadArgs,
}

#[derive(Debug, clap::Args)]
pub(crate) struct DumpArgs {
    /// The motion file; - is standard input
    #[arg(value_name = "INPUT")]
    pub(crate) file: PathBuf,
    /// The sections to print [default: all sections of the layout]
    pub(crate) sections: Vec<SectionArg>,
    /// The layout: the year of the course
    #[arg(long, value_name = "YEAR", default_value = "2019", conflicts_with = "json")]
    pub(crate) layout: LayoutArg,
    /// Print the scene as imported: one skinned mesh and every key
    #[arg(long)]
    pub(crate) raw: bool,
    /// Print the whole scene as JSON
    #[arg(long, conflicts_with = "sections")]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) read: InputOptions,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum SectionArg {
    Scene,
    Mesh,
    Tree,
    Bone,
    Anim,
}

impl From<SectionArg> for mocap::dump::Section {
    fn from(arg: SectionArg) -> Self {
        match arg {
            SectionArg::Scene => Self::Scene,
            SectionArg::Mesh => Self::Mesh,
            SectionArg::Tree => Self::Tree,
            SectionArg::Bone => Self::Bone,
            SectionArg::Anim => Self::Anim,
        }
    }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum LayoutArg {
    #[value(name = "2017")]
    Y2017,
    #[value(name = "2018")]
    Y2018,
    /// 2019 and 2020
    #[value(name = "2019", alias = "2020")]
    Y2019,
    /// 2021 to 2024
    #[value(name = "2021", aliases = ["2022", "2023", "2024"])]
    Y2021,
}

impl From<LayoutArg> for mocap::dump::Layout {
    fn from(arg: LayoutArg) -> Self {
        match arg {
            LayoutArg::Y2017 => Self::Y2017,
            LayoutArg::Y2018 => Self::Y2018,
            LayoutArg::Y2019 => Self::Y2019,
            LayoutArg::Y2021 => Self::Y2021,
        }
    }
}
