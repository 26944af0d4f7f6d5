//! When the frames of a file are, in ticks of its source.

use mocap_scene::error::Result;
use mocap_scene::limits::Limits;
use mocap_scene::process;
use mocap_scene::scene::Scene;
use mocap_scene::scene::report::AppliedStep;

use super::chain::Skeleton;
use super::change::Change;
use super::{Finding, FindingKind};

/// How near, in ticks, two moments are that are one.
const SAME_TICK: f64 = 1e-6;

/// How near, in frames, a key of a file is to the frame that it stands for: its time is rounded.
const NEAR_FRAME: f64 = 1e-2;

/// The least movement of a joint, in metres, by a motion whose absence is reported: the usual error of compressed
/// files. What is less is seen in the distances.
pub(super) const SMALLEST_MOTION: f64 = 1e-3;

/// Moments between frames that are looked at, for each frame on average, at most.
const MOST_BETWEEN: usize = 8;

/// When the frames of a clip are. Ticks are those of the source.
pub(super) struct Timeline {
    /// Ticks of the source in a second of the source.
    pub(super) rate: f64,
    /// Ticks of the source in a second of the file, and in one of its frames.
    file_rate: f64,
    frame: f64,
    /// The part of the source that the file is to have, and the last moment of it that the file has.
    first: f64,
    last: f64,
    end: f64,
    /// The moment above whose place over the ground a motion in place stays.
    pub(super) place: f64,
    /// The moments at which the file is to be what its source is: the frames of the source; or, where the frame rate is
    /// another, its own.
    pub(super) moments: Vec<f64>,
    pub(super) is_resampled: bool,
    /// The frames between which the source jumps, and another frame rate takes no value.
    cuts: Vec<(f64, f64)>,
    /// Whether the changes of times are known.
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

    /// Keeps the frames from `first` to `last` of those that are there.
    fn trim(&mut self, first: f64, last: f64) {
        let start = self.first;
        self.first = f64::min(start + first * self.frame, self.last);
        self.last = f64::min(start + last * self.frame, self.last).max(self.first);
    }

    /// Resamples `before`, the motion before this step, and takes its frames.
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
        // The rest behind the last whole frame is gone.
        let frames = before.animations.get(clip).map_or(0.0, |clip| clip.duration);
        self.last = self.last.min(self.first + frames * self.frame);
        Ok(())
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

    /// The frames of the file, and both sides of each cut, as [`Scene::resample`] sets them.
    fn own_frames(&self) -> Vec<f64> {
        let near = SAME_TICK * self.frame;
        let mut moments: Vec<f64> = (0..self.whole_frames()).map(|frame| self.tick(frame)).collect();
        let is_in_part = |edge: &f64| self.first - near <= *edge && *edge <= self.last + near;
        let edges = self.cuts.iter().flat_map(|&(before, after)| [before, after]);
        moments.extend(edges.filter(is_in_part));
        moments.sort_by(f64::total_cmp);
        moments.dedup_by(|later, earlier| *later - *earlier < near);
        moments
    }

    /// The time of a tick in the file, in seconds.
    pub(super) fn seconds(&self, tick: f64) -> f64 {
        (tick - self.first) / self.file_rate
    }

    /// Moments halfway between keys of the file at which it can be compared beside its frames. One of the two
    /// neighbouring keys is at no frame, as samples of a cubic curve are. Halfway, because a jump is at a key.
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

    /// The tick of the source that a moment of the file shows: within a cut its nearer side, and at most the end.
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

    /// The tick of a frame of evenly spaced ones.
    pub(super) fn tick(&self, frame: usize) -> f64 {
        self.first + frame as f64 * self.frame
    }

    /// How many evenly spaced frames there are: at the rate of the source up to the one nearest to the end, at another
    /// as [`Scene::resample`] sets them.
    pub(super) fn whole_frames(&self) -> usize {
        let frames = (self.last - self.first) / self.frame;
        let last = match self.is_resampled {
            true => (frames + SAME_TICK).floor(),
            false => frames.round(),
        };
        last as usize + 1
    }

    /// The timeline of a file that has whole frames alone. What its source does between two of them, at its end and in
    /// a cut too, is not in the file, and is not looked for.
    pub(super) fn of_whole_frames(mut self) -> Self {
        let frames = 0..self.frame_count() as usize;
        self.moments = frames.map(|frame| self.tick(frame)).collect();
        self
    }

    /// Frames per second.
    pub(super) fn frame_rate(&self) -> f64 {
        self.file_rate / self.frame
    }

    /// How many frames the file is to have, as it says so itself.
    pub(super) fn frame_count(&self) -> u64 {
        ((self.end - self.first) / self.frame).round() as u64 + 1
    }

    /// Whether anything moves in the part of the source that the file is to have.
    pub(super) fn moves(&self, ours: &Skeleton) -> bool {
        ours.span(self.first / self.rate, self.last / self.rate).is_some()
    }

    /// Finds missing frames at either end, and additional ones. `farthest` is the greatest error of a frame, and
    /// `allowed` that which a file may have, in metres.
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
            // A motion below the error that was allowed is none in a compressed file.
            (Some(_), None) if least_end > room && (farthest > allowed || farthest.is_nan()) => {
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
