//! Rotates from the axes of a camera, which may be tilted, to a level world.

use glam::{DMat2, DQuat, DVec2, DVec3};
use mocap_scene::math::median::median;
use mocap_scene::report::counted;
use mocap_scene::scene::joint_tables::Joint;
use mocap_scene::scene::{Confidence, HumanoidBone as Bone, Topic};

use super::Sample;
use crate::array_files::read::motion::Motion;

/// The largest tilt of a camera in degrees. If a body seems tilted more, it lies or does a handstand.
const MOST_TILT: f64 = 50.0;

/// If the mean of the unit posture directions is shorter than this number, the directions contradict each other.
const STEADY: f64 = 0.5;

/// The standard deviation of the height of the lower foot above the ground, in metres.
const FOOT_NOISE: f64 = 0.03;

/// The standard deviation of the mean posture from the vertical, in radians: for a body that walks, and for one that
/// stays in place and may lean. In clips of 30 kinds of motion the median error of the mean is 3 degrees.
const POSTURE_NOISE: [f64; 2] = [0.06, 0.14];

/// The standard deviation of the up direction from parallel soles, in radians. In the clips of `POSTURE_NOISE`, the
/// median error is 1.4 degrees. In the fifth of the clips with the largest errors, the median error is 11 degrees.
const SOLE_NOISE: f64 = 0.07;

/// The largest angle in degrees between soles on the same ground.
const PARALLEL: f64 = 16.0;

/// The largest height difference in metres between feet that stand side by side.
const SIDE_BY_SIDE: f64 = 0.04;

/// The smallest mean distance in metres between the steps of a body that counts as walking.
const WALKED: f64 = 0.5;

/// The height in metres of the ball joint above the sole, from the vertices of SAM 3D Body for standing feet.
pub(super) const BALL_HEIGHT: f64 = 0.024;

/// Points of the sole in metres, in the axes of the ball joint in the T-pose: below the joint, and at the end of the
/// toes. These points and `HEEL` come from the same vertices.
const BALL: [DVec3; 2] = [DVec3::new(0.0, -BALL_HEIGHT, 0.0), DVec3::new(0.0, -BALL_HEIGHT, 0.05)];

/// The heel, relative to the parent of the ball joint, in the axes of this parent.
const HEEL: DVec3 = DVec3::new(0.0, -0.05, -0.118);

/// The rotation that makes the ground level.
pub(super) struct Level {
    pub(super) turn: DQuat,
    tilt: f64,
    /// The mean distance between steps, in metres.
    walked: f64,
    /// The number of frames with parallel soles.
    flat: usize,
    is_upright: bool,
    is_stated: bool,
}

impl Level {
    /// Finds the up direction. If the file states an up direction, mocap uses the stated direction unchanged. Otherwise
    /// the up direction is the mean of the postures and of the normals of parallel soles. If the postures show no
    /// upright body, the camera counts as level. If the lowest sole stands in several places, the ground through these
    /// places corrects the result. The standard deviations determine the weights, as in least squares.
    pub(super) fn of(joints: &[Joint], frames: &[DQuat], samples: &[Sample], stated: Option<DVec3>) -> Self {
        let of = |up: DVec3, walked: f64, flat: usize| Self {
            turn: DQuat::from_rotation_arc(up, DVec3::Y),
            tilt: up.angle_between(DVec3::Y).to_degrees(),
            walked,
            flat,
            is_upright: true,
            is_stated: stated.is_some(),
        };
        if let Some(up) = stated.and_then(DVec3::try_normalize) {
            return of(up, 0.0, 0);
        }
        let feet = Feet::new(joints, frames);
        let [neck, ankle, other] = [Bone::Neck, Bone::LeftFoot, Bone::RightFoot].map(|bone| find(joints, bone));
        let posture = |sample: &Sample| {
            let at = |joint: usize| sample.at(joint);
            (at(neck) - at(ankle).midpoint(at(other))).normalize_or_zero()
        };
        let mean = samples.iter().map(posture).sum::<DVec3>() / samples.len().max(1) as f64;
        let up = mean.normalize_or(DVec3::Y);
        let is_upright = mean.length() > STEADY && up.angle_between(DVec3::Y).to_degrees() < MOST_TILT;
        if !is_upright {
            let camera = of(DVec3::Y, 0.0, 0);
            return Self { is_upright, ..camera };
        }
        let steps: Vec<DVec3> = samples.iter().filter_map(|sample| feet.lowest(sample, up)).collect();
        let share = 1.0 / steps.len().max(1) as f64;
        let middle = steps.iter().sum::<DVec3>() * share;
        let walked = steps.iter().map(|step| step.distance(middle)).sum::<f64>() * share;
        let posture_noise = POSTURE_NOISE[usize::from(walked < WALKED)];
        let soles: Vec<DVec3> = samples.iter().filter_map(|sample| feet.soles(sample, up)).collect();
        let of_soles = soles.iter().sum::<DVec3>() * share * (posture_noise / SOLE_NOISE).powi(2);
        let up = (up + of_soles).normalize();
        let (x, z) = up.any_orthonormal_pair();
        let (mut sums, mut right) = (DMat2::IDENTITY * (FOOT_NOISE / posture_noise).powi(2), DVec2::ZERO);
        for step in &steps {
            let from_middle = *step - middle;
            let across = DVec2::new(x.dot(from_middle), z.dot(from_middle));
            sums += DMat2::from_cols(across * across.x, across * across.y) * share;
            right -= across * up.dot(from_middle) * share;
        }
        let slope = sums.inverse() * right;
        let up = (up + x * slope.x + z * slope.y).normalize();
        of(up, walked, soles.len())
    }

    /// Records how the up direction was found.
    pub(super) fn assume(&self, motion: &mut Motion) {
        let (choice, reason, confidence) = match self {
            Self {
                is_stated: true, tilt, ..
            } => (
                format!("the camera is tilted by {tilt:.0} degrees"),
                "the file states the up direction".to_owned(),
                Confidence::Sure,
            ),
            Self { is_upright: false, .. } => (
                "the camera is level".to_owned(),
                "the body is not upright, so its posture does not show the tilt of the camera".to_owned(),
                Confidence::Unsure,
            ),
            Self { tilt, walked, flat, .. } => (
                format!("the camera is tilted by {tilt:.0} degrees"),
                match flat {
                    0 => format!(
                        "feet, neck and the ground below the steps show this tilt; the mean distance of steps from \
                        their centre is {walked:.1} m"
                    ),
                    flat => format!(
                        "feet, neck, parallel soles in {} and the ground below the steps show this tilt; the mean \
                        distance of steps from their centre is {walked:.1} m",
                        counted(*flat, "frame")
                    ),
                },
                if *walked > WALKED {
                    Confidence::Likely
                } else {
                    Confidence::Unsure
                },
            ),
        };
        motion.assume(Topic::Up, choice, reason, confidence);
    }

    /// The median height of the ground below the soles. In a file that states the up direction the ground is at 0.
    pub(super) fn floor(&self, joints: &[Joint], frames: &[DQuat], samples: &[Sample]) -> f64 {
        if self.is_stated {
            return 0.0;
        }
        let feet = Feet::new(joints, frames);
        let up = self.turn.inverse() * DVec3::Y;
        let lowest = samples.iter().filter_map(|sample| feet.lowest(sample, up));
        let mut heights: Vec<f64> = lowest.map(|place| up.dot(place)).collect();
        median(&mut heights).unwrap_or(0.0)
    }
}

fn find(joints: &[Joint], bone: Bone) -> usize {
    joints.iter().position(|joint| joint.bone == Some(bone)).unwrap_or(0)
}

/// The joints near the ground when a body stands.
pub(super) fn feet(joints: &[Joint]) -> [usize; 2] {
    [Bone::LeftToes, Bone::RightToes].map(|bone| find(joints, bone))
}

/// The soles of a body.
struct Feet<'a> {
    /// The ball joints, each with its parent.
    joints: [[usize; 2]; 2],
    /// The axes of the joints in the T-pose.
    frames: &'a [DQuat],
}

impl<'a> Feet<'a> {
    fn new(joints: &[Joint], frames: &'a [DQuat]) -> Self {
        Self {
            joints: feet(joints).map(|ball| [ball, joints[ball].parent.unwrap_or(0)]),
            frames,
        }
    }

    /// The rotation of a joint from the T-pose.
    fn turn(&self, sample: &Sample, joint: usize) -> DQuat {
        sample.rotation(joint) * self.frames[joint].inverse()
    }

    /// The normal of both soles, if they are parallel.
    fn soles(&self, sample: &Sample, up: DVec3) -> Option<DVec3> {
        let [left, right] = self.joints.map(|[ball, _]| self.turn(sample, ball) * DVec3::Y);
        let [[one, _], [other, _]] = self.joints;
        let rise = up.dot(sample.at(one) - sample.at(other)).abs();
        let is_flat = rise < SIDE_BY_SIDE && left.angle_between(right).to_degrees() < PARALLEL;
        (left + right).try_normalize().filter(|_| is_flat)
    }

    /// The lowest point of the soles, in camera axes with +Y up.
    fn lowest(&self, sample: &Sample, up: DVec3) -> Option<DVec3> {
        let points = self.joints.iter().flat_map(|[ball, above]| {
            let [ball, above] = [*ball, *above];
            let of_ball = BALL.map(|point| sample.at(ball) + self.turn(sample, ball) * point);
            let heel = sample.at(above) + self.turn(sample, above) * HEEL;
            of_ball.into_iter().chain([heel])
        });
        points
            .map(|point| point + sample.place)
            .min_by(|a, b| up.dot(*a).total_cmp(&up.dot(*b)))
    }
}
