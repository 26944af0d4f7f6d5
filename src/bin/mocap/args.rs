//! Commands and options. Nothing is done here.

mod arrays;
mod batch;
mod bvh;
mod change;
mod compress;

use std::path::PathBuf;

use clap::{Parser, Subcommand, ValueEnum};

pub(crate) use self::arrays::ArraysArgs;
use mocap::{Importer, RootOffset};

pub(crate) use self::batch::{BatchArgs, FormatArg, MergeManifestArgs, SpreadArgs};
pub(crate) use self::bvh::BvhArgs;
pub(crate) use self::change::{ChangeArgs, DropArg, Moment, RestArg, TrimArg, UnitArg, UpArg};
pub(crate) use self::compress::{CompressArg, CompressArgs};

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

/// How to read a file.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Reading")]
pub(crate) struct ReadArgs {
    /// Format of the input [default: found from its contents, else from its extension]
    #[arg(long, value_name = "NAME")]
    from: Option<String>,
    /// The skeleton of an .amc motion [default: the .asf file beside it that has the same prefix, or the only one]
    #[arg(long, value_name = "FILE")]
    skeleton: Option<PathBuf>,
    /// What to do with the root's OFFSET when the root has position channels too
    #[arg(long, value_name = "POLICY", default_value = "auto")]
    root_offset: RootOffsetArg,
    /// Read every row of the motion, also those beyond the declared number of frames
    #[arg(long)]
    all_rows: bool,
    /// Take every warning for an error
    #[arg(long)]
    pub(crate) strict: bool,
}

impl ReadArgs {
    /// An importer with these options.
    pub(crate) fn importer(&self) -> Importer {
        let mut importer = Importer::new()
            .root_offset(self.root_offset.into())
            .all_rows(self.all_rows)
            .strict(self.strict);
        if let Some(format) = &self.from {
            importer = importer.format(format);
        }
        if let Some(skeleton) = &self.skeleton {
            importer = importer.skeleton(skeleton);
        }
        importer
    }
}

/// The frame rate, for commands that do not write one.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Reading")]
pub(crate) struct FrameRateArgs {
    /// Frames per second to take in place of the file's own
    #[arg(long, value_name = "RATE")]
    fps: Option<f64>,
    #[command(flatten)]
    pub(crate) read: ReadArgs,
}

impl FrameRateArgs {
    /// An importer with these options.
    pub(crate) fn importer(&self) -> Importer {
        let importer = self.read.importer();
        match self.fps {
            Some(frame_rate) => importer.frame_rate(frame_rate),
            None => importer,
        }
    }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum RootOffsetArg {
    /// Add where the first frame's root position is near zero while the OFFSET is not, else replace
    Auto,
    /// The position channels stand in place of the OFFSET
    Replace,
    /// The position channels are added to the OFFSET
    Add,
}

impl From<RootOffsetArg> for RootOffset {
    fn from(arg: RootOffsetArg) -> Self {
        match arg {
            RootOffsetArg::Auto => Self::Auto,
            RootOffsetArg::Replace => Self::Replace,
            RootOffsetArg::Add => Self::Add,
        }
    }
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
pub(crate) struct FkArgs {
    /// The motion file
    pub(crate) input: PathBuf,
    /// The file to write: .npz, .csv or .parquet
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) arrays: ArraysArgs,
    #[command(flatten)]
    pub(crate) read: ReadArgs,
}

#[cfg(feature = "parquet")]
#[derive(Debug, clap::Args)]
pub(crate) struct PackArgs {
    /// Motion files, folders and wildcards
    #[arg(required = true, value_name = "PATH")]
    pub(crate) paths: Vec<PathBuf>,
    /// Folder for the Parquet files and a manifest of their inputs
    #[arg(short, long, value_name = "FOLDER")]
    pub(crate) out_dir: PathBuf,
    /// Format of the outputs
    #[arg(long, value_name = "FORMAT", default_value = "parquet")]
    pub(crate) to: PackFormatArg,
    /// What a row is
    #[arg(long, value_name = "SHAPE", default_value = "clips")]
    table: TableArg,
    /// A row a file, without its motion: the same as --table inventory
    #[arg(long, conflicts_with = "table")]
    inventory: bool,
    /// Megabytes of values, not compressed, after which a Parquet file ends
    #[arg(long, value_name = "MB", default_value = "256")]
    pub(crate) part_size: u32,
    /// Skip files that the manifest says were packed with the same options, and have not changed since
    #[arg(long)]
    pub(crate) resume: bool,
    #[command(flatten)]
    pub(crate) arrays: ArraysArgs,
    #[command(flatten)]
    pub(crate) spread: SpreadArgs,
    #[command(flatten)]
    pub(crate) read: ReadArgs,
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
    Parquet,
}

#[cfg(feature = "parquet")]
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum TableArg {
    /// A clip, with lists of all its values
    Clips,
    /// A joint in a frame
    Long,
    /// A file, without its motion
    Inventory,
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

#[derive(Debug, clap::Args)]
pub(crate) struct ViewArgs {
    /// The motion files, shown together, or one folder, whose clips are listed
    #[arg(required = true)]
    pub(crate) files: Vec<PathBuf>,
    /// The page to write [default: one among the temporary files, opened in the browser]
    #[arg(long, short, value_name = "PATH")]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) read: ReadArgs,
}

#[derive(Debug, clap::Args)]
pub(crate) struct SheetArgs {
    /// The motion files
    #[arg(required = true)]
    pub(crate) files: Vec<PathBuf>,
    /// The picture to write: .png or .svg
    #[arg(long, short, value_name = "PATH")]
    pub(crate) output: PathBuf,
    /// Poses a file
    #[arg(long, value_name = "COUNT", default_value_t = mocap::render::SheetOptions::default().poses)]
    pub(crate) poses: usize,
    /// Width in pixels
    #[arg(long, value_name = "PIXELS", default_value_t = mocap::render::SheetOptions::default().width)]
    pub(crate) width: u32,
    #[command(flatten)]
    pub(crate) read: ReadArgs,
}

#[derive(Debug, clap::Args)]
pub(crate) struct GifArgs {
    /// The motion file
    pub(crate) file: PathBuf,
    /// The film to write: .gif, or .apng or .png for an animated PNG
    #[arg(long, short, value_name = "PATH")]
    pub(crate) output: PathBuf,
    /// Width in pixels
    #[arg(long, value_name = "PIXELS", default_value_t = mocap::render::MovieOptions::default().width)]
    pub(crate) width: u32,
    /// Height in pixels
    #[arg(long, value_name = "PIXELS", default_value_t = mocap::render::MovieOptions::default().height)]
    pub(crate) height: u32,
    /// Pictures a second
    #[arg(long, value_name = "RATE", default_value_t = mocap::render::MovieOptions::default().frames_per_second)]
    pub(crate) rate: f64,
    /// How fast to play; 1 is the speed of life
    #[arg(long, value_name = "FACTOR", default_value_t = mocap::render::MovieOptions::default().speed)]
    pub(crate) speed: f64,
    /// Leave the camera where it sees the whole way, and do not follow the root
    #[arg(long)]
    pub(crate) still: bool,
    #[command(flatten)]
    pub(crate) read: ReadArgs,
}

#[derive(Debug, clap::Args)]
pub(crate) struct PlotArgs {
    /// The motion file
    pub(crate) file: PathBuf,
    /// The joint; give several to see them below one another
    #[arg(long, value_name = "NAME", required = true)]
    pub(crate) joint: Vec<String>,
    /// The picture to write: .svg or .png
    #[arg(long, short, value_name = "PATH")]
    pub(crate) output: PathBuf,
    /// Width in pixels
    #[arg(long, value_name = "PIXELS", default_value_t = mocap::render::PlotOptions::default().width)]
    pub(crate) width: u32,
    #[command(flatten)]
    pub(crate) read: ReadArgs,
}
