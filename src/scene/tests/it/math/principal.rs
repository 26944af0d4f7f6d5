//! Tests principal axes of matrices.

use mocap_scene::math::cholesky::dot;
use mocap_scene::math::principal::{axes, products};

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
