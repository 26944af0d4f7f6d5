//! The features of a frame: the features of Holden's motion matching (orangeduck/Motion-Matching), in the same order.
//!
//! | numbers | feature |
//! |---|---|
//! | 0-2, 3-5 | position of the left and the right foot |
//! | 6-8, 9-11 | velocity of the left and the right foot |
//! | 12-14 | velocity of the hips |
//! | 15-20 | position on the ground in 20, 40 and 60 frames: to the left, forward |
//! | 21-26 | facing of the body in 20, 40 and 60 frames: to the left, forward |
//!
//! All features are relative to the root: the point on the ground below the hips, with the facing of the body. A
//! Savitzky-Golay filter of degree 3 smooths the position over 31 frames and the facing over 61 frames. Axes are left,
//! up and forward. Lengths are in metres on a body with legs of length [`LEG`].

use glam::Vec3;
use mocap_scene::scene::{HumanoidBone as Bone, Side};

use crate::survey::{Body, Motion};

/// The number of features of a frame.
pub(super) const FEATURES: usize = 27;

/// The frame rate of the features, in frames per second. Many games run at this rate.
pub(super) const FEATURE_RATE: f64 = 60.0;
/// The leg length to which all features are scaled, in metres from hip through knee to ankle: the leg of a man 1.78 m
/// tall.
pub(super) const LEG: f32 = 0.87;
/// How far ahead the features sample the trajectory, in frames.
pub const AHEAD: [usize; 3] = [20, 40, 60];

/// The indices of the velocities of the feet and the hips among the features.
const VELOCITIES: std::ops::Range<usize> = 6..15;

/// The index of the first velocity of the hips among the features.
const HIPS_VELOCITY: usize = 12;

/// The index of the first of the three positions of the trajectory among the features.
const POSITIONS: usize = 15;

/// The index of the first of the three directions of the trajectory among the features.
const DIRECTIONS: usize = 21;

/// Half the window that smooths the position of the root, in frames. The window is half a second, one step.
const SMOOTH_POSITION: usize = 15;

/// Half the window that smooths the facing of the root, in frames. The window is one second, two steps.
const SMOOTH_DIRECTION: usize = 30;
/// The contact bits of the left ankle and ball. The bits of the right foot are these bits shifted left by 1.
const LEFT: u8 = 0b0101;

/// The position of a body on the ground, and the facing of the body. The facing is horizontal and of length 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Root {
    pub position: Vec3,
    pub forward: Vec3,
}

impl Root {
    /// Converts a vector from the world to the axes left, up and forward.
    pub(super) fn local(&self, vector: Vec3) -> Vec3 {
        let left = Vec3::Y.cross(self.forward);
        Vec3::new(vector.dot(left), vector.y, vector.dot(self.forward))
    }
}

/// A motion at [`FEATURE_RATE`]. Its lengths are in metres, and are not scaled to [`LEG`].
pub(super) struct Track {
    hips: Vec<Vec3>,
    feet: [Vec<Vec3>; 2],
    pub(super) roots: Vec<Root>,
    pub(super) contacts: Vec<u8>,
}

impl Track {
    /// Returns `None` for a body without feet, and for a motion without duration.
    pub(super) fn new(motion: &Motion, body: &Body) -> Option<Self> {
        let feet = Side::ALL.map(|side| body.bones.get(&Bone::LeftFoot.on(side)).copied());
        let [Some(left), Some(right)] = feet else { return None };
        let at = |node: usize, frame: f64| {
            let before = (frame.floor() as usize).min(motion.frames - 1);
            let after = (before + 1).min(motion.frames - 1);
            motion
                .at(before, node)
                .lerp(motion.at(after, node), frame.fract() as f32)
        };
        let frames = frames_of(motion)?;
        let of = |node: usize| -> Vec<Vec3> { frames.iter().map(|frame| at(node, *frame)).collect() };
        let hips = of(body.hips());
        let looks = |frame: &f64| body.forward(motion, (frame.round() as usize).min(motion.frames - 1));
        let forwards: Vec<Vec3> = frames.iter().map(looks).collect();
        let contacts = frames.iter().map(|frame| contacts_at(body, frame.round() as usize));
        Some(Self {
            roots: roots(&hips, &forwards),
            contacts: contacts.collect(),
            feet: [of(left), of(right)],
            hips,
        })
    }

    pub(super) fn frames(&self) -> usize {
        self.hips.len()
    }

    /// The features of a frame. `scale` multiplies lengths.
    pub(super) fn features(&self, frame: usize, scale: f32) -> [f32; FEATURES] {
        let root = &self.roots[frame];
        let last = self.frames() - 1;
        let position = |track: &[Vec3]| scale * root.local(track[frame] - root.position);
        let velocity = |track: &[Vec3]| {
            let (before, after) = (frame.saturating_sub(1), (frame + 1).min(last));
            let seconds = (after - before).max(1) as f32 / FEATURE_RATE as f32;
            scale * root.local(track[after] - track[before]) / seconds
        };
        let mut features = [0.0; FEATURES];
        let vectors = [
            position(&self.feet[0]),
            position(&self.feet[1]),
            velocity(&self.feet[0]),
            velocity(&self.feet[1]),
            velocity(&self.hips),
        ];
        for (slot, vector) in vectors.into_iter().enumerate() {
            features[3 * slot..3 * slot + 3].copy_from_slice(&vector.to_array());
        }
        for (slot, ahead) in AHEAD.into_iter().enumerate() {
            let then = &self.roots[(frame + ahead).min(last)];
            let position = scale * root.local(then.position - root.position);
            let forward = root.local(then.forward);
            set_ahead(&mut features, slot, position, forward);
        }
        features
    }
}

/// Sets the future position and facing at `AHEAD[index]`, both relative to the root.
pub(super) fn set_ahead(features: &mut [f32; FEATURES], index: usize, position: Vec3, forward: Vec3) {
    features[POSITIONS + 2 * index..][..2].copy_from_slice(&[position.x, position.z]);
    features[DIRECTIONS + 2 * index..][..2].copy_from_slice(&[forward.x, forward.z]);
}

/// Sets the velocities of feet and hips to zero: the features of a figure that stands still.
pub(super) fn set_still(features: &mut [f32; FEATURES]) {
    features[VELOCITIES].fill(0.0);
}

/// The speed of the hips.
pub(super) fn speed_of_hips(features: &[f32; FEATURES]) -> f32 {
    Vec3::from_slice(&features[HIPS_VELOCITY..]).length()
}

/// The features of the mirrored motion: left and right exchanged.
pub(super) fn mirrored(features: &[f32; FEATURES]) -> [f32; FEATURES] {
    let mut mirrored = *features;
    for (a, b) in [(0, 3), (6, 9)] {
        for axis in 0..3 {
            mirrored.swap(a + axis, b + axis);
        }
    }
    for sideways in [0, 3, 6, 9, 12, 15, 17, 19, 21, 23, 25] {
        mirrored[sideways] = -mirrored[sideways];
    }
    mirrored
}

/// The contacts of the mirrored motion.
pub(super) fn mirrored_contacts(contacts: u8) -> u8 {
    (contacts & LEFT) << 1 | (contacts >> 1) & LEFT
}

/// The points of the feet that are at rest. Bits from the lowest: left ankle, right ankle, left ball, right ball.
fn contacts_at(body: &Body, frame: usize) -> u8 {
    let bits = body.contacts.points.iter().map(|point| {
        let bit = match point.bone {
            Bone::LeftFoot => 1,
            Bone::RightFoot => 2,
            Bone::LeftToes => 4,
            Bone::RightToes => 8,
            _ => 0,
        };
        let frame = frame.min(point.at_rest.len().saturating_sub(1));
        bit * u8::from(point.at_rest.get(frame) == Some(&true))
    });
    bits.fold(0, |all, bit| all | bit)
}

/// The fractional frames of a motion at which the features are sampled, at [`FEATURE_RATE`].
fn frames_of(motion: &Motion) -> Option<Vec<f64>> {
    let step = motion.rate / FEATURE_RATE;
    let last = motion.frames.checked_sub(1)? as f64;
    if !(step.is_finite() && step > 0.0) {
        return None;
    }
    let first = motion.first as f64;
    // Allow 0.01 frames of rounding, for rates such as 119.99 frames per second.
    let count = ((last - first) / step + 0.01).floor() as usize + 1;
    Some(
        (0..count)
            .map(|frame| (first + frame as f64 * step).min(last))
            .collect(),
    )
}

/// The smoothed root of each frame.
fn roots(hips: &[Vec3], forwards: &[Vec3]) -> Vec<Root> {
    let ground: Vec<Vec3> = hips.iter().map(|hips| hips.with_y(0.0)).collect();
    let positions = smoothed(&ground, SMOOTH_POSITION);
    let mut last = forwards
        .iter()
        .copied()
        .find(|forward| *forward != Vec3::ZERO)
        .unwrap_or(Vec3::Z);
    let directions = smoothed(forwards, SMOOTH_DIRECTION);
    let pairs = positions.into_iter().zip(directions);
    pairs
        .map(|(position, direction)| {
            // A body that lies on its side has no facing, and keeps the previous facing.
            last = direction.with_y(0.0).try_normalize().unwrap_or(last);
            Root {
                position,
                forward: last,
            }
        })
        .collect()
}

/// Applies a Savitzky-Golay filter of degree 3 over `half` values on each side, or fewer if the list is shorter. A
/// point reflection extends the list beyond both ends, so that a straight path stays straight.
fn smoothed(values: &[Vec3], half: usize) -> Vec<Vec3> {
    let half = half.min(values.len().saturating_sub(1));
    let [Some(first), Some(last)] = [values.first(), values.last()] else {
        return Vec::new();
    };
    let at = |index: isize| match usize::try_from(index) {
        Err(_) => 2.0 * *first - values[index.unsigned_abs()],
        Ok(index) if index < values.len() => values[index],
        Ok(index) => 2.0 * *last - values[2 * (values.len() - 1) - index],
    };
    let m = half as f32;
    let weight = |i: f32| 3.0 * (3.0 * m * m + 3.0 * m - 1.0 - 5.0 * i * i);
    let sum = (2.0 * m + 3.0) * (2.0 * m + 1.0) * (2.0 * m - 1.0);
    if half < 2 {
        return values.to_vec();
    }
    let weights: Vec<f32> = (0..=half).map(|i| weight(i as f32) / sum).collect();
    let value = |index: usize| {
        let offsets = -(half as isize)..=half as isize;
        let terms = offsets.map(|offset| weights[offset.unsigned_abs()] * at(index as isize + offset));
        terms.sum()
    };
    (0..values.len()).map(value).collect()
}
