//! Options of the commands that draw.

use std::path::PathBuf;

use mocap::Conversion;
use mocap::convert::TimeRange;
use mocap::job::{InputOptions, SourceMap, SourceSpace, SourceUp};

use super::ForceArgs;
use crate::batch::inputs::InputArgs;

#[derive(Debug, clap::Args)]
pub(crate) struct ViewArgs {
    /// The motion files to show together, or one folder, whose clips are listed. The page compares two humanoids if
    /// their frame counts and frame rates are equal
    #[arg(required = true, value_name = "INPUT")]
    pub(crate) files: Vec<PathBuf>,
    /// The page to write: .html, or - for standard output [default: a temporary file, opened in the browser]
    #[arg(long, short, value_name = "OUTPUT")]
    pub(crate) output: Option<PathBuf>,
    /// Format of standard output
    #[arg(long, value_name = "FORMAT", value_parser = ["html"])]
    pub(crate) to: Option<String>,
    /// Print the report as JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    /// Show the motions on this character, with its skin: a .glb, .gltf, .vrm or .fbx file with the skeleton of a
    /// humanoid
    #[arg(long, value_name = "TARGET")]
    pub(crate) character: Option<PathBuf>,
    /// Also show the motions on this robot, next to their sources: a .urdf file or a MuJoCo .xml file
    #[arg(long, value_name = "TARGET", conflicts_with = "character")]
    pub(crate) robot: Option<PathBuf>,
    /// Part to show, both ends included: A..B in seconds, or Af..Bf in frames; either end is optional
    #[arg(long, value_name = "A..B", allow_hyphen_values = true)]
    pub(crate) trim: Option<TimeRange>,
    /// Resample to this number of frames per second, at the same playback speed. For an input without a valid rate, set
    /// its rate
    #[arg(long, value_name = "RATE", value_parser = InputOptions::parse_rate)]
    pub(crate) fps: Option<f64>,
    #[command(flatten)]
    pub(crate) inputs: InputArgs,
    #[command(flatten)]
    pub(crate) source: SourceSpace,
    #[command(flatten)]
    pub(crate) map: SourceMap,
    #[command(flatten)]
    pub(crate) read: InputOptions,
}

impl ViewArgs {
    /// The arguments that show one file without options.
    pub(crate) fn of_file(file: PathBuf) -> Self {
        Self {
            files: vec![file],
            output: None,
            to: None,
            json: false,
            force: ForceArgs { force: false },
            character: None,
            robot: None,
            trim: None,
            fps: None,
            inputs: InputArgs { allow_empty: false },
            source: SourceSpace::default(),
            map: SourceMap::default(),
            read: InputOptions::default(),
        }
    }

    /// The frames to show. The values of the file are not converted: the page has the file's unit and up axis.
    pub(crate) fn conversion(&self) -> Conversion {
        let mut conversion = Conversion::new().keep_units(true).bones(self.map.bones_here());
        if let Some(TimeRange { first, last }) = self.trim {
            conversion = conversion.trim(first, last);
        }
        if let Some(rate) = self.fps {
            conversion = conversion.frame_rate(rate);
        }
        conversion
    }
}

/// A picture to write.
#[derive(Debug, clap::Args)]
pub(crate) struct PictureArgs {
    /// The picture to write: .png or .svg; - is standard output
    #[arg(long, short, value_name = "OUTPUT")]
    pub(crate) output: PathBuf,
    /// Format of standard output [default: png]
    #[arg(long, value_name = "FORMAT", value_parser = ["png", "svg"])]
    pub(crate) to: Option<String>,
    /// Print the report as JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
}

#[derive(Debug, clap::Args)]
pub(crate) struct SheetArgs {
    /// The motion files
    #[arg(required = true, value_name = "INPUT")]
    pub(crate) files: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) picture: PictureArgs,
    /// Poses per file
    #[arg(long, value_name = "COUNT", default_value_t = mocap::render::SheetOptions::default().poses, value_parser = poses())]
    pub(crate) poses: usize,
    /// Width in pixels
    #[arg(long, value_name = "PIXELS", default_value_t = mocap::render::SheetOptions::default().width, value_parser = pixels())]
    pub(crate) width: u32,
    /// Draw the motions on this robot, a .urdf file or a MuJoCo .xml file
    #[arg(long, value_name = "TARGET", conflicts_with = "t_pose")]
    pub(crate) robot: Option<PathBuf>,
    /// Draw the T-pose of each skeleton instead of its motion
    #[arg(long, conflicts_with = "poses")]
    pub(crate) t_pose: bool,
    #[command(flatten)]
    pub(crate) up: SourceUp,
    #[command(flatten)]
    pub(crate) map: SourceMap,
    #[command(flatten)]
    pub(crate) read: InputOptions,
}

#[derive(Debug, clap::Args)]
pub(crate) struct GifArgs {
    /// The motion file; - is standard input
    #[arg(value_name = "INPUT")]
    pub(crate) file: PathBuf,
    /// The animation to write: .gif, or .apng or .png for an animated PNG; - is standard output
    #[arg(long, short, value_name = "OUTPUT")]
    pub(crate) output: PathBuf,
    /// Format of standard output [default: gif]
    #[arg(long, value_name = "FORMAT", value_parser = ["gif", "apng", "png"])]
    pub(crate) to: Option<String>,
    /// Print the report as JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    /// Width in pixels
    #[arg(long, value_name = "PIXELS", default_value_t = mocap::render::MovieOptions::default().width, value_parser = pixels())]
    pub(crate) width: u32,
    /// Height in pixels
    #[arg(long, value_name = "PIXELS", default_value_t = mocap::render::MovieOptions::default().height, value_parser = pixels())]
    pub(crate) height: u32,
    /// Pictures per second
    #[arg(long, value_name = "RATE", default_value_t = mocap::render::MovieOptions::default().frames_per_second)]
    pub(crate) rate: f64,
    /// Playback speed; 1 is real time
    #[arg(id = "playback-speed", long, alias = "speed", value_name = "FACTOR", default_value_t = mocap::render::MovieOptions::default().speed)]
    pub(crate) speed: f64,
    /// Draw the motion on this robot, a .urdf file or a MuJoCo .xml file
    #[arg(long, value_name = "TARGET")]
    pub(crate) robot: Option<PathBuf>,
    /// Show the whole path with a fixed camera, instead of a camera that follows the root
    #[arg(long)]
    pub(crate) still: bool,
    #[command(flatten)]
    pub(crate) up: SourceUp,
    #[command(flatten)]
    pub(crate) read: InputOptions,
}

#[derive(Debug, clap::Args)]
pub(crate) struct PlotArgs {
    /// The motion file; - is standard input
    #[arg(value_name = "INPUT")]
    pub(crate) file: PathBuf,
    /// The joint, by its name or its bone, such as leftFoot; repeatable
    #[arg(long, value_name = "NAME", required = true)]
    pub(crate) joint: Vec<String>,
    #[command(flatten)]
    pub(crate) picture: PictureArgs,
    /// Width in pixels
    #[arg(long, value_name = "PIXELS", default_value_t = mocap::render::PlotOptions::default().width, value_parser = pixels())]
    pub(crate) width: u32,
    #[command(flatten)]
    pub(crate) read: InputOptions,
}

/// The number of poses in a row.
fn poses() -> impl clap::builder::TypedValueParser<Value = usize> {
    use clap::builder::TypedValueParser;

    clap::value_parser!(u16).range(1..).map(usize::from)
}

/// The sides of a picture, in pixels.
fn pixels() -> clap::builder::RangedI64ValueParser<u32> {
    clap::value_parser!(u32).range(1..=16_384)
}
