//! Velocities by central differences.

/// The change per second of `values`, which has `width` values per frame: central differences, one-sided at both ends,
/// 0 for a single frame.
pub fn velocities(values: &[f32], width: usize, frame_rate: f64) -> Vec<f32> {
    let frames = values.len().checked_div(width).unwrap_or(0);
    let mut velocities = Vec::with_capacity(values.len());
    for frame in 0..frames {
        let before = frame.saturating_sub(1);
        let after = (frame + 1).min(frames - 1);
        let frames_per_second = frame_rate / (after - before).max(1) as f64;
        let (from, to) = (&values[before * width..], &values[after * width..]);
        for (from, to) in from.iter().zip(to).take(width) {
            velocities.push(((f64::from(*to) - f64::from(*from)) * frames_per_second) as f32);
        }
    }
    velocities
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inside_over_both_neighbours_at_the_ends_over_one() {
        // t^2: its central difference is exactly 2 t; at the ends it is 1 and 5 per frame.
        let squares = [0.0, 1.0, 4.0, 9.0];
        assert_eq!(velocities(&squares, 1, 10.0), [10.0, 20.0, 40.0, 50.0]);
        assert_eq!(velocities(&[1.0, 2.0], 2, 10.0), [0.0, 0.0]);
        assert_eq!(velocities(&[], 3, 10.0), [0.0; 0]);
        assert_eq!(velocities(&[], 0, 10.0), [0.0; 0]);
    }
}
