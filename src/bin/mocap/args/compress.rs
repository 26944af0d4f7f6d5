//! Options of compression, and its largest error.

use clap::ValueEnum;
use mocap::compress::ErrorBound;
use mocap::gltf::Compression;
use mocap::job::Length;

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

impl CompressArgs {
    pub(crate) fn compression(&self) -> Compression {
        match (self.compress, self.max_error) {
            (None | Some(CompressArg::None), None) | (Some(CompressArg::None), Some(_)) => Compression::None,
            (None, Some(_)) | (Some(CompressArg::Int16), _) => Compression::Int16,
            (Some(CompressArg::Meshopt), _) => Compression::Meshopt,
            (Some(CompressArg::MeshoptKhr), _) => Compression::MeshoptKhr,
        }
    }

    /// The largest error in metres, where one is named.
    pub(crate) fn max_error(&self) -> Option<f64> {
        self.max_error.map(Length::to_metres)
    }

    /// The shell distance in metres; 0 where none is named.
    pub(crate) fn shell_distance(&self) -> f64 {
        self.shell_distance.map_or(0.0, Length::to_metres)
    }

    /// The largest error in metres, including the default.
    pub(crate) fn tolerance(&self) -> f64 {
        self.max_error().unwrap_or(ErrorBound::default().max_error)
    }

    /// The bound that glTF keeps; `None` where every key stays.
    pub(crate) fn bound_of_keys(&self) -> Option<ErrorBound> {
        let is_asked_for = self.max_error.is_some() || self.compression() != Compression::None;
        is_asked_for.then(|| self.error_bound())
    }

    /// The same with its shell.
    pub(crate) fn error_bound(&self) -> ErrorBound {
        ErrorBound::new(self.tolerance()).shell_distance(self.shell_distance())
    }
}
