//! Velocities by central differences.

/// The change per second of `values`, which has `width` values per frame: central differences, one-sided at both ends.
/// The change is 0 for a single frame.
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
