//! Decoding: computes the positions of a joint at several frames, in the raw clip and as readers of the file decode
//! them.
//!
//! Readers use rotation keys differently: see [`Decoder`]. This module simulates them all, in double precision.

use std::ops::Range;
use std::sync::Arc;

use glam::DQuat;
use mocap_scene::math::soa::double::{LANES, Lanes, Matrices, Quaternions, Vectors};

use super::clip::{CompressedTrack, Track};
use super::curves::{Curve, EulerAngles};
use super::key_frames::KeyFrames;
use super::quantize::{QuantizedRotation, QuantizedTranslation};
use super::raw_clip::{RawJoint, RawTrack};
use super::read_ahead;

/// The ways in which readers decode rotations.
#[derive(Clone, Copy)]
pub(super) enum Decoder {
    /// Normalizes the keys and interpolates along the arc, as the glTF specification says.
    Slerp,
    /// Like [`Self::Slerp`], but without normalization. A quaternion whose length is slightly off 1 then also scales
    /// the children of the joint. Babylon.js decodes in this way, and also three.js, unless two keys have nearly the
    /// same rotation.
    Unnormalized,
    /// Interpolates component by component and normalizes, as many engines do.
    Nlerp,
    /// Evaluates the curves of the angles, as for FBX.
    Curves,
}

impl Decoder {
    pub(super) const ALL: &[Self] = &[Self::Slerp, Self::Unnormalized, Self::Nlerp];
    /// The decoders whose results differ even if every frame has a key, so that nothing is interpolated.
    pub(super) const AT_KEYS: &[Self] = &[Self::Slerp, Self::Unnormalized];
    /// The decoders for files with curves.
    pub(super) const WITH_CURVES: &[Self] = &[Self::Slerp, Self::Unnormalized, Self::Nlerp, Self::Curves];

    /// The number of decoders, for arrays with a value for each.
    const COUNT: usize = Self::WITH_CURVES.len();
}

/// Consecutive frames, at most as many as there are lanes. Excess lanes repeat the last frame.
#[derive(Clone, Copy)]
pub(super) struct Block {
    pub(super) first: usize,
    pub(super) count: usize,
}

impl Block {
    fn frame(self, lane: usize) -> usize {
        self.first + lane.min(self.count - 1)
    }
}

/// Finds the keys around the frames of a block, for all tracks with the same key frames.
pub(super) struct Cursor<'a> {
    pub(super) key_frames: &'a Arc<KeyFrames>,
    /// The last key at or before each frame.
    keys: [usize; LANES],
    /// The interpolation factor from the last key to the next key.
    alphas: Lanes,
    /// Whether one of the frames lies between two keys.
    interpolates: bool,
}

impl<'a> Cursor<'a> {
    fn new(key_frames: &'a Arc<KeyFrames>) -> Self {
        Self {
            key_frames,
            keys: [0; LANES],
            alphas: Lanes::ZERO,
            interpolates: false,
        }
    }

    /// The index of the cursor for `key_frames`. Adds the cursor if there is none.
    fn find(cursors: &mut Vec<Self>, key_frames: &'a Arc<KeyFrames>) -> usize {
        let known = cursors
            .iter()
            .position(|cursor| Arc::ptr_eq(cursor.key_frames, key_frames));
        known.unwrap_or_else(|| {
            cursors.push(Self::new(key_frames));
            cursors.len() - 1
        })
    }

    /// Moves to a block, which must come after the previous one. `times` are the times of the frames in the file.
    #[inline(always)]
    pub(super) fn advance(&mut self, times: &[f32], block: Block) {
        let key_frames = self.key_frames;
        let time_of = |key: usize| f64::from(times[key_frames[key] as usize]);
        let mut key = self.keys[LANES - 1];
        self.interpolates = false;
        for lane in 0..LANES {
            let time = f64::from(times[block.frame(lane)]);
            while key + 1 < key_frames.len() && time_of(key + 1) <= time {
                key += 1;
            }
            self.keys[lane] = key;
            self.alphas.0[lane] = if key + 1 == key_frames.len() || time <= time_of(key) {
                0.0
            } else {
                self.interpolates = true;
                (time - time_of(key)) / (time_of(key + 1) - time_of(key))
            };
        }
    }
}

/// A joint in object space at the frames of a block.
#[derive(Clone)]
pub(super) struct JointState {
    /// The position in the raw clip.
    pub(super) raw_position: Vectors,
    raw_rotation: Matrices,
    /// The position and the rotation that each decoder computes.
    lossy: [(Vectors, Matrices); Decoder::COUNT],
    /// The largest distance between the raw position and the decoded positions.
    pub(super) error: Lanes,
    /// The largest angle in radians by which implementations of one decoder may differ; `None` if they agree.
    pub(super) ambiguity: Option<Lanes>,
    /// Whether the joint or one of its ancestors has an `ambiguity`.
    pub(super) is_ambiguous: bool,
}

impl Default for JointState {
    fn default() -> Self {
        Self {
            raw_position: Vectors::ZERO,
            raw_rotation: Matrices::ZERO,
            lossy: [(Vectors::ZERO, Matrices::ZERO); Decoder::COUNT],
            error: Lanes::ZERO,
            ambiguity: None,
            is_ambiguous: false,
        }
    }
}

impl JointState {
    #[inline(always)]
    fn set_rotation(&mut self, decoder: Decoder, parent: Option<&Self>, local: &Matrices) {
        let (_, rotation) = &mut self.lossy[decoder as usize];
        match parent {
            None => *rotation = *local,
            Some(parent) => rotation.set_product(&parent.lossy[decoder as usize].1, local),
        }
    }
}

/// Samples one joint in the raw clip and in its compressed tracks.
pub(super) struct JointSampler<'a> {
    pub(super) raw: &'a RawJoint<'a>,
    parent_scale: Lanes,
    translation: TrackSampler<'a, Vectors, QuantizedTranslation>,
    /// A constant rotation has two matrices: from a decoder that normalizes, and from one that does not.
    rotation: TrackSampler<'a, [Matrices; 2], QuantizedRotation>,
    angles: Option<AngleSampler<'a>>,
}

/// Angle curves, each with its cursor.
struct AngleSampler<'a> {
    euler: EulerAngles,
    curves: [(usize, &'a [f32]); 3],
}

enum TrackSampler<'a, Constant, Key> {
    Constant(Constant),
    Animated { cursor: usize, keys: &'a [Key] },
}

impl<'a> JointSampler<'a> {
    /// Makes a sampler, and adds cursors for the key frames of `track` to `cursors`.
    pub(super) fn new(raw: &'a RawJoint<'a>, track: &'a CompressedTrack, cursors: &mut Vec<Cursor<'a>>) -> Self {
        Self {
            raw,
            parent_scale: Lanes::all(raw.parent_scale.into()),
            translation: match &track.translation {
                Track::Constant(value) => TrackSampler::Constant(Vectors::all(value.as_dvec3().to_array())),
                Track::Animated { key_frames, keys, .. } => TrackSampler::Animated {
                    cursor: Cursor::find(cursors, key_frames),
                    keys,
                },
            },
            rotation: match &track.rotation {
                Track::Constant(value) => {
                    let value = value.as_dquat();
                    let unit = Quaternions::all(value.normalize().to_array());
                    let squared_length = Lanes::all(value.length_squared());
                    TrackSampler::Constant([unit.into(), Matrices::from_unnormalized(unit, squared_length)])
                }
                Track::Animated { key_frames, keys, .. } => TrackSampler::Animated {
                    cursor: Cursor::find(cursors, key_frames),
                    keys,
                },
            },
            angles: track.curves.as_ref().and_then(|joint| {
                let curves = joint.rotation.as_ref()?;
                let sampler = |curve: &'a Curve| (Cursor::find(cursors, &curve.key_frames), curve.values.as_slice());
                Some(AngleSampler {
                    euler: joint.euler,
                    curves: curves.each_ref().map(sampler),
                })
            }),
        }
    }

    /// Prefetches the data for the blocks of some frames. The cursors must be at the first of these frames.
    pub(super) fn read_ahead(&self, frames: &Range<usize>, cursors: &[Cursor]) {
        let keys = |cursor: usize| {
            let first = cursors[cursor].keys[0];
            first..first + frames.len()
        };
        read_ahead::read(self.raw.translation.animated_values(), frames.clone(), |value| value.x);
        read_ahead::read(self.raw.rotation.animated_values(), frames.clone(), |value| value.x);
        if let TrackSampler::Animated { cursor, keys: values } = &self.translation {
            read_ahead::read(values, keys(*cursor), |key| key.value.x);
        }
        if let TrackSampler::Animated { cursor, keys: values } = &self.rotation {
            read_ahead::read(values, keys(*cursor), |key| key.value.x);
        }
    }

    /// Moves `joint` to a block. Its parent and the cursors must already be there.
    #[inline(always)]
    pub(super) fn sample(
        &self,
        block: Block,
        cursors: &[Cursor],
        decoders: &[Decoder],
        parent: Option<&JointState>,
        joint: &mut JointState,
    ) {
        let raw_translation = match &self.raw.translation {
            RawTrack::Constant(value) => Vectors::all(value.as_dvec3().to_array()),
            RawTrack::Animated(values) => Vectors::of_single(|lane| values[block.frame(lane)].to_array()),
        };
        let translation = self.translation(cursors);
        match parent {
            None => {
                joint.raw_position = raw_translation;
                joint.lossy.iter_mut().for_each(|lossy| lossy.0 = translation);
            }
            Some(parent) => {
                joint.raw_position = parent.raw_position + &parent.raw_rotation * (raw_translation * self.parent_scale);
                let offset = translation * self.parent_scale;
                let lossy = &mut joint.lossy[..decoders.len()];
                for ((position, _), (parent_position, parent_rotation)) in std::iter::zip(lossy, &parent.lossy) {
                    *position = *parent_position + parent_rotation * offset;
                }
            }
        }
        let positions = joint.lossy[..decoders.len()].iter();
        let squares = positions.map(|(position, _)| joint.raw_position.distance_squared(*position));
        joint.error = squares.fold(Lanes::ZERO, Lanes::max).sqrt();
        // The rotation of a leaf moves no joint.
        if !self.raw.children.is_empty() {
            let raw_rotation = match &self.raw.rotation {
                RawTrack::Constant(value) => Quaternions::all(value.as_dquat().to_array()),
                RawTrack::Animated(values) => Quaternions::of_single(|lane| values[block.frame(lane)].to_array()),
            };
            let raw_rotation = Matrices::from(raw_rotation.normalize());
            match parent {
                None => joint.raw_rotation = raw_rotation,
                Some(parent) => joint.raw_rotation.set_product(&parent.raw_rotation, &raw_rotation),
            }
            self.sample_rotation(cursors, decoders, parent, joint);
        }
        joint.is_ambiguous = joint.ambiguity.is_some() || parent.is_some_and(|parent| parent.is_ambiguous);
    }

    /// The translation relative to the parent. All decoders interpolate translations linearly.
    #[inline(always)]
    fn translation(&self, cursors: &[Cursor]) -> Vectors {
        let (cursor, keys) = match &self.translation {
            TrackSampler::Constant(value) => return *value,
            TrackSampler::Animated { cursor, keys } => (&cursors[*cursor], *keys),
        };
        Vectors::of(|lane| {
            let (key, alpha) = (cursor.keys[lane], cursor.alphas.0[lane]);
            let from = keys[key].value.as_dvec3();
            match keys.get(key + 1) {
                Some(to) if alpha > 0.0 => from.lerp(to.value.as_dvec3(), alpha).to_array(),
                _ => from.to_array(),
            }
        })
    }

    /// The rotation in object space for every decoder, and its ambiguity.
    #[inline(always)]
    fn sample_rotation(
        &self,
        cursors: &[Cursor],
        decoders: &[Decoder],
        parent: Option<&JointState>,
        joint: &mut JointState,
    ) {
        let has_nlerp = decoders.len() > Decoder::Nlerp as usize;
        let has_curves = decoders.len() > Decoder::Curves as usize;
        let (cursor, keys) = match &self.rotation {
            TrackSampler::Constant([unit, unnormalized]) => {
                joint.set_rotation(Decoder::Slerp, parent, unit);
                joint.set_rotation(Decoder::Unnormalized, parent, unnormalized);
                if has_nlerp {
                    joint.set_rotation(Decoder::Nlerp, parent, unit);
                }
                if has_curves {
                    joint.set_rotation(Decoder::Curves, parent, unit);
                }
                return;
            }
            TrackSampler::Animated { cursor, keys } => (&cursors[*cursor], *keys),
        };
        let next = |lane: usize| (cursor.keys[lane] + usize::from(cursor.alphas.0[lane] > 0.0)).min(keys.len() - 1);
        let from = Quaternions::of_single(|lane| keys[cursor.keys[lane]].value.to_array());
        let mut length = from.length();
        let mut unit = from * length.recip();
        if cursor.interpolates {
            let to = Quaternions::of_single(|lane| keys[next(lane)].value.to_array());
            let to_length = to.length();
            let (slerp, nlerp) = interpolate(unit, to * to_length.recip(), cursor.alphas);
            unit = slerp;
            length = length + (to_length - length) * cursor.alphas;
            joint.set_rotation(Decoder::Nlerp, parent, &nlerp.into());
        } else if has_nlerp {
            joint.set_rotation(Decoder::Nlerp, parent, &unit.into());
        }
        joint.set_rotation(Decoder::Slerp, parent, &unit.into());
        if has_curves {
            let angles = self.angles.as_ref();
            let evaluated = angles.map_or(unit, |angles| angles.rotation(cursors));
            joint.set_rotation(Decoder::Curves, parent, &evaluated.into());
        }
        let unnormalized = Matrices::from_unnormalized(unit, length * length);
        joint.set_rotation(Decoder::Unnormalized, parent, &unnormalized);
        let ends = |lane: usize| [&keys[cursor.keys[lane]], &keys[next(lane)]];
        let mut ambiguous = 0;
        for lane in 0..LANES {
            let [from, to] = ends(lane);
            ambiguous |= from.ambiguous | to.ambiguous;
        }
        let largest = |lane: usize| {
            ends(lane)
                .map(QuantizedRotation::ambiguity)
                .into_iter()
                .fold(0.0, f64::max)
        };
        joint.ambiguity = (ambiguous > 0).then(|| Lanes::of(largest));
    }
}

impl AngleSampler<'_> {
    fn rotation(&self, cursors: &[Cursor]) -> Quaternions {
        Quaternions::of(|lane| {
            let angles = self.curves.map(|(cursor, values)| {
                let (key, alpha) = (cursors[cursor].keys[lane], cursors[cursor].alphas.0[lane]);
                let from = f64::from(values[key]);
                let to = values.get(key + 1).map_or(from, |to| f64::from(*to));
                from + (to - from) * alpha
            });
            self.euler.rotation(angles.into()).to_array()
        })
    }
}

/// Slerp and nlerp on the shorter arc, between unit quaternions.
#[inline(always)]
fn interpolate(from: Quaternions, to: Quaternions, alpha: Lanes) -> (Quaternions, Quaternions) {
    let dot = from.dot(to);
    let sign = Lanes::of(|lane| 1f64.copysign(dot.0[lane]));
    let (to, dot) = (to * sign, dot * sign);
    let rest = Lanes::ONE - alpha;
    let nlerp = (from * rest + to * alpha).normalize();
    if dot.0.iter().all(|dot| 1.0 - dot < SMALL_ANGLE) {
        (from * slerp_weight(rest, dot) + to * slerp_weight(alpha, dot), nlerp)
    } else {
        let slerp = Quaternions::of(|lane| {
            let [from, to] = [from, to].map(|end| DQuat::from_array(end.lane(lane)));
            from.slerp(to, alpha.0[lane]).to_array()
        });
        (slerp, nlerp)
    }
}

/// The value of `1 - cos(angle)` up to which [`slerp_weight`] is as exact as sines: an angle of 11 degrees.
const SMALL_ANGLE: f64 = 0.02;

/// `sin(alpha angle) / sin(angle)` for a small angle, given its cosine: a power series in `cos(angle) - 1`, with a
/// ninth term below 1e-18.
///
/// D. Eberly, "A Fast and Accurate Algorithm for Computing SLERP", Journal of Graphics, GPU, and Game Tools 15 (2011),
/// <https://www.geometrictools.com/Documentation/FastAndAccurateSlerp.pdf>
#[inline(always)]
pub fn slerp_weight(alpha: Lanes, cosine: Lanes) -> Lanes {
    let x = cosine - Lanes::ONE;
    let square = alpha * alpha;
    let mut sum = Lanes::ONE;
    for term in (1..=8).rev() {
        let term = f64::from(term);
        let factor = Lanes::all(1.0 / (term * (2.0 * term + 1.0)));
        sum = Lanes::ONE + sum * ((square - Lanes::all(term * term)) * factor * x);
    }
    alpha * sum
}
