//! The curves between keys.

/// A curve from (0, 0) to (1, 1) by two points between: `[ax, ay, bx, by]`, each from 0 to 127.
pub(super) type Curve = [u8; 4];

/// The largest coordinate of a point.
const LARGEST: f64 = 127.0;

/// Halvings of the interval: 2^-40 is far below what 32 bits hold.
const HALVINGS: usize = 40;

/// How much of a change is made after the fraction `time` of its time.
pub(super) fn ease(curve: Curve, time: f64) -> f64 {
    let [ax, ay, bx, by] = curve.map(|coordinate| f64::from(coordinate.min(127)) / LARGEST);
    if ax == ay && bx == by {
        return time;
    }
    let at = |a: f64, b: f64, s: f64| {
        let rest = 1.0 - s;
        3.0 * rest * rest * s * a + 3.0 * rest * s * s * b + s * s * s
    };
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if at(ax, bx, middle) < time {
            low = middle;
        } else {
            high = middle;
        }
    }
    at(ay, by, 0.5 * (low + high))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_is_that_of_its_points() {
        assert_eq!(ease([20, 20, 107, 107], 0.3), 0.3);
        assert_eq!(ease([0, 0, 0, 0], 0.3), 0.3);
        // With both points at (1, 0): x = 1 - (1-s)^3, y = s^3. At s = 1/2, x = 7/8 and y = 1/8.
        assert!((ease([127, 0, 127, 0], 0.875) - 0.125).abs() < 1e-9);
        for curve in [[64, 0, 64, 127], [0, 127, 127, 0], [127, 0, 0, 127]] {
            assert!(ease(curve, 0.0).abs() < 1e-3 && (ease(curve, 1.0) - 1.0).abs() < 1e-3);
        }
    }
}
