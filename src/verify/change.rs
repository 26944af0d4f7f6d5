//! What lies on purpose between a source and a file: where its points are, and when its frames are.

use glam::{DMat4, DQuat, DVec3};

use super::chain::Skeleton;
use super::pairs::Pairs;
use super::{Finding, FindingKind};
use crate::edit::{EditStep, StepInput};
use crate::error::Result;
use crate::figure;
use crate::limits::Limits;
use crate::process;
use crate::scene::{AppliedStep, Scene, SecondMotion, UpAxis};

/// How near, in ticks, two moments are that are one.
const SAME_TICK: f64 = 1e-6;

/// The source after all steps up to the last edit, and how many steps these are: edits are not undone, but done to the
/// source too. `None` without an edit. `second` imports the second motion of a step.
pub(super) fn edited(
    source: &Scene,
    steps: &[AppliedStep],
    second: &dyn Fn(&SecondMotion) -> Result<Scene>,
) -> Result<Option<(Scene, usize)>> {
    let is_edit = |step: &AppliedStep| matches!(step, AppliedStep::Edit { .. });
    let Some(last) = steps.iter().rposition(is_edit) else {
        return Ok(None);
    };
    let mut scene = source.clone();
    apply(&mut scene, &steps[..=last], second)?;
    Ok(Some((scene, last + 1)))
}

fn apply(scene: &mut Scene, steps: &[AppliedStep], second: &dyn Fn(&SecondMotion) -> Result<Scene>) -> Result<()> {
    for step in steps {
        match step {
            AppliedStep::ConvertUnits {
                metres_per_unit,
                up,
                out_metres_per_unit,
                out_up,
            } => {
                process::convert_units_to(scene, (*metres_per_unit, *up), (*out_metres_per_unit, *out_up));
                scene.metadata.metres_per_unit = Some(*out_metres_per_unit);
                scene.metadata.up = Some(*out_up);
            }
            AppliedStep::Trim { first, last } => process::trim(scene, *first, *last),
            AppliedStep::Resample { frames_per_second } => {
                process::resample(scene, *frames_per_second, &Limits::default())?;
            }
            AppliedStep::InPlace => process::in_place(scene),
            AppliedStep::RootMotion => process::root_motion(scene),
            AppliedStep::SelectClip { .. } | AppliedStep::VrmHumanoid { .. } | AppliedStep::Retarget { .. } => {}
            AppliedStep::Edit { edit, with, bones } => {
                let other = match with {
                    Some(with) => {
                        let mut other = second(with)?;
                        apply(&mut other, &with.steps, second)?;
                        Some(other)
                    }
                    None => None,
                };
                let known = match bones.is_empty() {
                    true => None,
                    false => Some(figure::humanoid(scene).with_map(scene, bones.clone())?),
                };
                let input = StepInput::new().other(other.as_ref()).humanoid(known.as_ref());
                EditStep::from_value(edit)?.apply(scene, &input)?;
            }
        }
    }
    Ok(())
}

/// What lies on purpose between a source and a file.
pub(super) struct Change {
    /// Units of the file in one of the source.
    pub(super) metres_per_unit: f64,
    /// The axis that points up in the source, and in the file.
    up: (UpAxis, UpAxis),
    pub(super) in_place: bool,
    pub(super) has_root_motion: bool,
    /// Metres in a unit of the file, where it was converted to one.
    pub(super) out_metres_per_unit: Option<f64>,
    /// Where only the bones of a humanoid are left: how the figure was rotated, and by which offset it was moved.
    pub(super) humanoid: Option<(DQuat, DVec3)>,
    /// The steps that change times, in their order.
    times: Vec<AppliedStep>,
}

impl Change {
    fn none() -> Self {
        Self {
            metres_per_unit: 1.0,
            up: (UpAxis::Y, UpAxis::Y),
            in_place: false,
            has_root_motion: false,
            out_metres_per_unit: None,
            humanoid: None,
            times: Vec::new(),
        }
    }

    /// What was done, step by step.
    pub(super) fn recorded(steps: &[AppliedStep]) -> Self {
        let mut change = Self::none();
        let mut is_turned = false;
        for step in steps {
            match *step {
                AppliedStep::ConvertUnits {
                    metres_per_unit,
                    up,
                    out_metres_per_unit,
                    out_up,
                } => {
                    change.metres_per_unit *= metres_per_unit / out_metres_per_unit;
                    change.up = (if is_turned { change.up.0 } else { up }, out_up);
                    change.out_metres_per_unit = Some(out_metres_per_unit);
                    is_turned = true;
                }
                AppliedStep::Trim { .. } | AppliedStep::Resample { .. } => change.times.push(step.clone()),
                AppliedStep::InPlace => change.in_place = true,
                AppliedStep::RootMotion => change.has_root_motion = true,
                AppliedStep::VrmHumanoid { heading, lift } => {
                    change.humanoid = Some((DQuat::from_rotation_y(heading.to_radians()), DVec3::Y * lift));
                }
                AppliedStep::SelectClip { .. } | AppliedStep::Retarget { .. } | AppliedStep::Edit { .. } => {}
            }
        }
        change
    }

    /// The unit from the lengths of the links in the first frame, and the up axis that brings the roots closer. Lengths
    /// of a lossy file are a little off: where they are near to what the file has stated, that is it.
    pub(super) fn guessed(ours: &Skeleton, theirs: &Skeleton, pairs: &Pairs, stated: Option<f64>) -> Self {
        let (mut here, mut there) = (Vec::new(), Vec::new());
        ours.world(0.0, &mut here);
        theirs.world(0.0, &mut there);
        let position = |world: &[DMat4], place: usize| world[place].w_axis.truncate();
        let span = |world: &[DMat4], pick: fn(&(usize, usize)) -> usize| -> f64 {
            let positions = || pairs.list.iter().map(|pair| position(world, pick(pair)));
            positions().zip(positions().skip(1)).map(|(a, b)| a.distance(b)).sum()
        };
        let ratio = span(&there, |pair| pair.1) / span(&here, |pair| pair.0);
        let mut change = Self::none();
        if ratio.is_finite() && ratio > 0.0 {
            let is_near = |stated: &f64| (ratio / stated - 1.0).abs() < 0.01;
            change.metres_per_unit = stated.filter(is_near).unwrap_or(ratio);
        }
        let distance = |change: &Self| -> f64 {
            let distances = pairs
                .list
                .iter()
                .map(|(a, b)| change.place(position(&here, *a)).distance(position(&there, *b)));
            distances.sum()
        };
        // The first of equal ones is kept, so that +Y is the usual answer.
        let mut nearest = (f64::INFINITY, UpAxis::Y);
        for up in UpAxis::ALL {
            change.up.0 = up;
            let found = distance(&change);
            if found < nearest.0 {
                nearest = (found, up);
            }
        }
        change.up.0 = nearest.1;
        change
    }

    /// Where a point of the source is in the file.
    pub(super) fn place(&self, point: DVec3) -> DVec3 {
        let lift = self.humanoid.map_or(DVec3::ZERO, |(_, lift)| lift);
        self.turn(point * self.metres_per_unit) + lift
    }

    /// Where a direction of the source points in the file.
    pub(super) fn turn(&self, direction: DVec3) -> DVec3 {
        let DVec3 { x, y, z } = direction;
        let (from, to) = self.up;
        let y_up = match from {
            UpAxis::Y => direction,
            UpAxis::Z => DVec3::new(x, z, -y),
            UpAxis::NegY => DVec3::new(x, -y, -z),
            UpAxis::NegZ => DVec3::new(x, -z, y),
        };
        let y_up = self.humanoid.map_or(y_up, |(heading, _)| heading * y_up);
        let DVec3 { x, y, z } = y_up;
        match to {
            UpAxis::Y => y_up,
            UpAxis::Z => DVec3::new(x, -z, y),
            UpAxis::NegY => DVec3::new(x, -y, -z),
            UpAxis::NegZ => DVec3::new(x, z, -y),
        }
    }

    /// The part of an offset in the file that is over the ground.
    pub(super) fn over_ground(&self, offset: DVec3) -> DVec3 {
        match self.up.1 {
            UpAxis::Y | UpAxis::NegY => DVec3::new(offset.x, 0.0, offset.z),
            UpAxis::Z | UpAxis::NegZ => DVec3::new(offset.x, offset.y, 0.0),
        }
    }
}

/// When the frames of a clip are. Ticks are those of the source.
pub(super) struct Timeline {
    /// Ticks of the source in a second of the source.
    pub(super) rate: f64,
    /// Ticks of the source in a second of the file, and in one of its frames.
    file_rate: f64,
    frame: f64,
    /// The part of the source that the file is to have.
    first: f64,
    last: f64,
    /// The moments at which the file is to be what its source is: the frames of the source; or, where the frame rate is
    /// another, its own.
    pub(super) moments: Vec<f64>,
    pub(super) is_resampled: bool,
    /// Whether anything is known of what was done to times.
    is_recorded: bool,
}

impl Timeline {
    /// Of a clip of `source`; without one, a single moment.
    ///
    /// # Errors
    /// Where a step that the file records cannot have been done.
    pub(super) fn new(source: &Scene, clip: Option<usize>, change: &Change) -> Result<Self> {
        let animation = clip.and_then(|clip| source.animations.get(clip));
        let rate = animation.map_or(1.0, |animation| animation.ticks_per_second);
        let duration = animation.map_or(0.0, |animation| animation.duration);
        let mut timeline = Self {
            rate,
            file_rate: rate,
            frame: 1.0,
            first: 0.0,
            last: duration,
            moments: Vec::new(),
            is_resampled: false,
            is_recorded: !change.times.is_empty(),
        };
        // The frames between which nothing may be taken from, each with the next.
        let mut cuts = Vec::new();
        let mut edges = Vec::new();
        let mut before = change.times.iter().any(is_resample).then(|| source.clone());
        for step in &change.times {
            match *step {
                AppliedStep::Trim { first, last } => {
                    let start = timeline.first;
                    timeline.first = f64::min(start + first * timeline.frame, timeline.last);
                    timeline.last = f64::min(start + last * timeline.frame, timeline.last).max(timeline.first);
                    if let Some(before) = &mut before {
                        process::trim(before, first, last);
                    }
                }
                AppliedStep::Resample { frames_per_second } => {
                    let (Some(before), Some(clip)) = (&mut before, clip) else {
                        continue;
                    };
                    for cut in figure::cuts(before, clip) {
                        let edge = |frame: usize| timeline.first + frame as f64 * timeline.frame;
                        cuts.push((edge(cut), edge(cut + 1)));
                        edges.extend([edge(cut), edge(cut + 1)]);
                    }
                    let old_rate = timeline.file_rate / timeline.frame;
                    let meant = figure::rate_before(old_rate, frames_per_second);
                    timeline.file_rate *= meant / old_rate;
                    timeline.frame *= meant / frames_per_second;
                    timeline.is_resampled = true;
                    process::resample(before, frames_per_second, &Limits::default())?;
                }
                _ => {}
            }
        }
        timeline.moments = match timeline.is_resampled {
            false => timeline.source_frames(),
            true => timeline.own_frames(&cuts, &edges),
        };
        Ok(timeline)
    }

    /// The whole ticks of the source that the file is to have, and the ends of its part.
    pub(super) fn source_frames(&self) -> Vec<f64> {
        let whole = self.first.ceil() as u64..=self.last.floor() as u64;
        let mut frames: Vec<_> = whole.map(|frame| frame as f64).collect();
        if self.first.fract() != 0.0 {
            frames.insert(0, self.first);
        }
        if self.last.fract() != 0.0 && self.last > self.first {
            frames.push(self.last);
        }
        frames
    }

    /// The frames of the file, as [`process::resample`] sets them.
    fn own_frames(&self, cuts: &[(f64, f64)], edges: &[f64]) -> Vec<f64> {
        let near = SAME_TICK * self.frame;
        let count = ((self.last - self.first) / self.frame + SAME_TICK).floor() as u64;
        let frames = (0..=count).map(|frame| self.first + frame as f64 * self.frame);
        let is_inside = |moment: f64| cuts.iter().any(|&(a, b)| a + near < moment && moment < b - near);
        let mut moments: Vec<_> = frames.filter(|moment| !is_inside(*moment)).collect();
        let is_in_part = |edge: &f64| self.first - near <= *edge && *edge <= self.last + near;
        moments.extend(edges.iter().copied().filter(is_in_part));
        moments.sort_by(f64::total_cmp);
        moments.dedup_by(|later, earlier| *later - *earlier < near);
        moments
    }

    /// The time of a tick in the file, in seconds.
    pub(super) fn seconds(&self, tick: f64) -> f64 {
        (tick - self.first) / self.file_rate
    }

    /// The tick of a frame of evenly spaced ones. Within one of `cuts` the nearer side is taken.
    pub(super) fn tick(&self, frame: usize, cuts: &[usize]) -> f64 {
        let tick = self.first + frame as f64 * self.frame;
        match cuts.contains(&(tick as usize)) {
            true => tick.round(),
            false => tick,
        }
    }

    /// How many evenly spaced frames there are.
    pub(super) fn whole_frames(&self) -> usize {
        ((self.last - self.first) / self.frame + SAME_TICK).floor() as usize + 1
    }

    /// Frames per second.
    pub(super) fn frame_rate(&self) -> f64 {
        self.file_rate / self.frame
    }

    /// How many frames the file is to have, as it says so itself.
    pub(super) fn frame_count(&self) -> u64 {
        let last = self.moments.last().copied().unwrap_or(self.first);
        ((last - self.first) / self.frame).round() as u64 + 1
    }

    /// Whether anything moves in the part of the source that the file is to have.
    pub(super) fn moves(&self, ours: &Skeleton) -> bool {
        ours.span(self.first / self.rate, self.last / self.rate).is_some()
    }

    /// Finds what is missing at either end, and what is too much.
    pub(super) fn find(&self, name: &str, ours: &Skeleton, theirs: &Skeleton, findings: &mut Vec<Finding>) {
        let last = self.moments.last().copied().unwrap_or(self.first);
        let end = self.seconds(last);
        // Times of other programs are rounded to their frames.
        let room = 0.5 * self.frame / self.file_rate + 1e-5 * end;
        let moving = ours.span(self.first / self.rate, self.last / self.rate);
        let start = moving.map(|(start, _)| self.seconds(start * self.rate));
        // Where nothing moves in the source at the end, a file need not say so.
        let least_end = match moving {
            Some((_, moving_end)) => self.seconds(moving_end * self.rate).min(end),
            None if self.is_recorded => end,
            None => 0.0,
        };
        let mut find = |kind, message| findings.push(Finding::new(kind, message));
        let found = theirs.span(f64::NEG_INFINITY, f64::INFINITY);
        match (start, found) {
            (Some(_), None) if least_end > room => {
                find(FindingKind::MissingFrames, format!("{name} does not move in the file"));
            }
            (Some(start), Some((found, _))) if found > start + room => {
                let message =
                    format!("{name} begins to move at {found:.4} s in the file, and in its source at {start:.4} s");
                find(FindingKind::MissingFrames, message);
            }
            _ => {}
        }
        if theirs.end < least_end - room {
            let message = format!(
                "{name} ends at {:.4} s in the file, and in its source at {least_end:.4} s",
                theirs.end
            );
            find(FindingKind::MissingFrames, message);
        } else if theirs.end > end + room {
            let message = format!(
                "{name} ends at {:.4} s in the file, and in its source at {end:.4} s",
                theirs.end
            );
            find(FindingKind::ExtraFrames, message);
        }
        if let Some(joint) = &theirs.stepped {
            let message =
                format!("{name} holds the keys of \"{joint}\" until the next, where its source goes straight");
            find(FindingKind::Stepped, message);
        }
    }
}

fn is_resample(step: &AppliedStep) -> bool {
    matches!(step, AppliedStep::Resample { .. })
}
