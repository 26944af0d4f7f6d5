//! Options of the commands that write arrays.

use std::path::PathBuf;

#[cfg(feature = "parquet")]
use clap::Args as _;
use clap::ValueEnum;
use mocap::arrays::{ArrayOptions, Contacts, Rotation, RotationSpace, Space};
use mocap::convert::TimeRange;

use mocap::job::{InputOptions, Length, OutSpace, SourceMap, SourceSpace};

use super::{ArgumentSources, ForceArgs};
use crate::Failure;
#[cfg(feature = "parquet")]
use crate::batch::{inputs::InputArgs, spread::SpreadArgs};

#[derive(Debug, clap::Args)]
pub(crate) struct FkArgs {
    /// The motion file; - is standard input
    pub(crate) input: PathBuf,
    /// The file to write: .npz, .csv or .parquet; - is standard output
    #[arg(short, long, value_name = "OUTPUT")]
    pub(crate) output: PathBuf,
    /// Format of standard output [default: csv]. Or the layout of another program, for humanoid motion: amass, smplx,
    /// kimodo, soma or mhr (.npz), humanml3d (.npy)
    #[arg(long, value_name = "FORMAT", value_parser = ["npz", "csv", "parquet", "amass", "smplx", "kimodo", "soma", "mhr", "humanml3d"])]
    pub(crate) to: Option<String>,
    /// Print the report as JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    /// Put ' before CSV names that begin with = + - or @, so that spreadsheets do not read them as formulas
    #[arg(long)]
    pub(crate) spreadsheet: bool,
    #[command(flatten)]
    pub(crate) arrays: ArraysArgs,
    #[command(flatten)]
    pub(crate) source: SourceSpace,
    #[command(flatten)]
    pub(crate) map: SourceMap,
    #[command(flatten)]
    pub(crate) read: InputOptions,
}

#[derive(Debug, clap::Args)]
pub(crate) struct AnglesArgs {
    /// The motion file; - is standard input
    pub(crate) input: PathBuf,
    /// The file to write: .mot of OpenSim, or .csv; - is standard output
    #[arg(short, long, value_name = "OUTPUT")]
    pub(crate) output: PathBuf,
    /// Format of standard output [default: csv]
    #[arg(long, value_name = "FORMAT", value_parser = ["mot", "csv"])]
    pub(crate) to: Option<String>,
    /// Print the report as JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    #[command(flatten)]
    pub(crate) source: SourceSpace,
    #[command(flatten)]
    pub(crate) map: SourceMap,
    #[command(flatten)]
    pub(crate) read: InputOptions,
}

/// The options of `mocap analog` and `mocap forces`.
#[derive(Debug, clap::Args)]
pub(crate) struct SeriesArgs {
    /// The C3D file; - is standard input
    pub(crate) input: PathBuf,
    /// The file to write: .mot or .sto of OpenSim, .csv or .parquet; - is standard output
    #[arg(short, long, value_name = "OUTPUT")]
    pub(crate) output: PathBuf,
    /// Format of standard output [default: csv]
    #[arg(long, value_name = "FORMAT", value_parser = ["mot", "sto", "csv", "parquet"])]
    pub(crate) to: Option<String>,
    /// Print the report as JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    #[command(flatten)]
    pub(crate) read: InputOptions,
}

#[derive(Debug, clap::Args)]
pub(crate) struct GaitArgs {
    /// The motion file; - is standard input
    #[arg(value_name = "INPUT")]
    pub(crate) file: PathBuf,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) source: SourceSpace,
    #[command(flatten)]
    pub(crate) map: SourceMap,
    #[command(flatten)]
    pub(crate) read: InputOptions,
}

#[cfg(feature = "parquet")]
#[derive(Debug, clap::Args)]
pub(crate) struct PackArgs {
    /// Motion files, folders and wildcards
    #[arg(required = true, value_name = "INPUT")]
    pub(crate) paths: Vec<PathBuf>,
    /// Folder for the Parquet files and a manifest of their inputs; with --to hf, a new folder or an earlier dataset
    #[arg(short, long = "output", alias = "out-dir", value_name = "OUTPUT")]
    pub(crate) out_dir: PathBuf,
    /// Format of the outputs
    #[arg(long, value_name = "FORMAT", default_value = "parquet")]
    pub(crate) to: PackFormatArg,
    /// Licence of the clips for the dataset card of --to hf, as a Hugging Face identifier such as cc-by-4.0 [default:
    /// unknown]
    #[arg(long, value_name = "ID")]
    pub(crate) license: Option<String>,
    /// What one row holds
    #[arg(long, value_name = "SHAPE", default_value = "clips")]
    table: TableArg,
    /// One row per file, without its motion; short for --table inventory
    #[arg(long, conflicts_with = "table")]
    inventory: bool,
    /// Size of one Parquet file, in megabytes of uncompressed values
    #[arg(long, value_name = "MB", default_value = "256")]
    pub(crate) part_size: u32,
    /// Print the report as JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    /// Skip unchanged files that the manifest lists with the same options
    #[arg(long)]
    pub(crate) resume: bool,
    #[command(flatten)]
    pub(crate) arrays: ArraysArgs,
    #[command(flatten)]
    pub(crate) inputs: InputArgs,
    #[command(flatten)]
    pub(crate) spread: SpreadArgs,
    #[command(flatten)]
    pub(crate) source: SourceSpace,
    #[command(flatten)]
    pub(crate) map: SourceMap,
    #[command(flatten)]
    pub(crate) read: InputOptions,
}

#[cfg(feature = "parquet")]
impl PackArgs {
    pub(crate) fn table(&self) -> TableArg {
        if self.inventory {
            TableArg::Inventory
        } else {
            self.table
        }
    }
}

#[cfg(feature = "parquet")]
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum PackFormatArg {
    /// Parquet files and a manifest
    Parquet,
    /// A Hugging Face dataset: Parquet files in metres with +Y up, and a dataset card
    Hf,
}

#[cfg(feature = "parquet")]
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum TableArg {
    /// One clip, with lists of all its values
    Clips,
    /// One joint in one frame
    Long,
    /// One file, without its motion
    Inventory,
}

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Arrays")]
pub(crate) struct ArraysArgs {
    /// What positions are relative to
    #[arg(long, value_name = "SPACE", default_value = "world")]
    space: SpaceArg,
    /// Representation of rotations
    #[arg(long, value_name = "FORM", default_value = "quat")]
    rot: RotationArg,
    /// What rotations are relative to
    #[arg(long, value_name = "SPACE", default_value = "local")]
    rot_space: RotationSpaceArg,
    /// Joints and end sites to keep: a regular expression, matched anywhere in the name [default: all]
    #[arg(long, value_name = "REGEX")]
    joints: Option<String>,
    /// Resample to this number of frames per second, at the same playback speed [default: the file's own]
    #[arg(long, value_name = "RATE", value_parser = InputOptions::parse_rate)]
    pub(crate) fps: Option<f64>,
    /// Part to keep, both ends included: A..B in seconds, or Af..Bf in frames; either end is optional
    #[arg(long, value_name = "A..B", allow_hyphen_values = true)]
    trim: Option<TimeRange>,
    /// Add velocities in units per second: central differences, one-sided at the first and last frame
    #[arg(long)]
    velocities: bool,
    /// Add foot contacts: a foot that is low and slow, by the rule of `mocap edit`
    #[arg(long)]
    contacts: bool,
    /// Names of the feet: a regular expression [default: the feet of the humanoid; else (?i)foot|toe|ankle]
    #[arg(
        id = "foot-joints",
        long,
        alias = "feet",
        value_name = "REGEX",
        requires = "contacts"
    )]
    feet: Option<String>,
    /// Largest height of a foot in contact above its resting level, such as 3cm [default: 5cm]
    #[arg(long, value_name = "LENGTH", requires = "contacts")]
    contact_height: Option<Length>,
    /// Largest speed of a foot in contact, in metres per second [default: 0.25]
    #[arg(long, value_name = "SPEED", requires = "contacts")]
    contact_speed: Option<f64>,
    #[command(flatten)]
    out: OutSpace,
}

impl ArraysArgs {
    /// The long names of all options.
    #[cfg(feature = "parquet")]
    pub(crate) fn names() -> Vec<String> {
        let command = Self::augment_args(clap::Command::default());
        let names = command.get_arguments().filter_map(clap::Arg::get_long);
        names.map(str::to_owned).collect()
    }

    /// Refuses options without an effect.
    pub(crate) fn check(&self, source: &SourceSpace, given: &ArgumentSources) -> Result<(), Failure> {
        let finds_unit = source.metres_per_unit().is_none() && (self.out.metres_per_unit().is_some() || self.contacts);
        let finds_up = source.up().is_none() && (self.out.up().is_some() || self.contacts);
        let finds_feet = self.contacts && self.feet.is_none();
        match finds_unit || finds_up || finds_feet {
            true => Ok(()),
            false => given.refuse(
                &["map"],
                "the bones are only needed to infer the unit, the up axis or the feet",
            ),
        }
    }

    /// The library's options.
    pub(crate) fn options(&self, source: &SourceSpace, map: &SourceMap) -> ArrayOptions {
        let standard = Contacts::default();
        ArrayOptions::new()
            .space(self.space.into())
            .rotation(self.rot.into())
            .rotation_space(self.rot_space.into())
            .joints(self.joints.clone())
            .frames_per_second(self.fps)
            .first(self.trim.and_then(|trim| trim.first))
            .last(self.trim.and_then(|trim| trim.last))
            .metres_per_unit(source.metres_per_unit())
            .up(source.up())
            .out_metres_per_unit(self.out.metres_per_unit())
            .out_up(self.out.up())
            .bones(map.bones_here())
            .velocities(self.velocities)
            .contacts(self.contacts.then(|| {
                Contacts::new()
                    .feet(self.feet.clone())
                    .height(self.contact_height.map_or(standard.height, Length::to_metres))
                    .speed(self.contact_speed.unwrap_or(standard.speed))
            }))
    }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum SpaceArg {
    /// The world
    World,
    /// The root's position in the same frame, in world axes
    Root,
    /// The parent, in the parent's axes
    Local,
}

impl From<SpaceArg> for Space {
    fn from(arg: SpaceArg) -> Self {
        match arg {
            SpaceArg::World => Self::World,
            SpaceArg::Root => Self::Root,
            SpaceArg::Local => Self::Local,
        }
    }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum RotationArg {
    /// Quaternion: x, y, z, w
    Quat,
    /// The first two columns of the matrix
    #[value(name = "6d")]
    SixD,
    /// The matrix, row by row
    Matrix,
    /// Degrees about x, y and z, in the joint's order in the file
    Euler,
}

impl From<RotationArg> for Rotation {
    fn from(arg: RotationArg) -> Self {
        match arg {
            RotationArg::Quat => Self::Quaternion,
            RotationArg::SixD => Self::SixD,
            RotationArg::Matrix => Self::Matrix,
            RotationArg::Euler => Self::Euler,
        }
    }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum RotationSpaceArg {
    /// The parent
    Local,
    /// The world
    World,
}

impl From<RotationSpaceArg> for RotationSpace {
    fn from(arg: RotationSpaceArg) -> Self {
        match arg {
            RotationSpaceArg::Local => Self::Local,
            RotationSpaceArg::World => Self::World,
        }
    }
}
