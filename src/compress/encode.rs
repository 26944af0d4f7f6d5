//! Encoding: one pass over all joints, parents first. Each joint has its own tolerance.

use std::ops::Range;
use std::sync::Arc;

use glam::{Quat, Vec3};
use mocap_scene::pose::forward_kinematics;

use super::bit_rate;
use super::clip::{CompressedTrack, RotationTrack, TIME_BYTES, Track, TranslationTrack};
use super::compensation::{Compensation, target_translation};
use super::curves::JointCurves;
use super::encoding::Encoding;
use super::error_bound::Bounds;
use super::error_metric::LeverArms;
use super::fitted_keys::{self, RotationFit, TranslationFit};
use super::key_frames::{self, Insertion, KeyFrames};
use super::object_space::{ObjectSpaceTrack, decode_rotations, decode_translations};
use super::quantize::{Lattice, QuantizedRotation, QuantizedTranslation, RotationFormat, TranslationFormat};
use super::raw_clip::{RawClip, RawJoint};

// The constants below are tuned on the fixtures. The error bound holds with any other values.

/// The part of the tolerance that the error of a joint's own translation may use, as a fraction.
const TRANSLATION_FRACTION: f32 = 0.8;
/// The largest step of a rotation that is tried, at the end of the longest lever arm, as a fraction of the tolerance.
const ROTATION_STEP: f32 = 1.5;
/// The step of a translation as a fraction of the tolerance. Half the diagonal of a cube of such steps is the
/// tolerance.
const TRANSLATION_STEP: f32 = 1.15;

/// The largest number of decimals of a constant: about the precision of 32-bit floats.
const MAX_DECIMALS: f64 = 9.0;

/// The data for encoding that no pass changes.
pub(super) struct Encoder<'a> {
    pub(super) clip: RawClip<'a>,
    /// The joints of the raw clip in object space.
    pub(super) raw: Vec<ObjectSpaceTrack>,
    pub(super) arms: Vec<LeverArms>,
    pub(super) bounds: Bounds,
    pub(super) encoding: &'a dyn Encoding,
}

/// The limits of an encoding pass for a joint.
pub(super) struct Budget {
    /// The largest error of the joint's children, in metres.
    pub(super) tolerance: f32,
    /// The largest error of the joint itself, in metres.
    pub(super) own_tolerance: f32,
    /// The coarsest lattice to try for the joint's rotation. Coarser lattices failed in an earlier pass with a larger
    /// tolerance.
    pub(super) coarsest: Option<Lattice>,
}

/// The result of an encoding pass.
pub(super) struct LossyClip {
    pub(super) tracks: Vec<CompressedTrack>,
    /// The joints as a reader decodes them. Static leaves are empty.
    pub(super) object_space: Vec<ObjectSpaceTrack>,
}

impl Encoder<'_> {
    /// Encodes all joints. With `shared`, all animated tracks have keys at these key frames. Otherwise each track has
    /// its own key frames.
    pub(super) fn encode(&self, budgets: &mut [Budget], shared: Option<&Arc<KeyFrames>>) -> LossyClip {
        let all_frames = self.clip.all_frames();
        let mut tracks = Vec::with_capacity(self.clip.joints.len());
        let mut object_space = vec![ObjectSpaceTrack::default(); self.clip.joints.len()];
        forward_kinematics(
            &mut object_space,
            |index| self.clip.parent_of(index),
            |index, lossy_parent, lossy| {
                let joint = self.joint(index, lossy_parent);
                if joint.raw_joint.is_static_leaf() {
                    tracks.push(CompressedTrack {
                        translation: joint.constant_translation(joint.raw_joint.offset()),
                        rotation: joint.constant_rotation(joint.raw_joint.orientation()),
                        curves: None,
                    });
                    return;
                }
                *lossy = ObjectSpaceTrack::at_origin(self.clip.frames());
                let budget = &mut budgets[index];
                let mut curves = self.encoding.euler_angles(index).map(JointCurves::new);
                let translation = joint.encode_translation(budget.own_tolerance, shared, curves.as_mut());
                joint.decode_translations(&translation, &all_frames, &mut lossy.positions);
                let rotation = joint.encode_rotation(&lossy.positions, budget, shared, curves.as_mut());
                joint.decode_rotations(&rotation, &all_frames, &mut lossy.rotations);
                tracks.push(CompressedTrack {
                    translation,
                    rotation,
                    curves: curves.map(Box::new),
                });
            },
        );
        LossyClip { tracks, object_space }
    }

    /// Encodes keys that were inserted into the shared key frames, and decodes the affected frames. All other keys
    /// stay.
    pub(super) fn insert(
        &self,
        lossy: &mut LossyClip,
        budgets: &[Budget],
        key_frames: &Arc<KeyFrames>,
        insertions: &[Insertion],
        changed: &[Range<usize>],
    ) {
        let LossyClip { tracks, object_space } = lossy;
        forward_kinematics(
            object_space,
            |index| self.clip.parent_of(index),
            |index, lossy_parent, lossy| {
                let joint = self.joint(index, lossy_parent);
                if joint.raw_joint.is_static_leaf() {
                    return;
                }
                let (track, budget) = (&mut tracks[index], &budgets[index]);
                joint.insert_translations(&mut track.translation, budget.own_tolerance, key_frames, insertions);
                joint.decode_translations(&track.translation, changed, &mut lossy.positions);
                let positions = &lossy.positions;
                joint.insert_rotations(&mut track.rotation, positions, budget.tolerance, key_frames, insertions);
                joint.decode_rotations(&track.rotation, changed, &mut lossy.rotations);
            },
        );
    }

    fn joint<'s>(&'s self, index: usize, lossy_parent: Option<&'s ObjectSpaceTrack>) -> JointEncoder<'s> {
        JointEncoder {
            encoder: self,
            raw_joint: &self.clip.joints[index],
            bound: self.bounds.of_subtree(index),
            arms: &self.arms[index],
            raw: &self.raw[index],
            ticks: &self.clip.ticks,
            lossy_parent,
        }
    }

    /// Whether a track with its own key frames, including the key times, is smaller than a track with keys at all
    /// frames. `bytes` is the size of a key without its time.
    fn is_smaller(&self, keys: usize, bytes: usize) -> bool {
        keys * (bytes + TIME_BYTES) < self.clip.frames() * bytes
    }

    /// Rounds a constant to no more decimals than `bound` needs, unless the encoding keeps constants exact.
    fn round(&self, value: f32, bound: f64) -> f32 {
        let Some(step) = self.encoding.constant_step() else {
            return value;
        };
        let per_unit = 10f64.powi((bound * step).log10().floor().clamp(-MAX_DECIMALS, -1.0).abs() as i32);
        ((f64::from(value) * per_unit).round() / per_unit) as f32
    }
}

/// Encodes one joint relative to its lossy parent.
struct JointEncoder<'a> {
    encoder: &'a Encoder<'a>,
    raw_joint: &'a RawJoint<'a>,
    /// The smallest bound of the joint and its descendants, in metres.
    bound: f64,
    arms: &'a LeverArms,
    raw: &'a ObjectSpaceTrack,
    ticks: &'a [f64],
    lossy_parent: Option<&'a ObjectSpaceTrack>,
}

impl<'a> JointEncoder<'a> {
    fn encode_translation(
        &self,
        tolerance: f32,
        shared: Option<&Arc<KeyFrames>>,
        curves: Option<&mut JointCurves>,
    ) -> TranslationTrack {
        if !self.raw_joint.translates() {
            return self.constant_translation(self.raw_joint.offset());
        }
        let targets: Vec<Vec3> = (0..self.ticks.len())
            .map(|frame| self.target_translation(frame))
            .collect();
        let tolerance = self.translation_tolerance(tolerance);
        if let Some(curves) = curves {
            let (key_frames, keys) = curves.reduce_translations(&targets, self.ticks, tolerance);
            let format = TranslationFormat::Float32;
            return Track::Animated {
                format,
                key_frames: Arc::new(key_frames),
                keys: keys.iter().map(|key| format.quantize(*key, None, tolerance)).collect(),
            };
        }
        let largest = targets.iter().map(|value| value.abs().max_element());
        let largest = largest.fold(0.0, f32::max);
        let encoding = self.encoder.encoding;
        let format = encoding.translations(tolerance * TRANSLATION_STEP, largest);
        let key_frames = match shared {
            Some(shared) => Arc::clone(shared),
            None => {
                let track = TranslationFit {
                    targets: &targets,
                    format,
                    tolerance,
                };
                let (key_frames, keys) = fitted_keys::fit(&track, self.ticks);
                if self.encoder.is_smaller(key_frames.len(), TranslationFormat::BYTES) {
                    return Track::Animated {
                        format,
                        key_frames: Arc::new(key_frames),
                        keys,
                    };
                }
                Arc::new(key_frames::every_frame(targets.len()))
            }
        };
        let mut keys: Vec<QuantizedTranslation> = Vec::with_capacity(key_frames.len());
        for &frame in key_frames.iter() {
            let key = format.quantize(targets[frame as usize], keys.last(), tolerance);
            keys.push(key);
        }
        Track::Animated {
            format,
            key_frames,
            keys,
        }
    }

    fn encode_rotation(
        &self,
        lossy_positions: &[Vec3],
        budget: &mut Budget,
        shared: Option<&Arc<KeyFrames>>,
        curves: Option<&mut JointCurves>,
    ) -> RotationTrack {
        if !self.raw_joint.rotates() {
            return self.constant_rotation(self.raw_joint.orientation());
        }
        let tolerance = budget.tolerance;
        let joint = self.compensation(lossy_positions);
        if let Some(constant) = joint.constant_rotation(tolerance) {
            return self.constant_rotation(constant);
        }
        if let Some(curves) = curves {
            let targets = joint.all_targets();
            let error = |frame: usize, rotation| targets[frame].error(self.arms, rotation);
            let rotations = targets.iter().map(|target| target.rotation);
            let (key_frames, rotations) = curves.reduce_rotations(rotations, self.ticks, tolerance, error);
            let format = RotationFormat::Float32;
            let mut keys: Vec<QuantizedRotation> = Vec::with_capacity(rotations.len());
            for rotation in rotations {
                let key = format.quantize(rotation, keys.last());
                keys.push(key);
            }
            return Track::Animated {
                format,
                key_frames: Arc::new(key_frames),
                keys,
            };
        }
        let steps = self.arms.longest / (tolerance * ROTATION_STEP);
        let format = self.encoder.encoding.rotations(steps);
        let key_frames = match shared {
            Some(shared) => Arc::clone(shared),
            None => {
                let targets = joint.all_targets();
                let track = RotationFit::new(&targets, self.arms, format, tolerance);
                let (key_frames, keys) = fitted_keys::fit(&track, self.ticks);
                if self.encoder.is_smaller(key_frames.len(), format.bytes()) {
                    return Track::Animated {
                        format,
                        key_frames: Arc::new(key_frames),
                        keys,
                    };
                }
                Arc::new(key_frames::every_frame(self.ticks.len()))
            }
        };
        let (format, keys) = match format {
            RotationFormat::QuaternionFilter(lattice) | RotationFormat::SmallestThree(lattice) => {
                let finer = budget.coarsest.filter(|coarsest| coarsest.max() > lattice.max());
                let (lattice, keys) = bit_rate::select(&joint, finer.unwrap_or(lattice), &key_frames, tolerance);
                budget.coarsest = Some(lattice);
                (format.with_lattice(lattice), keys)
            }
            format => (format, joint.quantize(format, &key_frames)),
        };
        Track::Animated {
            format,
            key_frames,
            keys,
        }
    }

    fn insert_translations(
        &self,
        track: &mut TranslationTrack,
        tolerance: f32,
        new_key_frames: &Arc<KeyFrames>,
        insertions: &[Insertion],
    ) {
        let tolerance = self.translation_tolerance(tolerance);
        track.insert(new_key_frames, insertions, |format, keys| {
            let new = insertions.iter().map(|insertion| {
                let (target, previous) = (self.target_translation(insertion.frame), &keys[insertion.after]);
                format.quantize(target, Some(previous), tolerance)
            });
            new.collect()
        });
    }

    fn insert_rotations(
        &self,
        track: &mut RotationTrack,
        lossy_positions: &[Vec3],
        tolerance: f32,
        new_key_frames: &Arc<KeyFrames>,
        insertions: &[Insertion],
    ) {
        track.insert(new_key_frames, insertions, |format, keys| {
            let joint = self.compensation(lossy_positions);
            let frames: Vec<u32> = insertions.iter().map(|insertion| insertion.frame as u32).collect();
            let previous: Vec<QuantizedRotation> = insertions.iter().map(|insertion| keys[insertion.after]).collect();
            match *format {
                RotationFormat::QuaternionFilter(lattice) | RotationFormat::SmallestThree(lattice) => {
                    bit_rate::quantize_after(&joint, lattice, &frames, &previous, tolerance)
                }
                format => joint.quantize_after(format, &frames, &previous),
            }
        });
    }

    fn decode_translations(&self, track: &TranslationTrack, ranges: &[Range<usize>], positions: &mut [Vec3]) {
        let scale = self.raw_joint.parent_scale;
        decode_translations(track, scale, self.ticks, ranges, self.lossy_parent, positions);
    }

    fn decode_rotations(&self, track: &RotationTrack, ranges: &[Range<usize>], rotations: &mut [Quat]) {
        decode_rotations(track, self.ticks, ranges, self.lossy_parent, rotations);
    }

    fn compensation<'s>(&'s self, lossy_positions: &'s [Vec3]) -> Compensation<'s> {
        Compensation {
            arms: self.arms,
            raw: self.raw,
            lossy_positions,
            lossy_parent: self.lossy_parent,
        }
    }

    fn target_translation(&self, frame: usize) -> Vec3 {
        target_translation(self.raw, self.raw_joint.parent_scale, self.lossy_parent, frame)
    }

    /// The largest error of a translation, in the translation's unit.
    fn translation_tolerance(&self, tolerance: f32) -> f32 {
        tolerance * TRANSLATION_FRACTION / self.raw_joint.parent_scale
    }

    fn constant_translation(&self, value: Vec3) -> TranslationTrack {
        Track::Constant(Vec3::from_array(
            value.to_array().map(|c| self.encoder.round(c, self.bound)),
        ))
    }

    fn constant_rotation(&self, value: Quat) -> RotationTrack {
        Track::Constant(Quat::from_array(
            value.to_array().map(|c| self.encoder.round(c, self.bound)),
        ))
    }
}
