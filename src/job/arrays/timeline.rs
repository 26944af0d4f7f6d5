//! The ticks of the output's frames.

use mocap_figure::convert::part_ticks;
use mocap_scene::error::{Code, Result};
use mocap_scene::limits;
use mocap_scene::process;
use mocap_scene::scene::Scene;
use mocap_scene::scene::report::AppliedStep;

use crate::arrays::ArrayOptions;

/// The largest distance in ticks at which a new frame equals a frame of the file.
const SAME_TICK: f64 = 1e-6;

/// Evenly spaced times of an animation.
pub(super) struct Timeline {
    pub(super) frames: usize,
    /// The number of frames at the file's own rate.
    pub(super) frames_in_file: usize,
    /// Frames per second; 0 without motion.
    pub(super) frame_rate: f64,
    first: f64,
    step: f64,
    /// The frames after which the motion jumps. Only computed if times may fall between two frames.
    cuts: Vec<usize>,
}

impl Timeline {
    /// Adds the steps that change times to `steps`.
    pub(super) fn new(scene: &Scene, options: &ArrayOptions, steps: &mut Vec<AppliedStep>) -> Result<Self> {
        if let Some(rate) = options.frames_per_second {
            limits::frame_rate(Code::InvalidValue, rate)?;
        }
        let Some(animation) = scene.animations.first() else {
            return Ok(Self {
                frames: 0,
                frames_in_file: 0,
                frame_rate: 0.0,
                first: 0.0,
                step: 1.0,
                cuts: Vec::new(),
            });
        };
        let old_rate = animation.ticks_per_second;
        let (first, last) = part_ticks(Some(animation), options.first, options.last, 0.0)?;
        let last = last.min(animation.duration);
        if options.first.is_some() || options.last.is_some() {
            steps.push(AppliedStep::Trim { first, last });
        }
        let (frame_rate, step, cuts) = match options.frames_per_second {
            Some(frames_per_second) => {
                steps.push(AppliedStep::Resample { frames_per_second });
                let cuts = scene.cuts(0);
                (
                    frames_per_second,
                    process::rate_before(old_rate, frames_per_second) / frames_per_second,
                    cuts,
                )
            }
            None => (old_rate, 1.0, Vec::new()),
        };
        // This number equals `Animation::frame_count`. `Scene::resample` drops a remainder at the end that is shorter
        // than a frame.
        let frames_in_file = ((last - first).round() as usize).saturating_add(1);
        let frames = match options.frames_per_second {
            Some(_) => (((last - first) / step + SAME_TICK).floor() as usize).saturating_add(1),
            None => frames_in_file,
        };
        Ok(Self {
            frames,
            frames_in_file,
            frame_rate,
            first,
            step,
            cuts,
        })
    }

    /// Seconds between two frames; 0 without motion.
    pub(super) fn frame_time(&self) -> f64 {
        if self.frame_rate > 0.0 {
            self.frame_rate.recip()
        } else {
            0.0
        }
    }

    /// The tick of a frame.
    pub(super) fn tick(&self, frame: usize) -> f64 {
        let tick = self.first + frame as f64 * self.step;
        // A time within a cut uses the nearer side of the cut.
        if self.cuts.binary_search(&(tick as usize)).is_ok() {
            tick.round()
        } else {
            tick
        }
    }
}
