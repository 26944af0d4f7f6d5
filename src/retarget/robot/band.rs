//! Solves symmetric positive definite systems whose entries are near the diagonal.

use mocap_scene::math::wide;

/// The number of rows of a panel: four doubles are a vector of AVX2.
const LANES: usize = 4;
type Lanes = [f64; LANES];

/// The lower triangle of a matrix whose entries are at most `width` below the diagonal, and a right side.
///
/// Four rows are a panel. The entries of a panel in one column are contiguous, so that a product of panels uses whole
/// vectors.
#[derive(Clone, Debug, Default)]
pub struct Band {
    size: usize,
    width: usize,
    /// The columns of each panel, from `before` panels before the diagonal to the diagonal.
    columns: Vec<Lanes>,
    /// The number of panels that the band reaches before the panel of the diagonal.
    before: usize,
    pub right: Vec<f64>,
}

/// The smallest pivot, as a fraction of 1. A row with a smaller pivot has no information, and a division by it would
/// overflow.
const SMALLEST: f64 = 1e-18;

impl Band {
    /// Clears the system, and sets its size.
    pub fn reset(&mut self, size: usize, width: usize) {
        (self.size, self.width) = (size, width);
        self.before = width.div_ceil(LANES);
        let panels = size.div_ceil(LANES);
        self.columns.clear();
        self.columns.resize(panels * self.stride(), [0.0; LANES]);
        self.right.clear();
        self.right.resize(panels * LANES, 0.0);
        // The remaining rows of the last panel.
        for row in size..panels * LANES {
            self.add(row, row, 1.0);
        }
    }

    /// The number of columns of a panel.
    fn stride(&self) -> usize {
        (self.before + 1) * LANES
    }

    /// Adds to an entry on or below the diagonal.
    pub fn add(&mut self, row: usize, column: usize, value: f64) {
        let index = self.index(row, column);
        self.columns[index][row % LANES] += value;
    }

    /// Adds to the entries of a row that begin at a column.
    pub(super) fn add_row(&mut self, row: usize, column: usize, values: &[f64]) {
        let (begin, lane) = (self.index(row, column), row % LANES);
        for (entry, value) in self.columns[begin..].iter_mut().zip(values) {
            entry[lane] += value;
        }
    }

    fn index(&self, row: usize, column: usize) -> usize {
        let panel = row / LANES;
        panel * self.stride() + column + self.before * LANES - panel * LANES
    }

    /// Fixes an unknown at 0, whatever the other unknowns are.
    pub fn fix(&mut self, unknown: usize) {
        let lane = unknown % LANES;
        let row = self.index(unknown, unknown.saturating_sub(self.width))..self.index(unknown, unknown);
        self.columns[row].iter_mut().for_each(|entry| entry[lane] = 0.0);
        for below in unknown + 1..(unknown + self.width + 1).min(self.size) {
            let index = self.index(below, unknown);
            self.columns[index][below % LANES] = 0.0;
        }
        let diagonal = self.index(unknown, unknown);
        self.columns[diagonal][lane] = 1.0;
        self.right[unknown] = 0.0;
    }

    /// Solves the system by Cholesky decomposition. The right side becomes the solution.
    pub fn solve(&mut self) {
        let stride = self.stride();
        for panel in 0..self.right.len() / LANES {
            let first = panel.saturating_sub(self.before);
            let (above, here) = self.columns.split_at_mut(panel * stride);
            // The index of a panel's column, in this panel and in another panel.
            let own = |other: usize| (other + self.before - panel) * LANES;
            for other in first..panel {
                let theirs = &above[other * stride..(other + 1) * stride];
                let skipped = (first + self.before - other) * LANES..self.before * LANES;
                let known = products(&here[own(first)..own(other)], &theirs[skipped]);
                let diagonal = &theirs[self.before * LANES..];
                below_diagonal(&mut here[own(other)..own(other) + LANES], known, diagonal);
            }
            let (left, diagonal) = here[..stride].split_at_mut(own(panel));
            let left = &left[own(first)..];
            factor_diagonal(diagonal, products(left, left));
            let known = product(left, &self.right[first * LANES..panel * LANES]);
            let right = &mut self.right[panel * LANES..(panel + 1) * LANES];
            for (row, known) in known.into_iter().enumerate() {
                let own: f64 = (0..row).map(|column| diagonal[column][row] * right[column]).sum();
                right[row] = (right[row] - known - own) / diagonal[row][row];
            }
        }
        self.backward();
    }

    /// Solves the system of the transposed factor.
    fn backward(&mut self) {
        let stride = self.stride();
        for panel in (0..self.right.len() / LANES).rev() {
            let first = panel.saturating_sub(self.before);
            let here = &self.columns[panel * stride..(panel + 1) * stride];
            let (left, diagonal) = here.split_at(self.before * LANES);
            let (before, right) = self.right.split_at_mut(panel * LANES);
            for row in (0..LANES).rev() {
                let own: f64 = (row + 1..LANES).map(|below| diagonal[row][below] * right[below]).sum();
                right[row] = (right[row] - own) / diagonal[row][row];
            }
            let solved: Lanes = std::array::from_fn(|row| right[row]);
            let left = &left[(first + self.before - panel) * LANES..];
            for (right, column) in before[first * LANES..].iter_mut().zip(left) {
                *right -= lanes(|row| column[row] * solved[row]).iter().sum::<f64>();
            }
        }
    }
}

#[inline(always)]
fn lanes(value: impl Fn(usize) -> f64) -> Lanes {
    std::array::from_fn(value)
}

wide::dispatch! {
    /// The products of the rows of two panels. For each row of the second panel, the products with all rows of the
    /// first.
    fn products(a: &[Lanes], b: &[Lanes]) -> [Lanes; LANES] {
        products_of(a, b)
    }
}

#[inline(always)]
fn products_of(a: &[Lanes], b: &[Lanes]) -> [Lanes; LANES] {
    let mut sums = [[0.0; LANES]; LANES];
    for (a, b) in a.iter().zip(b) {
        let mut row = 0;
        while row < LANES {
            let mut lane = 0;
            while lane < LANES {
                sums[row][lane] += a[lane] * b[row];
                lane += 1;
            }
            row += 1;
        }
    }
    sums
}

/// The products of the rows of a panel with a vector.
fn product(a: &[Lanes], b: &[f64]) -> Lanes {
    let mut sums = [0.0; LANES];
    for (a, b) in a.iter().zip(b) {
        for (sum, a) in sums.iter_mut().zip(a) {
            *sum += a * b;
        }
    }
    sums
}

/// Four columns of a factor below the diagonal. The `known` products are subtracted, and the rest is solved with the
/// block on the diagonal.
fn below_diagonal(here: &mut [Lanes], known: [Lanes; LANES], diagonal: &[Lanes]) {
    for (column, known) in known.into_iter().enumerate() {
        let mut value: Lanes = lanes(|row| here[column][row] - known[row]);
        for (before, factors) in diagonal.iter().enumerate().take(column) {
            value = lanes(|row| value[row] - here[before][row] * factors[column]);
        }
        here[column] = lanes(|row| value[row] / diagonal[column][column]);
    }
}

/// The factor of a block on the diagonal.
fn factor_diagonal(block: &mut [Lanes], known: [Lanes; LANES]) {
    for (column, known) in known.into_iter().enumerate() {
        for (row, known) in known.into_iter().enumerate().skip(column) {
            let before: f64 = (0..column).map(|other| block[other][row] * block[other][column]).sum();
            let value = block[column][row] - known - before;
            block[column][row] = match row == column {
                true => value.max(SMALLEST).sqrt(),
                false => value / block[column][column],
            };
        }
    }
}
