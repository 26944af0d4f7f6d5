//! Options of commands that take many files.

use std::path::{Path, PathBuf};

use mocap::files::ReplacePolicy;

use super::OutputFormat;
use crate::batch::inputs::{InputArgs, names_several};
use crate::batch::spread::SpreadArgs;
use crate::{Failure, streams};

/// Options for many files. They decide the names of outputs, but not their contents.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Many files")]
pub(crate) struct BatchArgs {
    /// The output of one file; or a folder for the outputs and a manifest. Outputs keep their paths relative to the
    /// input folders
    #[arg(short, long = "output", alias = "out-dir", value_name = "OUTPUT")]
    pub(crate) out_dir: Option<PathBuf>,
    /// Format of the outputs; or the layout of arrays, if several layouts share the extension of the output
    #[arg(long, value_name = "FORMAT", default_value = "glb")]
    pub(crate) to: OutputFormat,
    /// Skip unchanged files that the manifest lists with the same options
    #[arg(long, requires = "out_dir")]
    pub(crate) resume: bool,
    #[command(flatten)]
    pub(crate) inputs: InputArgs,
    #[command(flatten)]
    pub(crate) spread: SpreadArgs,
}

impl BatchArgs {
    /// Takes the output of one file, if `-o` names a file.
    pub(super) fn take_file(&mut self, paths: &[PathBuf]) -> Option<PathBuf> {
        let is_one = matches!(paths, [path] if !names_several(path));
        self.out_dir.take_if(|output| is_one && names_file(output))
    }

    /// The folder of the outputs.
    ///
    /// # Errors
    /// If the output is the name of a file, also of a format that is only read.
    pub(crate) fn folder(&self) -> Result<Option<&Path>, Failure> {
        match self.out_dir.as_deref() {
            Some(output) if names_file(output) => Err(Failure::Usage(format!(
                "{}: several inputs need an output folder; end the name of a folder with /",
                output.display()
            ))),
            Some(output) if names_source(output) => Err(Failure::Usage(format!(
                "{}: files of this format are read, not written: the name of the output must end in {}; end the \
                 name of a folder with /",
                output.display(),
                OutputFormat::extensions()
            ))),
            folder => Ok(folder),
        }
    }
}

/// Whether an output has the name of a file, and no folder of that name exists.
fn names_file(output: &Path) -> bool {
    streams::is_unnamed(output) || !is_folder(output) && OutputFormat::of(output).is_some()
}

/// Whether an output has the extension of a readable format, and no folder of that name exists.
fn names_source(output: &Path) -> bool {
    !is_folder(output) && ReplacePolicy::is_source(output)
}

/// Whether an output is a folder: an existing folder, or a name that ends in a separator.
pub(super) fn is_folder(output: &Path) -> bool {
    output.is_dir() || output.to_string_lossy().ends_with(std::path::is_separator)
}

#[derive(Debug, clap::Args)]
pub(crate) struct MergeManifestArgs {
    /// The folder of the outputs
    #[arg(value_name = "INPUT")]
    pub(crate) folder: PathBuf,
    /// Print the number of files, and of failed files, as JSON
    #[arg(long)]
    pub(crate) json: bool,
}
