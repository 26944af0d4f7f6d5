//! The array layouts of a motion that keeps its skeleton.

use std::path::Path;

use mocap_figure::Humanoid;
use mocap_formats::{Export, FormatInfo, WriteOption};
use mocap_scene::error::Result;
#[cfg(not(all(feature = "npz", feature = "parquet")))]
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::scene::{Format, Scene};

use crate::arrays::{ArrayOptions, Arrays};
#[cfg(feature = "npz")]
use crate::arrays::{BodyArrays, BodyLayout};

/// How a motion is stored as arrays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ArrayLayout {
    /// Positions and rotations of all joints, as `mocap fk` writes them, in an archive of NumPy.
    Npz,
    /// The same arrays as CSV.
    Csv,
    /// The same arrays as a Parquet table.
    Parquet,
    /// The layout of another program, for humanoid motion.
    #[cfg(feature = "npz")]
    Body(BodyLayout),
}

impl ArrayLayout {
    /// The layout of this name or file extension. Only HumanML3D is written to an `.npy`.
    pub(super) fn named(name: &str) -> Option<Self> {
        Some(match name {
            "npz" => Self::Npz,
            "csv" => Self::Csv,
            "parquet" => Self::Parquet,
            #[cfg(feature = "npz")]
            "npy" => Self::Body(BodyLayout::HumanMl3d),
            #[cfg(feature = "npz")]
            name => Self::Body(name.parse().ok()?),
            #[cfg(not(feature = "npz"))]
            _ => return None,
        })
    }

    /// The extension of the files in this layout.
    pub(super) fn extension(self) -> &'static str {
        match self {
            Self::Npz => "npz",
            Self::Csv => "csv",
            Self::Parquet => "parquet",
            #[cfg(feature = "npz")]
            Self::Body(layout) => layout.extension(),
        }
    }

    /// The row of the layout's file format in the table of formats.
    pub(super) fn row(self) -> &'static FormatInfo {
        FormatInfo::of(match self {
            Self::Npz => Format::Npz,
            Self::Csv => Format::Csv,
            Self::Parquet => Format::Parquet,
            #[cfg(feature = "npz")]
            Self::Body(BodyLayout::HumanMl3d) => Format::Npy,
            #[cfg(feature = "npz")]
            Self::Body(_) => Format::Npz,
        })
    }

    /// Whether the values of this layout keep the unit and the axes of the motion. The layouts of other programs are in
    /// metres, each with its own up axis.
    pub(super) fn keeps_units(self) -> bool {
        matches!(self, Self::Npz | Self::Csv | Self::Parquet)
    }

    /// Whether an output option changes the files in this layout.
    pub(super) fn takes(self, option: WriteOption) -> bool {
        let of_own = [
            WriteOption::OutUnit,
            WriteOption::OutUp,
            WriteOption::Names,
            WriteOption::Rest,
            WriteOption::RootMotion,
        ];
        self.keeps_units() && of_own.contains(&option)
    }

    /// The arrays of the first animation of `scene`. A layout with a T-pose takes the T-pose from the frames of
    /// `whole`. `motion` is the file of `scene`.
    #[cfg_attr(
        not(feature = "npz"),
        expect(unused_variables, reason = "the layouts of other programs take them")
    )]
    pub(super) fn write(
        self,
        scene: &Scene,
        humanoid: &Humanoid,
        whole: Option<&Scene>,
        motion: &Path,
    ) -> Result<Export> {
        match self {
            #[cfg(feature = "npz")]
            Self::Body(layout) => {
                let body = BodyArrays::of_humanoid(scene, whole, Some(humanoid.clone()))?;
                let mut written = Export::from(body.write(layout)?);
                let rate = match layout {
                    BodyLayout::HumanMl3d => ", at 20 frames a second",
                    _ => "",
                };
                written.notes.push(format!("layout: {}{rate}", layout.as_str()));
                written.nodes = layout.joints();
                written.notes.extend(layout.note());
                Ok(written)
            }
            own => {
                let arrays = Arrays::of(scene, &ArrayOptions::new())?;
                let name = motion.file_name().unwrap_or_default().to_string_lossy();
                let mut written = Export::from(own.bytes(&arrays, &name)?);
                written.nodes = arrays.joints().len();
                Ok(written)
            }
        }
    }

    fn bytes(self, arrays: &Arrays, clip: &str) -> Result<Vec<u8>> {
        match self {
            Self::Csv => Ok(arrays.to_csv().into_bytes()),
            Self::Parquet => parquet(arrays, clip),
            _ => npz(arrays),
        }
    }
}

#[cfg(feature = "parquet")]
fn parquet(arrays: &Arrays, clip: &str) -> Result<Vec<u8>> {
    arrays.to_parquet(clip)
}

#[cfg(not(feature = "parquet"))]
fn parquet(_: &Arrays, _: &str) -> Result<Vec<u8>> {
    missing("Parquet", "parquet")
}

#[cfg(feature = "npz")]
#[expect(clippy::unnecessary_wraps, reason = "a build without archives fails")]
fn npz(arrays: &Arrays) -> Result<Vec<u8>> {
    Ok(arrays.to_npz())
}

#[cfg(not(feature = "npz"))]
fn npz(_: &Arrays) -> Result<Vec<u8>> {
    missing("NumPy's .npz", "npz")
}

#[cfg(not(all(feature = "npz", feature = "parquet")))]
fn missing<T>(what: &str, feature: &str) -> Result<T> {
    let message = format!("this build cannot write {what}");
    let help = format!("build it with the feature {feature}, or write .csv");
    Err(Diagnostic::new(Code::MissingFeature, message).help(help).into())
}
