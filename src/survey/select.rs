//! Chooses clips that are far apart: farthest-point sampling (Gonzalez 1985) over the descriptors.

/// Chooses `count` of the points at `allowed`: first that which is nearest to the mean, then again and again the one
/// that is farthest from all chosen ones. The largest distance to a chosen one is at most twice the least possible.
pub(super) fn farthest_points(points: &[Option<Vec<f32>>], allowed: &[usize], count: usize) -> Vec<usize> {
    let point = |index: usize| points[index].as_deref().unwrap_or(&[]);
    let mut left: Vec<(usize, f32)> = allowed
        .iter()
        .filter(|index| points[**index].is_some())
        .map(|index| (*index, f32::INFINITY))
        .collect();
    // Descriptors have the mean 0.
    let from_mean = |index: usize| point(index).iter().map(|value| value * value).sum::<f32>();
    let Some(mut next) = left
        .iter()
        .map(|(index, _)| *index)
        .min_by(|a, b| from_mean(*a).total_cmp(&from_mean(*b)))
    else {
        return Vec::new();
    };
    let mut chosen = Vec::new();
    while chosen.len() < count {
        chosen.push(next);
        left.retain(|(index, _)| *index != next);
        for (index, nearest) in &mut left {
            *nearest = nearest.min(squared_distance(point(*index), point(next)));
        }
        let farthest = left.iter().max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)));
        match farthest {
            Some((index, _)) => next = *index,
            None => break,
        }
    }
    chosen
}

fn squared_distance(a: &[f32], b: &[f32]) -> f32 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}
