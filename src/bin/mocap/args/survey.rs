//! The options of `mocap survey`.

use std::path::PathBuf;
use std::str::FromStr;

use clap::ValueEnum;
use mocap::job::Reading;
use mocap::survey::{Condition, Quality, Thresholds};

use super::{ForceArgs, InputArgs, SpreadArgs};

#[derive(Debug, clap::Args)]
pub(crate) struct SurveyArgs {
    /// The motion files, folders and wildcards; a .jsonl file is what an earlier survey, or a shard, wrote
    #[arg(required = true, value_name = "PATH")]
    pub(crate) paths: Vec<PathBuf>,
    /// The table to write: .parquet, .csv, .json, or .jsonl, which is read again and merged; .txt is the list of the
    /// files alone; - is standard output, in the format of --to. Without it, verdicts and the ten worst clips are
    /// printed, or with --select the list
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Format of standard output
    #[arg(long, value_name = "FORMAT", value_parser = ["csv", "json", "jsonl", "parquet", "txt"])]
    pub(crate) to: Option<String>,
    /// The amount from which a clip is bad, KIND=BAD, or suspect and bad, KIND=SUSPECT..BAD, as skate=2; inf turns a
    /// kind off; once for each kind
    #[arg(long, value_name = "KIND=AMOUNT")]
    pub(crate) threshold: Vec<String>,
    /// Keep the rows for which this holds, as "skate < 1 and not twin"
    #[arg(long = "where", value_name = "EXPR")]
    pub(crate) condition: Option<Condition>,
    /// Keep so many clips, or so many per cent, which are as different as can be
    #[arg(long, value_name = "N|N%")]
    pub(crate) select: Option<Amount>,
    /// By what to select: quality leaves out bad clips and twins first
    #[arg(
        long,
        value_name = "LIST",
        value_delimiter = ',',
        default_value = "quality,diversity",
        requires = "select"
    )]
    pub(crate) by: Vec<By>,
    /// Write the findings as SARIF, which code hosts show beside files
    #[arg(long, value_name = "FILE")]
    pub(crate) sarif: Option<PathBuf>,
    /// Write a page that shows the corpus: counts, the worst and usual clips as moving figures, twins, a map
    #[arg(long, value_name = "FILE")]
    pub(crate) html: Option<PathBuf>,
    /// Take the rows of files that a .jsonl output of an earlier run has and whose bytes are the same
    #[arg(long, requires = "output")]
    pub(crate) resume: bool,
    /// Exit with 1 where a clip that is kept is so bad
    #[arg(long, value_name = "VERDICT")]
    pub(crate) fail_on: Option<FailOn>,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    #[command(flatten)]
    pub(crate) read: Reading,
    #[command(flatten)]
    pub(crate) inputs: InputArgs,
    #[command(flatten)]
    pub(crate) spread: SpreadArgs,
}

/// From which verdict on a run fails.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum FailOn {
    /// Suspect or bad clips
    Suspect,
    /// Bad clips
    Bad,
}

/// How many clips to select.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Amount {
    Clips(usize),
    Fraction(f64),
}

/// By what clips are selected.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum By {
    /// No bad clips, and no twins
    Quality,
    /// Clips that are far apart
    Diversity,
}

impl FromStr for Amount {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let fraction = |text: &str| {
            text.parse::<f64>()
                .ok()
                .filter(|percent| (0.0..=100.0).contains(percent))
        };
        let parsed = match text.strip_suffix('%') {
            Some(percent) => fraction(percent).map(|percent| Self::Fraction(percent / 100.0)),
            None => text.parse().ok().map(Self::Clips),
        };
        parsed.ok_or_else(|| "not a number of clips, or of per cent, as 100 or 3%".to_owned())
    }
}

impl Amount {
    /// How many of so many clips: at least one of any.
    pub(crate) fn of(self, clips: usize) -> usize {
        match self {
            Self::Clips(count) => count,
            Self::Fraction(fraction) => (fraction * clips as f64).ceil() as usize,
        }
    }
}

impl SurveyArgs {
    /// From which verdict on the run fails.
    pub(crate) fn fails_from(&self) -> Option<Quality> {
        self.fail_on.map(|fail_on| match fail_on {
            FailOn::Suspect => Quality::Suspect,
            FailOn::Bad => Quality::Bad,
        })
    }

    /// Whether bad clips and twins are left out of a selection.
    pub(crate) fn by_quality(&self) -> bool {
        self.by.contains(&By::Quality)
    }

    pub(crate) fn thresholds(&self) -> mocap::Result<Thresholds> {
        let mut thresholds = Thresholds::default();
        self.threshold.iter().try_for_each(|text| thresholds.set(text))?;
        Ok(thresholds)
    }
}
