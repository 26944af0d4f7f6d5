//! The options of `mocap index`, `mocap find` and `mocap match`.

use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::str::FromStr;

use mocap::convert::{Moment, TimeRange};
use mocap::glam::Vec2;
use mocap::job::InputOptions;
use mocap::survey::Condition;

use super::ForceArgs;
use super::write::extensions_and;
use crate::batch::inputs::InputArgs;
use crate::batch::spread::SpreadArgs;

#[derive(Debug, clap::Args)]
pub(crate) struct IndexArgs {
    /// The motion files, folders and wildcards, or .mdb databases of earlier runs and shards
    #[arg(required = true, value_name = "INPUT")]
    pub(crate) paths: Vec<PathBuf>,
    /// The database to write, an .mdb file; - is standard output
    #[arg(short, long, value_name = "OUTPUT")]
    pub(crate) output: PathBuf,
    /// Format of standard output
    #[arg(long, value_name = "FORMAT", value_parser = ["mdb"])]
    pub(crate) to: Option<String>,
    /// Print the report as JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Also add the mirror image of every motion, for motion matching. `mocap find` does not need mirror images
    #[arg(long)]
    pub(crate) mirror: bool,
    /// Also store the motions in the database, as packed clips within 0.1 mm. Without this option the database only
    /// names their files
    #[arg(long)]
    pub(crate) pack: bool,
    /// Reuse the clips in the output of an earlier run if the bytes of their files are unchanged
    #[arg(long)]
    pub(crate) resume: bool,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    #[command(flatten)]
    pub(crate) read: InputOptions,
    #[command(flatten)]
    pub(crate) inputs: InputArgs,
    #[command(flatten)]
    pub(crate) spread: SpreadArgs,
}

#[derive(Debug, clap::Args)]
#[command(group(clap::ArgGroup::new("query").required(true).args(["like", "pose"])))]
pub(crate) struct FindArgs {
    /// The database, an .mdb file that `mocap index` wrote
    #[arg(value_name = "INPUT")]
    pub(crate) database: PathBuf,
    /// A part of a motion: walk.bvh@2.0s..3.5s or walk.bvh@120f..210f. Without a part, the whole motion: walk.bvh
    #[arg(long, value_name = "FILE@A..B")]
    pub(crate) like: Option<PartArg>,
    /// A pose: walk.bvh@2.5s, or walk.bvh@150f
    #[arg(long, value_name = "FILE@T")]
    pub(crate) pose: Option<PoseArg>,
    /// Largest number of results
    #[arg(short = 'n', long, value_name = "N", default_value = "10")]
    pub(crate) count: usize,
    /// Largest number of results from one take: a clip and its near-duplicates are one take
    #[arg(long, value_name = "N", default_value = "1")]
    pub(crate) per_clip: NonZeroUsize,
    /// Skip results of which only the mirror image matches
    #[arg(long)]
    pub(crate) no_mirror: bool,
    /// Search only clips that fulfil this condition on the columns of `mocap survey`, such as "walking > 0.5 and skate
    /// < 3"
    #[arg(long = "where", value_name = "EXPR")]
    pub(crate) condition: Option<Condition>,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Draw the results below the query: a sheet of poses, .png or .svg
    #[arg(long, value_name = "FILE")]
    pub(crate) sheet: Option<PathBuf>,
    /// Write a page that plays the query and the results side by side: .html
    #[arg(long, value_name = "FILE")]
    pub(crate) page: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    #[command(flatten)]
    pub(crate) read: InputOptions,
}

#[derive(Debug, clap::Args)]
pub(crate) struct MatchArgs {
    /// The database, an .mdb file that `mocap index` wrote. Motions that are not stored in the database are read from
    /// their files
    #[arg(value_name = "INPUT")]
    pub(crate) database: PathBuf,
    #[command(flatten)]
    pub(crate) aim: MatchAim,
    /// The speed in metres per second; with --gamepad, the speed at full deflection of the left stick
    #[arg(long, value_name = "M/S", default_value = "1.2")]
    pub(crate) speed: f32,
    /// The character: a glTF, VRM, FBX or BVH file with the skeleton of a humanoid
    #[arg(long = "character", alias = "on", value_name = "TARGET")]
    pub(crate) on: PathBuf,
    /// The file to write: the character with the motion; - is standard output. For database.bin, mocap also writes
    /// features.bin to the same folder, for the controller of Holden's motion matching demo
    #[arg(short, long, value_name = "OUTPUT")]
    pub(crate) output: PathBuf,
    /// Format of standard output [default: glb]
    #[arg(long, value_name = "FORMAT", value_parser = extensions_and(&[]))]
    pub(crate) to: Option<String>,
    /// Print the deviation from the path as JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    #[command(flatten)]
    pub(crate) read: InputOptions,
}

/// The path to follow.
#[derive(Debug, clap::Args)]
#[group(multiple = false)]
pub(crate) struct MatchAim {
    /// The path over the ground: points X/Z in metres, such as 0/0+0/4+3/4
    #[arg(long, value_name = "X/Z+...", allow_hyphen_values = true)]
    pub(crate) path: Option<PathArg>,
    /// The stick positions of a gamepad over time: a table (CSV) or a list (JSON) of seconds, left_x, left_y, right_x,
    /// right_y
    #[arg(long, value_name = "FILE")]
    pub(crate) gamepad: Option<PathBuf>,
}

impl MatchAim {
    pub(crate) fn is_nothing(&self) -> bool {
        self.path.is_none() && self.gamepad.is_none()
    }
}

/// Points over the ground.
#[derive(Clone, Debug)]
pub(crate) struct PathArg(pub(crate) Vec<Vec2>);

impl FromStr for PathArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || "not X/Z+X/Z, such as 0/0+0/4+3/4 in metres".to_owned();
        let number = |text: &str| text.parse().ok().filter(|number: &f32| number.abs() <= 1e5);
        let point = |text: &str| {
            let (x, z) = text.split_once('/')?;
            Some(Vec2::new(number(x)?, number(z)?))
        };
        let points: Option<Vec<Vec2>> = text.split('+').map(point).collect();
        points.filter(|points| points.len() > 1).map(Self).ok_or_else(wrong)
    }
}

/// A file, and a part of its motion.
#[derive(Clone, Debug)]
pub(crate) struct PartArg {
    pub(crate) file: PathBuf,
    pub(crate) part: TimeRange,
}

/// A file, and a time of its motion.
#[derive(Clone, Debug)]
pub(crate) struct PoseArg {
    pub(crate) file: PathBuf,
    pub(crate) at: Moment,
}

impl FromStr for PartArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let Some((file, part)) = text.rsplit_once('@') else {
            return Ok(Self {
                file: text.into(),
                part: TimeRange::default(),
            });
        };
        Ok(Self {
            file: file.into(),
            part: part.parse()?,
        })
    }
}

impl FromStr for PoseArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || "not FILE@T, as in walk.bvh@2.5s (seconds) or walk.bvh@150f (a frame)".to_owned();
        let (file, at) = text.rsplit_once('@').ok_or_else(wrong)?;
        let part: TimeRange = format!("{at}..").parse().map_err(|_| wrong())?;
        Ok(Self {
            file: file.into(),
            at: part.first.ok_or_else(wrong)?,
        })
    }
}
