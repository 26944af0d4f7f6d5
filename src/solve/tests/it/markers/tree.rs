//! Tests systems of equations over a tree.

use mocap::glam::{DMat3, DVec3};
use mocap_scene::math::cholesky;
use mocap_solve::internals::{Tree, TreeMatrix};

/// Two chains of two blocks below a root: 0 below 1, 2 below 3, both below 4.
const PARENTS: [Option<usize>; 5] = [Some(1), Some(4), Some(3), Some(4), None];

/// The ancestors of each block, with the block itself.
const CHAINS: [&[usize]; 5] = [&[0, 1, 4], &[1, 4], &[2, 3, 4], &[3, 4], &[4]];

/// The number of unknowns.
const SIZE: usize = 15;

#[test]
fn a_tree_is_solved_as_the_whole_matrix_is() {
    let tree = Tree::new(&PARENTS);
    let mut matrix = TreeMatrix::default();
    matrix.clear(&tree);
    let mut whole = vec![0.0; SIZE * SIZE];
    for (block, chain) in CHAINS.iter().enumerate() {
        for (level, above) in chain.iter().enumerate() {
            for cell in 0..9 {
                let (row, column) = (3 * above + cell / 3, 3 * block + cell % 3);
                let value = match (row == column, row + column) {
                    (true, sum) => 9.0 + sum as f64,
                    (false, sum) => 0.3 + 0.1 * (sum % 7) as f64,
                };
                whole[row * SIZE + column] = value;
                matrix.block(&tree, block, level).col_mut(cell % 3)[cell / 3] = value;
            }
        }
    }
    matrix.add_diagonal(&tree, 3, 2.5);
    (9..12).for_each(|row| whole[row * SIZE + row] += 2.5);
    let mut right: Vec<DVec3> = (0..5).map(|block| DVec3::new(1.0, -2.0, f64::from(block))).collect();
    let mut solution: Vec<f64> = right.iter().flat_map(DVec3::to_array).collect();

    let mut dense = whole.clone();
    cholesky::solve(&mut dense, &mut solution, SIZE);
    matrix.factor(&tree);
    matrix.forward(&tree, &mut right);
    matrix.backward(&tree, &mut right);
    for (own, other) in right.iter().flat_map(DVec3::to_array).zip(&solution) {
        assert!((own - other).abs() < 1e-12, "{right:?} {solution:?}");
    }
    for block in 0..5 {
        let variance = |axis: usize| {
            let mut unit = vec![0.0; SIZE];
            unit[3 * block + axis] = 1.0;
            cholesky::solve(&mut whole.clone(), &mut unit, SIZE);
            unit[3 * block + axis]
        };
        let expected = DVec3::from([0, 1, 2].map(variance));
        assert!(
            matrix.variances(&tree, block).distance(expected) < 1e-12,
            "block {block}"
        );
    }
}

#[test]
fn unknowns_without_information_stay_finite() {
    let tree = Tree::new(&[None]);
    let mut matrix = TreeMatrix::default();
    matrix.clear(&tree);
    *matrix.block(&tree, 0, 0) = DMat3::from_diagonal(DVec3::new(4.0, 0.0, 0.0));
    matrix.factor(&tree);
    let mut right = [DVec3::new(8.0, 0.0, 0.0)];
    matrix.forward(&tree, &mut right);
    matrix.backward(&tree, &mut right);
    assert_eq!(right[0], DVec3::new(2.0, 0.0, 0.0));
}
