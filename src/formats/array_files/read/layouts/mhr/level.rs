//! From the frame of a camera, which may look down or up, to a level world.

use glam::{DMat2, DQuat, DVec2, DVec3};
use mocap_scene::math::median::median;
use mocap_scene::scene::joint_tables::Joint;
use mocap_scene::scene::{Confidence, HumanoidBone as Bone, Topic};

use super::Sample;
use crate::array_files::read::motion::Motion;

/// Degrees that a camera is tilted at most: beyond them the body lies or does a handstand.
const MOST_TILT: f64 = 50.0;

/// The length of the mean of the directions of postures, below which they contradict each other.
const STEADY: f64 = 0.5;

/// Standard deviation of the height of the lower foot above the ground, in metres.
const FOOT_NOISE: f64 = 0.03;

/// Standard deviation of the mean of postures from the vertical, in radians.
const POSTURE_NOISE: f64 = 0.06;

/// Metres between steps on the average from which on the ground below them is level.
const WALKED: f64 = 0.5;

/// Metres from the sole to the joint of the ball, as the vertices of SAM 3D Body have it.
pub(super) const BALL_HEIGHT: f64 = 0.035;

/// The rotation that makes the ground level.
pub(super) struct Level {
    pub(super) turn: DQuat,
    tilt: f64,
    /// How far apart the steps are, on the average.
    walked: f64,
    is_upright: bool,
    is_stated: bool,
}

impl Level {
    /// Along the mean of the postures, corrected by the ground below the lower foot of each frame where it stands in
    /// several places: the least squares of both, each by its deviation.
    pub(super) fn of(joints: &[Joint], samples: &[Sample], stated: Option<DVec3>) -> Self {
        let of = |up: DVec3, walked: f64| Self {
            turn: DQuat::from_rotation_arc(up, DVec3::Y),
            tilt: up.angle_between(DVec3::Y).to_degrees(),
            walked,
            is_upright: true,
            is_stated: stated.is_some(),
        };
        if let Some(up) = stated.and_then(DVec3::try_normalize) {
            return of(up, 0.0);
        }
        let feet = feet(joints);
        let [neck, ankle, other] = [Bone::Neck, Bone::LeftFoot, Bone::RightFoot].map(|bone| find(joints, bone));
        let posture = |sample: &Sample| {
            let at = |joint: usize| sample.positions[joint];
            (at(neck) - at(ankle).midpoint(at(other))).normalize_or_zero()
        };
        let mean = samples.iter().map(posture).sum::<DVec3>() / samples.len().max(1) as f64;
        let up = mean.normalize_or(DVec3::Y);
        let is_upright = mean.length() > STEADY && up.angle_between(DVec3::Y).to_degrees() < MOST_TILT;
        if !is_upright {
            let camera = of(DVec3::Y, 0.0);
            return Self { is_upright, ..camera };
        }
        let steps: Vec<DVec3> = samples
            .iter()
            .filter_map(|sample| lower_foot(&feet, sample, up))
            .collect();
        let middle = steps.iter().sum::<DVec3>() / steps.len().max(1) as f64;
        let (x, z) = up.any_orthonormal_pair();
        let (mut sums, mut right) = (DMat2::IDENTITY * (FOOT_NOISE / POSTURE_NOISE).powi(2), DVec2::ZERO);
        let share = 1.0 / steps.len().max(1) as f64;
        for step in &steps {
            let from_middle = *step - middle;
            let across = DVec2::new(x.dot(from_middle), z.dot(from_middle));
            sums += DMat2::from_cols(across * across.x, across * across.y) * share;
            right -= across * up.dot(from_middle) * share;
        }
        let slope = sums.inverse() * right;
        let up = (up + x * slope.x + z * slope.y).normalize();
        let walked = steps.iter().map(|step| step.distance(middle)).sum::<f64>() * share;
        of(up, walked)
    }

    /// Says how the world was found.
    pub(super) fn assume(&self, motion: &mut Motion) {
        let (choice, reason, confidence) = match self {
            Self {
                is_stated: true, tilt, ..
            } => (
                format!("the camera is tilted by {tilt:.0} degrees"),
                "the file says which direction is up".to_owned(),
                Confidence::Sure,
            ),
            Self { is_upright: false, .. } => (
                "the camera is level".to_owned(),
                "the body is not upright, so its posture does not tell how the camera is tilted".to_owned(),
                Confidence::Unsure,
            ),
            Self { tilt, walked, .. } => (
                format!("the camera is tilted by {tilt:.0} degrees"),
                format!(
                    "feet and neck of the frames say so, and the ground below steps {walked:.1} m from their middle"
                ),
                if *walked > WALKED {
                    Confidence::Likely
                } else {
                    Confidence::Unsure
                },
            ),
        };
        motion.assume(Topic::Up, choice, reason, confidence);
    }

    /// The height of the ground below the lower foot, as the median of the frames. A file that states which direction
    /// is up has the ground at 0.
    pub(super) fn floor(&self, joints: &[Joint], samples: &[Sample]) -> f64 {
        if self.is_stated {
            return 0.0;
        }
        let feet = feet(joints);
        let heights = samples
            .iter()
            .filter_map(|sample| lower_foot(&feet, sample, self.turn.inverse() * DVec3::Y));
        let mut heights: Vec<f64> = heights.map(|foot| (self.turn * foot).y).collect();
        median(&mut heights).map_or(0.0, |height| height - BALL_HEIGHT)
    }
}

fn find(joints: &[Joint], bone: Bone) -> usize {
    joints.iter().position(|joint| joint.bone == Some(bone)).unwrap_or(0)
}

/// The joints that are near the ground where a body stands.
pub(super) fn feet(joints: &[Joint]) -> [usize; 2] {
    [Bone::LeftToes, Bone::RightToes].map(|bone| find(joints, bone))
}

/// Where the lower foot is, in the camera's frame with +Y up.
fn lower_foot(feet: &[usize; 2], sample: &Sample, up: DVec3) -> Option<DVec3> {
    let places = feet.iter().map(|foot| sample.positions[*foot] + sample.place);
    places.min_by(|a, b| up.dot(*a).total_cmp(&up.dot(*b)))
}
