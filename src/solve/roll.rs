//! The roll of a limb, from the hinge at its end, over all frames.

use std::f32::consts::{PI, TAU};

use glam::{Quat, Vec3};

use mocap_scene::math::directions::arc;

/// The bend in degrees below which a hinge does not show the roll. Noise of the points, or a knee that bends slightly
/// backwards, would roll the limb by half a turn.
const TELLS: f32 = 20.0;

/// The smallest bend in degrees at which a frame shows the roll, if no frame has a bend of [`TELLS`].
const TELLS_LITTLE: f32 = 6.0;

/// The fastest change of roll from one frame to the next, in degrees, in addition to the rotation of the limb itself.
const FASTEST: f32 = 45.0;

/// A limb in one frame, in the axes of its parent: its direction, and the direction of the bone after the hinge.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limb {
    pub(super) upper: Vec3,
    pub(super) lower: Vec3,
}

impl Limb {
    /// The axis of the hinge, and its bend in degrees.
    fn hinge(&self) -> (Vec3, f32) {
        let axis = self.upper.cross(self.lower);
        let bend = axis.length().atan2(self.upper.dot(self.lower)).to_degrees();
        (axis.normalize_or_zero(), bend)
    }
}

/// The hinge axis in each frame, at right angles to the limb. In the T-pose the limb points along `direction` and bends
/// about `axis`.
pub(super) fn axes(limbs: &[Limb], direction: Vec3, axis: Vec3) -> Vec<Vec3> {
    let carried = carried(limbs, direction, axis);
    let most = limbs
        .iter()
        .map(|limb| limb.hinge().1)
        .filter(|bend| *bend < 175.0)
        .fold(0.0, f32::max);
    let tells = if most >= TELLS { TELLS } else { TELLS_LITTLE };
    // A limb that is folded back onto itself also has no axis.
    let angle = |frame: usize| {
        let (hinge, bend) = limbs[frame].hinge();
        (bend >= tells && bend <= 180.0 - TELLS_LITTLE).then(|| {
            let across = limbs[frame].upper.cross(carried[frame]);
            hinge.dot(across).atan2(hinge.dot(carried[frame]))
        })
    };
    let known: Vec<(usize, f32)> = (0..limbs.len())
        .filter_map(|frame| Some((frame, angle(frame)?)))
        .collect();
    let angles = limited(&between(&unwrapped(known), limbs.len()));
    (0..limbs.len())
        .map(|frame| Quat::from_axis_angle(limbs[frame].upper, angles[frame]) * carried[frame])
        .collect()
}

/// The axis of the T-pose, carried to the first frame by the shortest rotation, and then from each frame to the next.
fn carried(limbs: &[Limb], direction: Vec3, axis: Vec3) -> Vec<Vec3> {
    let (mut before, mut carried) = (direction, axis);
    limbs
        .iter()
        .map(|limb| {
            carried = arc(before, limb.upper) * carried;
            // Remove the rounding error, which grows over a long motion.
            carried =
                (carried - limb.upper * limb.upper.dot(carried)).normalize_or(limb.upper.any_orthonormal_vector());
            before = limb.upper;
            carried
        })
        .collect()
}

/// Adds whole revolutions so that each angle is as near as possible to the one before.
fn unwrapped(mut known: Vec<(usize, f32)>) -> Vec<(usize, f32)> {
    let mut before = known.first().map_or(0.0, |(_, angle)| *angle);
    for (_, angle) in &mut known {
        *angle = before + (*angle - before + PI).rem_euclid(TAU) - PI;
        before = *angle;
    }
    known
}

/// An angle for every frame: interpolated linearly between known angles; 0 if none is known.
fn between(known: &[(usize, f32)], frames: usize) -> Vec<f32> {
    let mut angles = vec![known.first().map_or(0.0, |(_, angle)| *angle); frames];
    for pair in known.windows(2) {
        let ((first, from), (last, to)) = (pair[0], pair[1]);
        for (frame, angle) in angles.iter_mut().enumerate().take(last).skip(first) {
            *angle = from + (to - from) * (frame - first) as f32 / (last - first) as f32;
        }
    }
    if let Some((last, angle)) = known.last() {
        angles[*last..].fill(*angle);
    }
    angles
}

/// The angles with no change above [`FASTEST`]: the mean of a forward and a backward limiter.
fn limited(angles: &[f32]) -> Vec<f32> {
    let most = FASTEST.to_radians();
    let pass = |angles: &mut dyn Iterator<Item = f32>| {
        let mut before: Option<f32> = None;
        let mut limited = Vec::new();
        for angle in angles {
            let angle = before.map_or(angle, |before| angle.clamp(before - most, before + most));
            limited.push(angle);
            before = Some(angle);
        }
        limited
    };
    let forwards = pass(&mut angles.iter().copied());
    let backwards = pass(&mut angles.iter().rev().copied());
    std::iter::zip(forwards, backwards.into_iter().rev())
        .map(|(a, b)| 0.5 * (a + b))
        .collect()
}
