//! Mixes two motions.

mod path;

use std::fmt;
use std::ops::RangeInclusive;

use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::pose::Trs;
use mocap_scene::scene::Scene;
use serde::{Deserialize, Serialize};

use self::path::Path;
use super::alike::Alikeness;
use super::body::metres_per_unit;
use super::carrier::Carrier;
use super::fit::Fit;
use super::frames::{Frames, lost_weights};
use super::pair::pair;
use super::pose_distance::Poses;
use super::quantity::centimetres;
use super::step::step;
use super::{Step, StepInput, StepKey, ValueKind};

step! {
    /// Mixes a motion with a second motion, which has the same joints. Weight 0 gives the first motion, weight 1 the
    /// second motion. Dynamic time warping aligns the poses of both motions in time. So the step mixes two footsteps at
    /// the same phase. The duration is the weighted mean of both durations. The step mixes movements over the ground
    /// relative to the heading of each figure: two walks in different directions give a walk in a direction between
    /// them. The scene gets the warning `poses-apart` if two mixed poses differ by more than 45 degrees or 30
    /// cm. This comparison ignores position and heading over the ground. With `within`, the step drops frames at the
    /// beginning of one motion and at the end of one motion, so that both motions begin and end in similar poses. To
    /// compare two frames, it uses the distance of [motion graphs](crate::graph), over a third of a second around each
    /// frame. With `within`, the second motion also begins at the position and in the heading of the first motion.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::edit::{Blend, BlendWeight, Step, StepInput};
    ///
    /// let mut scene = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
    /// let other = scene.clone();
    /// // From the first motion to the second, from 1 s to 2 s.
    /// let blend = Blend::new().weight(BlendWeight::Curve(vec![(1.0, 0.0), (2.0, 1.0)]));
    /// let report = blend.apply(&mut scene, &StepInput::new().other(&other))?;
    /// assert_eq!(report.frames, 524);
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Code::InvalidValue`] if the joints differ, a weight is not from 0 to 1, or `within` is not from 0 to 10 s;
    /// [`Code::NoMotion`] if one of the animations is missing.
    Blend {
        /// The number of the second motion among the inputs of a command, from 2. Default: the next one.
        with: Option<usize> = None, ValueKind::Input;
        /// The fraction of the second motion: one number, or pairs of a time and a fraction. Default: 0.5 all the time.
        weight: BlendWeight = BlendWeight::Constant(0.5), ValueKind::Weights;
        /// The step searches this many seconds at the beginning and at the end of both motions for the most similar
        /// frames. Default: 0, which mixes both motions completely.
        within: f64 = 0.0, ValueKind::Seconds;
    }
}

impl Step for Blend {
    const NAME: &'static str = "blend";
    const HELP: &'static str = "mix with the next input, or the input number N, aligned in time";
    const KEYS: &'static [StepKey] = Self::OPTIONS;
    const TAKES_OTHER: bool = true;
    type Report = BlendReport;

    fn change(&self, scene: &mut Scene, input: &StepInput<'_>) -> Result<BlendReport> {
        blend(scene, input, input.second::<Self>()?, self)
    }

    fn with(&self) -> Option<usize> {
        self.with
    }
}

/// The report of [`Blend`].
///
/// [`Blend`](crate::Blend) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct BlendReport {
    /// The number of frames after the step.
    pub frames: usize,
    /// The largest time shift by the alignment, in seconds: relative to a second motion that is evenly stretched to the
    /// duration of the first motion.
    pub largest_time_shift: f64,
    /// The seconds that the step dropped from the beginning of the first motion and from the beginning of the second
    /// motion.
    pub left_out_before: [f64; 2],
    /// The seconds that the step dropped from the end of the first motion and from the end of the second motion.
    pub left_out_after: [f64; 2],
    /// The mean distance in metres between the joints of the first motion and the joints of the second motion, at the
    /// beginning and at the end. `None` if the option `within` is 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub apart: Option<[f32; 2]>,
}

impl fmt::Display for BlendReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} frames; aligned by time shifts of at most {:.2} s",
            self.frames, self.largest_time_shift,
        )?;
        let Some(apart) = self.apart else { return Ok(()) };
        for (part, left_out, apart) in [
            ("beginning", self.left_out_before, apart[0]),
            ("end", self.left_out_after, apart[1]),
        ] {
            write!(
                f,
                "; at the {part}, {:.2} s of the first and {:.2} s of the second were dropped, and joints are {} apart",
                left_out[0],
                left_out[1],
                centimetres(apart),
            )?;
        }
        Ok(())
    }
}

/// The fraction of the second motion in a mix: 0 gives the first motion, 1 the second.
///
/// [`Blend`](crate::Blend) has an example.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged)]
#[non_exhaustive]
pub enum BlendWeight {
    /// One weight for the whole motion.
    Constant(f64),
    /// Pairs of a time in the result, in seconds, and the weight at this time. The times increase. The weight is linear
    /// between two times, and constant before the first and after the last.
    Curve(Vec<(f64, f64)>),
}

impl From<f64> for BlendWeight {
    fn from(weight: f64) -> Self {
        Self::Constant(weight)
    }
}

impl BlendWeight {
    fn check(&self) -> Result<()> {
        let refuse = |message: String| Err(Diagnostic::new(Code::InvalidValue, message).into());
        let is_weight = |weight: &f64| (0.0..=1.0).contains(weight);
        match self {
            Self::Constant(weight) if !is_weight(weight) => refuse(format!("weight must be from 0 to 1, got {weight}")),
            Self::Constant(_) => Ok(()),
            Self::Curve(points) => {
                if points.is_empty() {
                    return refuse("a curve of weights must have at least one point, got 0".to_owned());
                }
                if let Some((time, weight)) = points.iter().find(|(_, weight)| !is_weight(weight)) {
                    return refuse(format!("weight must be from 0 to 1, got {weight} at {time} s"));
                }
                let increase = points.windows(2).all(|pair| pair[0].0 < pair[1].0);
                if !increase || !points.iter().all(|(time, _)| time.is_finite() && *time >= 0.0) {
                    let times: Vec<f64> = points.iter().map(|(time, _)| *time).collect();
                    return refuse(format!(
                        "the times of a curve of weights must be finite, at least 0, and in increasing order, \
                         got {times:?}"
                    ));
                }
                Ok(())
            }
        }
    }

    /// The weight at a time in seconds.
    fn at(&self, time: f64) -> f64 {
        let points = match self {
            Self::Constant(weight) => return *weight,
            Self::Curve(points) => points,
        };
        let after = points.partition_point(|point| point.0 <= time);
        match (after.checked_sub(1).map(|before| points[before]), points.get(after)) {
            (Some((from, weight)), Some((to, next))) => weight + (next - weight) * (time - from) / (to - from),
            (Some((_, weight)), None) | (None, Some(&(_, weight))) => weight,
            (None, None) => 0.0,
        }
    }
}

/// The largest number of frames of a motion that are compared to align it. A longer motion is sampled evenly.
const COMPARED: usize = 160;

/// Cuts both motions at the frames where they are most similar. Moves and turns the second motion so that it begins at
/// the position and the heading of the first motion.
fn parts_alike<'a>(
    alikeness: &Alikeness,
    (first, second): (&Frames<'a>, &Frames<'a>),
    carrier: &Carrier,
) -> (Frames<'a>, Frames<'a>, BlendReport) {
    let (beginning, end) = (alikeness.beginning(), alikeness.end());
    let mut report = BlendReport {
        apart: Some([beginning.apart, end.apart]),
        ..BlendReport::default()
    };
    let mut part = |frames: &Frames, motion: usize| {
        let last = frames.len() - 1;
        let frame = |seconds: f64| ((seconds * frames.rate).round() as usize).min(last);
        let (from, to) = (frame(beginning.at[motion]), frame(end.at[motion]));
        report.left_out_before[motion] = from as f64 / frames.rate;
        report.left_out_after[motion] = (last - to) as f64 / frames.rate;
        from..=to
    };
    let (own, other) = (part(first, 0), part(second, 1));
    let rows = |frames: &Frames, part: &RangeInclusive<usize>| -> Vec<Vec<Trs>> {
        part.clone().map(|frame| frames.row(frame)).collect()
    };
    let (rows, mut others) = (rows(first, &own), rows(second, &other));
    let placement = carrier.placement(&others[0], &rows[0]);
    others.iter_mut().for_each(|row| carrier.apply(&placement, row));
    let cut = |frames: &Frames<'a>, rows, part: RangeInclusive<usize>| {
        let taken: Vec<_> = part.map(|frame| (frames, frame as f64)).collect();
        frames.with_rows_of(rows, &taken)
    };
    (cut(first, rows, own), cut(second, others, other), report)
}

fn blend(scene: &mut Scene, input: &StepInput<'_>, other: &Scene, options: &Blend) -> Result<BlendReport> {
    let weight = &options.weight;
    weight.check()?;
    let animation = input.animation;
    let (mut first, mut second) = pair(scene, animation, other)?;
    let carrier = Carrier::new(scene, &first);
    carrier.share_parents(scene, &first, &mut second);
    let mut report = BlendReport::default();
    if let Some(alikeness) = Alikeness::new(scene, input, other, &first, options.within)? {
        (first, second, report) = parts_alike(&alikeness, (&first, &second), &carrier);
    }
    let path = align(&first, &second, &carrier);
    let mut ground = Path::new(&carrier);
    let times = times(&path, weight, [first.rate, second.rate]);
    let (last_a, last_b) = ((first.len() - 1) as f64, (second.len() - 1) as f64);
    let count = first.up_to(times[times.len() - 1] * first.rate + 1e-6, &[&second])?;
    let mut rows: Vec<Vec<Trs>> = Vec::with_capacity(count);
    let mut taken = Vec::with_capacity(count);
    let mut piece = 0;
    let mut fit = Fit::new(scene, &first, metres_per_unit(scene, input));
    report.frames = count;
    for frame in 0..count {
        let time = frame as f64 / first.rate;
        while piece + 2 < path.len() && times[piece + 1] < time {
            piece += 1;
        }
        let next = (piece + 1).min(path.len() - 1);
        let (from, to) = (path[piece], path[next]);
        let length = times[next] - times[piece];
        let fraction = if length > 0.0 {
            ((time - times[piece]) / length).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let (a, b) = (from.0 + fraction * (to.0 - from.0), from.1 + fraction * (to.1 - from.1));
        let even = a / last_a.max(1.0) * last_b;
        report.largest_time_shift = report.largest_time_shift.max((b - even).abs() / second.rate);
        // With a constant weight of 0 or 1, the result has only one motion. Its frames are taken at even times, without
        // time warping.
        let (a, b) = match weight {
            BlendWeight::Constant(0.0) => (frame as f64, b),
            BlendWeight::Constant(1.0) => (a, time * second.rate),
            _ => (whole(a), whole(b)),
        };
        taken.push((a, b, weight.at(time) as f32));
        rows.push(match weight {
            BlendWeight::Constant(0.0) => first.row_at(a),
            BlendWeight::Constant(1.0) => second.row_at(b),
            weight => {
                let weight = weight.at(time) as f32;
                let (row, other) = (first.row_at(a), second.row_at(b));
                if weight > 0.0 && weight < 1.0 {
                    fit.see_poses(&carrier, &row, &other, frame);
                }
                ground.mix(&row, &other, weight)
            }
        });
    }
    let warning = fit.warning(
        Blend::NAME,
        "search for similar frames with within=0.5 or a larger value, or choose more similar motions",
    );
    let mut mixed = first.with_rows(rows);
    mixed.mix_weights((&first, &second), &taken);
    mixed.write_all(scene, animation);
    scene
        .warnings
        .extend(warning.into_iter().chain(lost_weights(scene, other)));
    Ok(report)
}

/// The time in the result, in seconds, of each pair of frames of the alignment. `path` has these pairs, and `rates` has
/// the frame rates of both motions.
fn times(path: &[(f64, f64)], weight: &BlendWeight, rates: [f64; 2]) -> Vec<f64> {
    let mut times = vec![0.0];
    for pair in path.windows(2) {
        let last = times[times.len() - 1];
        let fraction = weight.at(last);
        let by_first = (pair[1].0 - pair[0].0) / rates[0];
        let by_second = (pair[1].1 - pair[0].1) / rates[1];
        times.push(last + (1.0 - fraction) * by_first + fraction * by_second);
    }
    times
}

/// Rounds a frame number that differs from a whole number only by the rounding of a sum.
fn whole(frame: f64) -> f64 {
    if (frame - frame.round()).abs() < 1e-6 {
        frame.round()
    } else {
        frame
    }
}

/// Pairs corresponding frames of both motions, from the first frames to the last frames. The method is dynamic time
/// warping (Sakoe and Chiba, 1978). From pair to pair, both frame numbers increase.
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
    let poses = Poses::new(first, &a, carrier, None);
    let others = Poses::new(second, &b, carrier, None);
    let width = b.len();
    let mut costs = vec![f32::INFINITY; a.len() * width];
    for i in 0..a.len() {
        for (j, own) in others.distances(&poses, i).into_iter().enumerate() {
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
