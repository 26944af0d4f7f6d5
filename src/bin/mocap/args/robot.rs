//! The options of `mocap robot`.

use std::path::PathBuf;

use mocap::convert::TimeRange;
use mocap::figure::HumanoidMap;
use mocap::job::{BoneMap, Feet, Reading, RequiredVerdict, RobotFormat, SourceMap, SourceSpace, StepLength};

use super::{InputArgs, PrintJobArgs, SpreadArgs};

#[derive(Debug, clap::Args)]
pub(crate) struct RobotArgs {
    /// The motion files of humans; with a folder as output also folders and wildcards
    #[arg(required = true, value_name = "MOTION")]
    pub(crate) paths: Vec<PathBuf>,
    /// The robot: a .urdf file, or an .xml file of MuJoCo
    #[arg(long, value_name = "FILE")]
    pub(crate) robot: PathBuf,
    /// The file to write, .npz, .pkl, .csv or .glb, or - for standard output; of several motions the folder to write
    /// into
    #[arg(short, long, value_name = "OUT")]
    pub(crate) output: PathBuf,
    /// Format of the outputs [default: what the name of the output says, else npz]
    #[arg(long, value_name = "FORMAT")]
    pub(crate) to: Option<RobotFormat>,
    /// Frames per second to write [default: those of the motion]
    #[arg(long, value_name = "RATE")]
    pub(crate) fps: Option<f64>,
    /// Part to keep, both ends included: A..B in seconds, or Af..Bf in frames; either end may be left out
    #[arg(long, value_name = "A..B", allow_hyphen_values = true)]
    pub(crate) trim: Option<TimeRange>,
    /// How large the steps are: auto (in the proportion of the legs), none (as in the source), or a factor
    #[arg(long, value_name = "SCALE", default_value = "auto")]
    pub(crate) scale: StepLength,
    /// Feet: lock (they stand where those of the source stand), or free
    #[arg(long, value_name = "KIND", default_value = "lock")]
    pub(crate) feet: Feet,
    /// Keep joints within the velocities too that the file of the robot allows
    #[arg(long)]
    pub(crate) velocity_limits: bool,
    /// Take the links of this JSON file as bones of the robot, of the shape that `mocap skeleton --json` prints for the
    /// robot; those that it does not name are searched for
    #[arg(long, value_name = "FILE", value_parser = BoneMap::parse_file)]
    pub(crate) robot_map: Option<HumanoidMap>,
    /// Exit with 1 where the verdict of a motion is worse than this
    #[arg(long, value_name = "VERDICT")]
    pub(crate) require: Option<RequiredVerdict>,
    /// Skip motions that were put on the robot with the same options, according to the manifest, and are unchanged
    #[arg(long)]
    pub(crate) resume: bool,
    /// Write the reports of many motions as a table to this .parquet file, a row for each; with --shard 1/8, x.parquet
    /// is x.1-of-8.parquet
    #[arg(long, value_name = "FILE")]
    pub(crate) report: Option<PathBuf>,
    /// Print the report of one motion as JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Replace a file that may be a source; an input is never replaced
    #[arg(long)]
    pub(crate) force: bool,
    #[command(flatten)]
    pub(crate) source: SourceSpace,
    #[command(flatten)]
    pub(crate) map: SourceMap,
    #[command(flatten)]
    pub(crate) read: Reading,
    #[command(flatten)]
    pub(crate) inputs: InputArgs,
    #[command(flatten)]
    pub(crate) spread: SpreadArgs,
    #[command(flatten)]
    pub(crate) print: PrintJobArgs,
}

impl RobotArgs {
    /// Whether the output is a folder: for several motions, for a folder of them, and where its name is no file's.
    pub(crate) fn is_many(&self) -> bool {
        let is_one = matches!(&self.paths[..], [path] if !path.is_dir());
        let is_file = self.output.as_os_str() == "-" || self.output.extension().is_some();
        !(is_one && is_file) || self.output.is_dir()
    }
}
