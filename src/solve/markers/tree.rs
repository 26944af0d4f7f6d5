//! Systems of normal equations over a tree of joints, in blocks of 3 x 3.
//!
//! The unknowns of a joint are coupled only to the unknowns of its ancestors and descendants. If children are
//! eliminated before their parents, the Cholesky factor has no other blocks either (Featherstone, Rigid Body Dynamics
//! Algorithms, 2008, chapter 6). The cost of a factor is the sum of the squared depths of the blocks.

use glam::{DMat3, DVec3};
use mocap_scene::math::wide;

/// The blocks of a tree. Children precede their parents, and the root is last.
#[derive(Clone, Debug, Default)]
pub struct Tree {
    /// The ancestors of each block: the block itself first, the root last.
    chains: Vec<Vec<usize>>,
    /// The index of each block's own matrix. The matrices with its ancestors follow.
    starts: Vec<usize>,
    count: usize,
}

impl Tree {
    /// `parents` has the parent of each block, which is a later block; `None` for the root.
    pub fn new(parents: &[Option<usize>]) -> Self {
        let chain = |block: usize| std::iter::successors(Some(block), |block| parents[*block]).collect();
        let chains: Vec<Vec<usize>> = (0..parents.len()).map(chain).collect();
        let mut count = 0;
        let starts = chains.iter().map(|chain| {
            count += chain.len();
            count - chain.len()
        });
        Self {
            starts: starts.collect(),
            count,
            chains,
        }
    }

    pub(super) fn chain(&self, block: usize) -> &[usize] {
        &self.chains[block]
    }
}

/// A symmetric positive definite matrix over a tree, or its factor.
#[derive(Debug, Default)]
pub struct TreeMatrix {
    /// For each block, the rows of its ancestors in its columns.
    blocks: Vec<DMat3>,
}

impl TreeMatrix {
    pub fn clear(&mut self, tree: &Tree) {
        self.blocks.clear();
        self.blocks.resize(tree.count, DMat3::ZERO);
    }

    /// The rows of the ancestor at `level` of a block's chain, in the columns of the block.
    pub fn block(&mut self, tree: &Tree, block: usize, level: usize) -> &mut DMat3 {
        &mut self.blocks[tree.starts[block] + level]
    }

    /// Adds `value` to the diagonal of a block.
    pub fn add_diagonal(&mut self, tree: &Tree, block: usize, value: f64) {
        *self.block(tree, block, 0) += DMat3::from_diagonal(DVec3::splat(value));
    }

    /// Replaces the matrix by its factor. The diagonal has the inverses of the factor's blocks.
    pub fn factor(&mut self, tree: &Tree) {
        factor(&mut self.blocks, tree);
    }

    /// Solves the factor times y = `right` on the chain of a block, and leaves y in `right`. `right` has a value for
    /// each block of the chain.
    pub(super) fn forward_chain<T>(&self, tree: &Tree, block: usize, right: &mut [T])
    where
        T: Copy + std::ops::SubAssign,
        DMat3: std::ops::Mul<T, Output = T>,
    {
        for (level, &own) in tree.chains[block].iter().enumerate() {
            let start = tree.starts[own];
            right[level] = self.blocks[start] * right[level];
            let known = right[level];
            for (above, right) in right[level + 1..].iter_mut().enumerate() {
                *right -= self.blocks[start + 1 + above] * known;
            }
        }
    }

    /// Solves the factor times y = `right`, and leaves y in `right`.
    pub fn forward(&self, tree: &Tree, right: &mut [DVec3]) {
        for (block, (chain, start)) in std::iter::zip(&tree.chains, &tree.starts).enumerate() {
            if right[block] == DVec3::ZERO {
                continue;
            }
            right[block] = self.blocks[*start] * right[block];
            for (level, above) in chain.iter().enumerate().skip(1) {
                let less = self.blocks[start + level] * right[block];
                right[*above] -= less;
            }
        }
    }

    /// Solves the transpose of the factor times x = `right`, and leaves x in `right`.
    pub fn backward(&self, tree: &Tree, right: &mut [DVec3]) {
        for (block, (chain, start)) in std::iter::zip(&tree.chains, &tree.starts).enumerate().rev() {
            for (level, above) in chain.iter().enumerate().skip(1) {
                let less = self.blocks[start + level].transpose() * right[*above];
                right[block] -= less;
            }
            right[block] = self.blocks[*start].transpose() * right[block];
        }
    }

    /// The diagonal of a block of the inverse matrix.
    pub fn variances(&self, tree: &Tree, block: usize) -> DVec3 {
        let mut columns = vec![DMat3::ZERO; tree.chains[block].len()];
        columns[0] = DMat3::IDENTITY;
        self.forward_chain(tree, block, &mut columns);
        let squares = |column: &DMat3| {
            DVec3::new(
                column.x_axis.length_squared(),
                column.y_axis.length_squared(),
                column.z_axis.length_squared(),
            )
        };
        columns.iter().map(squares).sum()
    }
}

wide::dispatch! {
    /// Replaces a matrix by its factor.
    fn factor(blocks: &mut [DMat3], tree: &Tree) {
        for (chain, &start) in std::iter::zip(&tree.chains, &tree.starts) {
            // The blocks of ancestors follow.
            let (own, ancestors) = blocks.split_at_mut(start + chain.len());
            let inverse = inverse_factor(&own[start]);
            own[start] = inverse;
            let own = &mut own[start + 1..];
            let across = inverse.transpose();
            own.iter_mut().for_each(|block| *block *= across);
            for (low, above) in chain[1..].iter().enumerate() {
                let across = own[low].transpose();
                let first = tree.starts[*above] - start - chain.len();
                for (less, high) in std::iter::zip(&mut ancestors[first..], &own[low..]) {
                    *less -= *high * across;
                }
            }
        }
    }
}

/// The inverse of the lower triangular L for which L times its transpose is the matrix.
fn inverse_factor(matrix: &DMat3) -> DMat3 {
    /// The least square of a diagonal element, so that rounding makes no division by 0.
    const LEAST: f64 = 1e-18;
    let at = |row: usize, column: usize| matrix.col(column)[row];
    let root = |square: f64| square.max(LEAST).sqrt();
    let a = root(at(0, 0));
    let (b, d) = (at(1, 0) / a, at(2, 0) / a);
    let c = root(at(1, 1) - b * b);
    let e = (at(2, 1) - d * b) / c;
    let f = root(at(2, 2) - d * d - e * e);
    DMat3::from_cols(
        DVec3::new(1.0 / a, -b / (a * c), (b * e - c * d) / (a * c * f)),
        DVec3::new(0.0, 1.0 / c, -e / (c * f)),
        DVec3::new(0.0, 0.0, 1.0 / f),
    )
}
