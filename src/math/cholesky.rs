//! Symmetric positive definite systems, of which the lower triangle is given row by row.

/// Replaces the lower triangle by its factor L, with L times its transpose the matrix.
pub(crate) fn factor(matrix: &mut [f64], size: usize) {
    for row in 0..size {
        for column in 0..=row {
            let (above, here) = matrix.split_at_mut(row * size);
            let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
            if column < row {
                let other = &above[column * size..column * size + column];
                let sum = here[column] - dot(&here[..column], other);
                here[column] = sum / above[column * size + column];
            } else {
                let sum = here[row] - dot(&here[..row], &here[..row]);
                here[row] = sum.max(1e-18).sqrt();
            }
        }
    }
}

/// Solves L y = right, and leaves y in `right`.
pub(crate) fn forward(matrix: &[f64], right: &mut [f64], size: usize) {
    for row in 0..size {
        let known: f64 = (0..row).map(|column| matrix[row * size + column] * right[column]).sum();
        right[row] = (right[row] - known) / matrix[row * size + row];
    }
}

/// Solves the transpose of L times x = right, and leaves x in `right`.
pub(crate) fn backward(matrix: &[f64], right: &mut [f64], size: usize) {
    for row in (0..size).rev() {
        let known: f64 = (row + 1..size)
            .map(|other| matrix[other * size + row] * right[other])
            .sum();
        right[row] = (right[row] - known) / matrix[row * size + row];
    }
}

/// Solves the system, and leaves the solution in its right side; the matrix becomes its factor.
pub(crate) fn solve(matrix: &mut [f64], right: &mut [f64], size: usize) {
    factor(matrix, size);
    forward(matrix, right, size);
    backward(matrix, right, size);
}
