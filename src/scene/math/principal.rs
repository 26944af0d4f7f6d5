//! Principal axes: the directions along which rows of numbers differ most.

use super::cholesky::dot;

/// An axis is left where the rows vary by less than this part of what they vary along the first, squared.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_eigenvectors_at_right_angles() {
        // The eigenvalues are 2 - sqrt(2), 2 and 2 + sqrt(2).
        let matrix = [2.0, -1.0, 0.0, -1.0, 2.0, -1.0, 0.0, -1.0, 2.0];
        let found = axes(&matrix, 3, 5, 200);
        assert_eq!(found.len(), 3);
        for (axis, value) in found.iter().zip([2.0 + 2_f64.sqrt(), 2.0, 2.0 - 2_f64.sqrt()]) {
            for (row, own) in matrix.chunks_exact(3).zip(axis) {
                assert!((dot(row, axis) - value * own).abs() < 1e-9, "{axis:?}");
            }
        }
        for (index, axis) in found.iter().enumerate() {
            for (other, with) in found.iter().enumerate() {
                let expected = f64::from(u8::from(index == other));
                assert!((dot(axis, with) - expected).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn a_matrix_has_no_more_axes_than_directions() {
        let rows = [[1.0, 2.0, 3.0], [2.0, 4.0, 6.0]];
        let matrix = products(rows.iter().map(<[f64; 3]>::as_slice), 3);
        assert_eq!(axes(&matrix, 3, 3, 50).len(), 1);
        assert!(axes(&[0.0; 9], 3, 3, 50).is_empty());
    }
}
