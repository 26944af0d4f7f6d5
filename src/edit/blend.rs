//! Mixes two motions.

use serde::Serialize;

use super::concat::pair;
use super::frames::{Frames, between};
use super::ground::Carrier;
use super::inertia::pose_distance;
use crate::error::{Code, Diagnostic, Result};
use crate::pose::Trs;
use crate::scene::Scene;

/// What [`blend()`] did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct BlendReport {
    /// The frames now.
    pub frames: usize,
    /// How far one motion was shifted in time against an even stretch to align the two, in seconds at most.
    pub largest_time_shift: f64,
}

/// Frames of each motion that are compared at most to align them; of longer ones only every so many are.
const COMPARED: usize = 160;

/// Mixes an animation of `other`, which has the same joints, into one of `scene`. At weight 0 it is the first, at 1 the
/// second. The two are aligned in time by dynamic time warping of their poses, so that a step meets a step, and the result
/// is as long as its share of both.
///
/// # Errors
/// [`Code::UnknownOption`] where the joints differ, or the weight is not from 0 to 1; [`Code::NoMotion`] without one of
/// the animations.
pub fn blend(
    scene: &mut Scene,
    animation: usize,
    other: &Scene,
    other_animation: usize,
    weight: f64,
) -> Result<BlendReport> {
    if !(0.0..=1.0).contains(&weight) {
        let message = format!("weight must be from 0 to 1, got {weight}");
        return Err(Diagnostic::new(Code::UnknownOption, message).into());
    }
    let (first, second) = pair(scene, animation, other, other_animation)?;
    let carrier = Carrier::new(scene, &first);
    let path = align(&first, &second, &carrier);
    // Time of the result in seconds at each point of the path.
    let at = |(a, b): (f64, f64)| (1.0 - weight) * a / first.rate + weight * b / second.rate;
    let (last_a, last_b) = ((first.len() - 1) as f64, (second.len() - 1) as f64);
    let count = (at((last_a, last_b)) * first.rate + 1e-6).floor() as usize + 1;
    let mut rows: Vec<Vec<Trs>> = Vec::with_capacity(count);
    let mut piece = 0;
    let mut report = BlendReport {
        frames: count,
        ..BlendReport::default()
    };
    for frame in 0..count {
        let time = frame as f64 / first.rate;
        while piece + 2 < path.len() && at(path[piece + 1]) < time {
            piece += 1;
        }
        let (from, to) = (path[piece], path[(piece + 1).min(path.len() - 1)]);
        let length = at(to) - at(from);
        let share = if length > 0.0 {
            ((time - at(from)) / length).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let (a, b) = (from.0 + share * (to.0 - from.0), from.1 + share * (to.1 - from.1));
        let even = a / last_a.max(1.0) * last_b;
        report.largest_time_shift = report.largest_time_shift.max((b - even).abs() / second.rate);
        // At both ends the time of a motion is that of its frames.
        let a = if weight == 0.0 { frame as f64 } else { a };
        let b = if weight == 1.0 { time * second.rate } else { b };
        let (row, other) = (first.row_at(a), second.row_at(b));
        rows.push(
            row.iter()
                .zip(&other)
                .map(|(a, b)| between(*a, *b, weight as f32))
                .collect(),
        );
    }
    first.with_rows(rows).write_all(scene, animation);
    Ok(report)
}

/// Pairs of frames of both motions that are the same moment, from the first of both to the last of both: dynamic time
/// warping (Sakoe and Chiba, 1978), with strictly increasing pairs.
fn align(first: &Frames, second: &Frames, carrier: &Carrier) -> Vec<(f64, f64)> {
    let picked = |frames: &Frames| -> Vec<usize> {
        let stride = frames.len().div_ceil(COMPARED).max(1);
        let mut picked: Vec<usize> = (0..frames.len()).step_by(stride).collect();
        if picked.last() != Some(&(frames.len() - 1)) {
            picked.push(frames.len() - 1);
        }
        picked
    };
    let (a, b) = (picked(first), picked(second));
    let width = b.len();
    let mut costs = vec![f32::INFINITY; a.len() * width];
    for (i, &in_a) in a.iter().enumerate() {
        for (j, &in_b) in b.iter().enumerate() {
            let own = pose_distance(first.row(in_a), second.row(in_b), carrier.column, carrier.up);
            let mut before = if i + j == 0 { 0.0 } else { f32::INFINITY };
            if i > 0 && j > 0 {
                before = costs[(i - 1) * width + j - 1];
            }
            if i > 0 {
                before = before.min(costs[(i - 1) * width + j]);
            }
            if j > 0 {
                before = before.min(costs[i * width + j - 1]);
            }
            costs[i * width + j] = before + own;
        }
    }
    let (mut i, mut j) = (a.len() - 1, b.len() - 1);
    let mut path = vec![(a[i] as f64, b[j] as f64)];
    while i + j > 0 {
        let steps = [(1, 1), (1, 0), (0, 1)]
            .into_iter()
            .filter(|(di, dj)| i >= *di && j >= *dj);
        let cost = |(di, dj): &(usize, usize)| costs[(i - di) * width + j - dj];
        let Some((di, dj)) = steps.min_by(|a, b| cost(a).total_cmp(&cost(b))) else {
            break;
        };
        (i, j) = (i - di, j - dj);
        path.push((a[i] as f64, b[j] as f64));
    }
    path.reverse();
    path
}
