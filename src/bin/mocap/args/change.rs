//! The options of `mocap convert` that change a motion, and the parsers of their values.

use std::str::FromStr;

use clap::ValueEnum;
use mocap::Conversion;
use mocap::convert::{FirstFrame, Moment, RestPoseSource, RootMotion};

use super::OutArgs;

/// Changes of the motion.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Changing")]
pub(crate) struct ChangeArgs {
    #[command(flatten)]
    pub(crate) out: OutArgs,
    /// Part to keep, both ends included: A..B in seconds, or Af..Bf in frames; either end may be left out
    #[arg(long, value_name = "A..B", allow_hyphen_values = true)]
    pub(crate) trim: Option<TrimArg>,
    /// Frames per second to write; for an input that states no valid rate, its rate
    #[arg(long, value_name = "RATE")]
    pub(crate) fps: Option<f64>,
    /// Whether to drop the first frame; auto: if it is a rest pose, and the motion jumps after it
    #[arg(long, value_name = "WHEN", default_value = "no")]
    pub(crate) drop_first_frame: DropArg,
    /// Rest pose: zero (all rotations 0, as in the file), or frame:N
    #[arg(long, value_name = "POSE", default_value = "zero")]
    pub(crate) rest: RestArg,
    /// Keep the figure in place over the ground
    #[arg(long, conflicts_with = "root_motion")]
    pub(crate) in_place: bool,
    /// Move the translation over the ground and the heading to a new joint `Root`
    #[arg(long)]
    pub(crate) root_motion: bool,
}

impl ChangeArgs {
    /// What the library is to do.
    pub(crate) fn conversion(&self) -> Conversion {
        let mut conversion = Conversion::new()
            .first_frame(self.drop_first_frame.into())
            .rest(self.rest.into())
            .root(match (self.in_place, self.root_motion) {
                (true, _) => RootMotion::InPlace,
                (false, true) => RootMotion::Extract,
                (false, false) => RootMotion::Keep,
            });
        if let Some(metres) = self.out.metres_per_unit() {
            conversion = conversion.out_metres_per_unit(metres);
        }
        if let Some(up) = self.out.up() {
            conversion = conversion.out_up(up);
        }
        if let Some(TrimArg { first, last }) = self.trim {
            conversion = conversion.trim(first, last);
        }
        if let Some(rate) = self.fps {
            conversion = conversion.frame_rate(rate);
        }
        conversion
    }
}

/// `--trim`: the first and the last moment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TrimArg {
    pub(crate) first: Option<Moment>,
    pub(crate) last: Option<Moment>,
}

impl FromStr for TrimArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || "not A..B, as in 1.5..4 (seconds) or 120f..480f (frames)".to_owned();
        let moment = |text: &str| -> Result<Option<Moment>, String> {
            if text.is_empty() {
                return Ok(None);
            }
            let moment = match text.strip_suffix('f') {
                Some(frame) => frame.parse().ok().map(Moment::Frame),
                None => text
                    .parse()
                    .ok()
                    .filter(|time: &f64| time.is_finite() && *time >= 0.0)
                    .map(Moment::Seconds),
            };
            moment.map(Some).ok_or_else(wrong)
        };
        let (first, last) = text.split_once("..").ok_or_else(wrong)?;
        Ok(Self {
            first: moment(first)?,
            last: moment(last)?,
        })
    }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum DropArg {
    Auto,
    Yes,
    No,
}

impl From<DropArg> for FirstFrame {
    fn from(arg: DropArg) -> Self {
        match arg {
            DropArg::Auto => Self::DropRestPose,
            DropArg::Yes => Self::Drop,
            DropArg::No => Self::Keep,
        }
    }
}

/// `--rest`.
#[derive(Clone, Copy, Debug)]
pub(crate) enum RestArg {
    Zero,
    Frame(u64),
}

impl From<RestArg> for RestPoseSource {
    fn from(arg: RestArg) -> Self {
        match arg {
            RestArg::Zero => Self::InFile,
            RestArg::Frame(frame) => Self::Frame(frame),
        }
    }
}

impl FromStr for RestArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let frame = text.strip_prefix("frame:").and_then(|frame| frame.parse().ok());
        match (text, frame) {
            ("zero", _) => Ok(Self::Zero),
            (_, Some(frame)) => Ok(Self::Frame(frame)),
            _ => Err("neither zero nor frame:N".to_owned()),
        }
    }
}
