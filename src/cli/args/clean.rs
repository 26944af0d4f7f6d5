//! The options of `mocap clean`.

use std::path::PathBuf;

use mocap::edit::{Clean, CleanPart};
use mocap::job::MotionJob;

use super::OwnArgs;

#[derive(Debug, clap::Args)]
pub(crate) struct CleanArgs {
    /// The motion to clean. If the output is a folder: any number of motions, folders and wildcards
    #[arg(required = true, value_name = "INPUT")]
    pub(crate) inputs: Vec<PathBuf>,
    /// Run only these parts: time, flips, noise, lengths, floor, contacts
    #[arg(long, value_name = "PART,...", value_delimiter = ',', value_parser = parse_part, conflicts_with = "without")]
    pub(crate) only: Vec<CleanPart>,
    /// Run all parts except these
    #[arg(long, value_name = "PART,...", value_delimiter = ',', value_parser = parse_part)]
    pub(crate) without: Vec<CleanPart>,
    /// Write a JSON report: the changes of each part, and measures before and after
    #[arg(long, value_name = "FILE")]
    pub(crate) report: Option<PathBuf>,
    /// Print the report as JSON
    #[arg(long, conflicts_with = "report")]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) own: OwnArgs,
}

impl CleanArgs {
    /// The job, with an output of the format of `extension`.
    pub(crate) fn job(&self, extension: &str) -> MotionJob {
        self.own
            .job(&self.inputs, Vec::new(), vec![self.step().into()], extension)
    }

    /// The cleaning step with the requested parts.
    fn step(&self) -> Clean {
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
