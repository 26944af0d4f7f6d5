//! Checks whether the numbers of arrays fit their layout, because arrays state no unit.

use std::f64::consts::TAU;

use glam::DVec3;
use mocap_scene::error::{Code, Diagnostic};

use crate::Failure;
use crate::array_files::read::humanml3d;

/// If at least this number of joints has a mean angle above a full turn, the angles are in degrees. One joint is not
/// enough, because a root may keep spinning.
const TURNED: usize = 2;

/// Refuses angles that are not radians. `means` has the mean angle of each joint.
pub(super) fn check_radians(name: &str, means: impl IntoIterator<Item = f64>) -> Result<(), Failure> {
    let (joints, largest) = means
        .into_iter()
        .filter(|mean| *mean > TAU)
        .fold((0, 0.0), |(joints, largest), mean| {
            (joints + 1, f64::max(largest, mean))
        });
    if joints < TURNED {
        return Ok(());
    }
    let message = format!("the angles of the array {name} are not in radians, but perhaps in degrees");
    let found = format!("larger mean angles of {joints} joints, the largest {largest:.1}");
    Err(Box::new(
        Diagnostic::new(Code::NumberRange, message)
            .expected_found("a mean angle of at most 6.28 for each joint", found)
            .help("multiply degrees by pi / 180 before you save them"),
    ))
}

/// Refuses rows of HumanML3D that were normalized to mean 0 and deviation 1. In other rows, the rotation columns have
/// length 1, or nearly 1 if a network made the rows.
pub(super) fn check_humanml3d(rows: &[f64]) -> Result<(), Failure> {
    /// The index of the first rotation number in a row, after the root and the positions.
    const ROTATIONS: usize = 4 + 3 * (humanml3d::JOINTS - 1);

    /// The count of numbers in two columns of a matrix.
    const COLUMNS: usize = 6;

    /// The lengths of rotation columns that a network produces. Exact columns have length 1.
    const LENGTH: std::ops::Range<f64> = 0.7..1.4;

    /// The smallest fraction of rotations whose columns both have a length in `LENGTH`. In normalized rows an eighth of
    /// the rotations has such columns.
    const KEPT: f64 = 0.5;
    let rotations = rows.chunks_exact(humanml3d::NUMBERS).flat_map(|row| {
        let columns = &row[ROTATIONS..ROTATIONS + COLUMNS * (humanml3d::JOINTS - 1)];
        columns.as_chunks::<COLUMNS>().0
    });
    // Some programs write only positions, and zeros in place of rotations.
    let stated = rotations.filter(|columns| columns.iter().any(|number| *number != 0.0));
    let (count, kept) = stated.fold((0_usize, 0_usize), |(count, kept), columns| {
        let mut columns = columns.as_chunks::<3>().0.iter();
        let is_kept = columns.all(|column| LENGTH.contains(&DVec3::from_array(*column).length()));
        (count + 1, kept + usize::from(is_kept))
    });
    if kept as f64 >= KEPT * count as f64 {
        return Ok(());
    }
    let percent = 100.0 * kept as f64 / count.max(1) as f64;
    Err(Box::new(
        Diagnostic::new(Code::NumberRange, "the 263 numbers a frame are normalized")
            .expected_found("rotations with columns of length 1", format!("{percent:.0} % of them"))
            .help(
                "multiply the numbers by the standard deviations and add the means of the data set: data * Std.npy + \
                Mean.npy",
            ),
    ))
}
