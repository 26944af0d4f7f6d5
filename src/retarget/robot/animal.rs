//! The motion of an animal on four legs, frame by frame: its trunk, its legs, and the stance of its paws.

use glam::{DMat3, DQuat, DVec3, Vec3};
use mocap_figure::Figure;
use mocap_figure::contacts::without_short_ones;
use mocap_figure::report::{Quadruped, QuadrupedLeg};
use mocap_scene::math::median::{median, ranked};
use mocap_scene::pose::{Binding, Pose};
use mocap_scene::scene::{Animation, NodeId, Scene};

/// The height above its resting level below which a paw is on the ground, as a fraction of the leg: paws roll.
const LOW: f64 = 0.09;

/// The speed below which a paw is in stance, in lengths of the leg per second. Captures are noisy, and paws roll.
const SLOW: f64 = 0.8;

/// The time around a frame over which the speed of a paw is averaged, in seconds. A shorter time would show noise of
/// the capture.
const AROUND: f64 = 0.02;

/// The shortest gap and the shortest contact, in seconds. Shorter gaps are closed, and shorter contacts dropped. A
/// gallop has contacts of 0.06 s.
const SHORTEST: f64 = 0.04;

/// The fraction of frames in which a paw is below its resting level, because of noise in the capture.
const RESTS: f64 = 0.1;

/// The largest tilt of a trunk in stance, in radians. An animal with a larger tilt sits.
const MOST_TILTED: f64 = 0.26;

/// The pose of an animal in a frame, in metres, +Z up.
#[derive(Clone, Copy, Debug)]
pub(super) struct AnimalFrame {
    /// The middle between hips and shoulders.
    pub(super) centre: DVec3,
    /// The rotation from forward, left and up of the trunk to the world.
    pub(super) rotation: DQuat,
    pub(super) hips: [DVec3; 4],
    pub(super) knees: [DVec3; 4],
    pub(super) paws: [DVec3; 4],
}

impl AnimalFrame {
    /// The vector from a hip or a shoulder to its paw, in the frame of the trunk.
    pub(super) fn leg(&self, index: usize) -> DVec3 {
        self.rotation.inverse() * (self.paws[index] - self.hips[index])
    }

    /// The vector of the upper part of the leg, in the frame of the trunk.
    pub(super) fn thigh(&self, index: usize) -> DVec3 {
        self.rotation.inverse() * (self.knees[index] - self.hips[index])
    }
}

/// The motion of an animal.
#[derive(Clone, Debug)]
pub(super) struct AnimalTrack {
    pub(super) frames: Vec<AnimalFrame>,
    /// The mean length of the legs along their bones, in metres.
    pub(super) leg: f64,
    /// The height at which each paw rests.
    pub(super) ground: [f64; 4],
    pub(super) contacts: Vec<[bool; 4]>,
}

impl AnimalTrack {
    pub(super) fn new(source: &Scene, animation: &Animation, figure: &Figure, animal: &Quadruped) -> Self {
        let metres = f64::from(figure.metres());
        // The file's axes in cyclic order, if +Y is up: +Z becomes +X.
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
                paws,
            });
        }
        let rest = Pose::rest(source);
        let length = |leg: &QuadrupedLeg| {
            let joints = [Some(leg.upper), Some(leg.lower), leg.ankle, Some(leg.paw)];
            let joints: Vec<DVec3> = joints.into_iter().flatten().map(|node| at(&rest, node)).collect();
            joints.windows(2).map(|pair| pair[0].distance(pair[1])).sum::<f64>()
        };
        let leg = 0.25 * animal.legs.iter().map(length).sum::<f64>();
        let mut track = Self {
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

    /// Rotates the trunk by its mean tilt in stance: shoulders may be lower or higher than hips.
    fn level(&mut self) {
        let tilts = self.frames.iter().map(|frame| (frame.rotation * DVec3::X).z.asin());
        let mut tilts: Vec<f64> = tilts.collect();
        let tilt = median(&mut tilts).unwrap_or(0.0).clamp(-MOST_TILTED, MOST_TILTED);
        let back = DQuat::from_rotation_y(tilt);
        for frame in &mut self.frames {
            frame.rotation = (frame.rotation * back).normalize();
        }
    }

    /// The paws in stance, for each frame.
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

    /// The mean sliding speed of paws in stance, in metres per second.
    pub(super) fn skate(&self, fps: f64) -> Option<f64> {
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
