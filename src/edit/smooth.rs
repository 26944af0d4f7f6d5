//! Filters fast changes out of a motion.

use std::fmt;

use glam::Vec3;
use mocap_figure::Humanoid;
use mocap_figure::convert::TimeRange;
use mocap_figure::names::node_named;
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::limits::{not_negative, positive};
use mocap_scene::math::quaternion::{exp, log, log_without_branches};
use mocap_scene::math::wide;
use mocap_scene::pose::Trs;
use mocap_scene::scene::{NodeId, Scene};
use serde::{Deserialize, Serialize};

use super::body::{figure_of, metres_per_unit};
use super::frames::{Frames, between};
use super::layer_part::LayerPart;
use super::quantity::{centimetres, degrees};
use super::step::step;
use super::window::Window;
use super::{Step, StepInput, StepKey, ValueKind};

/// A low-pass filter that does not shift the motion in time.
///
/// [`Smooth`](crate::Smooth) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum SmoothFilter {
    /// A Butterworth filter of the second order, applied forwards and backwards, as in biomechanics (Winter). An
    /// oscillation at the cut-off keeps half of its amplitude. Far above the cut-off, the amplitude falls with the
    /// fourth power of the frequency.
    #[default]
    Butterworth,
    /// A Gaussian, which never overshoots. An oscillation at the cut-off keeps half of its amplitude.
    Gaussian,
}

impl SmoothFilter {
    /// The name of the filter.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Butterworth => "butterworth",
            Self::Gaussian => "gaussian",
        }
    }

    /// The weights of the frames at a distance of 0, 1, 2, ... frames, at most `most` weights. The sum over both sides
    /// of a frame is 1.
    #[doc(hidden)]
    pub fn kernel(self, cut_off: f64, rate: f64, most: usize) -> Vec<f32> {
        use std::f64::consts::{LN_2, SQRT_2, TAU};
        let per_frame = TAU * cut_off / rate;
        let response = |frame: f64| match self {
            // The Fourier transform of 1 / (1 + (f / cut-off)^4).
            Self::Butterworth => {
                let t = per_frame * frame / SQRT_2;
                (-t).exp() * (t.cos() + t.sin())
            }
            // exp(-s^2 w^2 / 2) is 1/2 at the cut-off.
            Self::Gaussian => (-(per_frame * frame).powi(2) / (4.0 * LN_2)).exp(),
        };
        // The number of frames after which the weights stay below 1e-4.
        let reach = match self {
            Self::Butterworth => 9.5 * SQRT_2 / per_frame,
            Self::Gaussian => (4.0 * LN_2 * 9.3f64).sqrt() / per_frame,
        };
        let weights: Vec<f64> = (0..=reach.ceil() as usize)
            .take(most)
            .map(|frame| response(frame as f64))
            .collect();
        let sum = 2.0 * weights.iter().sum::<f64>() - weights[0];
        weights.into_iter().map(|weight| (weight / sum) as f32).collect()
    }
}

step! {
    /// Removes fast changes from the rotations and positions of all joints, or of chosen joints. The result does not
    /// depend on the axes of the joints, and a joint may rotate by any angle. The first and the last frame do not
    /// change. Frames outside `range` do not change, except the frames within
    /// `ease` seconds of the range.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::edit::{Smooth, Step, StepInput};
    ///
    /// let mut scene = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
    /// let report = Smooth::new().apply(&mut scene, &StepInput::new())?;
    /// assert!(report.largest_rotation > 0.1);
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// - [`Code::NoMotion`] if the scene lacks the animation
    /// - [`Code::InvalidValue`] for a cut-off that is not above 0, or is at least half of the frame rate, and for a
    ///   joint that the scene lacks
    /// - [`Code::LimitExceeded`] for a cut-off that is too far below the frame rate for a long motion
    /// - [`Code::NotHumanoid`](mocap_scene::Code::NotHumanoid) for a part of a skeleton that is no humanoid
    Smooth {
        /// The filter. Default: Butterworth.
        filter: SmoothFilter = SmoothFilter::default(), ValueKind::OneOf(&["butterworth", "gaussian"]);
        /// The cut-off frequency in Hz: the filter keeps slower changes, and removes faster ones. Default: 6, which is
        /// above the frequencies of a walk.
        cut_off: f64 = 6.0, ValueKind::Hertz;
        /// The part of the body to filter. Default: the whole body; with `joints`, only these joints.
        part: Option<LayerPart> = None, ValueKind::OneOf(LayerPart::NAMES);
        /// The joints to filter, by the name of a joint or of a bone. The step does not filter the joints below these
        /// joints. With `part`, the step filters both the part and these joints.
        joints: Vec<String> = Vec::new(), ValueKind::Names;
        /// The time range to filter. Default: the whole motion.
        range: TimeRange = TimeRange::default(), ValueKind::TimeRange;
        /// Seconds before the range during which the effect of the filter fades in, and after the range during which it
        /// fades out. Default: 0.2.
        ease: f64 = 0.2, ValueKind::Seconds;
    }
}

impl Step for Smooth {
    const NAME: &'static str = "smooth";
    const HELP: &'static str = "remove fast changes";
    const KEYS: &'static [StepKey] = Self::OPTIONS;
    const TAKES_BONES: bool = true;
    type Report = SmoothReport;

    fn change(&self, scene: &mut Scene, input: &StepInput<'_>) -> Result<SmoothReport> {
        smooth(scene, input, self)
    }
}

/// The report of [`Smooth`].
///
/// [`Smooth`](crate::Smooth) has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct SmoothReport {
    /// The largest change of a joint's rotation relative to its parent, in degrees.
    pub largest_rotation: f32,
    /// The name of the joint with `largest_rotation`.
    pub joint: String,
    /// The largest change of a joint's position relative to its parent, in metres.
    pub largest_position: f32,
}

impl fmt::Display for SmoothReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "rotations changed by {} at most ({}), positions by {} at most",
            degrees(self.largest_rotation),
            self.joint,
            centimetres(self.largest_position),
        )
    }
}

impl Smooth {
    /// The nodes to filter; `None` for all.
    fn nodes(&self, scene: &Scene, input: &StepInput<'_>) -> Result<Option<Vec<NodeId>>> {
        if self.part.is_none() && self.joints.is_empty() {
            return Ok(None);
        }
        let mut nodes = match self.part {
            Some(part) => part.joints(scene, &figure_of(scene, input.bones())?.humanoid),
            None => Vec::new(),
        };
        if !self.joints.is_empty() {
            let humanoid = input.bones().cloned().unwrap_or_else(|| Humanoid::of(scene));
            for name in &self.joints {
                nodes.push(node_named(scene, name, |bone| humanoid.joint(bone))?);
            }
        }
        Ok(Some(nodes))
    }

    /// The weights of the filter. Before its start and after its end, the motion continues as its reflection.
    fn kernel(&self, frames: &Frames) -> Result<Vec<f32>> {
        let cut_off = positive(Code::InvalidValue, "cut-off", self.cut_off)?;
        let half = 0.5 * frames.rate;
        if cut_off >= half {
            let message =
                format!("cut-off must be above 0 and below half of the frame rate, {half:.3} Hz, got {cut_off}");
            return Err(Diagnostic::new(Code::InvalidValue, message).into());
        }
        // Limits the number of weights. Weights after this number are nearly 0.
        let most = frames.len().max(1 << 16);
        let mut kernel = self.filter.kernel(cut_off.max(1e-3), frames.rate, most);
        // The reflected motion repeats after twice its length, so more weights than frames are not needed.
        kernel.truncate(frames.len());
        frames.filter_radius(kernel.len() - 1)?;
        let total = 2.0 * kernel.iter().sum::<f32>() - kernel[0];
        kernel.iter_mut().for_each(|weight| *weight /= total);
        Ok(kernel)
    }
}

fn smooth(scene: &mut Scene, input: &StepInput<'_>, options: &Smooth) -> Result<SmoothReport> {
    let animation = input.animation;
    let mut frames = Frames::new(scene, animation, &[])?;
    let kernel = options.kernel(&frames)?;
    let nodes = options.nodes(scene, input)?;
    let ease = not_negative(Code::InvalidValue, "ease", options.ease)?;
    let window = Window::new(&scene.animations[animation], &frames, options.range, [ease; 2])?;
    let weights: Vec<f32> = (0..frames.len()).map(|frame| window.weight(frame)).collect();
    let mut report = SmoothReport::default();
    let (mut rotated, mut moved) = (Vec::new(), Vec::new());
    for column in 0..frames.nodes().len() {
        let (node, track) = (frames.nodes()[column], frames.track(column));
        if nodes.as_ref().is_some_and(|nodes| !nodes.contains(&node)) {
            continue;
        }
        let rotates = track.windows(2).any(|pair| pair[0].rotation != pair[1].rotation);
        let moves = track.windows(2).any(|pair| pair[0].translation != pair[1].translation);
        let mut filtered = track.clone();
        if rotates {
            rotations(&track, &kernel, &mut filtered);
            rotated.push(node);
        }
        if moves {
            positions(&track, &kernel, &mut filtered);
            moved.push(node);
        }
        for ((old, new), weight) in track.iter().zip(&mut filtered).zip(&weights) {
            match *weight {
                0.0 => *new = *old,
                weight if weight < 1.0 => *new = between(*old, *new, weight),
                _ => {}
            }
        }
        for (old, new) in track.iter().zip(&filtered) {
            let by = log(old.rotation.inverse() * new.rotation).length().to_degrees();
            if by > report.largest_rotation {
                report.largest_rotation = by;
                report.joint.clone_from(&scene.nodes[node.index()].name);
            }
            let by = old.translation.distance(new.translation);
            report.largest_position = report.largest_position.max(by);
        }
        frames.set_track(column, &filtered);
    }
    report.largest_position *= metres_per_unit(scene, input);
    frames.write(scene, animation, &rotated, &moved);
    Ok(report)
}

/// The weighted mean of the differences between the frames around `frame` and this frame. `at` gives the difference for
/// one frame. Before the first and after the last frame, the motion continues as its point reflection.
fn mean(frame: usize, last: usize, kernel: &[f32], at: impl Fn(usize) -> Vec3) -> Vec3 {
    let (start, end) = (at(0), at(last));
    let mut sum = Vec3::ZERO;
    for (offset, weight) in kernel.iter().enumerate().skip(1) {
        let before = match frame.checked_sub(offset) {
            Some(before) => at(before),
            None => 2.0 * start - at((offset - frame).min(last)),
        };
        let after = match frame + offset {
            after if after <= last => at(after),
            after => 2.0 * end - at((2 * last).saturating_sub(after)),
        };
        sum += (before + after) * *weight;
    }
    sum
}

/// Rotates each frame by the weighted mean of the rotations from this frame to the frames around it. The mean is taken
/// in the tangent space of the frame.
fn rotations(track: &[Trs], kernel: &[f32], filtered: &mut [Trs]) {
    let padded = PaddedTrack::new(track, kernel.len() - 1);
    let [x, y, z] = change(&padded, kernel);
    for (frame, filtered) in filtered.iter_mut().enumerate() {
        let turn = exp(Vec3::new(x[frame], y[frame], z[frame]));
        filtered.rotation = (track[frame].rotation * turn).normalize();
    }
}

/// The number of frames that are filtered together, so that their lists fit in the first-level cache.
const BLOCK: usize = 256;

/// The rotations of a track, with additional rotations at both ends. Point reflections of the first and the last
/// rotations continue the track.
struct PaddedTrack {
    /// The number of additional rotations at each end.
    pad: usize,
    last: usize,
    /// The components x, y, z, w.
    components: [Vec<f32>; 4],
    /// -1 for an additional rotation, which is reflected, and 1 for any other rotation.
    sign: Vec<f32>,
}

impl PaddedTrack {
    fn new(track: &[Trs], pad: usize) -> Self {
        let last = track.len() - 1;
        let samples = 0..2 * pad + track.len();
        let frame = |sample: usize| match sample.checked_sub(pad) {
            None => (pad - sample).min(last),
            Some(frame) if frame <= last => frame,
            Some(frame) => (2 * last).saturating_sub(frame),
        };
        let component = |component: usize| {
            let values = samples
                .clone()
                .map(|sample| track[frame(sample)].rotation.to_array()[component]);
            values.collect()
        };
        let is_inside = |sample: usize| (pad..=pad + last).contains(&sample);
        let sign = |sample: usize| if is_inside(sample) { 1.0 } else { -1.0 };
        Self {
            pad,
            last,
            components: [0, 1, 2, 3].map(component),
            sign: samples.clone().map(sign).collect(),
        }
    }

    fn at(&self, frame: usize) -> [f32; 4] {
        [0, 1, 2, 3].map(|component: usize| self.components[component][self.pad + frame])
    }
}

/// The changes of all frames in their tangent spaces: x, y and z.
///
/// The rotation vector from one frame to another is the same in the tangent spaces of both, and its negative leads
/// back. So each rotation vector is computed once, for both frames.
fn change(padded: &PaddedTrack, kernel: &[f32]) -> [Vec<f32>; 3] {
    let (pad, end) = (padded.pad, padded.pad + padded.last + 1);
    let mut sums = [0, 1, 2].map(|_| vec![0.0; padded.sign.len()]);
    let mut turns = [0, 1, 2].map(|_| vec![0.0; BLOCK]);
    for block in (0..end).step_by(BLOCK) {
        for (offset, weight) in kernel.iter().enumerate().skip(1) {
            let here = block.max(pad - offset);
            let count = (block + BLOCK).min(end).saturating_sub(here);
            if count > 0 {
                differences(&mut turns, padded, here, here + offset, count);
                for (sums, turns) in sums.iter_mut().zip(&turns) {
                    add(
                        &mut sums[here..here + count],
                        turns,
                        &padded.sign[here + offset..],
                        *weight,
                    );
                    add(
                        &mut sums[here + offset..here + offset + count],
                        turns,
                        &padded.sign[here..],
                        -weight,
                    );
                }
            }
        }
    }
    let mut sums = sums.map(|sums| sums[pad..end].to_vec());
    // A point reflection is twice the value at the end minus the reflected value. `beyond` has for each distance the
    // sum of the weights of all larger distances:
    let mut beyond = kernel.to_vec();
    let mut sum = 0.0;
    for weight in beyond.iter_mut().rev() {
        sum += std::mem::replace(weight, sum);
    }
    for (end, is_start) in [(0, true), (padded.last, false)] {
        for frame in 0..=padded.last {
            let inside = if is_start { frame } else { padded.last - frame };
            let beyond = beyond.get(inside).copied().unwrap_or_default();
            if beyond > 0.0 {
                let difference = log_without_branches(difference(padded.at(frame), padded.at(end)));
                for (sum, difference) in sums.iter_mut().zip(difference) {
                    sum[frame] += 2.0 * beyond * difference;
                }
            }
        }
    }
    sums
}

wide::dispatch! {
    /// The rotation vectors from the rotations that begin at the index `here` to the rotations that begin at the index
    /// `there`.
    fn differences(turns: &mut [Vec<f32>; 3], padded: &PaddedTrack, here: usize, there: usize, count: usize) {
        let [turn_x, turn_y, turn_z] = turns;
        let (turn_x, turn_y, turn_z) = (&mut turn_x[..count], &mut turn_y[..count], &mut turn_z[..count]);
        let [x, y, z, w] = &padded.components;
        let [ax, ay, az, aw] = [&x[here..here + count], &y[here..here + count], &z[here..here + count], &w[here..here + count]];
        let [bx, by, bz, bw] =
            [&x[there..there + count], &y[there..there + count], &z[there..there + count], &w[there..there + count]];
        for i in 0..count {
            let turn = difference([ax[i], ay[i], az[i], aw[i]], [bx[i], by[i], bz[i], bw[i]]);
            let [x, y, z] = log_without_branches(turn);
            turn_x[i] = x;
            turn_y[i] = y;
            turn_z[i] = z;
        }
    }
}

wide::dispatch! {
    /// Adds each value times its sign and `weight` to the sum at the same index.
    fn add(sums: &mut [f32], values: &[f32], signs: &[f32], weight: f32) {
        for ((sum, value), sign) in sums.iter_mut().zip(values).zip(signs) {
            *sum += *value * (weight * sign);
        }
    }
}

/// The rotation from the first to the second unit quaternion: the inverse of the first times the second.
#[inline(always)]
fn difference([ax, ay, az, aw]: [f32; 4], [bx, by, bz, bw]: [f32; 4]) -> [f32; 4] {
    [
        aw * bx - ax * bw - ay * bz + az * by,
        aw * by + ax * bz - ay * bw - az * bx,
        aw * bz - ax * by + ay * bx - az * bw,
        aw * bw + ax * bx + ay * by + az * bz,
    ]
}

fn positions(track: &[Trs], kernel: &[f32], filtered: &mut [Trs]) {
    let last = track.len() - 1;
    for (frame, filtered) in filtered.iter_mut().enumerate() {
        let here = track[frame].translation;
        filtered.translation = here + mean(frame, last, kernel, |other| track[other].translation - here);
    }
}
