//! How an output is written: its format, from the table of formats, and the options that the format takes.

use std::path::Path;
use std::sync::LazyLock;

use clap::ValueEnum;
use clap::builder::PossibleValue;
use mocap::{Exporter, FORMATS, Format, FormatInfo, WriteOption};

use mocap::job::{Smaller, Writing, WritingBvh, WritingFbx};

use super::{Given, compress, fbx};
use crate::Failure;

/// A written format, by one of its extensions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OutputFormat {
    pub(crate) format: Format,
    pub(crate) extension: &'static str,
}

/// All of them, in the order of the table.
static WRITTEN: LazyLock<Vec<OutputFormat>> = LazyLock::new(|| {
    let written = FORMATS.iter().filter(|row| row.writes());
    let extensions = written.flat_map(|row| row.extensions.iter().map(|extension| (row.format, *extension)));
    extensions
        .map(|(format, extension)| OutputFormat { format, extension })
        .collect()
});

impl OutputFormat {
    /// The format that the extension of `path` names.
    pub(crate) fn of(path: &Path) -> Option<Self> {
        let extension = path.extension()?;
        let mut written = WRITTEN.iter().copied();
        written.find(|format| extension.eq_ignore_ascii_case(format.extension))
    }

    pub(crate) fn row(self) -> &'static FormatInfo {
        FormatInfo::of(self.format)
    }
}

impl ValueEnum for OutputFormat {
    fn value_variants<'a>() -> &'a [Self] {
        &WRITTEN
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.extension).help(self.row().description))
    }
}

/// The options of all writers.
#[derive(Debug, clap::Args)]
pub(crate) struct WriteArgs {
    /// Keep constant tracks in the animation; by default they become part of the rest pose
    #[arg(long)]
    pub(crate) keep_constant: bool,
    #[command(flatten)]
    pub(crate) bvh: WritingBvh,
    #[command(flatten)]
    pub(crate) fbx: WritingFbx,
    #[command(flatten)]
    pub(crate) smaller: Smaller,
}

impl WriteArgs {
    /// The exporter to a format, unless one of the options has no effect there. Where `one_file` gives a reason,
    /// no textures may stand beside the output.
    pub(crate) fn exporter(
        &self,
        given: &Given,
        format: OutputFormat,
        one_file: Option<&str>,
    ) -> Result<Exporter, Failure> {
        refuse_options(given, format)?;
        compress::check(&self.smaller, given, format)?;
        if let Some(reason) = one_file {
            fbx::check_one_file(&self.fbx, reason)?;
        }
        let mut writing = Writing::default();
        self.fill(&mut writing);
        Ok(writing.exporter().format(format.format))
    }

    /// Puts the options into a job.
    pub(super) fn fill(&self, writing: &mut Writing) {
        writing.keep_constant = self.keep_constant;
        writing.smaller = self.smaller.clone();
        writing.bvh = self.bvh.clone();
        writing.fbx = self.fbx.clone();
    }
}

/// Refuses the options that have no effect on a format, as its row says.
pub(crate) fn refuse_options(given: &Given, format: OutputFormat) -> Result<(), Failure> {
    let given = WriteOption::ALL.into_iter().filter(|option| given.has(option.as_str()));
    let mut refused = given.filter_map(|option| format.row().refusal(option, format.extension));
    match refused.next() {
        Some(refusal) => Err(Failure::Usage(refusal.message)),
        None => Ok(()),
    }
}
