//! Principal axes: the directions along which rows of numbers differ most.

use super::cholesky::dot;

/// The least squared variation of rows along an axis, as a fraction of that along the first axis. Further axes are
/// dropped.
const LEAST: f64 = 1e-12;

/// Up to `count` eigenvectors of a symmetric matrix, those of the largest eigenvalues first, by power iteration of so
/// many rounds each. They are at right angles and have length 1 to the last bits, however few the rounds are; fewer are
/// returned where the matrix has not so many directions.
pub fn axes(matrix: &[f64], size: usize, count: usize, rounds: usize) -> Vec<Vec<f64>> {
    let mut axes: Vec<Vec<f64>> = Vec::new();
    let mut first = 0.0;
    while axes.len() < count.min(size) {
        let number = axes.len();
        // Any beginning will do that is not at a right angle to the axis.
        let begin = (0..size).map(|index| ((index * 7 + number * 3 + 1) % 11) as f64 - 5.0);
        let mut axis: Vec<f64> = begin.collect();
        let mut value = 0.0;
        for _ in 0..rounds.max(1) {
            axis = matrix.chunks_exact(size).map(|row| dot(row, &axis)).collect();
            // Once leaves what rounding leaves, twice does not.
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

/// Takes away what is along some axes.
fn without(row: &mut [f64], axes: &[Vec<f64>]) {
    for other in axes {
        let along = dot(row, other);
        row.iter_mut()
            .zip(other)
            .for_each(|(number, other)| *number -= along * other);
    }
}

/// The sums of the products of columns of some rows, which are symmetric.
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
