//! The `extras` of the clips of a glTF file: data besides keys, such as events and whether a clip loops.

use serde_json::{Map, Value};

use super::{Animation, Keys, Scene};

/// The names of members with a time in seconds.
const TIMES: [&str; 4] = ["time", "t", "seconds", "timestamp"];

/// The names of members with the two ends of a span, in seconds.
const SPANS: [(&str, &str); 2] = [("start", "end"), ("startTime", "endTime")];

/// The largest difference in seconds between two times that count as equal: the rounding of single precision.
const SAME_TIME: f64 = 1e-4;

/// The extras of clips, and the record of the changes of their times.
#[derive(Clone, Debug, Default, PartialEq)]
#[doc(hidden)]
pub struct ClipExtras {
    /// The extras of each animation; null for an animation without extras.
    values: Vec<Value>,
    /// For each animation, the time in the file in seconds, as keys over its ticks. Steps change these keys like the
    /// keys of morph targets.
    clocks: Vec<Keys<f32>>,
}

impl ClipExtras {
    pub(super) fn values_mut(&mut self) -> &mut Vec<Value> {
        &mut self.values
    }

    pub(super) fn clocks(&self) -> &[Keys<f32>] {
        &self.clocks
    }

    pub(super) fn clocks_mut(&mut self) -> &mut Vec<Keys<f32>> {
        &mut self.clocks
    }

    /// The number of clips with extras.
    #[doc(hidden)]
    pub fn count(&self) -> usize {
        self.values.iter().filter(|extras| !extras.is_null()).count()
    }
}

impl Scene {
    /// Sets the extras of an animation as its file states them.
    #[doc(hidden)]
    pub fn set_clip_extras(&mut self, index: usize, extras: Value) {
        let Some(clip) = self.animations.get(index).filter(|_| !extras.is_null()) else {
            return;
        };
        let seconds = (clip.duration / clip.ticks_per_second) as f32;
        let clock = match clip.duration > 0.0 {
            true => Keys::at_ticks(vec![0.0, seconds], vec![0.0, clip.duration]),
            false => Keys::constant(0.0),
        };
        let (own, count) = (&mut self.metadata.clip_extras, self.animations.len());
        own.values.resize(count, Value::Null);
        own.clocks.resize(count, Keys::default());
        own.values[index] = extras;
        own.clocks[index] = clock;
    }

    /// The extras of an animation. Times of events are converted to the current times of the clip: members such as
    /// `time`, and spans such as `start` to `end`. Events that are no longer in the clip are dropped.
    #[doc(hidden)]
    pub fn clip_extras(&self, index: usize) -> Option<Value> {
        let extras = self
            .metadata
            .clip_extras
            .values
            .get(index)
            .filter(|extras| !extras.is_null())?;
        let clip = self.animations.get(index)?;
        let clock = self
            .metadata
            .clip_extras
            .clocks
            .get(index)
            .filter(|clock| clock.len() > 1);
        let Some(run) = clock.and_then(|clock| Run::of(clock, clip)) else {
            return Some(extras.clone());
        };
        Some(run.shifted(extras).unwrap_or_else(|| extras.clone()))
    }
}

/// The first part of a clock in which the time runs in one direction. Later parts belong to clips that were appended.
struct Run {
    /// The time in the file and the current time of each key, in seconds.
    times: Vec<(f64, f64)>,
}

impl Run {
    fn of(clock: &Keys<f32>, clip: &Animation) -> Option<Self> {
        let time = |key: usize| (f64::from(clock.values[key]), clock.tick(key) / clip.ticks_per_second);
        let keys: Vec<(f64, f64)> = (0..clock.len()).map(time).collect();
        let steps = || keys.windows(2).map(|pair| pair[1].0 - pair[0].0);
        let way = steps().map(f64::signum).sum::<f64>().signum();
        let goes = |step: f64| step * way > 0.0;
        let from = steps().position(goes)?;
        let count = steps().skip(from).take_while(|step| goes(*step)).count();
        Some(Self {
            times: keys[from..=from + count].to_vec(),
        })
    }

    /// The current time of an event at `time` in the file; `None` if the event is not in the clip.
    fn at(&self, time: f64) -> Option<f64> {
        let found = self.times.windows(2).find_map(|pair| {
            let [(from, start), (to, end)] = [pair[0], pair[1]];
            let part = (time - from) / (to - from);
            let margin = SAME_TIME / (to - from).abs();
            (-margin..=1.0 + margin)
                .contains(&part)
                .then(|| start + part.clamp(0.0, 1.0) * (end - start))
        })?;
        let is_same = (found - time).abs() < SAME_TIME;
        Some(if is_same {
            time
        } else {
            (found / SAME_TIME).round() * SAME_TIME
        })
    }

    /// The current span of an event from `from` to `to` in the file, cut to the clip.
    fn span(&self, from: f64, to: f64) -> Option<[f64; 2]> {
        let ends = || self.times.iter().map(|(time, _)| *time);
        let (first, last) = (
            ends().fold(f64::INFINITY, f64::min),
            ends().fold(f64::NEG_INFINITY, f64::max),
        );
        let (from, to) = (from.max(first), to.min(last));
        let (from, to) = (from <= to).then_some((self.at(from)?, self.at(to)?))?;
        Some([from.min(to), from.max(to)])
    }

    /// A value with its current times; `None` for an event that is not in the clip.
    fn shifted(&self, value: &Value) -> Option<Value> {
        match value {
            Value::Array(items) => Some(items.iter().filter_map(|item| self.shifted(item)).collect()),
            Value::Object(members) => {
                let mut shifted: Map<String, Value> = Map::new();
                for (key, member) in members {
                    let nested = self.shifted(member).unwrap_or_else(|| member.clone());
                    shifted.insert(key.clone(), nested);
                }
                for key in TIMES {
                    if let Some(time) = members.get(key).and_then(Value::as_f64) {
                        shifted.insert(key.to_owned(), self.at(time)?.into());
                    }
                }
                for (start, end) in SPANS {
                    let number = |key: &str| members.get(key).and_then(Value::as_f64);
                    if let (Some(from), Some(to)) = (number(start), number(end)) {
                        let [from, to] = self.span(from, to)?;
                        shifted.insert(start.to_owned(), from.into());
                        shifted.insert(end.to_owned(), to.into());
                    }
                }
                Some(shifted.into())
            }
            other => Some(other.clone()),
        }
    }
}
