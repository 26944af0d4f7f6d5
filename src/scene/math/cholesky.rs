//! Solves symmetric positive definite systems. A matrix is stored as its lower triangle, row by row.

/// The number of products that are summed in parallel, so that no addition waits for another.
const LANES: usize = 4;

/// The dot product of two rows of equal length.
#[inline]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let size = a.len().min(b.len());
    let (a, a_rest) = a[..size].as_chunks::<LANES>();
    let (b, b_rest) = b[..size].as_chunks::<LANES>();
    let mut lanes = [0.0; LANES];
    // An index loop compiles to one loop without calls at every optimisation level. Iterator chains do not.
    let mut at = 0;
    while at < a.len() {
        let (a, b) = (&a[at], &b[at]);
        lanes = [
            lanes[0] + a[0] * b[0],
            lanes[1] + a[1] * b[1],
            lanes[2] + a[2] * b[2],
            lanes[3] + a[3] * b[3],
        ];
        at += 1;
    }
    let mut sum = (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]);
    let mut at = 0;
    while at < a_rest.len() {
        sum += a_rest[at] * b_rest[at];
        at += 1;
    }
    sum
}

/// Replaces the lower triangle by its factor L: L times its transpose is the matrix.
pub fn factor(matrix: &mut [f64], size: usize) {
    for row in 0..size {
        for column in 0..=row {
            let (above, here) = matrix.split_at_mut(row * size);
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
pub fn forward(matrix: &[f64], right: &mut [f64], size: usize) {
    for row in 0..size {
        let known = dot(&matrix[row * size..row * size + row], &right[..row]);
        right[row] = (right[row] - known) / matrix[row * size + row];
    }
}

/// Solves the transpose of L times x = right, and leaves x in `right`.
pub fn backward(matrix: &[f64], right: &mut [f64], size: usize) {
    for row in (0..size).rev() {
        let known: f64 = (row + 1..size)
            .map(|other| matrix[other * size + row] * right[other])
            .sum();
        right[row] = (right[row] - known) / matrix[row * size + row];
    }
}

/// Solves the system in place: the right side becomes the solution, and the matrix becomes its factor.
pub fn solve(matrix: &mut [f64], right: &mut [f64], size: usize) {
    factor(matrix, size);
    forward(matrix, right, size);
    backward(matrix, right, size);
}
