//! Options of compression, and its largest error.

use clap::ValueEnum;
use mocap::compress::ErrorBound;
use mocap::gltf::{Compression, DEFAULT_MAX_ERROR};

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Smaller files")]
pub(crate) struct CompressArgs {
    /// Largest distance of any joint or end site from its position, at any frame, in metres or with a unit, such as
    /// 1mm. Keys and bits are removed within it; fails where it cannot be kept [default with --compress: 1mm]
    #[arg(long, value_name = "LENGTH", value_parser = parse_length)]
    pub(crate) max_error: Option<f64>,
    /// Points at this distance from each joint keep the largest error too, as the skin; 3cm is the default of ACL
    /// [default: 0, joints and end sites alone]
    #[arg(long, value_name = "LENGTH", value_parser = parse_length)]
    pub(crate) shell_distance: Option<f64>,
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

    /// The largest error, including the default.
    pub(crate) fn tolerance(&self) -> f64 {
        self.max_error.unwrap_or(DEFAULT_MAX_ERROR)
    }

    /// The same with its shell.
    pub(crate) fn error_bound(&self) -> ErrorBound {
        ErrorBound {
            max_error: self.tolerance(),
            shell_distance: self.shell_distance.unwrap_or_default(),
        }
    }
}

/// Parses a length: a number in metres, or with the unit m, cm, mm or um.
pub(crate) fn parse_length(text: &str) -> Result<f64, String> {
    let units = [("mm", 1e-3), ("cm", 1e-2), ("um", 1e-6), ("m", 1.0)];
    let (number, metres) = units
        .into_iter()
        .find_map(|(unit, metres)| Some((text.strip_suffix(unit)?, metres)))
        .unwrap_or((text, 1.0));
    match number.trim().parse::<f64>() {
        Ok(number) if number.is_finite() && number >= 0.0 => Ok(number * metres),
        _ => Err("not a length, such as 1mm, 0.5cm or 0.001, which is in metres".to_owned()),
    }
}
