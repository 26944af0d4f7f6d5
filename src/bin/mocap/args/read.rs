//! Options of the reader.

use std::path::PathBuf;

use clap::ValueEnum;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use mocap::{Format, Importer, RootOffset};

/// Options of the reader.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Reading")]
pub(crate) struct ReadArgs {
    /// Format of the input [default: found from its contents, or else from its extension]
    #[arg(long, value_name = "NAME", ignore_case = true, value_parser = format_parser())]
    from: Option<Format>,
    /// The skeleton of an .amc motion [default: the .asf file beside it that has the same prefix, or the only one]
    #[arg(long, value_name = "FILE")]
    skeleton: Option<PathBuf>,
    /// How the root's OFFSET and its position channels combine
    #[arg(long, value_name = "POLICY", default_value = "auto")]
    root_offset: RootOffsetArg,
    /// Read all rows of the motion, including those beyond the declared number of frames
    #[arg(long)]
    all_rows: bool,
    /// The animation to use, by name or by place from 0, of a file that has several
    #[arg(long, value_name = "NAME|N|all", default_value = "all")]
    clip: String,
    /// Treat every warning as an error
    #[arg(long)]
    pub(crate) strict: bool,
}

impl ReadArgs {
    /// An importer with these options.
    pub(crate) fn importer(&self) -> Importer {
        let mut importer = Importer::new()
            .root_offset(self.root_offset.into())
            .all_rows(self.all_rows)
            .strict(self.strict)
            .clips(match self.clip.parse() {
                Ok(clips) => clips,
                Err(never) => match never {},
            });
        if let Some(format) = self.from {
            importer = importer.format(format);
        }
        if let Some(skeleton) = &self.skeleton {
            importer = importer.skeleton(skeleton);
        }
        importer
    }
}

fn format_parser() -> impl TypedValueParser<Value = Format> {
    PossibleValuesParser::new(Format::ALL.map(Format::as_str)).try_map(|name| name.parse::<Format>())
}

/// The frame rate, for commands that do not resample.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Reading")]
pub(crate) struct FrameRateArgs {
    /// Frames per second, in place of the file's own
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
    /// Add if the root's position is near zero, in the first frame or the median, while the OFFSET is not, otherwise
    /// replace
    Auto,
    /// The position channels replace the OFFSET
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
