//! The interpolation curves between keys.

/// A curve from (0, 0) to (1, 1) with two control points: `[ax, ay, bx, by]`, each from 0 to 127.
pub(super) type Curve = [u8; 4];

/// The largest coordinate of a point, a number of 7 bits, as MikuMikuDance stores it.
const LARGEST: f64 = 127.0;

/// The number of interval halvings: 2^-40 is far below the precision of 32 bits.
const HALVINGS: usize = 40;

/// The completed fraction of a change at the fraction `time` of its duration.
pub fn ease(curve: Curve, time: f64) -> f64 {
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
