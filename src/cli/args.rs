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
mod parse;
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

/// What the exit codes mean, in every command. `src/cli/tests/it/exit_codes.rs` holds them to it.
const EXIT_CODES: &str = "\
Exit codes:
  0  done
  1  a file is at fault: it cannot be read or written, is broken, has no motion where one is
     needed, would be replaced, or is not what --verify, --max-angle or --require asks for
  2  the arguments are at fault: an unknown option, a wrong value, or a clip, joint or frame that
     the file does not have
  3  some of many files failed";

/// Motion capture: convert files, put motions on characters and robots, change them, look at them, prove the result.
#[derive(Debug, Parser)]
#[command(name = "mocap", version, long_version = build_info::long(), arg_required_else_help = true)]
pub struct Args {
    /// Say nothing but warnings and errors: neither notes nor progress nor a summary
    #[arg(short, long, global = true)]
    pub(crate) quiet: bool,
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Convert motion files: to glTF, VRM animation, FBX, BVH, packed clips or arrays
    Convert(ConvertArgs),
    /// Put motions on a character: onto the skeleton of a glTF, VRM, FBX or BVH file
    Retarget(RetargetArgs),
    /// Put motions of humans on a robot of URDF or MJCF, within the limits of its joints
    Robot(RobotArgs),
    /// Change a motion: foot lock, mirror, smooth, loop, join, blend, warp
    Edit(EditArgs),
    /// Clean a motion of a camera or a generator: time, flips, noise, floor, contacts
    Clean(CleanArgs),
    /// Find where motions can pass into each other, and walk through them: motion graphs
    Graph(GraphArgs),
    /// Solve rotations from markers of C3D and TRC, or from positions of joints with --joint-set
    Solve(SolveArgs),
    /// Summarise a file
    Info(InfoArgs),
    /// Write a motion as arrays: positions and rotations of all joints in all frames
    Fk(FkArgs),
    /// Write the angles of a body's joints as biomechanics states them, for OpenSim or as a table
    Angles(AnglesArgs),
    /// Print the table of a gait laboratory: heel strikes, toe offs, cadence, speed, lengths of steps
    Gait(GaitArgs),
    /// Write the forces of the ground from the force plates of a C3D file, for OpenSim or as a table
    Forces(SeriesArgs),
    /// Write the analog channels of a C3D file, such as electromyograms, for OpenSim or as a table
    Analog(SeriesArgs),
    /// Write many motions as arrays into Parquet files
    #[cfg(feature = "parquet")]
    Pack(PackArgs),
    /// Write many motions as arrays into Parquet files: this build cannot
    #[cfg(not(feature = "parquet"))]
    #[command(disable_help_flag = true)]
    Pack {
        #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
        any: Vec<std::ffi::OsString>,
    },
    /// Print the node matrices at a tick
    Pose(PoseArgs),
    /// Print the matrices from the root to a joint, T = J0 L1 J1 L2 ..., each apart, and place a point
    Chain(ChainArgs),
    /// Print unit, axes, rest pose, and which joint is which bone of a humanoid
    Skeleton(SkeletonArgs),
    /// Report errors and warnings of files
    Check(CheckArgs),
    /// Say of many motions what is wrong with them, which repeat others, and which to choose
    Survey(SurveyArgs),
    /// Make a database of the frames of many motions, to search in
    Index(IndexArgs),
    /// Find in a database the moments that are most like a part of a motion, or a pose, on any skeleton
    Find(FindArgs),
    /// Let a character follow a path by motion matching: jumps between the frames of a database
    Match(MatchArgs),
    /// Print a scene in the layout of the graphics course
    Dump(DumpArgs),
    /// Compare a written file with its source: the position of every joint in every frame
    Verify(VerifyArgs),
    /// Score a motion of a robot against its reference, by the measures of publications
    Score(ScoreArgs),
    /// Record what a program sends by the VMC protocol, until Ctrl-C
    Record(RecordArgs),
    /// Send a motion of a humanoid to programs that take the VMC protocol, as it would be captured
    Play(PlayArgs),
    /// Put motion of the VMC protocol on a character or a robot as it comes, and send it on
    Bridge(BridgeArgs),
    /// Write a page with a player for the motion, and open it
    View(ViewArgs),
    /// Draw poses over time, one row per file
    Sheet(SheetArgs),
    /// Draw a film as animated GIF or PNG
    Gif(GifArgs),
    /// Draw curves of a joint's position and angles
    Plot(PlotArgs),
    /// List the formats that can be read and written
    Formats(FormatsArgs),
    /// Print what this build and this machine lack, and which commands need it
    Doctor(DoctorArgs),
    /// Do the job of a JSON file, as --print-job of convert, edit, clean, retarget, robot, survey and graph prints it
    Run(RunArgs),
    /// Merge the manifests of a run's shards
    MergeManifest(MergeManifestArgs),
    /// Print the completions of a shell
    Completions(CompletionsArgs),
    /// Print the manual page of a command
    Man(ManArgs),
    /// Serve agents: the Model Context Protocol over standard input and output, within one folder
    Mcp(McpArgs),
}

impl Command {
    /// Whether a command ends without anybody who stops it, however long it takes.
    pub(crate) fn ends_by_itself(&self) -> bool {
        !matches!(self, Self::Mcp(_) | Self::Record(_) | Self::Play(_) | Self::Bridge(_))
    }
}

#[derive(Debug, clap::Args)]
pub(crate) struct ConvertArgs {
    /// The motion file, and after it the OUTPUT [default: the input's name with the extension .glb]; - is standard
    /// input or output, in the format of --to. With -o any number of motion files, folders and wildcards
    #[arg(required = true, value_name = "INPUT")]
    pub(crate) paths: Vec<PathBuf>,
    /// Compare the written file with its source, as `mocap verify` does
    #[arg(long)]
    pub(crate) verify: bool,
    /// Print what was done as JSON
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
    /// Smooth the solved motion as a whole: a Butterworth filter of this cut-off in Hz, forwards and backwards
    /// [without a number: 6]
    #[arg(long, value_name = "HZ", num_args = 0..=1, default_missing_value = "6", require_equals = true)]
    smooth: Option<f64>,
    #[command(flatten)]
    pub(crate) convert: ConvertArgs,
}

impl SolveArgs {
    /// Tells the reader the joints, or to find them from markers.
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
    /// Takes `-o take.glb` for the output of one file, as other commands have it.
    pub(crate) fn settle(&mut self) {
        let file = self.batch.take_file(&self.paths);
        self.paths.extend(file);
    }
}

/// The tolerance of `verify`.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Verifying")]
pub(crate) struct ToleranceArgs {
    /// Largest allowed distance of a joint from its position in the source, such as 1mm; above it the exit code is 1
    #[arg(long, value_name = "LENGTH", default_value = "1mm")]
    pub(crate) max_error: Length,
}

#[derive(Debug, clap::Args)]
pub(crate) struct VerifyArgs {
    /// The motion file
    #[arg(value_name = "INPUT")]
    pub(crate) source: PathBuf,
    /// The file that was made from it: any that is read, or the .npz or .csv of `mocap fk`
    #[arg(value_name = "OUTPUT")]
    pub(crate) output: PathBuf,
    /// A second motion that `mocap edit` joined, blended or layered with the source; once for each
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
    /// The motion of the robot that follows it, which any program made, in any layout that is read
    #[arg(value_name = "OUTPUT")]
    pub(crate) output: PathBuf,
    /// The robot that moves: a .urdf file, or an .xml file of MuJoCo
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
    /// Say why each joint is the bone that it is: how lengths, names and shape score, and what came second
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
    /// Print the completions within JSON
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
    /// Print the page within JSON; with -o the names of the pages
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Debug, clap::Args)]
pub(crate) struct McpArgs {
    /// The folder whose files may be read and written; paths of calls are relative to it. Nothing outside of it is
    /// opened, and no file is replaced that the session has not written
    #[arg(long, value_name = "FOLDER")]
    pub(crate) root: PathBuf,
    /// End a call that takes longer than so many seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 600, value_parser = clap::value_parser!(u64).range(1..=MOST_SECONDS))]
    pub(crate) time_limit: u64,
    /// Do one call of a server, which starts itself with this option.
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
