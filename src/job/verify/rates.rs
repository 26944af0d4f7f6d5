//! The frame rates of the clips in an FBX file, which stores one rate for all clips.

use mocap_formats::fbx;
use mocap_scene::process;
use mocap_scene::scene::Scene;
use mocap_scene::scene::report::AppliedStep;

use super::output::Output;

/// The frame rates of the clips that an FBX file should have.
pub(super) struct Rates {
    /// The rate of every clip of the source after the steps.
    pub(super) of_clips: Vec<f64>,
    /// Further rates at which the file may have keys: the rates before resampling. If a step cuts the motion, the
    /// frames on both sides of the cut keep the times that they had at such a rate.
    others: Vec<f64>,
    /// Whether the file rounds rates that are near whole numbers.
    is_whole: bool,
}

impl Rates {
    /// The rates that the file `output` of `source` should have after `steps`. If this crate wrote the file, and the
    /// file states a whole number instead of the rate of its fastest clip, all rates are rounded.
    pub(super) fn new(source: &Scene, steps: &[AppliedStep], output: &Output<'_>) -> Self {
        let mut of_clips: Vec<f64> = source.animations.iter().map(|clip| clip.ticks_per_second).collect();
        let mut others = Vec::new();
        for step in steps {
            if let AppliedStep::Resample { frames_per_second } = step {
                let before = of_clips
                    .iter()
                    .map(|rate| process::rate_before(*rate, *frames_per_second));
                others.extend(before);
                of_clips.fill(*frames_per_second);
            }
        }
        let fastest = of_clips.iter().copied().max_by(f64::total_cmp);
        let whole = fastest
            .and_then(fbx::whole_rate)
            .filter(|whole| Some(*whole) != fastest);
        let stated = output.frame_rate().filter(|_| output.is_ours());
        Self {
            is_whole: whole.is_some() && stated == whole,
            of_clips,
            others,
        }
    }

    /// The rate of a clip of the source in the file.
    pub(super) fn written(&self, clip: usize) -> f64 {
        self.in_file(self.of_clips[clip])
    }

    fn in_file(&self, rate: f64) -> f64 {
        fbx::whole_rate(rate).filter(|_| self.is_whole).unwrap_or(rate)
    }

    /// All rates, each once.
    fn all(&self) -> Vec<f64> {
        let rates = self.of_clips.iter().chain(&self.others);
        let mut rates: Vec<f64> = rates.map(|rate| self.in_file(*rate)).collect();
        rates.sort_unstable_by(f64::total_cmp);
        rates.dedup();
        rates
    }

    /// The lowest frame rate that contains the frames of all clips, if the clips have several whole rates.
    pub(super) fn common(&self) -> Option<f64> {
        /// The highest common rate, in frames per second.
        const MOST: u64 = 6000;
        let greatest_divisor = |mut a: u64, mut b: u64| {
            while b != 0 {
                (a, b) = (b, a % b);
            }
            a
        };
        let rates = self.all();
        let mut common = 1;
        for &rate in &rates {
            let whole = rate.round();
            if (rate - whole).abs() > 1e-6 * rate || !(1.0..=MOST as f64).contains(&whole) {
                return None;
            }
            let whole = whole as u64;
            common = common / greatest_divisor(common, whole) * whole;
            if common > MOST {
                return None;
            }
        }
        (rates.len() > 1).then_some(common as f64)
    }

    /// The distinct rates of the clips if no common rate has the frames of all clips. Empty if there is a common rate
    /// or only one rate.
    pub(super) fn several(&self) -> Vec<f64> {
        /// The most rates: the file is read again for each rate.
        const MOST: usize = 16;
        let mut rates: Vec<f64> = (0..self.of_clips.len()).map(|clip| self.written(clip)).collect();
        rates.sort_unstable_by(f64::total_cmp);
        rates.dedup();
        let has_several = (2..=MOST).contains(&rates.len()) && self.common().is_none();
        if has_several { rates } else { Vec::new() }
    }
}
