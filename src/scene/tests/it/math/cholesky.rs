//! Systems of equations.

use mocap_scene::math::cholesky::{solve, solve_envelope};

#[test]
fn a_tree_is_solved_as_the_whole_matrix_is() {
    // Two chains of two below a root: 0 below 1, 2 below 3, both below 4.
    let first = [0, 0, 2, 2, 0];
    let mut matrix = vec![0.0; 25];
    for (row, from) in first.into_iter().enumerate() {
        for column in from..row {
            let is_other_chain = row == 3 && column < 2;
            matrix[row * 5 + column] = if is_other_chain {
                0.0
            } else {
                0.3 + 0.1 * (row + column) as f64
            };
        }
        matrix[row * 5 + row] = 4.0 + row as f64;
    }
    let mut right = vec![1.0, -2.0, 3.0, 0.5, -1.0];
    let (mut whole, mut solution) = (matrix.clone(), right.clone());
    solve(&mut whole, &mut solution, 5);
    solve_envelope(&mut matrix, &mut right, &first);
    for (own, other) in right.iter().zip(&solution) {
        assert!((own - other).abs() < 1e-12, "{right:?} {solution:?}");
    }
}
