//! What must hold of the largest error of an output.

use mocap::WriteOption;
use mocap::gltf::Compression;
use mocap::job::{Length, Smaller};

use super::{Given, OutputFormat};
use crate::Failure;

/// Refuses a largest error that the format cannot keep, and a shell without a largest error.
pub(super) fn check(smaller: &Smaller, given: &Given, format: OutputFormat) -> Result<(), Failure> {
    let row = format.row();
    // Only 32-bit floats lose nothing.
    let is_exact = row.takes(WriteOption::Compress) && smaller.compress == Some(Compression::None);
    if smaller.max_error.map(Length::to_metres) == Some(0.0) && !is_exact {
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
    if row.takes(WriteOption::Compress) && !smaller.has_bound() {
        let why = "it needs a largest error; add --max-error 1mm, or leave it out";
        given.refuse(&["shell-distance"], why)?;
    }
    Ok(())
}
