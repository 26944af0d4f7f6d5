//! Makes a keyframe animation: keeps the poses of chosen frames, and computes the poses between them.

use std::fmt;

use glam::{Quat, Vec3};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::math::quaternion::{exp, in_hemisphere_of, log};
use mocap_scene::pose::Trs;
use mocap_scene::scene::Scene;
use serde::{Deserialize, Serialize};

use super::body::metres_per_unit;
use super::frames::{Frames, between};
use super::quantity::{centimetres, degrees};
use super::step::step;
use super::{Step, StepInput, StepKey, ValueKind};

/// The interpolation of poses between two keys.
///
/// [`InBetween`](crate::InBetween) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum KeyInterpolation {
    /// Spherical linear interpolation of rotations, and linear interpolation of positions. The speed jumps at keys.
    Slerp,
    /// Spherical and quadrangle interpolation (Shoemake, 1987) of rotations, and Catmull-Rom curves of positions. The
    /// speed does not jump at keys. A motion of constant speed keeps this speed, even if its keys are unevenly spaced.
    #[default]
    Squad,
}

step! {
    /// Makes a keyframe animation: keeps the poses of chosen frames, the keys, and interpolates all other frames.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::edit::{InBetween, Step, StepInput};
    ///
    /// let mut scene = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
    /// let report = InBetween::new().every(100).apply(&mut scene, &StepInput::new())?;
    /// assert_eq!(report.keys, [0, 100, 200, 300, 400, 500, 523]);
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Code::NoMotion`] if the scene lacks the animation; [`Code::InvalidValue`] for a key after the last frame.
    InBetween {
        /// The frames whose poses the step keeps. It always keeps the first and the last frame, too.
        keys: Vec<usize> = Vec::new(), ValueKind::Frames;
        /// Frames whose number is a multiple of this number are also keys. Default: 0, no further keys.
        every: usize = 0, ValueKind::Count;
        /// The interpolation between keys. Default: squad, whose speed does not jump at a key. A speed that is constant
        /// over the keys stays constant.
        interpolation: KeyInterpolation = KeyInterpolation::default(), ValueKind::OneOf(&["slerp", "squad"]);
    }
}

impl Step for InBetween {
    const NAME: &'static str = "in-between";
    const HELP: &'static str = "keep key frames, compute all other frames";
    const KEYS: &'static [StepKey] = Self::OPTIONS;
    type Report = InBetweenReport;

    fn change(&self, scene: &mut Scene, input: &StepInput<'_>) -> Result<InBetweenReport> {
        in_between(scene, input, self)
    }
}

/// The report of [`InBetween`].
///
/// [`InBetween`](crate::InBetween) has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct InBetweenReport {
    /// The frames whose poses the step kept, in order.
    pub keys: Vec<usize>,
    /// The largest change of a joint's rotation relative to its parent, in degrees.
    pub largest_rotation: f32,
    /// The largest change of a joint's position relative to its parent, in metres.
    pub largest_position: f32,
}

impl fmt::Display for InBetweenReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} key frames; rotations changed by {} at most, positions by {} at most",
            self.keys.len(),
            degrees(self.largest_rotation),
            centimetres(self.largest_position),
        )
    }
}

fn in_between(scene: &mut Scene, input: &StepInput<'_>, options: &InBetween) -> Result<InBetweenReport> {
    let animation = input.animation;
    let frames = Frames::new(scene, animation, &[])?;
    let last = frames.len() - 1;
    if let Some(key) = options.keys.iter().find(|key| **key > last) {
        let message = format!("frame {key} cannot be a key: the last frame is {last}");
        return Err(Diagnostic::new(Code::InvalidValue, message).into());
    }
    let mut keys = options.keys.clone();
    keys.extend([0, last]);
    if options.every > 0 {
        keys.extend((0..=last).step_by(options.every));
    }
    keys.sort_unstable();
    keys.dedup();
    let mut rows: Vec<Vec<Trs>> = (0..frames.len()).map(|frame| frames.row(frame)).collect();
    for (first, pair) in keys.windows(2).enumerate() {
        let around = [
            keys[first.saturating_sub(1)],
            pair[0],
            pair[1],
            keys[(first + 2).min(keys.len() - 1)],
        ];
        for column in 0..frames.nodes().len() {
            let values = around.map(|key| frames.at(key, column));
            let squad = (options.interpolation == KeyInterpolation::Squad).then(|| Squad::new(values, around));
            for (offset, row) in rows[pair[0] + 1..pair[1]].iter_mut().enumerate() {
                let fraction = (offset + 1) as f32 / (pair[1] - pair[0]) as f32;
                row[column] = match &squad {
                    None => between(values[1], values[2], fraction),
                    Some(squad) => squad.at(fraction),
                };
            }
        }
    }
    let mut report = InBetweenReport {
        keys: keys.clone(),
        ..InBetweenReport::default()
    };
    for (frame, row) in rows.iter().enumerate() {
        for (old, new) in frames.row(frame).into_iter().zip(row) {
            let by = log(old.rotation.inverse() * new.rotation).length().to_degrees();
            report.largest_rotation = report.largest_rotation.max(by);
            report.largest_position = report.largest_position.max(old.translation.distance(new.translation));
        }
    }
    report.largest_position *= metres_per_unit(scene, input);
    frames.with_rows(rows).write_all(scene, animation);
    Ok(report)
}

/// The curve of one joint between the second and the third of four successive keys.
struct Squad {
    /// The rotations at both ends, and the two control rotations that shape the curve between them.
    rotations: [Quat; 2],
    controls: [Quat; 2],
    /// The positions at both ends of the curve, and the tangents: the speed at each end times the duration of the
    /// curve.
    positions: [Vec3; 2],
    tangents: [Vec3; 2],
    scales: [Vec3; 2],
}

impl Squad {
    fn new(values: [Trs; 4], keys: [usize; 4]) -> Self {
        let q = values.map(|value| value.rotation);
        // A quaternion and its negative are the same rotation. Of the two, the quaternion that is nearer to the
        // quaternion of the next key is chosen.
        let q1 = q[1];
        let (q0, q2) = (in_hemisphere_of(q1, q[0]), in_hemisphere_of(q1, q[2]));
        let q3 = in_hemisphere_of(q2, q[3]);
        // The slope at a key comes from the keys before and after it, which may be unevenly spaced. The slope is scaled
        // to the duration of this curve. The first and the last key of the motion have only one neighbour, so the curve
        // is straight there.
        let part = |before: usize, after: usize| {
            let [before, after] = [before, after].map(|index| keys[index] as f32);
            (keys[2] - keys[1]) as f32 / (after - before)
        };
        let tangent = |before: usize, after: usize| {
            (values[after].translation - values[before].translation) * part(before, after)
        };
        let turn = |from: Quat, to: Quat| log(from.inverse() * to);
        let slope = |at: Quat, [before, after]: [Quat; 2], part: f32| (turn(at, after) - turn(at, before)) * part;
        // The curve leaves q1 with the slope turn(q1, q2) + 2 log(q1^-1 control). If keys are evenly spaced, the
        // controls are Shoemake's.
        let whole = turn(q1, q2);
        let leaving = 0.5 * (slope(q1, [q0, q2], part(0, 2)) - whole);
        let arriving = 0.5 * (whole - slope(q2, [q1, q3], part(1, 3)));
        Self {
            rotations: [q1, q2],
            controls: [(q1 * exp(leaving)).normalize(), (q2 * exp(arriving)).normalize()],
            positions: [values[1].translation, values[2].translation],
            tangents: [tangent(0, 2), tangent(1, 3)],
            scales: [values[1].scale, values[2].scale],
        }
    }

    fn at(&self, fraction: f32) -> Trs {
        let [along, beside] = [self.rotations, self.controls].map(|[from, to]| from.slerp(to, fraction));
        let (t, t2, t3) = (fraction, fraction * fraction, fraction * fraction * fraction);
        Trs {
            translation: self.positions[0] * (2.0 * t3 - 3.0 * t2 + 1.0)
                + self.positions[1] * (3.0 * t2 - 2.0 * t3)
                + self.tangents[0] * (t3 - 2.0 * t2 + t)
                + self.tangents[1] * (t3 - t2),
            rotation: along.slerp(beside, 2.0 * fraction * (1.0 - fraction)).normalize(),
            scale: self.scales[0].lerp(self.scales[1], fraction),
        }
    }
}
