//! The limbs of a sample, and of its mirror image.

use crate::survey::fingerprint::{LIMBS, WIDTH};

/// The limb on the other side of the body, for each limb.
const OTHER_SIDE: [usize; LIMBS] = [0, 1, 3, 2, 5, 4, 7, 6, 9, 8];

/// The numbers of a sample with left and right exchanged.
pub(crate) fn mirrored_row(row: &[i8]) -> [i8; WIDTH] {
    std::array::from_fn(|column| match (column / 3, column % 3) {
        (limb @ 0..LIMBS, 0) => -row[3 * OTHER_SIDE[limb]],
        (limb @ 0..LIMBS, axis) => row[3 * OTHER_SIDE[limb] + axis],
        // Mirroring changes the signs of the speed sideways and of the turning speed.
        _ if column == 3 * LIMBS + 1 || column == 3 * LIMBS + 3 => -row[column],
        _ => row[column],
    })
}

/// The directions of the limbs of a sample. With `mirrored`, each direction is the mirror image of the limb on the
/// other side.
pub(super) fn numbers(row: &[i8], mirrored: bool) -> [[f32; 3]; LIMBS] {
    let mut numbers = [[0.0; 3]; LIMBS];
    for limb in 0..LIMBS {
        let (from, sign) = match mirrored {
            true => (OTHER_SIDE[limb], -1.0),
            false => (limb, 1.0),
        };
        for axis in 0..3 {
            numbers[limb][axis] = f32::from(row[3 * from + axis]) / 127.0;
        }
        numbers[limb][0] *= sign;
    }
    numbers
}
