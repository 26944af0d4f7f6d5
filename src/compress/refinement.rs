//! Refinement: repeats encoding passes until the error is within the bound.
//!
//! If the error at a frame is too large, the shared key frames get a key at this frame, as in the algorithm of Ramer,
//! Douglas and Peucker. Only the new keys are encoded. Key frames do not suffice if a frame with a key has too large an
//! error, or if each joint has its own key frames. Then the joint with the error and its ancestors get smaller
//! tolerances, and another pass starts.

use std::iter::zip;
use std::ops::Range;
use std::sync::Arc;

use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::scene::Scene;

use super::clip::{CompressedClip, MeasuredError};
use super::encode::{Budget, Encoder, LossyClip};
use super::key_frames::{self, KeyFrames, Refine};
use super::measure::{FrameErrors, Measurement, measure};
use super::object_space::ObjectSpaceTrack;

/// The largest number of encoding passes. In as many rounds, only the worst frame between two keys gets a key. In later
/// rounds, all frames between the two keys get a key.
const MAX_PASSES: usize = 16;

/// The next tolerance, as a fraction of the tolerance that would suffice if errors were proportional to it.
const SAFETY: f32 = 0.97;
/// The smallest factor by which a pass multiplies a tolerance.
const MIN_SHRINK: f32 = 0.5;

/// The tolerance of the first pass at a root's children, as a fraction of the bound. Tuned on the fixtures: the bound
/// holds with any value.
const FIRST_TOLERANCE: f32 = 0.75;

/// The tolerance of the first pass at the end of a chain, as a fraction of the bound. Tuned on the fixtures.
const LAST_TOLERANCE: f32 = 0.97;

/// An encoder, and the data to measure the error of its output.
pub(super) struct Refinement<'a> {
    pub(super) encoder: Encoder<'a>,
    /// The times of the frames in the file.
    pub(super) times: Vec<f32>,
    /// The rounding error of the raw clip, in metres.
    pub(super) raw_rounding: f64,
}

impl Refinement<'_> {
    /// Encodes the clip within the bound. With `shared`, all tracks have keys at these key frames, and at further
    /// frames as needed. Otherwise each track has its own key frames.
    ///
    /// # Errors
    /// [`Code::ErrorBound`] if the storage is too coarse. The message names the node of `scene` with the largest error.
    pub(super) fn within_bound(&self, scene: &Scene, mut shared: Option<Arc<KeyFrames>>) -> Result<CompressedClip> {
        let Encoder { clip, bounds, .. } = &self.encoder;
        let bound = bounds.max_error;
        let mut budgets = self.budgets();
        let mut best = MeasuredError {
            max: f64::INFINITY,
            ..MeasuredError::default()
        };
        for _ in 0..MAX_PASSES {
            let mut lossy = self.encoder.encode(&mut budgets, shared.as_ref());
            if let Some(key_frames) = &mut shared {
                self.add_keys_by_estimate(&mut lossy, &budgets, key_frames);
            }
            let mut errors = FrameErrors::new(clip.frames());
            let mut error = self.measure(&lossy, &clip.all_frames(), &mut errors);
            for step in 0.. {
                let changed = match &mut shared {
                    Some(key_frames) if error.max > bound => {
                        self.add_keys(&mut lossy, &budgets, key_frames, (&errors.largest, bound), step)
                    }
                    _ => Vec::new(),
                };
                if changed.is_empty() {
                    break;
                }
                error = self.measure(&lossy, &changed, &mut errors);
            }
            if error.max <= bound {
                if !bounds.weights().is_empty() {
                    error = self.measure_weighted(&lossy, &clip.all_frames(), &mut errors, &[]);
                }
                lossy.tracks.truncate(clip.nodes());
                return Ok(CompressedClip {
                    tracks: lossy.tracks,
                    ticks: clip.ticks.clone(),
                    error,
                });
            }
            if error.max < best.max {
                best = error;
            }
            self.shrink_tolerances(&mut budgets, &errors.by_node(clip.joints.len()));
        }
        let millimetres = |metres: f64| format!("{:.6} mm", metres * 1000.0);
        Err(Diagnostic::new(
            Code::ErrorBound,
            "this compression is too coarse for the allowed largest error",
        )
        .in_joint(&scene.nodes[best.node].name)
        .expected_found(
            millimetres(bounds.of(best.node)),
            millimetres(best.max / bound * bounds.of(best.node)),
        )
        .help(self.encoder.encoding.help())
        .into())
    }

    fn measure(&self, lossy: &LossyClip, ranges: &[Range<usize>], errors: &mut FrameErrors) -> MeasuredError {
        self.measure_weighted(lossy, ranges, errors, self.encoder.bounds.weights())
    }

    /// Measures errors as [`Self::measure`] does, but with these joint weights. Without weights, errors are distances.
    fn measure_weighted(
        &self,
        lossy: &LossyClip,
        ranges: &[Range<usize>],
        errors: &mut FrameErrors,
        weights: &[f64],
    ) -> MeasuredError {
        let measurement = Measurement {
            clip: &self.encoder.clip,
            tracks: &lossy.tracks,
            times: &self.times,
            raw_rounding: self.raw_rounding,
            weights,
        };
        measure(&measurement, ranges, errors);
        errors.summary(&self.encoder.clip)
    }

    /// The budgets of the first pass. Tolerances grow along a chain, because joints further down compensate for the
    /// errors of their ancestors.
    fn budgets(&self) -> Vec<Budget> {
        let joints = &self.encoder.clip.joints;
        // The number of rotating joints from the root to each joint, and to its farthest descendant.
        let mut depth = vec![0usize; joints.len()];
        for (index, joint) in joints.iter().enumerate() {
            depth[index] = joint.parent.map_or(0, |parent| depth[parent]) + usize::from(joint.rotates());
        }
        let mut deepest = depth.clone();
        for index in (0..joints.len()).rev() {
            if let Some(parent) = joints[index].parent {
                deepest[parent] = deepest[parent].max(deepest[index]);
            }
        }
        let budget = |(index, (depth, deepest)): (usize, (usize, usize))| {
            let along_chain = depth as f32 / deepest.max(1) as f32;
            let fraction = FIRST_TOLERANCE + (LAST_TOLERANCE - FIRST_TOLERANCE) * along_chain;
            let bounds = &self.encoder.bounds;
            Budget {
                tolerance: bounds.below(index) as f32 * fraction,
                own_tolerance: bounds.of_subtree(index) as f32 * fraction,
                coarsest: None,
            }
        };
        zip(depth, deepest).enumerate().map(budget).collect()
    }

    /// Shrinks the tolerances of joints with too large an error, and of their ancestors. `errors` has one value per
    /// joint.
    fn shrink_tolerances(&self, budgets: &mut [Budget], errors: &[f64]) {
        let joints = &self.encoder.clip.joints;
        let bound = self.encoder.bounds.max_error;
        let mut fractions = vec![1f32; joints.len()];
        for (index, error) in errors.iter().enumerate().rev() {
            if *error > bound {
                fractions[index] = fractions[index].min((bound / error) as f32 * SAFETY).max(MIN_SHRINK);
            }
            budgets[index].tolerance *= fractions[index];
            budgets[index].own_tolerance *= fractions[index];
            if let Some(parent) = joints[index].parent {
                fractions[parent] = fractions[parent].min(fractions[index]);
            }
        }
    }

    /// Adds keys until the estimated error of every frame is within the bound. The estimate is in single precision, and
    /// is faster than a measurement.
    fn add_keys_by_estimate(&self, lossy: &mut LossyClip, budgets: &[Budget], key_frames: &mut Arc<KeyFrames>) {
        let mut errors = vec![0f32; self.encoder.clip.frames()];
        let mut changed = self.encoder.clip.all_frames();
        for step in 0.. {
            self.estimate_errors(&lossy.object_space, &changed, &mut errors);
            let bound = self.encoder.bounds.max_error as f32;
            changed = self.add_keys(lossy, budgets, key_frames, (&errors, bound), step);
            if changed.is_empty() {
                break;
            }
        }
    }

    /// The largest weighted error of a joint at every frame of some ranges, in single precision and for a reader with
    /// nlerp.
    fn estimate_errors(&self, lossy: &[ObjectSpaceTrack], ranges: &[Range<usize>], errors: &mut [f32]) {
        for frames in ranges {
            errors[frames.clone()].fill(0.0);
        }
        for (index, joint) in self.encoder.clip.joints.iter().enumerate() {
            let of = |joint: usize| (&self.encoder.raw[joint], &lossy[joint]);
            let weight = self.encoder.bounds.weights().get(index).unwrap_or(&1.0);
            let squared_weight = weight.powi(2) as f32;
            for frames in ranges {
                let errors = &mut errors[frames.clone()];
                match (joint.is_static_leaf(), joint.parent) {
                    (false, _) => {
                        let (raw, lossy) = of(index);
                        let positions = zip(&raw.positions[frames.clone()], &lossy.positions[frames.clone()]);
                        for (error, (raw, lossy)) in zip(errors, positions) {
                            *error = error.max(raw.distance_squared(*lossy) * squared_weight);
                        }
                    }
                    (true, Some(parent)) => {
                        let (raw, lossy) = of(parent);
                        let offset = joint.offset() * joint.parent_scale;
                        let positions = zip(
                            raw.attached(offset, frames.clone()),
                            lossy.attached(offset, frames.clone()),
                        );
                        for (error, (raw, lossy)) in zip(errors, positions) {
                            *error = error.max(raw.distance_squared(lossy) * squared_weight);
                        }
                    }
                    // A root that is a static leaf has no error.
                    (true, None) => {}
                }
            }
        }
        for frames in ranges {
            errors[frames.clone()]
                .iter_mut()
                .for_each(|error| *error = error.sqrt());
        }
    }

    /// Adds and encodes keys where the error is above `bound`. Returns the affected ranges of frames. From round
    /// ("step") [`MAX_PASSES`] on, all frames between two keys get a key, so that the rounds end.
    fn add_keys<T: Copy + PartialOrd>(
        &self,
        lossy: &mut LossyClip,
        budgets: &[Budget],
        key_frames: &mut Arc<KeyFrames>,
        (errors, bound): (&[T], T),
        step: usize,
    ) -> Vec<Range<usize>> {
        let refine = if step < MAX_PASSES { Refine::Worst } else { Refine::All };
        let (insertions, changed) = key_frames::refine(Arc::make_mut(key_frames), errors, bound, refine);
        if !insertions.is_empty() {
            self.encoder.insert(lossy, budgets, key_frames, &insertions, &changed);
        }
        changed
    }
}
