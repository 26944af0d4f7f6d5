//! The report of a cleaning: what each part did.

use std::fmt;

use serde::Serialize;

use super::Flips;
use super::hands::Meetings;
use super::measures::{self, CleanMeasures};
use super::noise::SmoothingOutcome;
use super::time::TimeRepair;
use crate::floor::FloorOutcome;
use crate::quantity::{centimetres, counted, degrees};
use crate::work::Work;

/// A part of a cleaning.
///
/// [`Clean`](crate::Clean) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum CleanPart {
    /// Repairs timing: frames that repeat the frame before, and missing frames.
    Time,
    /// Repairs flips: rotations that jump away and back.
    Flips,
    /// Removes noise from rotations and positions.
    Noise,
    /// Gives each bone a constant length.
    Lengths,
    /// Corrects the height and the slope of the floor, and the drift of the body.
    Floor,
    /// Stops foot sliding during ground contact.
    Contacts,
}

impl CleanPart {
    /// Every part, in the order in which they are done.
    pub const ALL: [Self; 6] = [
        Self::Time,
        Self::Flips,
        Self::Noise,
        Self::Lengths,
        Self::Floor,
        Self::Contacts,
    ];

    /// The name of the part in kebab case.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Time => "time",
            Self::Flips => "flips",
            Self::Noise => "noise",
            Self::Lengths => "lengths",
            Self::Floor => "floor",
            Self::Contacts => "contacts",
        }
    }
}

/// The outcome of a part of the cleaning.
///
/// [`Clean`](crate::Clean) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum CleanOutcome {
    /// The part changed the motion.
    Changed,
    /// The part found nothing to change in the motion.
    Nothing,
    /// The part did not run, because an option excluded it.
    LeftOut,
    /// The part made a measure of the motion worse, so its changes were undone.
    TakenBack,
}

/// A part of a cleaning, and what it did.
///
/// [`Clean`](crate::Clean) has an example.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct CleanedPart {
    /// The part.
    pub part: CleanPart,
    /// The outcome of the part.
    pub outcome: CleanOutcome,
    /// What the part did, or why it did nothing, as text.
    pub about: String,
    /// The measures of the motion after the part.
    pub after: CleanMeasures,
}

/// The report of [`Clean`](crate::Clean). As text, it is a table.
///
/// [`Clean`](crate::Clean) has an example.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct CleanReport {
    /// The measures of the motion before the step.
    pub before: CleanMeasures,
    /// The measures of the motion after all parts.
    pub after: CleanMeasures,
    /// The parts, in the order in which they ran.
    pub parts: Vec<CleanedPart>,
    /// Possible defects that the step did not repair, because they are uncertain.
    pub doubts: Vec<String>,
}

/// The largest ratio of jitter after to jitter before the removal of noise at which a motion counts as noisy.
const NOISY: f64 = 0.7;
/// The additional jitter that locking the feet may cause, as a fraction of the jitter of the noise.
const OF_NOISE: f64 = 0.02;

impl CleanReport {
    pub(super) fn new(work: &Work<'_>) -> Self {
        let before = CleanMeasures::new(work);
        Self {
            after: before.clone(),
            before,
            parts: Vec::new(),
            doubts: Vec::new(),
        }
    }

    pub(super) fn leave_out(&mut self, part: CleanPart, why: &str) {
        self.add(part, CleanOutcome::LeftOut, why.to_owned());
    }

    fn add(&mut self, part: CleanPart, outcome: CleanOutcome, about: String) {
        let after = self.after.clone();
        self.parts.push(CleanedPart {
            part,
            outcome,
            about,
            after,
        });
    }

    /// Measures the hands of a motion before it is smoothed.
    pub(super) fn measure_hands(&mut self, meetings: &Meetings, work: &Work<'_>) {
        self.before.hands = meetings.apart(work);
        self.after.hands = self.before.hands;
    }

    /// Measures the peak speed after the depth was smoothed, because peaks of the jitter in depth do not count.
    pub(super) fn measure_steadied(&mut self, work: &Work<'_>) {
        self.after.peak_speed = CleanMeasures::new(work).peak_speed;
    }

    /// Whether a part changed the motion.
    pub(super) fn has_changed(&self, which: CleanPart) -> bool {
        let is_changed = |part: &CleanedPart| part.part == which && part.outcome == CleanOutcome::Changed;
        self.parts.iter().any(is_changed)
    }

    /// Whether much noise was removed.
    pub(super) fn had_noise(&self) -> bool {
        self.has_changed(CleanPart::Noise) && self.after.jitter < NOISY * self.before.jitter
    }

    /// Whether [`Self::take`] would find that a part made a measure worse.
    pub(super) fn is_worse(&self, part: CleanPart, (before, work): (&Work<'_>, &Work<'_>)) -> bool {
        self.worse(&CleanMeasures::new(work), part, (before, work)).is_some()
    }

    /// Records what a part did, as text; an empty text if it did nothing. If the part made a measure worse, nothing is
    /// recorded, and the text is returned with the reason.
    pub(super) fn take(
        &mut self,
        part: CleanPart,
        about: String,
        (before, work): (&Work<'_>, &Work<'_>),
        meetings: &Meetings,
    ) -> Option<String> {
        if about.is_empty() {
            self.add(part, CleanOutcome::Nothing, self.why_nothing(part, work));
            return None;
        }
        let after = CleanMeasures::new(work);
        if let Some(worse) = self.worse(&after, part, (before, work)) {
            return Some(format!("{about}; with this change, {worse}"));
        }
        let hands = meetings.apart(work);
        self.after = CleanMeasures { hands, ..after };
        self.add(part, CleanOutcome::Changed, about);
        None
    }

    /// Records that a part was undone, and why.
    pub(super) fn take_back(&mut self, part: CleanPart, about: String) {
        self.add(part, CleanOutcome::TakenBack, about);
    }
}

impl CleanReport {
    /// A message about why a part changed nothing; empty if no measure shows it.
    fn why_nothing(&self, part: CleanPart, work: &Work<'_>) -> String {
        let now = &self.after;
        match part {
            CleanPart::Floor => match now.floor_height {
                Some(0.0) => "the soles are on a floor at height 0".to_owned(),
                Some(height) => format!("the floor is kept at {}", centimetres(height)),
                None => "no foot ever rests, so the height of the floor is unknown".to_owned(),
            },
            CleanPart::Contacts => now.skate.map_or(String::new(), |skate| {
                let least = 100.0 * work.weights.least_skate;
                format!(
                    "feet in contact slide at {:.0} cm/s; mocap locks feet only above {least:.0} cm/s",
                    100.0 * skate
                )
            }),
            _ => String::new(),
        }
    }

    /// A message about the measure that a part made worse.
    fn worse(
        &self,
        after: &CleanMeasures,
        part: CleanPart,
        (unchanged, changed): (&Work<'_>, &Work<'_>),
    ) -> Option<String> {
        let (came, before) = (&self.before, &self.after);
        let more = |before: f64, after: f64, by: f64, least: f64| after > (1.0 + by) * before + least;
        let optional = |before: Option<f64>, after: Option<f64>, least: f64| {
            before
                .zip(after)
                .is_some_and(|(before, after)| more(before, after, 0.1, least))
        };
        if part != CleanPart::Time && after.held_frames > before.held_frames {
            return Some("frames would repeat".to_owned());
        }
        // Noise can hide jumps, so the part `noise` may reveal some.
        if part != CleanPart::Noise && after.jumps > before.jumps && measures::has_new_jump(unchanged, changed) {
            return Some("rotations would jump".to_owned());
        }
        // If slow motion was corrected to its true rate, the jitter grows with the cube of the rate.
        let jitter = before.jitter * (after.frame_rate / before.frame_rate).max(1.0).powi(3);
        // A foot that comes to rest suddenly adds jitter, compared with a foot that was smoothed to a stop. This
        // addition is small beside the removed noise.
        let (by, least) = match part {
            CleanPart::Contacts => (1.0, (OF_NOISE * came.jitter).max(5.0)),
            CleanPart::Noise => (0.0, 0.0),
            _ => (0.25, 5.0),
        };
        if more(jitter, after.jitter, by, least) {
            return Some(format!(
                "the jitter would rise from {jitter:.0} to {:.0} m/s3",
                after.jitter
            ));
        }
        if part == CleanPart::Noise && after.peak_speed < 0.9 * before.peak_speed {
            let (before, after) = (before.peak_speed, after.peak_speed);
            return Some(format!("the peak speed would fall from {before:.2} to {after:.2} m/s"));
        }
        if part == CleanPart::Floor && optional(before.floor_slope, after.floor_slope, 0.3) {
            return Some("the floor would be steeper".to_owned());
        }
        // When the floor moves, other feet are in contact than before, so the sliding before and after cannot be
        // compared.
        let moves_feet = matches!(part, CleanPart::Lengths | CleanPart::Contacts);
        if moves_feet && optional(before.skate, after.skate, 0.01) {
            return Some("the feet would slide more".to_owned());
        }
        if moves_feet && before.skate.is_some() && after.skate.is_none() {
            return Some("the feet would lose their contacts".to_owned());
        }
        // A foot with noise is at rest in few frames, and these are even.
        if part == CleanPart::Contacts
            && optional(before.uneven, after.uneven, 0.003)
            && optional(measures::uneven_before(unchanged, changed), after.uneven, 0.003)
        {
            return Some("the heights of feet in contact would differ more".to_owned());
        }
        None
    }
}

impl fmt::Display for TimeRepair {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kinds = [
            (self.filled, "held frame", "filled"),
            (self.removed, "duplicate frame", "removed"),
            (self.inserted, "dropped frame", "inserted"),
        ];
        let kinds = listed(&kinds);
        f.write_str(&kinds)?;
        let Some([stated, rate]) = self.rate else { return Ok(()) };
        let comma = if kinds.is_empty() { "" } else { ", " };
        write!(f, "{comma}{rate} frames per second instead of {stated}: {}", self.tells)
    }
}

impl fmt::Display for Flips {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut done = Vec::new();
        if self.exchanged > 0 {
            done.push(format!(
                "exchange of left and right undone in {} of frames",
                counted(self.exchanged, "run")
            ));
        }
        if self.runs > 0 {
            done.push(format!(
                "{} of {} rotated back or interpolated",
                counted(self.runs, "run"),
                counted(self.joints, "joint")
            ));
        }
        if self.positions > 0 {
            done.push(format!("{} of positions replaced", counted(self.positions, "spike")));
        }
        if self.spread > 0 {
            done.push(format!(
                "{} about the axis of a bone spread over 0.4 s",
                counted(self.spread, "turn")
            ));
        }
        f.write_str(&done.join(", "))
    }
}

impl fmt::Display for SmoothingOutcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(depth) = self.depth {
            let comma = if self.rotations + self.positions > 0 { ", " } else { "" };
            write!(f, "depth smoothed (noise {}){comma}", centimetres(depth))?;
        }
        if self.rotations > 0 {
            let noise = degrees(self.angle);
            write!(f, "{} smoothed (noise {noise})", counted(self.rotations, "joint"))?;
        }
        if self.positions > 0 {
            let comma = if self.rotations > 0 { ", " } else { "" };
            let noise = centimetres(self.distance);
            write!(
                f,
                "{comma}{} smoothed (noise at most {noise})",
                counted(self.positions, "position")
            )?;
        }
        Ok(())
    }
}

impl fmt::Display for FloorOutcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let parts = [
            self.depth
                .map(|depth| format!("unsteady depth removed, by {} at most", centimetres(depth))),
            self.slope.map(|slope| format!("slope of {} removed", degrees(slope))),
            self.drift
                .map(|drift| format!("drift of {} removed", centimetres(drift))),
            self.height
                .map(|height| format!("floor moved from height {} to 0", centimetres(height))),
        ];
        f.write_str(&parts.into_iter().flatten().collect::<Vec<_>>().join(", "))
    }
}

/// Lists the kinds whose count is not 0.
fn listed(kinds: &[(usize, &str, &str)]) -> String {
    let kinds = kinds.iter().filter(|(count, ..)| *count > 0);
    kinds
        .map(|(count, noun, done)| format!("{} {done}", counted(*count, noun)))
        .collect::<Vec<_>>()
        .join(", ")
}

impl fmt::Display for CleanReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for part in &self.parts {
            let name = part.part.as_str();
            match part.outcome {
                CleanOutcome::Nothing if part.about.is_empty() => write!(f, "\n  {name:<9} nothing to do")?,
                CleanOutcome::Nothing => write!(f, "\n  {name:<9} nothing to do: {}", part.about)?,
                CleanOutcome::LeftOut => write!(f, "\n  {name:<9} skipped: {}", part.about)?,
                CleanOutcome::TakenBack => write!(f, "\n  {name:<9} undone: {}", part.about)?,
                CleanOutcome::Changed => write!(f, "\n  {name:<9} {}", part.about)?,
            }
        }
        for doubt in &self.doubts {
            write!(f, "\n  check     {doubt}")?;
        }
        write!(f, "\n{:>24}{:>12}{:>12}", "", "before", "after")?;
        let (before, after) = (&self.before, &self.after);
        let count = |count: usize| Some(count as f64);
        let rows = [
            (
                "held frames",
                count(before.held_frames),
                count(after.held_frames),
                0,
                1.0,
            ),
            ("jumps", count(before.jumps), count(after.jumps), 0, 1.0),
            ("jitter m/s3", Some(before.jitter), Some(after.jitter), 0, 1.0),
            (
                "peak speed m/s",
                Some(before.peak_speed),
                Some(after.peak_speed),
                2,
                1.0,
            ),
            ("foot sliding cm/s", before.skate, after.skate, 2, 100.0),
            ("foot height error cm", before.uneven, after.uneven, 2, 100.0),
            ("hand contact gap cm", before.hands, after.hands, 2, 100.0),
            ("floor height cm", before.floor_height, after.floor_height, 1, 100.0),
            ("floor slope degrees", before.floor_slope, after.floor_slope, 2, 1.0),
        ];
        for (name, before, after, digits, factor) in rows {
            if before.is_none() && after.is_none() {
                continue;
            }
            let number =
                |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{:.digits$}", factor * value));
            write!(f, "\n  {name:<22}{:>12}{:>12}", number(before), number(after))?;
        }
        Ok(())
    }
}
