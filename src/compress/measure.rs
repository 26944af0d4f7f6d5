//! Error measurement: the distance of each joint from its position in the raw clip, at every frame, for every decoder.
//!
//! Encoding runs in single precision. This module decides in double precision whether the decoded result is within the
//! bound.

use std::ops::Range;

use mocap_scene::math::soa::double::{LANES, Lanes};
use mocap_scene::math::wide;
use mocap_scene::pose::forward_kinematics;

use super::clip::{CompressedTrack, MeasuredError};
use super::decode::{Block, Cursor, Decoder, JointSampler, JointState};
use super::raw_clip::RawClip;
use super::read_ahead::FrameReader;

/// The errors at every frame, multiplied by the weights of the joints.
pub struct FrameErrors {
    /// The largest error of a joint, in metres.
    pub largest: Vec<f64>,
    /// The joint or shell point with the largest error.
    pub nodes: Vec<usize>,
    /// The sum of the squared errors of all joints.
    pub squares: Vec<f64>,
}

impl FrameErrors {
    /// Zero errors for a number of frames.
    pub fn new(frames: usize) -> Self {
        Self {
            largest: vec![0.0; frames],
            nodes: vec![0; frames],
            squares: vec![0.0; frames],
        }
    }

    pub fn summary(&self, clip: &RawClip) -> MeasuredError {
        let mut summary = MeasuredError::default();
        for (frame, &error) in self.largest.iter().enumerate() {
            if error > summary.max || error.is_nan() {
                summary = MeasuredError {
                    max: error,
                    node: clip.node_of(self.nodes[frame]),
                    tick: clip.ticks[frame],
                    rms: 0.0,
                };
            }
        }
        let distances = (clip.joints.len() * self.largest.len()).max(1);
        summary.rms = (self.squares.iter().sum::<f64>() / distances as f64).sqrt();
        summary
    }

    /// For each of `nodes` joints and shell points, its largest error. A frame counts only for the joint or point that
    /// has the largest error in this frame.
    pub fn by_node(&self, nodes: usize) -> Vec<f64> {
        let mut errors = vec![0.0; nodes];
        for (&node, &error) in std::iter::zip(&self.nodes, &self.largest) {
            errors[node] = f64::max(errors[node], error);
        }
        errors
    }
}

/// A raw clip and the compressed tracks to compare with it.
pub struct Measurement<'a> {
    pub clip: &'a RawClip<'a>,
    pub tracks: &'a [CompressedTrack],
    /// The times of the frames in the file, as 32-bit floats. Errors are measured at these times.
    pub times: &'a [f32],
    /// The rounding error of the raw clip itself, in metres. This rounding error is added to every measured error.
    pub raw_rounding: f64,
    /// The error factor of each joint; empty if all are 1.
    pub weights: &'a [f64],
}

wide::dispatch! {
    /// Measures the errors in all frames of some ranges.
    pub fn measure(measurement: &Measurement<'_>, ranges: &[Range<usize>], errors: &mut FrameErrors) {
        measure_lanes(measurement, ranges, errors);
    }
}

#[inline(always)]
pub fn measure_lanes(measurement: &Measurement<'_>, ranges: &[Range<usize>], errors: &mut FrameErrors) {
    let clip = measurement.clip;
    let mut cursors: Vec<Cursor> = Vec::new();
    let samplers: Vec<JointSampler> = std::iter::zip(&clip.joints, measurement.tracks)
        .map(|(joint, track)| JointSampler::new(joint, track, &mut cursors))
        .collect();
    let has_all_keys = |cursor: &Cursor| cursor.key_frames.len() == measurement.times.len();
    let decoders = if cursors.iter().all(has_all_keys) {
        Decoder::AT_KEYS
    } else if measurement.tracks.iter().any(|track| track.curves.is_some()) {
        Decoder::WITH_CURVES
    } else {
        Decoder::ALL
    };
    let raw_rounding = Lanes::all(measurement.raw_rounding);
    let mut joints = vec![JointState::default(); samplers.len()];
    let mut ahead = FrameReader::default();
    for range in ranges {
        for first in range.clone().step_by(LANES) {
            let count = (range.end - first).min(LANES);
            let block = Block { first, count };
            for cursor in &mut cursors {
                cursor.advance(measurement.times, block);
            }
            ahead.reach(first, range.end, |frames| {
                for sampler in &samplers {
                    sampler.read_ahead(&frames, &cursors);
                }
            });
            forward_kinematics(
                &mut joints,
                |index| clip.parent_of(index),
                // A closure that is not inlined would be compiled without wide vectors.
                #[inline(always)]
                |index, parent, joint| samplers[index].sample(block, &cursors, decoders, parent, joint),
            );
            let mut largest = Lanes::ZERO;
            let mut nodes = Lanes::ZERO;
            let mut squares = Lanes::ZERO;
            for (index, joint) in joints.iter().enumerate() {
                let mut error = joint.error + raw_rounding + ambiguity(clip, &joints, index);
                if let Some(weight) = measurement.weights.get(index) {
                    error = error * Lanes::all(*weight);
                }
                squares = squares + error * error;
                nodes = Lanes::of(|lane| {
                    let is_larger = error.0[lane] > largest.0[lane] || error.0[lane].is_nan();
                    if is_larger { index as f64 } else { nodes.0[lane] }
                });
                largest = largest.max(error);
            }
            for lane in 0..count {
                errors.largest[first + lane] = largest.0[lane];
                errors.nodes[first + lane] = nodes.0[lane] as usize;
                errors.squares[first + lane] = squares.0[lane];
            }
        }
    }
}

/// The largest distance between the positions that implementations of one decoder compute for a joint. It is a sum over
/// the joint's ancestors: the angle by which implementations may differ, times the distance from the ancestor to the
/// joint.
#[inline(always)]
fn ambiguity(clip: &RawClip, joints: &[JointState], index: usize) -> Lanes {
    let mut sum = Lanes::ZERO;
    let mut ancestor = clip.parent_of(index);
    while let Some(above) = ancestor.filter(|above| joints[*above].is_ambiguous) {
        if let Some(angle) = joints[above].ambiguity {
            let squared_distance = joints[index].raw_position.distance_squared(joints[above].raw_position);
            sum = sum + angle * squared_distance.sqrt();
        }
        ancestor = clip.parent_of(above);
    }
    sum
}
