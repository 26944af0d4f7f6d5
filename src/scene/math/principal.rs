//! Principal axes: the directions in which rows of numbers vary most.

use super::cholesky::dot;

/// The smallest squared variation along an axis, as a fraction of the variation along the first axis. Axes with less
/// variation are dropped.
const LEAST: f64 = 1e-12;

/// Up to `count` eigenvectors of a symmetric matrix, largest eigenvalue first, by power iteration of `rounds` rounds
/// each. They are orthonormal to the last bits, even after few rounds. Fewer eigenvectors are returned if the matrix
/// has a lower rank.
pub fn axes(matrix: &[f64], size: usize, count: usize, rounds: usize) -> Vec<Vec<f64>> {
    let mut axes: Vec<Vec<f64>> = Vec::new();
    let mut first = 0.0;
    while axes.len() < count.min(size) {
        let number = axes.len();
        // Any start that is not at right angles to the axis works.
        let begin = (0..size).map(|index| ((index * 7 + number * 3 + 1) % 11) as f64 - 5.0);
        let mut axis: Vec<f64> = begin.collect();
        let mut value = 0.0;
        for _ in 0..rounds.max(1) {
            axis = matrix.chunks_exact(size).map(|row| dot(row, &axis)).collect();
            // The second pass removes the rounding error of the first.
            (0..2).for_each(|_| without(&mut axis, &axes));
            value = dot(&axis, &axis).sqrt();
            if value <= LEAST * first || value < f64::MIN_POSITIVE {
                return axes;
            }
            axis.iter_mut().for_each(|number| *number /= value);
        }
        first = f64::max(first, value);
        axes.push(axis);
    }
    axes
}

/// Removes the components along some axes.
fn without(row: &mut [f64], axes: &[Vec<f64>]) {
    for other in axes {
        let along = dot(row, other);
        row.iter_mut()
            .zip(other)
            .for_each(|(number, other)| *number -= along * other);
    }
}

/// The sums of the products of the rows' columns: a symmetric matrix.
pub fn products<R: AsRef<[f64]>>(rows: impl Iterator<Item = R>, size: usize) -> Vec<f64> {
    let mut matrix = vec![0.0; size * size];
    for row in rows {
        let row = row.as_ref();
        for (own, sums) in row.iter().zip(matrix.chunks_exact_mut(size)) {
            sums.iter_mut().zip(row).for_each(|(sum, other)| *sum += own * other);
        }
    }
    matrix
}
