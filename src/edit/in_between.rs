//! Keyframe animation: keeps the poses of chosen frames, and computes those between them.

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::body::metres_per_unit;
use super::frames::{Frames, between};
use crate::error::{Code, Diagnostic, Result};
use crate::math::quaternion::{exp, in_hemisphere_of, log};
use crate::pose::Trs;
use crate::scene::Scene;

/// How poses between two keys are computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum KeyInterpolation {
    /// Spherical linear interpolation of rotations, and lines of positions: the speed jumps at keys.
    Slerp,
    /// Spherical and quadrangle interpolation (Shoemake, 1987) of rotations, and Catmull-Rom curves of positions: the speed
    /// is continuous.
    #[default]
    Squad,
}

/// Options of [`in_between()`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct InBetweenOptions {
    /// The frames whose poses stay. The first and the last frame always do.
    pub keys: Vec<usize>,
    /// Every so many frames stay, besides those. Default: 0, no others.
    pub every: usize,
    /// How the others are computed.
    pub interpolation: KeyInterpolation,
}

/// What [`in_between()`] changed.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct InBetweenReport {
    /// The frames that stayed, in order.
    pub keys: Vec<usize>,
    /// The largest change of a rotation to its parent, in degrees.
    pub largest_rotation: f32,
    /// The largest change of a position to its parent, in metres.
    pub largest_position: f32,
}

/// Replaces the frames of `animation`, an index into the animations of `scene`, by what lies between chosen ones.
///
/// # Errors
/// [`Code::NoMotion`] without this animation; [`Code::UnknownOption`] for a key after the last frame.
pub fn in_between(scene: &mut Scene, animation: usize, options: &InBetweenOptions) -> Result<InBetweenReport> {
    let frames = Frames::new(scene, animation, &[])?;
    let last = frames.len() - 1;
    if let Some(key) = options.keys.iter().find(|key| **key > last) {
        let message = format!("frame {key} cannot be a key: the last frame is {last}");
        return Err(Diagnostic::new(Code::UnknownOption, message).into());
    }
    let mut keys = options.keys.clone();
    keys.extend([0, last]);
    if options.every > 0 {
        keys.extend((0..=last).step_by(options.every));
    }
    keys.sort_unstable();
    keys.dedup();
    let mut rows: Vec<Vec<Trs>> = (0..frames.len()).map(|frame| frames.row(frame).to_vec()).collect();
    for (place, pair) in keys.windows(2).enumerate() {
        let around = [
            keys[place.saturating_sub(1)],
            pair[0],
            pair[1],
            keys[(place + 2).min(keys.len() - 1)],
        ];
        for (offset, row) in rows[pair[0] + 1..pair[1]].iter_mut().enumerate() {
            let share = (offset + 1) as f32 / (pair[1] - pair[0]) as f32;
            for (column, trs) in row.iter_mut().enumerate() {
                let values = around.map(|key| frames.row(key)[column]);
                *trs = match options.interpolation {
                    KeyInterpolation::Slerp => between(values[1], values[2], share),
                    KeyInterpolation::Squad => squad(values, around, share),
                };
            }
        }
    }
    let mut report = InBetweenReport {
        keys: keys.clone(),
        ..InBetweenReport::default()
    };
    for (frame, row) in rows.iter().enumerate() {
        for (old, new) in frames.row(frame).iter().zip(row) {
            let by = log(old.rotation.inverse() * new.rotation).length().to_degrees();
            report.largest_rotation = report.largest_rotation.max(by);
            report.largest_position = report.largest_position.max(old.translation.distance(new.translation));
        }
    }
    report.largest_position *= metres_per_unit(scene);
    frames.with_rows(rows).write_all(scene, animation);
    Ok(report)
}

/// Between the second and the third of four keys.
fn squad(values: [Trs; 4], keys: [usize; 4], share: f32) -> Trs {
    let q = values.map(|value| value.rotation);
    // On the shorter way from each to the next.
    let q1 = q[1];
    let (q0, q2) = (in_hemisphere_of(q1, q[0]), in_hemisphere_of(q1, q[2]));
    let q3 = in_hemisphere_of(q2, q[3]);
    let control = |before: glam::Quat, at: glam::Quat, after: glam::Quat| {
        let inverse = at.inverse();
        (at * exp((log(inverse * before) + log(inverse * after)) * -0.25)).normalize()
    };
    let (a, b) = (control(q0, q1, q2), control(q1, q2, q3));
    let rotation = q1
        .slerp(q2, share)
        .slerp(a.slerp(b, share), 2.0 * share * (1.0 - share));
    // A cubic with the slopes between the neighbours of each key, which need not be evenly apart.
    let slope = |before: usize, after: usize, get: fn(&Trs) -> Vec3| {
        let [from, to] = [before, after].map(|index| keys[index] as f32);
        if to > from {
            (get(&values[after]) - get(&values[before])) / (to - from)
        } else {
            Vec3::ZERO
        }
    };
    let steps = (keys[2] - keys[1]) as f32;
    let cubic = |get: fn(&Trs) -> Vec3| {
        let (t, t2, t3) = (share, share * share, share * share * share);
        get(&values[1]) * (2.0 * t3 - 3.0 * t2 + 1.0)
            + get(&values[2]) * (3.0 * t2 - 2.0 * t3)
            + (slope(0, 2, get) * (t3 - 2.0 * t2 + t) + slope(1, 3, get) * (t3 - t2)) * steps
    };
    Trs {
        translation: cubic(|trs| trs.translation),
        rotation: rotation.normalize(),
        scale: values[1].scale.lerp(values[2].scale, share),
    }
}
