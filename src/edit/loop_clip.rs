//! Cuts a motion to a loop.

mod level;

use std::fmt;

use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::limits::{not_negative, positive};
use mocap_scene::pose::{Pose, Trs};
use mocap_scene::scene::{NodeId, Scene};
use serde::Serialize;

use super::body::{figure_of, metres_per_unit};
use super::carrier::Carrier;
use super::contacts::{ContactOptions, DetectedContacts, detect};
use super::frames::Frames;
use super::inertia::{self, Seam};
use super::pose_distance::Poses;
use super::quantity::{degrees, metres};
use super::step::step;
use super::{Step, StepInput, StepKey, ValueKind};

step! {
    /// Cuts a motion to a loop. Without `frames`, the loop starts and ends at the two frames whose poses, speeds and
    /// foot contacts match best. The last frame equals the first frame, except for the position over the ground. Joint
    /// velocities are continuous at the seam, where the loop starts again.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::edit::{Loop, Step, StepInput};
    ///
    /// let mut scene = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
    /// let report = Loop::new().in_place(true).apply(&mut scene, &StepInput::new())?;
    /// assert!(report.first < report.last && report.distance < 0.01);
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Code::NoMotion`] if the scene lacks the animation; [`Code::InvalidValue`] if the motion is too short for a
    /// loop, or an option is not valid.
    Loop {
        /// The first and the last frame of the loop. Default: the two frames that match best.
        frames: Option<[usize; 2]> = None, ValueKind::FrameRange;
        /// The shortest loop to look for, in seconds. Default: 0.6.
        shortest: f64 = 0.6, ValueKind::Seconds;
        /// The longest loop to look for, in seconds. Default: 4.
        longest: f64 = 4.0, ValueKind::Seconds;
        /// Seconds after the seam during which the difference between the first and the last pose fades out. Default:
        /// 0.3.
        blend: f64 = 0.3, ValueKind::Seconds;
        /// Whether the loop stays in place instead of travelling over the ground from cycle to cycle. Default: `false`.
        in_place: bool = false, ValueKind::Flag;
    }
}

impl Step for Loop {
    const NAME: &'static str = "loop";
    const HELP: &'static str = "cut to a loop between two frames, by default the two that match best";
    const KEYS: &'static [StepKey] = Self::OPTIONS;
    const TAKES_BONES: bool = true;
    type Report = LoopReport;

    fn change(&self, scene: &mut Scene, input: &StepInput<'_>) -> Result<LoopReport> {
        loop_clip(scene, input, self)
    }
}

/// The report of [`Loop`].
///
/// [`Loop`](crate::Loop) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct LoopReport {
    /// The number of the first frame of the loop in the motion before the step.
    pub first: usize,
    /// The number of the last frame of the loop in the motion before the step.
    pub last: usize,
    /// The largest difference between the rotations of a joint at both ends of the loop, in degrees. The step fades it
    /// out.
    pub largest_rotation: f32,
    /// The distance that the figure moves over the ground in one cycle of the loop, in metres. It is 0 if the loop
    /// stays in place.
    pub distance: f32,
    /// Whether the same feet are on the ground in the first and in the last frame of the loop.
    pub contacts_agree: bool,
}

impl fmt::Display for LoopReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let feet = match self.contacts_agree {
            true => "the same feet are",
            false => "different feet are",
        };
        write!(
            f,
            "from frame {} to frame {}; rotations changed by {} at most after the seam; {} over the ground per cycle; {feet} on the \
             ground at both ends",
            self.first,
            self.last,
            degrees(self.largest_rotation),
            metres(self.distance),
        )
    }
}

/// The largest number of frames that are compared to find the best cut. A longer motion is sampled evenly.
const CANDIDATES: usize = 200;

/// A cut in calmer frames is preferred if the squared distance of its two poses is at most this multiple of the
/// smallest squared distance.
const CALM: f32 = 3.0;

/// The approximate number of frames of a cycle that are examined to find a cut in calmer frames.
const MOMENTS: usize = 60;

fn loop_clip(scene: &mut Scene, input: &StepInput<'_>, options: &Loop) -> Result<LoopReport> {
    positive(Code::InvalidValue, "shortest", options.shortest)?;
    positive(Code::InvalidValue, "longest", options.longest)?;
    not_negative(Code::InvalidValue, "blend", options.blend)?;
    let animation = input.animation;
    let frames = Frames::new(scene, animation, &[])?;
    frames.require_nodes()?;
    let refused = |message: String| Err(Diagnostic::new(Code::InvalidValue, message).into());
    let carrier = Carrier::new(scene, &frames);
    let contacts = figure_of(scene, input.bones())
        .ok()
        .map(|figure| detect(scene, &frames, &figure, &ContactOptions::default()));
    if options.frames.is_none() && options.longest < options.shortest {
        return refused(format!(
            "the longest loop, {} s, must not be shorter than the shortest, {} s",
            options.longest, options.shortest
        ));
    }
    let found = match options.frames {
        Some([first, last]) => Some((first, last)),
        None => best(scene, &frames, &carrier, contacts.as_ref(), options),
    };
    let Some((first, last)) = found else {
        let seconds = (frames.len() - 1) as f64 / frames.rate;
        return refused(format!(
            "the motion of {seconds:.3} s is too short for a loop of {} s",
            options.shortest
        ));
    };
    if first + 2 > last || last >= frames.len() {
        return refused(format!(
            "a loop from frame {first} to frame {last} is not possible: the motion has frames 0 to {}",
            frames.len() - 1
        ));
    }
    let mut rows: Vec<Vec<Trs>> = (first..=last).map(|frame| frames.row(frame)).collect();
    let count = rows.len();
    // The last pose, moved to the start of the next cycle.
    let onward = carrier.placement(&rows[0], &rows[count - 1]);
    let next = match last + 1 < frames.len() {
        true => frames.row(last + 1),
        false => inertia::onward([&rows[count - 3], &rows[count - 2], &rows[count - 1]]),
    };
    let mut old = [rows[count - 1].clone(), next];
    old.iter_mut().for_each(|row| carrier.apply(&onward.inverse(), row));
    let seam = Seam::new([&old[0], &old[1]], [&rows[0], &rows[1]]);
    let steps = frames.frames_in(options.blend).min(count - 1);
    for (frame, row) in rows.iter_mut().enumerate().take(steps) {
        seam.apply(row, frame, steps);
    }
    level::level(scene, &frames, &mut rows, |row, is_back| {
        carrier.apply(&if is_back { onward.inverse() } else { onward }, row);
    });
    if options.in_place {
        for (frame, row) in rows.iter_mut().enumerate() {
            let part = onward.part(frame as f32 / (count - 1) as f32);
            carrier.apply(&part.inverse(), row);
        }
    }
    let report = LoopReport {
        first,
        last,
        largest_rotation: seam.largest_rotation(),
        distance: if options.in_place {
            0.0
        } else {
            onward.distance() * metres_per_unit(scene, input)
        },
        contacts_agree: contacts.is_some_and(|contacts| agree(&contacts, first, last)),
    };
    let taken: Vec<_> = (first..=last).map(|frame| (&frames, frame as f64)).collect();
    let mut changed = frames.with_rows_of(rows, &taken);
    changed.fade_weights(0, [(&frames, last as f64), (&frames, first as f64)], steps);
    changed.write_all(scene, animation);
    Ok(report)
}

/// The sum of the squared speeds of the joints at a frame, relative to the joint that carries the figure. A seam is
/// least visible in a frame with a small sum, for example with both feet on the ground.
fn squared_speeds(scene: &Scene, frames: &Frames, carrier: NodeId, frame: usize) -> f32 {
    let pose_at = |frame: usize| {
        let mut pose = Pose::rest(scene);
        frames.pose(frame.min(frames.len() - 1), &mut pose);
        pose
    };
    let (from, to) = (pose_at(frame), pose_at(frame + 1));
    let step = |node: NodeId| to.position(node) - from.position(node);
    let nodes = (0..scene.nodes.len()).map(NodeId::new);
    nodes.map(|node| (step(node) - step(carrier)).length_squared()).sum()
}

fn agree(contacts: &DetectedContacts, a: usize, b: usize) -> bool {
    contacts.points.iter().all(|point| point.at_rest[a] == point.at_rest[b])
}

/// The two frames whose poses, speeds and contacts are most alike.
fn best(
    scene: &Scene,
    frames: &Frames,
    carrier: &Carrier,
    contacts: Option<&DetectedContacts>,
    options: &Loop,
) -> Option<(usize, usize)> {
    let (least, most) = (
        (options.shortest * frames.rate).ceil() as usize,
        (options.longest * frames.rate) as usize,
    );
    let stride = frames.len().div_ceil(CANDIDATES).max(1);
    // A speed has the weight of the displacement that it causes in a tenth of a second.
    let weight = (0.1 * frames.rate).powi(2) as f32;
    let cost = |distance: f32, first: usize, last: usize| {
        let agree = contacts.is_none_or(|contacts| agree(contacts, first, last));
        if agree { distance } else { 4.0 * distance }
    };
    let poses = |chosen: &[usize]| Poses::new(frames, chosen, carrier, Some(weight));
    let mut found: Option<(f32, usize, usize)> = None;
    let mut consider = |firsts: &[usize], lasts: &[usize]| {
        let poses = [firsts, lasts].map(poses);
        for (index, &first) in firsts.iter().enumerate() {
            for (distance, &last) in poses[1].distances(&poses[0], index).into_iter().zip(lasts) {
                let length = last.saturating_sub(first);
                if length < least.max(2) || length > most {
                    continue;
                }
                let cost = cost(distance, first, last);
                if found.is_none_or(|found| cost < found.0) {
                    found = Some((cost, first, last));
                }
            }
        }
        found
    };
    let candidates: Vec<usize> = (0..frames.len()).step_by(stride).collect();
    let (_, first, last) = consider(&candidates, &candidates)?;
    // Compares all frames near the two best candidates.
    let near = |frame: usize| -> Vec<usize> {
        (frame.saturating_sub(stride)..=(frame + stride).min(frames.len() - 1)).collect()
    };
    let (least_cost, first, last) = consider(&near(first), &near(last))?;
    // Shifts the cycle in time, so that it starts at the frame with the least motion.
    let length = last - first;
    let step = (length / MOMENTS).max(1);
    let earliest = first - step * (first.min(length / 2) / step);
    let latest = (first + length / 2).min(frames.len() - 1 - length);
    let firsts: Vec<usize> = (earliest..=latest).step_by(step).collect();
    let lasts: Vec<usize> = firsts.iter().map(|first| first + length).collect();
    let (from, to) = (poses(&firsts), poses(&lasts));
    let carrier = frames.nodes()[carrier.column];
    let alike = firsts.iter().zip(&lasts).enumerate().filter(|(index, (first, last))| {
        let distance = to.distances(&from, *index)[*index];
        cost(distance, **first, **last) <= CALM * least_cost
    });
    let speeds = alike.map(|(_, (first, last))| (squared_speeds(scene, frames, carrier, *first), *first, *last));
    let calmest = speeds.min_by(|a, b| a.0.total_cmp(&b.0));
    Some(calmest.map_or((first, last), |(_, first, last)| (first, last)))
}
