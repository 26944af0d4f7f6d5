//! Commands and options. Nothing is done here.

mod arrays;
mod batch;
mod bvh;
mod change;
mod compress;
mod pictures;
mod read;

use std::path::PathBuf;

use clap::{Parser, Subcommand, ValueEnum};

pub(crate) use self::arrays::FkArgs;
#[cfg(feature = "parquet")]
pub(crate) use self::arrays::{PackArgs, TableArg};
pub(crate) use self::batch::{BatchArgs, FormatArg, MergeManifestArgs, SpreadArgs};
pub(crate) use self::bvh::BvhArgs;
pub(crate) use self::change::{ChangeArgs, DropArg, Moment, RestArg, TrimArg, UnitArg, UpArg};
pub(crate) use self::compress::{CompressArg, CompressArgs};
pub(crate) use self::pictures::{GifArgs, PlotArgs, SheetArgs, ViewArgs};
pub(crate) use self::read::{FrameRateArgs, ReadArgs};

/// Motion capture into an Assimp-style scene: convert it to animated glTF, look into it, drive it from a tick.
#[derive(Debug, Parser)]
#[command(version, arg_required_else_help = true)]
pub(crate) struct Args {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Write motion files as animated glTF or as BVH
    Convert(ConvertArgs),
    /// Say what is in a file
    Info(InfoArgs),
    /// Write a motion as arrays: positions and rotations of every joint in every frame
    Fk(FkArgs),
    /// Write many motions as arrays into Parquet files
    #[cfg(feature = "parquet")]
    Pack(PackArgs),
    /// Print the node matrices at a tick
    Pose(PoseArgs),
    /// Say what is wrong with files
    Check(CheckArgs),
    /// Print a scene as the graphics course does
    Dump(DumpArgs),
    /// Prove that a written glTF file moves as its source does
    Verify(VerifyArgs),
    /// Look at the motion: write a page with a player, and open it
    View(ViewArgs),
    /// Draw poses over time, one row a file
    Sheet(SheetArgs),
    /// Draw a film: animated GIF or PNG
    Gif(GifArgs),
    /// Draw curves of a joint's position and angles
    Plot(PlotArgs),
    /// List the formats that can be read and written
    Formats,
    /// Make one manifest of those that the shards of a run have left
    MergeManifest(MergeManifestArgs),
}

#[derive(Debug, clap::Args)]
pub(crate) struct ConvertArgs {
    /// The motion file, and the file to write [default: the input's name with the extension .glb]; with -o any number
    /// of motion files, folders and wildcards
    #[arg(required = true, value_name = "PATH")]
    pub(crate) paths: Vec<PathBuf>,
    /// How to draw the skeleton
    #[arg(long, value_name = "KIND", default_value = "skinned")]
    pub(crate) mesh: MeshArg,
    /// Keep tracks that never change as animation, and do not fold them into the rest pose
    #[arg(long)]
    pub(crate) keep_constant: bool,
    /// Put the numbers of a .gltf into the file itself, not into a .bin beside it
    #[arg(long)]
    pub(crate) embed: bool,
    #[command(flatten)]
    pub(crate) bvh: BvhArgs,
    #[command(flatten)]
    pub(crate) change: ChangeArgs,
    /// Compare the written file with its source afterwards, as `mocap verify` does
    #[arg(long)]
    pub(crate) verify: bool,
    #[command(flatten)]
    pub(crate) compress: CompressArgs,
    #[command(flatten)]
    pub(crate) read: ReadArgs,
    #[command(flatten)]
    pub(crate) batch: BatchArgs,
}

/// How far is too far.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Verifying")]
pub(crate) struct ToleranceArgs {
    /// Largest distance of a joint from its place in the source, in metres or with a unit, as 1mm; beyond it the exit
    /// code is 1
    #[arg(long, value_name = "LENGTH", default_value = "1mm", value_parser = compress::parse_length)]
    pub(crate) max_error: f64,
}

#[derive(Debug, clap::Args)]
pub(crate) struct VerifyArgs {
    /// The motion file
    pub(crate) source: PathBuf,
    /// The .glb, or the .gltf with its buffer inside, that was made from it
    pub(crate) output: PathBuf,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) tolerance: ToleranceArgs,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum MeshArg {
    /// One mesh a node
    Segmented,
    /// One mesh with bones
    Skinned,
    /// No mesh
    None,
}

impl From<MeshArg> for mocap::SkeletonMesh {
    fn from(arg: MeshArg) -> Self {
        match arg {
            MeshArg::Segmented => Self::Segmented,
            MeshArg::Skinned => Self::Skinned,
            MeshArg::None => Self::None,
        }
    }
}

#[derive(Debug, clap::Args)]
pub(crate) struct InfoArgs {
    /// The motion file
    pub(crate) file: PathBuf,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) read: FrameRateArgs,
}

#[derive(Debug, clap::Args)]
pub(crate) struct PoseArgs {
    /// The motion file
    pub(crate) file: PathBuf,
    /// The tick; one between two frames is interpolated
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    pub(crate) tick: f64,
    /// Matrices to the world, not to the parent
    #[arg(long)]
    pub(crate) world: bool,
    /// Take a tick outside of the motion from its repetition, not from its nearest end
    #[arg(long = "loop")]
    pub(crate) repeat: bool,
    /// Print JSON
    #[arg(long, conflicts_with = "csv")]
    pub(crate) json: bool,
    /// Print comma-separated values
    #[arg(long)]
    pub(crate) csv: bool,
    #[command(flatten)]
    pub(crate) read: FrameRateArgs,
}

#[derive(Debug, clap::Args)]
pub(crate) struct CheckArgs {
    /// The motion files, folders and wildcards
    #[arg(required = true, value_name = "PATH")]
    pub(crate) paths: Vec<PathBuf>,
    /// Print JSON, an object a file
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) read: FrameRateArgs,
    #[command(flatten)]
    pub(crate) spread: SpreadArgs,
}

#[derive(Debug, clap::Args)]
pub(crate) struct DumpArgs {
    /// The motion file
    pub(crate) file: PathBuf,
    /// What to print [default: everything that the layout has]
    pub(crate) sections: Vec<SectionArg>,
    /// The year of the course whose print-out to give
    #[arg(long, value_name = "YEAR", default_value = "2019", conflicts_with = "json")]
    pub(crate) layout: LayoutArg,
    /// The scene as imported: one skinned mesh and every key
    #[arg(long)]
    pub(crate) raw: bool,
    /// Print the whole scene as JSON
    #[arg(long, conflicts_with = "sections")]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) read: FrameRateArgs,
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
    #[value(name = "2019")]
    Y2019,
    #[value(name = "2021")]
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
