//! Computes curves over frames: completes a shift that is known only in contacts, and finds a smooth upper bound of a
//! curve.

use std::ops::{Add, Div, Mul};

use glam::Vec3;

/// Completes a shift that is known only in contacts. After a contact, the shift fades out to zero within `blend`
/// frames, and before the next contact it fades in. If the time between two contacts is too short for both fades, the
/// shift changes directly from one contact to the other. The curve is cubic Hermite, so values and speeds are
/// continuous.
pub fn complete(known: &[Option<Vec3>], blend: usize) -> Vec<Vec3> {
    let mut shifts: Vec<Vec3> = known.iter().map(|shift| shift.unwrap_or_default()).collect();
    let slope = |frame: usize, other: Option<usize>| {
        let value = known.get(frame).copied().flatten()?;
        let other_value = known.get(other?).copied().flatten()?;
        Some(value - other_value)
    };
    let mut frame = 0;
    while frame < known.len() {
        if known[frame].is_some() {
            frame += 1;
            continue;
        }
        let end = (frame..known.len())
            .find(|frame| known[*frame].is_some())
            .unwrap_or(known.len());
        // The frames `before` and `end` are known, unless they are outside the motion.
        let before = frame.checked_sub(1);
        let out = before.and_then(|last| Some((known[last]?, slope(last, last.checked_sub(1)).unwrap_or_default())));
        let into = known
            .get(end)
            .copied()
            .flatten()
            .map(|value| (value, -slope(end, Some(end + 1)).unwrap_or_default()));
        let gap = end - frame + 1;
        for (index, shift) in shifts[frame..end].iter_mut().enumerate() {
            let (after, ahead) = (index + 1, end - frame - index);
            *shift = match (out, into) {
                (Some(out), Some(into)) if gap < 2 * blend => hermite(out, into, after, gap),
                (Some(out), _) if after < blend => hermite(out, (Vec3::ZERO, Vec3::ZERO), after, blend),
                (_, Some(into)) if ahead < blend => hermite((Vec3::ZERO, Vec3::ZERO), into, blend - ahead, blend),
                _ => Vec3::ZERO,
            };
        }
        frame = end;
    }
    shifts
}

/// Approximates the centre of the smallest sphere around all `points`, by the iteration of Bădoiu and Clarkson (2003).
pub(super) fn middle(points: &[Vec3]) -> Vec3 {
    let mut middle = points.first().copied().unwrap_or_default();
    for step in 1..=64 {
        let away = |point: &&Vec3| point.distance_squared(middle);
        let Some(farthest) = points.iter().max_by(|a, b| away(a).total_cmp(&away(b))) else {
            break;
        };
        middle += (farthest - middle) / (step + 1) as f32;
    }
    middle
}

/// The value after `step` of `steps` frames between two values. Each value is given with its change per frame.
fn hermite(from: (Vec3, Vec3), to: (Vec3, Vec3), step: usize, steps: usize) -> Vec3 {
    let (t, length) = (step as f32 / steps as f32, steps as f32);
    let (t2, t3) = (t * t, t * t * t);
    from.0 * (2.0 * t3 - 3.0 * t2 + 1.0)
        + from.1 * (length * (t3 - 2.0 * t2 + t))
        + to.0 * (3.0 * t2 - 2.0 * t3)
        + to.1 * (length * (t3 - t2))
}

/// A smooth curve that is never below `values`, which are not negative. The function takes the largest value within
/// `radius` frames of each frame. It then averages these largest values within `radius` frames, with the weights of a
/// Hann window.
pub fn envelope(values: &[f32], radius: usize) -> Vec<f32> {
    if values.iter().all(|value| *value == 0.0) {
        return values.to_vec();
    }
    let around = |index: usize| index.saturating_sub(radius)..=(index + radius).min(values.len().saturating_sub(1));
    let highest: Vec<f32> = (0..values.len())
        .map(|index| values[around(index)].iter().copied().fold(0.0, f32::max))
        .collect();
    // Rounding must not bring the curve below the values.
    smooth(&highest, radius)
        .iter()
        .zip(values)
        .map(|(smooth, value)| smooth.max(*value))
        .collect()
}

/// Averages over `radius` frames on both sides, with the weights of a Hann window.
pub(super) fn smooth<T>(values: &[T], radius: usize) -> Vec<T>
where
    T: Copy + Default + Add<Output = T> + Mul<f32, Output = T> + Div<f32, Output = T>,
{
    let weight = |offset: usize| 1.0 + (std::f32::consts::PI * offset as f32 / (radius as f32 + 1.0)).cos();
    let weights: Vec<f32> = (0..=radius).map(weight).collect();
    (0..values.len())
        .map(|index| {
            let around = index.saturating_sub(radius)..=(index + radius).min(values.len() - 1);
            let terms = around.map(|other| (weights[other.abs_diff(index)], values[other]));
            let (sum, weights) = terms.fold((T::default(), 0.0), |(sum, weights), (weight, value)| {
                (sum + value * weight, weights + weight)
            });
            sum / weights
        })
        .collect()
}

/// Interpolates values linearly between the frames in which they are known. If none is known, all are 0.
pub fn filled(known: impl Iterator<Item = Option<Vec3>>) -> Vec<Vec3> {
    let mut filled = Vec::new();
    let mut last: Option<(usize, Vec3)> = None;
    for (frame, value) in known.enumerate() {
        filled.push(value.or(last.map(|(_, value)| value)).unwrap_or_default());
        let Some(value) = value else { continue };
        let (start, from) = last.map_or((0, value), |(frame, value)| (frame + 1, value));
        let steps = (frame + 1 - start) as f32;
        for (step, between) in filled[start..frame].iter_mut().enumerate() {
            *between = from + (value - from) * ((step + 1) as f32 / steps);
        }
        last = Some((frame, value));
    }
    filled
}
