//! The times of a file's frames, in ticks of its source.

use mocap_scene::error::Result;
use mocap_scene::limits::Limits;
use mocap_scene::process;
use mocap_scene::scene::Scene;
use mocap_scene::scene::report::AppliedStep;

use super::chain::Skeleton;
use super::change::Change;
use super::{Finding, FindingKind};

/// The largest difference in ticks of equal times.
const SAME_TICK: f64 = 1e-6;

/// The largest distance in frames of a key from its frame: times of keys are rounded.
const NEAR_FRAME: f64 = 1e-2;

/// The smallest movement in metres of a joint whose absence is reported: the usual error of compressed files. Smaller
/// movements only appear in the distances.
pub(super) const SMALLEST_MOTION: f64 = 1e-3;

/// The most compared times between frames, for each frame on average.
const MOST_BETWEEN: usize = 8;

/// The times of a clip's frames, in ticks of the source.
pub(super) struct Timeline {
    /// Ticks of the source per second of the source.
    pub(super) rate: f64,
    /// Ticks of the source per second of the file, and per frame of the file.
    file_rate: f64,
    frame: f64,
    /// The part of the source that the file should have, and the last time of this part that the file has.
    first: f64,
    last: f64,
    end: f64,
    /// For a motion in place, the time that determines its place on the ground.
    pub(super) place: f64,
    /// The times at which file and source are compared: the frames of the source, or if the frame rate differs, the
    /// frames of the file.
    pub(super) moments: Vec<f64>,
    pub(super) is_resampled: bool,
    /// The frames of cuts, between which the source jumps. Resampling takes no value between them.
    cuts: Vec<(f64, f64)>,
    /// Whether the changes of times are known.
    is_recorded: bool,
}

impl Timeline {
    /// The timeline of a clip of `source`; without a clip, a single time.
    ///
    /// # Errors
    /// If a step that the file records is impossible.
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
            end: duration,
            place: 0.0,
            moments: Vec::new(),
            is_resampled: false,
            cuts: Vec::new(),
            is_recorded: !change.times.is_empty(),
        };
        timeline.apply(source, clip, change)?;
        timeline.cuts.sort_by(|a, b| a.0.total_cmp(&b.0));
        timeline.moments = match timeline.is_resampled {
            false => timeline.source_frames(),
            true => timeline.own_frames(),
        };
        timeline.end = timeline.moments.last().copied().unwrap_or(timeline.first);
        Ok(timeline)
    }

    /// Repeats the steps that changed times.
    fn apply(&mut self, source: &Scene, clip: Option<usize>, change: &Change) -> Result<()> {
        let mut before = change.times.iter().any(is_resample).then(|| source.clone());
        for (index, step) in change.times.iter().enumerate() {
            if change.in_place == Some(index) {
                self.place = self.first;
            }
            match *step {
                AppliedStep::Trim { first, last } => {
                    self.trim(first, last);
                    if let Some(before) = &mut before {
                        before.trim(first, last);
                    }
                }
                AppliedStep::Resample { frames_per_second } => {
                    if let (Some(before), Some(clip)) = (&mut before, clip) {
                        self.resample(before, clip, frames_per_second)?;
                    }
                }
                _ => {}
            }
        }
        if change.in_place == Some(change.times.len()) {
            self.place = self.first;
        }
        Ok(())
    }

    /// Keeps the frames from `first` to `last` of the current frames.
    fn trim(&mut self, first: f64, last: f64) {
        let start = self.first;
        self.first = f64::min(start + first * self.frame, self.last);
        self.last = f64::min(start + last * self.frame, self.last).max(self.first);
    }

    /// Resamples `before`, the motion before this step, and uses the new frames.
    fn resample(&mut self, before: &mut Scene, clip: usize, frames_per_second: f64) -> Result<()> {
        for cut in before.cuts(clip) {
            let edge = |frame: usize| self.first + frame as f64 * self.frame;
            let edges = (edge(cut), edge(cut + 1));
            self.cuts.push(edges);
        }
        let old_rate = self.file_rate / self.frame;
        let meant = process::rate_before(old_rate, frames_per_second);
        self.file_rate *= meant / old_rate;
        self.frame *= meant / frames_per_second;
        self.is_resampled = true;
        before.resample(frames_per_second, &Limits::default())?;
        // The motion after the last whole frame is dropped.
        let frames = before.animations.get(clip).map_or(0.0, |clip| clip.duration);
        self.last = self.last.min(self.first + frames * self.frame);
        Ok(())
    }

    /// The whole ticks of the source that the file should have, and the ends of the part.
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

    /// The frames of the file, and both sides of each cut, as [`Scene::resample`] sets them.
    fn own_frames(&self) -> Vec<f64> {
        let near = SAME_TICK * self.frame;
        let mut moments: Vec<f64> = (0..self.whole_frames()).map(|frame| self.tick(frame)).collect();
        let is_in_part = |edge: &f64| self.first - near <= *edge && *edge <= self.last + near;
        let edges = self.cuts.iter().flat_map(|&(before, after)| [before, after]);
        moments.extend(edges.filter(is_in_part));
        moments.sort_unstable_by(f64::total_cmp);
        moments.dedup_by(|later, earlier| *later - *earlier < near);
        moments
    }

    /// The time of a tick in the file, in seconds.
    pub(super) fn seconds(&self, tick: f64) -> f64 {
        (tick - self.first) / self.file_rate
    }

    /// Additional times for the comparison: halfway between two keys of the file, if one of the keys is not at a frame.
    /// Samples of cubic curves have such keys. The middle is used, because a jump is always at a key.
    pub(super) fn between(&self, theirs: &Skeleton) -> Vec<f64> {
        let near = NEAR_FRAME * self.frame;
        let is_frame = |tick: f64| {
            let after = self.moments.partition_point(|moment| *moment < tick - near);
            self.moments.get(after).is_some_and(|moment| *moment <= tick + near)
        };
        let tick = |seconds: f32| self.first + f64::from(seconds) * self.file_rate;
        let keys: Vec<(f32, bool)> = theirs
            .key_seconds()
            .into_iter()
            .map(|key| (key, is_frame(tick(key))))
            .collect();
        let pairs = keys.windows(2).filter_map(|pair| {
            let [(start, of_start), (end, of_end)] = [pair[0], pair[1]];
            let is_between = !(of_start && of_end) && start.next_up() < end;
            let (start, end) = (tick(start), tick(end));
            (is_between && self.first <= start && end <= self.last).then_some((start, end))
        });
        let middles: Vec<f64> = pairs.map(|(start, end)| f64::midpoint(start, end)).collect();
        let step = middles.len().div_ceil(MOST_BETWEEN * self.moments.len()).max(1);
        middles.into_iter().step_by(step).collect()
    }

    /// The tick of the source that a time of the file shows. Within a cut, this is the nearer side of the cut. After
    /// the end, the result is the end.
    pub(super) fn shown(&self, tick: f64) -> f64 {
        let tick = tick.min(self.end);
        let near = SAME_TICK * self.frame;
        let begun = self.cuts.partition_point(|(before, _)| before + near < tick);
        match begun.checked_sub(1).map(|cut| self.cuts[cut]) {
            Some((_, after)) if tick >= after - near => tick,
            Some((before, after)) if tick - before < after - tick => before,
            Some((_, after)) => after,
            None => tick,
        }
    }

    /// The tick of an evenly spaced frame.
    pub(super) fn tick(&self, frame: usize) -> f64 {
        self.first + frame as f64 * self.frame
    }

    /// The number of evenly spaced frames. At the rate of the source, the last frame is the frame nearest to the end.
    /// At another rate, the number is the number of [`Scene::resample`].
    pub(super) fn whole_frames(&self) -> usize {
        let frames = (self.last - self.first) / self.frame;
        let last = match self.is_resampled {
            true => (frames + SAME_TICK).floor(),
            false => frames.round(),
        };
        last as usize + 1
    }

    /// The timeline of a file that has only whole frames. The file has nothing of the source between these frames, so
    /// cuts and an end between them are not compared.
    pub(super) fn of_whole_frames(mut self) -> Self {
        let frames = 0..self.frame_count() as usize;
        self.moments = frames.map(|frame| self.tick(frame)).collect();
        self
    }

    /// Frames per second.
    pub(super) fn frame_rate(&self) -> f64 {
        self.file_rate / self.frame
    }

    /// The number of frames that the file should state.
    pub(super) fn frame_count(&self) -> u64 {
        ((self.end - self.first) / self.frame).round() as u64 + 1
    }

    /// Whether anything moves in the part of the source that the file should have.
    pub(super) fn moves(&self, ours: &Skeleton) -> bool {
        ours.span(self.first / self.rate, self.last / self.rate).is_some()
    }

    /// Finds missing and additional frames at either end. `farthest` is the largest error of a frame, and `allowed` the
    /// allowed error, in metres.
    pub(super) fn find(
        &self,
        name: &str,
        ours: &Skeleton,
        theirs: &Skeleton,
        (farthest, allowed): (f64, f64),
        findings: &mut Vec<Finding>,
    ) {
        let last = self.moments.last().copied().unwrap_or(self.first);
        let end = self.seconds(last);
        // Other programs round times to their frames.
        let room = 0.5 * self.frame / self.file_rate + 1e-5 * end;
        let moving = ours.span(self.first / self.rate, self.last / self.rate);
        let start = moving.map(|(start, _)| self.seconds(start * self.rate));
        // A file may omit the end of the source if nothing moves there.
        let least_end = match moving {
            Some((_, moving_end)) => self.seconds(moving_end * self.rate).min(end),
            None if self.is_recorded => end,
            None => 0.0,
        };
        let mut find = |kind, message| findings.push(Finding::new(kind, message));
        let found = theirs.span(f64::NEG_INFINITY, f64::INFINITY);
        match (start, found) {
            // A compressed file may drop a motion below the allowed error.
            (Some(_), None) if least_end > room && (farthest > allowed || farthest.is_nan()) => {
                find(FindingKind::MissingFrames, format!("{name} does not move in the file"));
            }
            (Some(start), Some((found, _))) if found > start + room => {
                let message =
                    format!("{name} begins to move at {found:.4} s in the file, but at {start:.4} s in its source");
                find(FindingKind::MissingFrames, message);
            }
            _ => {}
        }
        if theirs.end < least_end - room {
            let message = format!(
                "{name} ends at {:.4} s in the file, but at {least_end:.4} s in its source",
                theirs.end
            );
            find(FindingKind::MissingFrames, message);
        } else if theirs.end > end + room {
            let message = format!(
                "{name} ends at {:.4} s in the file, but at {end:.4} s in its source",
                theirs.end
            );
            find(FindingKind::ExtraFrames, message);
        }
        if let Some(joint) = &theirs.stepped {
            let message =
                format!("{name} holds each key of \"{joint}\" until the next, but its source is linear between keys");
            find(FindingKind::Stepped, message);
        }
    }
}

fn is_resample(step: &AppliedStep) -> bool {
    matches!(step, AppliedStep::Resample { .. })
}
