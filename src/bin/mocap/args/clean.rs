//! The options of `mocap clean`.

use std::path::PathBuf;

use mocap::edit::{Clean, CleanPart};
use mocap::job::{Reading, SourceMap, SourceSpace};

use super::batch::is_folder;
use super::{ForceArgs, InputArgs, OutputFormat, PrintJobArgs, SpreadArgs, WriteArgs};

#[derive(Debug, clap::Args)]
pub(crate) struct CleanArgs {
    /// The motion to clean; with a folder as output any number of motions, folders and wildcards
    #[arg(required = true, value_name = "IN")]
    pub(crate) inputs: Vec<PathBuf>,
    /// The file to write, in any format of mocap formats, or - for standard output. If it is a folder, or ends in /,
    /// each motion gets a file of its own in it, beside a manifest
    #[arg(short, long, value_name = "OUT")]
    pub(crate) output: PathBuf,
    /// Format of standard output, or of the outputs in a folder [default: glb]
    #[arg(long, value_name = "FORMAT")]
    pub(crate) to: Option<OutputFormat>,
    /// Do these parts alone: time, flips, noise, lengths, floor, contacts
    #[arg(long, value_name = "PART,...", value_delimiter = ',', value_parser = parse_part, conflicts_with = "without")]
    pub(crate) only: Vec<CleanPart>,
    /// Do all parts but these
    #[arg(long, value_name = "PART,...", value_delimiter = ',', value_parser = parse_part)]
    pub(crate) without: Vec<CleanPart>,
    /// Write what each part did, with the measures before and after, as JSON
    #[arg(long, value_name = "FILE.json")]
    pub(crate) report: Option<PathBuf>,
    /// Frames per second of the motions before they are cleaned, at the same speed; for an input that states no valid
    /// rate, its rate
    #[arg(long, value_name = "RATE", value_parser = Reading::parse_rate)]
    pub(crate) fps: Option<f64>,
    /// Compare the written file with its source, cleaned again, as `mocap verify` does
    #[arg(long)]
    pub(crate) verify: bool,
    #[command(flatten)]
    pub(crate) force: ForceArgs,
    /// Skip motions that were cleaned in the same way, according to the manifest, and are unchanged
    #[arg(long)]
    pub(crate) resume: bool,
    #[command(flatten)]
    pub(crate) write: WriteArgs,
    #[command(flatten)]
    pub(crate) source: SourceSpace,
    #[command(flatten)]
    pub(crate) map: SourceMap,
    #[command(flatten)]
    pub(crate) read: Reading,
    #[command(flatten)]
    pub(crate) many: InputArgs,
    #[command(flatten)]
    pub(crate) spread: SpreadArgs,
    #[command(flatten)]
    pub(crate) print: PrintJobArgs,
}

impl CleanArgs {
    /// Whether the output is a folder, with an output of each motion.
    pub(crate) fn is_many(&self) -> bool {
        is_folder(&self.output)
    }

    /// The step with the parts that are asked for.
    pub(crate) fn step(&self) -> Clean {
        let is_wanted = |part: &CleanPart| match self.only.is_empty() {
            true => !self.without.contains(part),
            false => self.only.contains(part),
        };
        let parts = CleanPart::ALL.iter();
        parts.fold(Clean::new(), |step, part| step.part(*part, is_wanted(part)))
    }
}

fn parse_part(text: &str) -> Result<CleanPart, String> {
    let found = CleanPart::ALL.into_iter().find(|part| part.as_str() == text);
    found.ok_or_else(|| {
        let names = CleanPart::ALL.map(CleanPart::as_str);
        format!("the parts are {}", names.join(", "))
    })
}
