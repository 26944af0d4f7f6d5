//! The format of an output, from the table of formats, and the options of that format.

use std::path::Path;
use std::sync::LazyLock;

use clap::ValueEnum;
use clap::builder::{PossibleValue, PossibleValuesParser};
use mocap::arrays::BodyLayout;
use mocap::job::{OutputOptions, RobotFormat};
use mocap::{Diagnostic, FormatInfo, WriteOption};

use super::{ArgumentSources, ForceArgs};
use crate::Failure;

/// A format that is written, named by an extension; or a layout of arrays, named by its name.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OutputFormat {
    /// The name that users type.
    pub(crate) name: &'static str,
    /// The extension of its files.
    pub(crate) extension: &'static str,
    description: &'static str,
    /// The row of a scene format in the table of formats; `None` for arrays.
    row: Option<&'static FormatInfo>,
}

/// The scene formats, in the order of the table.
static WRITTEN: LazyLock<Vec<OutputFormat>> = LazyLock::new(|| {
    let written = FormatInfo::ALL.iter().filter(|row| row.writes());
    let extensions = written.flat_map(|row| row.extensions.iter().map(move |extension| (row, *extension)));
    let format = |(row, extension): (&'static FormatInfo, &'static str)| OutputFormat {
        name: extension,
        extension,
        description: row.description,
        row: Some(row),
    };
    extensions.map(format).collect()
});

/// All formats: scene formats and layouts of arrays.
static ALL: LazyLock<Vec<OutputFormat>> = LazyLock::new(|| {
    let arrays = |name, extension, description| OutputFormat {
        name,
        extension,
        description,
        row: None,
    };
    let own = ["npz", "csv", "parquet"].map(|name| arrays(name, name, "arrays as mocap fk writes them"));
    let bodies = BodyLayout::ALL.map(|layout| arrays(layout.as_str(), layout.extension(), "arrays of a humanoid"));
    let robots = RobotFormat::ALL.into_iter();
    let robots = robots.map(|format| {
        arrays(
            format.name(),
            format.extension(),
            "joints of a robot; --body names the robot",
        )
    });
    let mut all = WRITTEN.clone();
    for format in own.into_iter().chain(bodies).chain(robots) {
        if all.iter().all(|known| known.name != format.name) {
            all.push(format);
        }
    }
    all
});

impl OutputFormat {
    /// The format that the extension of `path` names.
    pub(crate) fn of(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            // The output is glTF, and keeps the contents of a VRM input.
            "vrm" => Some(Self {
                extension: "vrm",
                name: "vrm",
                ..Self::named("glb")?
            }),
            // The only layout with this extension.
            "npy" => Self::named(BodyLayout::HumanMl3d.as_str()),
            extension => Self::named(extension),
        }
    }

    /// The format of this name.
    pub(crate) fn named(name: &str) -> Option<Self> {
        ALL.iter().copied().find(|format| format.name == name)
    }

    /// The extensions of all outputs, as a phrase.
    pub(crate) fn extensions() -> String {
        let of_scenes = FormatInfo::written_extensions();
        format!("{of_scenes}, or for arrays .npz, .npy, .csv, .parquet or .pkl")
    }

    /// The row of a scene format.
    pub(crate) fn row(self) -> Option<&'static FormatInfo> {
        self.row
    }

    /// Whether this is a layout that its file extension does not determine.
    pub(crate) fn is_layout(self) -> bool {
        self.name != self.extension
    }

    /// The reason why an option of writing has no effect, as far as the format alone determines it.
    pub(crate) fn refusal(self, option: WriteOption) -> Option<Diagnostic> {
        self.row?.refusal(option, self.extension)
    }
}

impl ValueEnum for OutputFormat {
    fn value_variants<'a>() -> &'a [Self] {
        &ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.name).help(self.description))
    }
}

/// The extensions of all written formats, and other names.
pub(super) fn extensions_and(others: &[&'static str]) -> PossibleValuesParser {
    let written = WRITTEN.iter().map(|format| format.name);
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

/// Refuses options without an effect on an output, even if they have their default value.
pub(crate) fn refuse_options(
    given: &ArgumentSources,
    refusal: impl Fn(WriteOption) -> Option<Diagnostic>,
) -> Result<(), Failure> {
    let given = WriteOption::ALL.into_iter().filter(|option| given.has(option.as_str()));
    match given.filter_map(refusal).next() {
        Some(refusal) => Err(Failure::Usage(refusal.message)),
        None => Ok(()),
    }
}
