//! Removes spikes: runs of a few frames that jump away from the motion.

use std::fmt;

use mocap_scene::error::{Code, Result};
use mocap_scene::limits::{not_negative, positive};
use mocap_scene::math::median::median;
use mocap_scene::math::quaternion::log;
use mocap_scene::pose::Trs;
use mocap_scene::scene::{NodeId, Scene};
use serde::Serialize;

use super::flips;
use super::frames::Frames;
use super::quantity::{counted, degrees};
use super::step::step;
use super::{Step, StepInput, StepKey, ValueKind};

step! {
    /// Replaces spikes. A spike is a rotation or a position that jumps away for a few frames and comes back. The new
    /// values are interpolated between the frames before and after the spike.
    ///
    /// Hampel's identifier finds spikes. It measures the distance of each value from the middle of the two values `n`
    /// frames before and after, for each `n` up to the longest spike. In a spike, this distance is above `threshold`
    /// times the median of these distances in the frames around. A bone may also jump, keep its new rotation for
    /// longer, and jump back: the step rotates these frames back. A bone may also roll suddenly and never roll back:
    /// the step spreads the roll over 0.4 s, and the joints below keep their positions.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::edit::{Despike, Step, StepInput};
    ///
    /// let mut scene = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
    /// let report = Despike::new().longest(2).apply(&mut scene, &StepInput::new())?;
    /// assert_eq!(report.joints, ["LeftToeBase"]); // which jumps by 7 degrees for a frame, three times
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// - [`Code::NoMotion`] if the scene lacks the animation
    /// - [`Code::InvalidValue`] for a number that is not finite or is negative
    /// - [`Code::LimitExceeded`] for a spike that is too long to look for in a long motion
    Despike {
        /// The smallest distance of a spike from the frames before and after it, as a multiple of the median of such
        /// distances in the frames around. Default: 8.
        threshold: f64 = 8.0, ValueKind::Factor;
        /// The smallest jump of a rotation, in degrees. Default: 3.
        angle: f64 = 3.0, ValueKind::Degrees;
        /// The smallest jump of a position, as a fraction of the total length of all bones. Default: 0.02.
        distance: f64 = 0.02, ValueKind::Fraction;
        /// The longest spike, in frames. Default: 3.
        longest: usize = 3, ValueKind::Count;
    }
}

impl Step for Despike {
    const NAME: &'static str = "despike";
    const HELP: &'static str = "remove spikes, which jump away and back";
    const KEYS: &'static [StepKey] = Self::OPTIONS;
    type Report = DespikeReport;

    fn change(&self, scene: &mut Scene, input: &StepInput<'_>) -> Result<DespikeReport> {
        despike(scene, input.animation, self)
    }
}

/// The report of [`Despike`].
///
/// [`Despike`](crate::Despike) has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct DespikeReport {
    /// The number of values that the step replaced. A value is the rotation or the position of one joint in one frame.
    pub replaced: usize,
    /// The frames with replaced values, in order.
    pub frames: Vec<usize>,
    /// The joints with replaced values, in the order of the scene.
    pub joints: Vec<String>,
    /// The largest removed jump of a rotation, in degrees.
    pub largest_rotation: f32,
}

impl fmt::Display for DespikeReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} replaced, in {} of {}; a rotation jumped by {} at most",
            counted(self.replaced, "value"),
            counted(self.frames.len(), "frame"),
            counted(self.joints.len(), "joint"),
            degrees(self.largest_rotation),
        )
    }
}

/// The number of frames on either side of a frame that show how much a track usually changes.
const AROUND: usize = 15;

fn despike(scene: &mut Scene, animation: usize, options: &Despike) -> Result<DespikeReport> {
    positive(Code::InvalidValue, "threshold", options.threshold)?;
    not_negative(Code::InvalidValue, "angle", options.angle)?;
    not_negative(Code::InvalidValue, "distance", options.distance)?;
    let mut frames = Frames::new(scene, animation, &[])?;
    // The work grows with the square of the longest spike, so the square is limited.
    frames.filter_radius(options.longest.min(frames.len()).saturating_pow(2))?;
    let before = frames.clone();
    let flipped = flips::mend_all(scene, &mut frames, false);
    let size = scene
        .nodes
        .iter()
        .map(|node| node.transform.w_axis.truncate().length())
        .sum::<f32>();
    let mut report = DespikeReport::default();
    let mut in_frame = vec![false; frames.len()];
    let (mut rotated, mut moved) = (Vec::<NodeId>::new(), Vec::<NodeId>::new());
    for column in 0..frames.nodes().len() {
        let (node, mut track) = (frames.nodes()[column], frames.track(column));
        let (old, flipped) = (before.track(column), &flipped[column].frames);
        let least = (options.angle as f32).to_radians();
        let by_angle = |a: &Trs, b: &Trs| log(a.rotation.inverse() * b.rotation).length();
        let turned = spikes(&track, options, least, by_angle, |a, b| Trs {
            rotation: a.rotation.slerp(b.rotation, 0.5),
            ..*a
        });
        let by_length = |a: &Trs, b: &Trs| a.translation.distance(b.translation);
        let middle = |a: &Trs, b: &Trs| Trs {
            translation: a.translation.midpoint(b.translation),
            ..*a
        };
        let shifted = spikes(&track, options, options.distance as f32 * size, by_length, middle);
        bridge(&mut track, &turned, |at, before, after, fraction| {
            at.rotation = before.rotation.slerp(after.rotation, fraction);
        });
        bridge(&mut track, &shifted, |at, before, after, fraction| {
            at.translation = before.translation.lerp(after.translation, fraction);
        });
        let is_flipped = |frame: usize| flipped.get(frame).copied().unwrap_or_default();
        let turned: Vec<bool> = (0..track.len())
            .map(|frame| turned[frame] || is_flipped(frame))
            .collect();
        for (frame, (turned, shifted)) in turned.iter().zip(&shifted).enumerate() {
            in_frame[frame] |= *turned || *shifted;
            report.replaced += usize::from(*turned) + usize::from(*shifted);
            report.largest_rotation = report
                .largest_rotation
                .max(by_angle(&old[frame], &track[frame]).to_degrees());
        }
        let (turns, shifts) = (turned.contains(&true), shifted.contains(&true));
        rotated.extend(turns.then_some(node));
        moved.extend(shifts.then_some(node));
        if turns || shifts {
            report.joints.push(scene.nodes[node.index()].name.clone());
            frames.set_track(column, &track);
        }
    }
    report.frames = (0..frames.len()).filter(|frame| in_frame[*frame]).collect();
    frames.write(scene, animation, &rotated, &moved);
    Ok(report)
}

/// For each frame of a track, whether the frame belongs to a spike.
fn spikes(
    track: &[Trs],
    options: &Despike,
    least: f32,
    distance: impl Fn(&Trs, &Trs) -> f32,
    middle: impl Fn(&Trs, &Trs) -> Trs,
) -> Vec<bool> {
    let mut found = vec![false; track.len()];
    if track.len() < 5 || track.windows(2).all(|pair| distance(&pair[0], &pair[1]) == 0.0) {
        return found;
    }
    for span in 1..=options.longest.min((track.len() - 1) / 2) {
        let off = |frame: usize| match (frame.checked_sub(span), track.get(frame + span)) {
            (Some(before), Some(after)) => distance(&track[frame], &middle(&track[before], after)),
            _ => 0.0,
        };
        let offs: Vec<f32> = (0..track.len()).map(off).collect();
        for frame in (span..track.len() - span).filter(|frame| offs[*frame] > least) {
            let from = frame.saturating_sub(AROUND);
            let mut around = offs[from..(frame + AROUND + 1).min(offs.len())].to_vec();
            let usual = median(&mut around).unwrap_or(0.0);
            // In the frame next to a spike, the distance is about half of the distance in the spike. So only the
            // largest distance counts.
            let highest = offs[frame - span..=frame + span].iter().copied().fold(0.0, f32::max);
            let is_peak = offs[frame] >= 0.75 * highest;
            // A spike comes back: the values before and after are nearer to each other than to the spike.
            let comes_back = distance(&track[frame - span], &track[frame + span]) < offs[frame];
            found[frame] |= f64::from(offs[frame]) > options.threshold * f64::from(usual) && is_peak && comes_back;
        }
    }
    found
}

/// Replaces every run of marked frames by values that are interpolated between the frame before and the frame after the
/// run.
fn bridge(track: &mut [Trs], marked: &[bool], mut set: impl FnMut(&mut Trs, Trs, Trs, f32)) {
    let mut frame = 1;
    while frame + 1 < track.len() {
        let end = (frame..track.len())
            .find(|frame| !marked[*frame])
            .unwrap_or(track.len());
        if end > frame && end < track.len() {
            let (before, after) = (track[frame - 1], track[end]);
            for (index, trs) in track[frame..end].iter_mut().enumerate() {
                let fraction = (index + 1) as f32 / (end + 1 - frame) as f32;
                set(trs, before, after, fraction);
            }
        }
        frame = end.max(frame) + 1;
    }
}
