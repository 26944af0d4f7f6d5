//! Options of the FBX writer.

use std::path::Path;

use mocap::compress::ErrorBound;
use mocap::fbx::{FbxOptions, FbxTextures};
use mocap::job::{Length, Writing, WritingFbx};

use super::{Given, OutputFormat, refuse_options};
use crate::{Failure, streams};

/// Why standard output has no textures beside it.
pub(crate) const NOT_ONE_FILE: &str = "standard output is one file; name a file, not -, or leave it out";

/// The options of a command whose largest error is that of FBX alone.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Writing FBX")]
pub(crate) struct FbxOutArgs {
    #[command(flatten)]
    fbx: WritingFbx,
    /// Largest distance of any joint from its position, at any frame, in metres or with a unit, such as 1mm; keys are
    /// removed within it [default: every key is written]
    #[arg(long, value_name = "LENGTH")]
    max_error: Option<Length>,
}

impl FbxOutArgs {
    /// Puts the options into a job.
    pub(super) fn fill(&self, writing: &mut Writing) {
        writing.fbx = self.fbx.clone();
        writing.smaller.max_error = self.max_error;
    }

    /// The options of an output in a format, unless one of them would do nothing there.
    pub(crate) fn options(&self, given: &Given, format: &str, output: &Path) -> Result<FbxOptions, Failure> {
        if let Some(format) = OutputFormat::of(&Path::new("scene").with_extension(format)) {
            refuse_options(given, format)?;
            let is_fbx = format.row().has_file_meshes;
            if !is_fbx {
                given.refuse(
                    &["max-error"],
                    "here it applies to FBX; mocap convert removes keys from glTF",
                )?;
            }
        }
        if streams::is_standard(output) {
            check_one_file(&self.fbx, NOT_ONE_FILE)?;
        }
        let max_error = self.max_error.map(Length::to_metres);
        if max_error == Some(0.0) {
            let message = "--max-error 0: FBX cannot be exact with fewer keys; name a length above 0, or leave it out";
            return Err(Failure::Usage(message.to_owned()));
        }
        Ok(self.fbx.options().error_bound(max_error.map(ErrorBound::new)))
    }
}

/// Refuses files beside the output, for a `reason`.
pub(super) fn check_one_file(fbx: &WritingFbx, reason: &str) -> Result<(), Failure> {
    match fbx.textures {
        FbxTextures::Embedded => Ok(()),
        _ => Err(Failure::Usage(format!("--textures beside: {reason}"))),
    }
}
