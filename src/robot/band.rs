//! Symmetric positive definite systems whose entries are near the diagonal.

/// The lower triangle of a matrix whose entries are at most `width` below the diagonal, and a right side.
#[derive(Clone, Debug, Default)]
pub(super) struct Band {
    size: usize,
    width: usize,
    /// Row by row, the columns from `width` before the diagonal to the diagonal.
    entries: Vec<f64>,
    pub(super) right: Vec<f64>,
}

/// The smallest pivot.
const SMALLEST: f64 = 1e-18;

impl Band {
    /// Empties it.
    pub(super) fn reset(&mut self, size: usize, width: usize) {
        (self.size, self.width) = (size, width);
        self.entries.clear();
        self.entries.resize(size * (width + 1), 0.0);
        self.right.clear();
        self.right.resize(size, 0.0);
    }

    /// Adds to an entry on or below the diagonal.
    pub(super) fn add(&mut self, row: usize, column: usize, value: f64) {
        let index = self.index(row, column);
        self.entries[index] += value;
    }

    /// Adds to the entries of a row that begin at a column.
    pub(super) fn add_row(&mut self, row: usize, column: usize, values: &[f64]) {
        let begin = self.index(row, column);
        for (entry, value) in self.entries[begin..].iter_mut().zip(values) {
            *entry += value;
        }
    }

    fn index(&self, row: usize, column: usize) -> usize {
        row * (self.width + 1) + column + self.width - row
    }

    /// Makes an unknown 0, whatever the others are.
    pub(super) fn fix(&mut self, unknown: usize) {
        let first = unknown.saturating_sub(self.width);
        let row = self.index(unknown, first)..self.index(unknown, unknown);
        self.entries[row].fill(0.0);
        for below in unknown + 1..(unknown + self.width + 1).min(self.size) {
            let index = self.index(below, unknown);
            self.entries[index] = 0.0;
        }
        let diagonal = self.index(unknown, unknown);
        self.entries[diagonal] = 1.0;
        self.right[unknown] = 0.0;
    }

    /// Solves the system by Cholesky's decomposition: the right side becomes the solution.
    pub(super) fn solve(&mut self) {
        let (width, stride) = (self.width, self.width + 1);
        for row in 0..self.size {
            let first = row.saturating_sub(width);
            let (above, here) = self.entries.split_at_mut(row * stride);
            let here = &mut here[first + width - row..stride];
            for column in first..row {
                let begin = column * stride + first + width - column;
                let other = &above[begin..=begin + column - first];
                let known = dot(&here[..column - first], &other[..column - first]);
                here[column - first] = (here[column - first] - known) / other[column - first];
            }
            let known = dot(&here[..row - first], &here[..row - first]);
            here[row - first] = (here[row - first] - known).max(SMALLEST).sqrt();
            let known = dot(&here[..row - first], &self.right[first..row]);
            self.right[row] = (self.right[row] - known) / here[row - first];
        }
        for row in (0..self.size).rev() {
            let first = row.saturating_sub(width);
            let here = &self.entries[self.index(row, first)..=self.index(row, row)];
            let value = self.right[row] / here[row - first];
            self.right[row] = value;
            for (right, entry) in self.right[first..row].iter_mut().zip(here) {
                *right -= entry * value;
            }
        }
    }
}

/// In four sums, of which the compiler makes vector instructions.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (a, b) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f64 = a.remainder().iter().zip(b.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a.zip(b) {
        for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *sum += a * b;
        }
    }
    rest + (sums[0] + sums[1]) + (sums[2] + sums[3])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A system is made of its solution.
    #[test]
    fn a_band_is_solved_and_what_is_fixed_is_0() {
        let (size, width) = (23, 6);
        let entry = |row: usize, column: usize| match row - column {
            0 => 9.0 + row as f64,
            apart if apart <= width => ((row * 7 + column * 3) % 11) as f64 / 11.0 - 0.5,
            _ => 0.0,
        };
        let full = |a: usize, b: usize| entry(a.max(b), a.min(b));
        for fixed in [None, Some(4)] {
            let known = |unknown: usize| match fixed {
                Some(fixed) if fixed == unknown => 0.0,
                _ => (unknown as f64).sin(),
            };
            let mut band = Band::default();
            band.reset(size, width);
            for row in 0..size {
                for column in row.saturating_sub(width)..=row {
                    band.add(row, column, entry(row, column));
                }
                band.right[row] = (0..size).map(|column| full(row, column) * known(column)).sum();
            }
            if let Some(fixed) = fixed {
                band.fix(fixed);
            }
            band.solve();
            for (unknown, found) in band.right.iter().enumerate() {
                assert!((found - known(unknown)).abs() < 1e-12, "{unknown} {found}");
            }
        }
    }
}
