//! Options of compression, and its largest error.

use clap::ValueEnum;
use mocap::WriteOption;
use mocap::compress::ErrorBound;
use mocap::gltf::Compression;
use mocap::job::Length;

use super::{Given, OutputFormat};
use crate::Failure;

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Smaller files")]
pub(crate) struct CompressArgs {
    /// Largest distance of any joint or end site from its position, at any frame, in metres or with a unit, such as
    /// 1mm. Keys and bits are removed within it; fails where it cannot be kept [default with --compress: 1mm]
    #[arg(long, value_name = "LENGTH")]
    max_error: Option<Length>,
    /// Points at this distance from each joint keep the largest error too, as the skin; 3cm is the default of ACL
    /// [default: 0, joints and end sites alone]
    #[arg(long, value_name = "LENGTH")]
    shell_distance: Option<Length>,
    /// How to store the keys [default with --max-error: int16, otherwise none]
    #[arg(long, value_name = "KIND")]
    pub(crate) compress: Option<CompressArg>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum CompressArg {
    /// 32-bit floats, which every program reads
    None,
    /// Rotations as 16-bit integers: core glTF, read by all but Assimp
    Int16,
    /// Streams that need EXT_meshopt_compression
    Meshopt,
    /// Streams that need KHR_meshopt_compression, a little smaller
    MeshoptKhr,
}

impl From<CompressArg> for Compression {
    fn from(arg: CompressArg) -> Self {
        match arg {
            CompressArg::None => Self::None,
            CompressArg::Int16 => Self::Int16,
            CompressArg::Meshopt => Self::Meshopt,
            CompressArg::MeshoptKhr => Self::MeshoptKhr,
        }
    }
}

impl CompressArgs {
    /// Refuses a largest error that the format cannot keep, and a shell without a largest error.
    pub(crate) fn check(&self, given: &Given, format: OutputFormat) -> Result<(), Failure> {
        let row = format.row();
        // Only 32-bit floats lose nothing.
        let is_exact = row.takes(WriteOption::Compress) && self.compress == Some(CompressArg::None);
        if self.max_error() == Some(0.0) && !is_exact {
            let exact = match row.takes(WriteOption::Compress) {
                true => "name a length above 0, or --compress none",
                false => "name a length above 0, or leave it out",
            };
            let message = format!(
                "--max-error 0: {} cannot be exact with fewer keys or bits; {exact}",
                row.name
            );
            return Err(Failure::Usage(message));
        }
        // A format that does not say how keys are stored always has a largest error, or takes none.
        let has_bound = self.max_error.is_some() || self.compress.is_some_and(|kind| kind != CompressArg::None);
        if row.takes(WriteOption::Compress) && !has_bound {
            let why = "it needs a largest error; add --max-error 1mm, or leave it out";
            given.refuse(&["shell-distance"], why)?;
        }
        Ok(())
    }

    /// The largest error in metres, where one is named.
    pub(crate) fn max_error(&self) -> Option<f64> {
        self.max_error.map(Length::to_metres)
    }

    /// The shell distance in metres, where one is named.
    pub(crate) fn shell_distance(&self) -> Option<f64> {
        self.shell_distance.map(Length::to_metres)
    }

    /// The largest error in metres, including the default.
    pub(crate) fn tolerance(&self) -> f64 {
        self.max_error().unwrap_or(ErrorBound::default().max_error)
    }
}
