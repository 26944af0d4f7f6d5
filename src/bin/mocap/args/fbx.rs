//! Options of the FBX writer.

use clap::ValueEnum;
use mocap::fbx::{FbxOptions, FbxRest, FbxTarget, FbxTextures, FbxVersion};

use std::path::Path;

use mocap::compress::ErrorBound;
use mocap::job::Length;

use super::{Given, OutputFormat, refuse_options};
use crate::{Failure, streams};

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Writing FBX")]
pub(crate) struct FbxArgs {
    /// Version of the file
    #[arg(long, value_name = "VERSION", default_value = "7.5")]
    fbx_version: VersionArg,
    /// Where the rotations of the rest pose are [default: rotation; for --target maya pre-rotation]
    #[arg(long, value_name = "PLACE")]
    fbx_rest: Option<RestArg>,
    /// The program whose conventions the file is to have: unit, axes, root, frame rate
    #[arg(long, value_name = "PROGRAM")]
    target: Option<TargetArg>,
    /// Where the images of textures are
    #[arg(long, value_name = "PLACE", default_value = "embedded")]
    textures: TexturesArg,
}

/// Why standard output has no textures beside it.
pub(crate) const NOT_ONE_FILE: &str = "standard output is one file; name a file, not -, or leave it out";

/// The options of a command whose largest error is that of FBX alone.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Writing FBX")]
pub(crate) struct FbxOutArgs {
    #[command(flatten)]
    fbx: FbxArgs,
    /// Largest distance of any joint from its position, at any frame, in metres or with a unit, such as 1mm; keys are
    /// removed within it [default: every key is written]
    #[arg(long, value_name = "LENGTH")]
    max_error: Option<Length>,
}

impl FbxOutArgs {
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
            self.fbx.check_one_file(NOT_ONE_FILE)?;
        }
        let max_error = self.max_error.map(Length::to_metres);
        if max_error == Some(0.0) {
            let message = "--max-error 0: FBX cannot be exact with fewer keys; name a length above 0, or leave it out";
            return Err(Failure::Usage(message.to_owned()));
        }
        Ok(FbxOptions {
            error_bound: max_error.map(ErrorBound::new),
            ..self.fbx.options()
        })
    }
}

impl FbxArgs {
    /// Refuses files beside the output, for a `reason`.
    pub(crate) fn check_one_file(&self, reason: &str) -> Result<(), Failure> {
        match self.textures {
            TexturesArg::Beside => Err(Failure::Usage(format!("--textures beside: {reason}"))),
            TexturesArg::Embedded => Ok(()),
        }
    }

    pub(crate) fn options(&self) -> FbxOptions {
        let target = self.target.map(FbxTarget::from);
        let options = target.map(FbxOptions::of_target).unwrap_or_default();
        FbxOptions {
            version: self.fbx_version.into(),
            rest: self.fbx_rest.map_or(options.rest, FbxRest::from),
            textures: self.textures.into(),
            ..options
        }
    }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum VersionArg {
    /// FBX 2014 and 2015
    #[value(name = "7.4")]
    V7400,
    /// FBX 2016 and newer
    #[value(name = "7.5")]
    V7500,
}

impl From<VersionArg> for FbxVersion {
    fn from(arg: VersionArg) -> Self {
        match arg {
            VersionArg::V7400 => Self::V7400,
            VersionArg::V7500 => Self::V7500,
        }
    }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum RestArg {
    /// PreRotation, Maya's joint orient: the rest pose has zero rotations
    PreRotation,
    /// Lcl Rotation: the curves have all of a rotation
    Rotation,
}

impl From<RestArg> for FbxRest {
    fn from(arg: RestArg) -> Self {
        match arg {
            RestArg::PreRotation => Self::PreRotation,
            RestArg::Rotation => Self::Rotation,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum TexturesArg {
    /// In the file
    Embedded,
    /// In files beside it
    Beside,
}

impl From<TexturesArg> for FbxTextures {
    fn from(arg: TexturesArg) -> Self {
        match arg {
            TexturesArg::Embedded => Self::Embedded,
            TexturesArg::Beside => Self::Beside,
        }
    }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum TargetArg {
    /// Unreal Engine: centimetres with +Z up, no root above the skeleton, a whole frame rate
    Unreal,
    /// Unity: metres with +Y up
    Unity,
    /// Maya: the rest pose as joint orient
    Maya,
    /// MotionBuilder: a root called Reference, a whole frame rate
    Motionbuilder,
}

impl From<TargetArg> for FbxTarget {
    fn from(arg: TargetArg) -> Self {
        match arg {
            TargetArg::Unreal => Self::Unreal,
            TargetArg::Unity => Self::Unity,
            TargetArg::Maya => Self::Maya,
            TargetArg::Motionbuilder => Self::MotionBuilder,
        }
    }
}
