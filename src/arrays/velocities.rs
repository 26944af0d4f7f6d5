//! Velocities by central differences.

/// The change a second of `values`, which has `width` values a frame: over both neighbours inside, over the one
/// neighbour at the ends, 0 where there is one frame only.
pub(super) fn velocities(values: &[f32], width: usize, frame_rate: f64) -> Vec<f32> {
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
        // A square number a frame: the central difference of t^2 is 2 t, exactly; at the ends 1 and 5 a frame.
        let squares = [0.0, 1.0, 4.0, 9.0];
        assert_eq!(velocities(&squares, 1, 10.0), [10.0, 20.0, 40.0, 50.0]);
        assert_eq!(velocities(&[1.0, 2.0], 2, 10.0), [0.0, 0.0]);
        assert_eq!(velocities(&[], 3, 10.0), [0.0; 0]);
        assert_eq!(velocities(&[], 0, 10.0), [0.0; 0]);
    }
}
