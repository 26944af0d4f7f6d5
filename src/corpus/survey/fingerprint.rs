//! The fingerprint of a clip: samples of the motion, ten per second, that stay in memory to compare clips. A sample has
//! the directions of ten limbs in the coordinate frame of the body, and the height, speed and turning speed of the
//! hips.
//!
//! Directions do not depend on the bone lengths of a skeleton or on the roll of its joints. In the coordinate frame of
//! the body, they do not depend on the position or the facing of the figure. Each number is one byte, so ten seconds
//! take 3.4 kB.

use base64::Engine;
use glam::Vec3;
use mocap_scene::scene::HumanoidBone as Bone;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::motion::{Body, Motion};

/// Samples per second of a fingerprint.
pub(crate) const RATE: f64 = 10.0;
/// The number of limbs. Each limb is a direction.
pub const LIMBS: usize = 10;
/// The numbers of a sample: three for each limb, then four for the hips. The four are the height in half leg lengths,
/// the speeds sideways and forward in leg lengths per second / 4, and the turning speed in turns per second.
pub const WIDTH: usize = 3 * LIMBS + 4;
/// The longest fingerprint, in samples: an hour.
const MOST_SAMPLES: usize = 36_000;
/// The largest number of positions before, and after, a sample that the filter averages. At 120 frames per second, 12
/// frames lie between two samples.
const MOST_PARTS: f64 = 12.0;

/// The bones from which and to which each limb goes. Each left limb comes directly before the right limb.
const BONES: [(Bone, Bone); LIMBS] = [
    (Bone::Hips, Bone::Neck),
    (Bone::Neck, Bone::Head),
    (Bone::LeftUpperArm, Bone::LeftLowerArm),
    (Bone::RightUpperArm, Bone::RightLowerArm),
    (Bone::LeftLowerArm, Bone::LeftHand),
    (Bone::RightLowerArm, Bone::RightHand),
    (Bone::LeftUpperLeg, Bone::LeftLowerLeg),
    (Bone::RightUpperLeg, Bone::RightLowerLeg),
    (Bone::LeftLowerLeg, Bone::LeftFoot),
    (Bone::RightLowerLeg, Bone::RightFoot),
];

/// The fingerprint of one clip.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Fingerprint {
    /// All samples, with [`WIDTH`] numbers each.
    pub(crate) values: Vec<i8>,
    /// Whether the limbs are limbs of a humanoid. Otherwise the limbs go from the root to joints of the skeleton.
    pub(crate) is_body: bool,
}

impl Fingerprint {
    pub(crate) fn new(motion: &Motion) -> Self {
        if motion.rate <= 0.0 || motion.nodes() == 0 {
            return Self::default();
        }
        let samples = ((motion.frames - motion.first) as f64 / motion.rate * RATE).ceil() as usize;
        let window = Window::new(motion.rate / RATE);
        Self::through(motion, &window, RATE, motion.first as f64, samples.min(MOST_SAMPLES))
    }

    /// The fingerprint with `samples` samples at another rate, starting at frame `from`. A speed is measured since the
    /// previous sample, which may lie before `from`.
    pub(crate) fn sampled(motion: &Motion, rate: f64, from: f64, samples: usize) -> Self {
        Self::through(motion, &Window::moment(), rate, from, samples)
    }

    fn through(motion: &Motion, window: &Window, rate: f64, from: f64, samples: usize) -> Self {
        let mut values = Vec::new();
        let step = motion.rate / rate;
        let limbs = motion.body.as_ref().map(limbs);
        let at = |frame: f64| Sample::new(motion, limbs.as_ref(), &window.around(motion, frame));
        let mut before = (from - step >= motion.first as f64).then(|| at(from - step));
        for sample in 0..samples {
            let sample = at(from + sample as f64 * step);
            sample.write(before.as_ref(), 1.0 / rate as f32, &mut values);
            before = Some(sample);
        }
        Self {
            values,
            is_body: motion.body.is_some(),
        }
    }

    pub(crate) fn samples(&self) -> usize {
        self.values.len() / WIDTH
    }

    /// The directions of the limbs in a sample.
    pub(crate) fn limbs(&self, sample: usize) -> &[i8] {
        &self.values[sample * WIDTH..sample * WIDTH + 3 * LIMBS]
    }

    /// All numbers of a sample.
    pub(crate) fn row(&self, sample: usize) -> &[i8] {
        &self.values[sample * WIDTH..(sample + 1) * WIDTH]
    }
}

/// The frames around a time, with their weights: a low-pass filter. Without the filter, two copies that are sampled at
/// different times would differ if their motion is faster than the sample rate (aliasing).
struct Window {
    /// Times as offsets from the middle, in frames, each with its weight.
    parts: Vec<(f64, f32)>,
}

impl Window {
    /// A triangle filter that reaches to the previous and the next sample.
    fn new(frames_per_sample: f64) -> Self {
        let half = frames_per_sample.ceil().clamp(1.0, MOST_PARTS) as i32;
        let step = frames_per_sample / f64::from(half);
        let weight = |part: i32| (half - part.abs()) as f32 / (half * half) as f32;
        Self {
            parts: (1 - half..half)
                .map(|part| (step * f64::from(part), weight(part)))
                .collect(),
        }
    }

    fn moment() -> Self {
        Self {
            parts: vec![(0.0, 1.0)],
        }
    }

    /// The window around a frame. At the ends of a motion the window is narrower, but still symmetric.
    fn around(&self, motion: &Motion, frame: f64) -> Vec<Part> {
        let last = motion.frames - 1;
        let reach = self.parts.last().map_or(0.0, |(offset, _)| *offset);
        let room = (frame - motion.first as f64).min(last as f64 - frame).max(0.0);
        let narrow = if reach > room { room / reach } else { 1.0 };
        let parts = self.parts.iter().map(|(offset, weight)| {
            let at = (frame + offset * narrow).max(0.0);
            let before = (at.floor() as usize).min(last);
            Part {
                frames: [before, (before + 1).min(last)],
                fraction: at.fract() as f32,
                weight: *weight,
            }
        });
        parts.collect()
    }
}

/// A time between two frames, with its weight.
struct Part {
    frames: [usize; 2],
    fraction: f32,
    weight: f32,
}

/// The nodes from which and to which each limb goes; `None` for a missing limb.
type Limbs = [Option<[usize; 2]>; LIMBS];

fn limbs(body: &Body) -> Limbs {
    let bone = |bone: Bone| body.bones.get(&bone).copied();
    // If a body has no neck, use its head.
    BONES.map(|(from, to)| Some([bone(from)?, bone(to).or_else(|| bone(Bone::Head))?]))
}

/// The limbs and the hips of a figure at one time.
struct Sample {
    limbs: [Vec3; LIMBS],
    forward: Vec3,
    hips: Vec3,
    height: f32,
    leg: f32,
}

impl Sample {
    fn new(motion: &Motion, limbs: Option<&Limbs>, parts: &[Part]) -> Self {
        let at = |node: usize| {
            let part = |part: &Part| {
                let [before, after] = part.frames.map(|frame| motion.at(frame, node));
                before.lerp(after, part.fraction) * part.weight
            };
            parts.iter().map(part).sum::<Vec3>()
        };
        match motion.body.as_ref().zip(limbs) {
            Some((body, limbs)) => Self::of_body(body, limbs, at),
            None => Self::of_nodes(motion, at),
        }
    }

    fn of_body(body: &Body, limbs: &Limbs, at: impl Fn(usize) -> Vec3) -> Self {
        let hip = |bone: Bone| body.bones.get(&bone).map(|node| at(*node));
        let hips = hip(Bone::LeftUpperLeg).zip(hip(Bone::RightUpperLeg));
        let across = hips.map(|(left, right)| left - right).unwrap_or_default();
        let forward = across.cross(Vec3::Y).normalize_or(Vec3::Z);
        let left = Vec3::Y.cross(forward);
        let limb = |limb: Option<[usize; 2]>| {
            let along = limb.map(|[from, to]| (at(to) - at(from)).normalize_or_zero());
            let along = along.unwrap_or_default();
            Vec3::new(along.dot(left), along.y, along.dot(forward))
        };
        let hips = at(body.hips());
        Self {
            limbs: limbs.map(limb),
            forward,
            hips,
            height: (hips.y - body.contacts.floor) / body.leg,
            leg: body.leg,
        }
    }

    fn of_nodes(motion: &Motion, at: impl Fn(usize) -> Vec3) -> Self {
        let nodes = motion.nodes();
        let limb = |index: usize| (at((index + 1) * (nodes - 1) / LIMBS) - at(0)).normalize_or_zero();
        Self {
            limbs: std::array::from_fn(limb),
            forward: Vec3::Z,
            hips: at(0),
            height: 1.0,
            leg: (motion.size() / 4.0).max(f32::MIN_POSITIVE),
        }
    }

    /// Appends the numbers of the sample. `before` is the sample `seconds` earlier.
    fn write(&self, before: Option<&Self>, seconds: f32, values: &mut Vec<i8>) {
        let byte = |value: f32| (value * 127.0).round().clamp(-127.0, 127.0) as i8;
        values.extend(self.limbs.iter().flat_map(Vec3::to_array).map(byte));
        let (step, turn) = before.map_or((Vec3::ZERO, 0.0), |before| {
            let turn = before
                .forward
                .cross(self.forward)
                .y
                .atan2(before.forward.dot(self.forward));
            (
                (self.hips - before.hips) / seconds / self.leg / 4.0,
                turn / seconds / std::f32::consts::TAU,
            )
        });
        let left = Vec3::Y.cross(self.forward);
        values.push(byte(self.height / 2.0));
        values.push(byte(step.dot(left)));
        values.push(byte(step.dot(self.forward)));
        values.push(byte(turn));
    }
}

/// Serializes base64 after a letter: `b` for limbs of a body, `n` for limbs between nodes.
impl Serialize for Fingerprint {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let bytes: &[u8] = bytemuck::cast_slice(&self.values);
        let letter = if self.is_body { 'b' } else { 'n' };
        let text = base64::engine::general_purpose::STANDARD.encode(bytes);
        serializer.serialize_str(&format!("{letter}{text}"))
    }
}

impl<'de> Deserialize<'de> for Fingerprint {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        use serde::de::Error;

        let text = String::deserialize(deserializer)?;
        let letter = text.chars().next().filter(|letter| ['b', 'n'].contains(letter));
        let letter = letter.ok_or_else(|| D::Error::custom("a fingerprint begins with b or n"))?;
        let bytes = base64::engine::general_purpose::STANDARD
            .decode(&text[1..])
            .map_err(D::Error::custom)?;
        if bytes.len() % WIDTH != 0 || bytes.len() / WIDTH > MOST_SAMPLES {
            return Err(D::Error::custom(format!("a fingerprint has {WIDTH} bytes a sample")));
        }
        Ok(Self {
            values: bytemuck::cast_slice(&bytes).to_vec(),
            is_body: letter == 'b',
        })
    }
}
