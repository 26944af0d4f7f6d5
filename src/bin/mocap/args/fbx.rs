//! Options of the FBX writer.

use clap::ValueEnum;
use mocap::fbx::{FbxOptions, FbxRest, FbxVersion};

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Writing FBX")]
pub(crate) struct FbxArgs {
    /// Version of the file
    #[arg(long, value_name = "VERSION", default_value = "7.5")]
    fbx_version: VersionArg,
    /// Where the rotations of the rest pose are
    #[arg(long, value_name = "PLACE", default_value = "rotation")]
    fbx_rest: RestArg,
}

/// The names of these options.
pub(crate) const FBX_OPTIONS: [&str; 2] = ["fbx-version", "fbx-rest"];

impl FbxArgs {
    pub(crate) fn options(&self) -> FbxOptions {
        FbxOptions {
            version: self.fbx_version.into(),
            rest: self.fbx_rest.into(),
            ..FbxOptions::default()
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
