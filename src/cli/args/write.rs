//! How an output is written: its format, from the table of formats, and the options that the format takes.

use std::path::Path;
use std::sync::LazyLock;

use clap::ValueEnum;
use clap::builder::{PossibleValue, PossibleValuesParser};
use mocap::job::OutputOptions;
use mocap::{Diagnostic, Format, FormatInfo, WriteOption};

use super::{ForceArgs, Given};
use crate::Failure;

/// A written format, by one of its extensions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OutputFormat {
    pub(crate) format: Format,
    pub(crate) extension: &'static str,
}

/// All of them, in the order of the table.
static WRITTEN: LazyLock<Vec<OutputFormat>> = LazyLock::new(|| {
    let written = FormatInfo::ALL.iter().filter(|row| row.writes());
    let extensions = written.flat_map(|row| row.extensions.iter().map(|extension| (row.format, *extension)));
    extensions
        .map(|(format, extension)| OutputFormat { format, extension })
        .collect()
});

impl OutputFormat {
    /// The format that the extension of `path` names.
    pub(crate) fn of(path: &Path) -> Option<Self> {
        let extension = path.extension()?;
        // It is glTF that keeps what a VRM input has.
        let vrm = OutputFormat {
            format: Format::Gltf,
            extension: "vrm",
        };
        let mut written = WRITTEN.iter().copied().chain([vrm]);
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

/// The extensions of all written formats, and other names.
pub(super) fn extensions_and(others: &[&'static str]) -> PossibleValuesParser {
    let written = WRITTEN.iter().map(|format| format.extension);
    PossibleValuesParser::new(written.chain(others.iter().copied()))
}

/// An output in the format of `extension`, with the options of a command line.
pub(super) fn writing(options: &OutputOptions, output: &Path, extension: &str, force: ForceArgs) -> OutputOptions {
    let own = output.extension().unwrap_or_default();
    let mut writing = options.clone();
    writing.output = output.to_owned();
    writing.to = (!own.eq_ignore_ascii_case(extension)).then(|| extension.to_owned());
    writing.force = force.force;
    writing
}

/// Refuses the options that have no effect on an output, also where they have the value of their default.
pub(crate) fn refuse_options(
    given: &Given,
    refusal: impl Fn(WriteOption) -> Option<Diagnostic>,
) -> Result<(), Failure> {
    let given = WriteOption::ALL.into_iter().filter(|option| given.has(option.as_str()));
    match given.filter_map(refusal).next() {
        Some(refusal) => Err(Failure::Usage(refusal.message)),
        None => Ok(()),
    }
}
