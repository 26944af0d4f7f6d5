//! Tests the solver of systems of equations with a band matrix.

use mocap_retarget::internals::Band;

/// The test makes a system from its solution.
#[test]
fn a_band_is_solved_and_what_is_fixed_is_0() {
    for (size, width) in [(23, 6), (24, 8), (5, 9), (61, 13)] {
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
            for (unknown, found) in band.right[..size].iter().enumerate() {
                assert!((found - known(unknown)).abs() < 1e-12, "{unknown} {found}");
            }
        }
    }
}
