//! Measures the motion of an animal on four legs: the pose of its trunk, its legs, and the contacts of its paws in each
//! frame.

mod leg;

use glam::{DMat3, DQuat, DVec3, Mat3, Quat, Vec3};
use mocap_scene::math::median::{median, ranked};
use mocap_scene::pose::{Binding, Pose};
use mocap_scene::scene::{Animation, NodeId, Scene};

pub use self::leg::LegGoal;
use super::Figure;
use super::contacts::without_short_ones;
use super::poses::poses;
use super::report::{Guess, Quadruped, QuadrupedLeg};
use super::{Axis, Confidence};

/// The largest height of a paw in contact above its resting level, as a fraction of the leg. The height is above 0,
/// because paws roll.
const LOW: f64 = 0.09;

/// The largest speed of a paw in contact, in lengths of the leg per second. The speed is above 0, because captures are
/// noisy and paws roll.
const SLOW: f64 = 0.8;

/// The time around a frame over which the speed of a paw is averaged, in seconds. A shorter time would show noise of
/// the capture.
const AROUND: f64 = 0.02;

/// The shortest gap between contacts and the shortest contact, in seconds. Shorter gaps are closed, and shorter
/// contacts are dropped. A gallop has contacts of 0.06 s.
const SHORTEST: f64 = 0.04;

/// The fraction of frames in which a paw is below its resting level, because of noise in the capture.
const RESTS: f64 = 0.1;

/// The largest tilt of a trunk in stance, in radians. An animal with a larger tilt sits.
const MOST_TILTED: f64 = 0.26;

/// In a pose that stands, the sum of two angles is at most this value, in radians. The angles are the mean angle of the
/// legs from straight down, and the tilt of the trunk. The sum is 0.3 for a rest pose in a step, and 1.5 for bones
/// along one axis.
const STANDS: f32 = 0.6;

/// The cosine of the largest angle between the mean direction of the legs and the up axis: 32 degrees.
const ALONG: f32 = 0.85;

/// The time in which a shifted foot in the air returns to its own path, in seconds: half of a step.
pub const RETURN: f64 = 0.2;

/// The pose of an animal in one frame. Positions are in metres, with +Z up.
#[derive(Clone, Copy, Debug)]
pub struct AnimalFrame {
    /// The middle between hips and shoulders.
    pub centre: DVec3,
    /// The rotation from the axes of the trunk (+X forward, +Y left, +Z up) to the world.
    pub rotation: DQuat,
    pub hips: [DVec3; 4],
    pub knees: [DVec3; 4],
    pub ankles: [Option<DVec3>; 4],
    pub paws: [DVec3; 4],
}

impl AnimalFrame {
    /// The vector from a hip or a shoulder to its paw, in the axes of the trunk.
    pub fn leg(&self, index: usize) -> DVec3 {
        self.rotation.inverse() * (self.paws[index] - self.hips[index])
    }

    /// The vectors of the bones of a leg from the hip to the paw: three, or two for a leg without an ankle.
    pub fn bones(&self, index: usize) -> Vec<DVec3> {
        let ends = [Some(self.knees[index]), self.ankles[index], Some(self.paws[index])];
        let joints: Vec<DVec3> = std::iter::once(self.hips[index])
            .chain(ends.into_iter().flatten())
            .collect();
        joints.windows(2).map(|pair| pair[1] - pair[0]).collect()
    }
}

/// The pose of an animal in each frame of its motion.
#[derive(Clone, Debug)]
pub struct AnimalTrack {
    /// The rotation from the axes of the file to axes with +Z up.
    pub to_world: DQuat,
    pub frames: Vec<AnimalFrame>,
    /// The mean length of the legs along their bones, in metres.
    pub leg: f64,
    /// The height at which each paw rests.
    pub ground: [f64; 4],
    pub contacts: Vec<[bool; 4]>,
}

impl AnimalTrack {
    pub fn new(source: &Scene, animation: &Animation, figure: &Figure, animal: &Quadruped) -> Self {
        let metres = f64::from(figure.metres());
        // If +Y is up, the axes of the file are exchanged in cyclic order: +Z becomes +X.
        let to_world = match figure.up_direction() {
            Vec3::Y => DQuat::from_mat3(&DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X)),
            up => DQuat::from_rotation_arc(up.as_dvec3().normalize(), DVec3::Z),
        };
        let binding = Binding::new(source, animation);
        let mut pose = Pose::rest(source);
        let at = |pose: &Pose, node: NodeId| to_world * (metres * pose.position(node).as_dvec3());
        let mut frames = Vec::with_capacity(animation.frame_count());
        for frame in 0..animation.frame_count() {
            pose.sample(&binding, animation, frame as f64);
            let [hips, knees, paws] = [0, 1, 2].map(|part| {
                animal
                    .legs
                    .each_ref()
                    .map(|leg| at(&pose, [leg.upper, leg.lower, leg.paw][part]))
            });
            let forward = (hips[0] + hips[1] - hips[2] - hips[3]).normalize_or(DVec3::X);
            let left = hips[0] + hips[2] - hips[1] - hips[3];
            let left = left.reject_from_normalized(forward).try_normalize();
            let left = left.unwrap_or_else(|| forward.any_orthonormal_vector());
            frames.push(AnimalFrame {
                centre: 0.25 * hips.iter().sum::<DVec3>(),
                rotation: DQuat::from_mat3(&DMat3::from_cols(forward, left, forward.cross(left))).normalize(),
                hips,
                knees,
                ankles: animal.legs.each_ref().map(|leg| Some(at(&pose, leg.ankle?))),
                paws,
            });
        }
        let rest = Pose::rest(source);
        let length = |leg: &QuadrupedLeg| {
            let joints: Vec<DVec3> = leg.joints().map(|node| at(&rest, node)).collect();
            joints.windows(2).map(|pair| pair[0].distance(pair[1])).sum::<f64>()
        };
        let leg = 0.25 * animal.legs.iter().map(length).sum::<f64>();
        let mut track = Self {
            to_world,
            ground: std::array::from_fn(|index| {
                let mut heights: Vec<f64> = frames.iter().map(|frame| frame.paws[index].z).collect();
                let rank = (RESTS * heights.len() as f64) as usize;
                ranked(&mut heights, rank).unwrap_or(0.0)
            }),
            leg,
            contacts: Vec::new(),
            frames,
        };
        track.level();
        track.contacts = track.find_contacts(animation.ticks_per_second);
        track
    }

    /// Rotates the world to other axes with +Z up. `to_world` is the rotation from the axes of the file.
    pub fn turn(&mut self, to_world: DQuat) {
        let turn = to_world * self.to_world.inverse();
        self.to_world = to_world;
        for frame in &mut self.frames {
            frame.centre = turn * frame.centre;
            frame.rotation = (turn * frame.rotation).normalize();
            let points = [&mut frame.hips, &mut frame.knees, &mut frame.paws];
            let ankles = frame.ankles.iter_mut().flatten();
            for point in points.into_iter().flatten().chain(ankles) {
                *point = turn * *point;
            }
        }
    }

    /// Rotates the trunk by its mean tilt during contacts, because the shoulders may be lower or higher than the hips.
    fn level(&mut self) {
        let tilts = self.frames.iter().map(|frame| (frame.rotation * DVec3::X).z.asin());
        let mut tilts: Vec<f64> = tilts.collect();
        let tilt = median(&mut tilts).unwrap_or(0.0).clamp(-MOST_TILTED, MOST_TILTED);
        let back = DQuat::from_rotation_y(tilt);
        for frame in &mut self.frames {
            frame.rotation = (frame.rotation * back).normalize();
        }
    }

    /// For each frame, whether each paw is in contact with the ground.
    fn find_contacts(&self, fps: f64) -> Vec<[bool; 4]> {
        let frames = self.frames.len();
        let around = (AROUND * fps).round().max(1.0) as usize;
        let of_paw = |index: usize| {
            let stands = |frame: usize| {
                let (before, after) = (frame.saturating_sub(around), (frame + around).min(frames - 1));
                let moved = self.frames[after].paws[index].distance(self.frames[before].paws[index]);
                let speed = moved * fps / (after - before).max(1) as f64;
                let height = self.frames[frame].paws[index].z - self.ground[index];
                height < LOW * self.leg && speed < SLOW * self.leg
            };
            let mut stood: Vec<bool> = (0..frames).map(stands).collect();
            let shortest = (SHORTEST * fps).round().max(1.0) as usize;
            without_short_ones(&mut stood, shortest, shortest);
            stood
        };
        let paws: [Vec<bool>; 4] = std::array::from_fn(of_paw);
        (0..frames)
            .map(|frame| paws.each_ref().map(|stood| stood[frame]))
            .collect()
    }

    /// The mean speed of paws that slide during contacts, in metres per second. `None` without a contact.
    pub fn skate(&self, fps: f64) -> Option<f64> {
        let (mut sum, mut count) = (0.0, 0_usize);
        for (frame, pair) in self.frames.windows(2).enumerate() {
            for index in (0..4).filter(|index| self.contacts[frame][*index] && self.contacts[frame + 1][*index]) {
                sum += (pair[1].paws[index] - pair[0].paws[index]).truncate().length() * fps;
                count += 1;
            }
        }
        (count > 0).then(|| sum / count as f64)
    }
}

/// The pose in which an animal stands. It is the rest pose if this pose stands, and otherwise the frame of the motion
/// that is nearest to standing.
#[derive(Clone, Debug)]
pub struct Standing {
    pub pose: Pose,
    pub is_rest: bool,
    /// The rotation from left (+X), up (+Y) and forward (+Z) of the level trunk to the world.
    pub axes: Quat,
}

impl Standing {
    pub fn new(scene: &Scene, figure: &Figure, animal: &Quadruped) -> Self {
        let up = figure.up_direction();
        let rest = Pose::rest(scene);
        let is_rest = unrest(&rest, animal, up) < STANDS;
        let pose = match is_rest {
            true => rest,
            false => {
                let posed = poses(scene).into_iter().chain([rest]);
                let best = posed.min_by(|a, b| unrest(a, animal, up).total_cmp(&unrest(b, animal, up)));
                best.unwrap_or_else(|| Pose::rest(scene))
            }
        };
        let forward = forward(&pose, animal).reject_from_normalized(up);
        let forward = forward.try_normalize().unwrap_or_else(|| up.any_orthonormal_vector());
        Self {
            axes: Quat::from_mat3(&Mat3::from_cols(up.cross(forward), up, forward)).normalize(),
            is_rest,
            pose,
        }
    }
}

/// The up axis: the axis along which the legs of an animal stand, in a few poses of its motion and in its rest pose.
/// `None` if the legs stand along no axis.
pub fn up(scene: &Scene, animal: &Quadruped) -> Option<Guess<Axis>> {
    let legs = |pose: Pose| -> Vec3 {
        let leg = |leg: &QuadrupedLeg| (pose.position(leg.upper) - pose.position(leg.paw)).normalize_or_zero();
        animal.legs.iter().map(leg).sum()
    };
    let sum: Vec3 = poses(scene).into_iter().map(legs).sum();
    let (value, cosine) = Axis::nearest(sum);
    let reason = format!(
        "the legs of the animal stand along this axis, with a mean deviation of {:.0} degrees",
        cosine.acos().to_degrees()
    );
    (cosine > ALONG && value.up().is_some()).then_some(Guess {
        value,
        confidence: Confidence::Sure,
        reason,
    })
}

/// The vector from the hips to the shoulders.
fn forward(pose: &Pose, animal: &Quadruped) -> Vec3 {
    let [left_fore, right_fore, left_hind, right_hind] = animal.legs.each_ref().map(|leg| pose.position(leg.upper));
    0.5 * (left_fore + right_fore - left_hind - right_hind)
}

/// The mean angle of the legs from straight down, plus the tilt of the trunk, in radians.
fn unrest(pose: &Pose, animal: &Quadruped, up: Vec3) -> f32 {
    let angle = |leg: &QuadrupedLeg| (pose.position(leg.paw) - pose.position(leg.upper)).angle_between(-up);
    let angles: f32 = animal.legs.iter().map(angle).sum();
    let tilt = forward(pose, animal).normalize_or_zero().dot(up).abs().asin();
    let sum = 0.25 * angles + tilt;
    if sum.is_finite() { sum } else { f32::MAX }
}

/// For each frame, the shift that keeps a foot at its mean position in each contact. A shift is at most `most` long. In
/// the air, it fades out within `fade` frames. If `ground` is given, the foot has this height in contact.
pub fn shifts(stands: &[bool], feet: &[DVec3], ground: Option<f64>, most: f64, fade: f64) -> Vec<DVec3> {
    let fade = fade.round().max(1.0);
    let mut shift = vec![DVec3::ZERO; feet.len()];
    let mut begin = 0;
    for run in stands.chunk_by(PartialEq::eq) {
        let frames = begin..begin + run.len();
        begin = frames.end;
        if !run[0] {
            continue;
        }
        let anchor = feet[frames.clone()].iter().sum::<DVec3>() / run.len() as f64;
        let of_frame = |frame: usize| {
            let z = ground.unwrap_or(feet[frame].z);
            (anchor.with_z(z) - feet[frame]).clamp_length_max(most)
        };
        for frame in frames.clone() {
            shift[frame] = of_frame(frame);
        }
        // The number of frames in the air before the contact and after it.
        let before = (0..frames.start).rev().take_while(|frame| !stands[*frame]);
        let after = (frames.end..stands.len()).take_while(|frame| !stands[*frame]);
        let sides: [(usize, Vec<usize>); 2] = [(frames.start, before.collect()), (frames.end - 1, after.collect())];
        for (edge, air) in sides {
            let length = fade.min(air.len() as f64 + 1.0);
            for (step, frame) in air.into_iter().enumerate() {
                let along = (step as f64 + 1.0) / length;
                if along < 1.0 {
                    let weight = 1.0 - along * along * (3.0 - 2.0 * along);
                    shift[frame] += weight * of_frame(edge);
                }
            }
        }
    }
    shift
}
