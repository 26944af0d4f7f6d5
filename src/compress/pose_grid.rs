//! Keys that all joints share: a frame goes only where no joint needs it.

use glam::{Quat, Vec3};

use super::chain::blend;
use super::keys::{self, Grid};
use super::motion::{Motion, World};

/// As few frames as it takes that no joint is more than `tolerance` metres from its place where the pose between is
/// interpolated.
pub(super) fn choose(motion: &Motion, truth: &[World], tolerance: f32) -> Grid {
    let mut pose = vec![(Vec3::ZERO, Quat::IDENTITY); motion.joints.len()];
    keys::farthest(motion.frames(), |from, to| {
        let mut inner = keys::inner(&motion.ticks, from, to);
        inner.all(|(frame, share)| is_near(motion, truth, [from, to, frame], share, tolerance, &mut pose))
    })
}

fn is_near(
    motion: &Motion,
    truth: &[World],
    [from, to, frame]: [usize; 3],
    share: f32,
    tolerance: f32,
    pose: &mut [(Vec3, Quat)],
) -> bool {
    for (index, joint) in motion.joints.iter().enumerate() {
        let translation = if joint.translation.moves() {
            joint.translation.at(from).lerp(joint.translation.at(to), share)
        } else {
            joint.translation.at(0)
        };
        let rotation = if joint.rotation.moves() {
            blend(joint.rotation.at(from), joint.rotation.at(to), share)
        } else {
            joint.rotation.at(0)
        };
        pose[index] = match joint.parent {
            None => (translation, rotation),
            Some(parent) => {
                let above = pose[parent];
                let way = translation * motion.joints[parent].scale;
                (above.0 + above.1 * way, above.1 * rotation)
            }
        };
        let place = match truth[index].positions.get(frame) {
            Some(place) => *place,
            None => {
                let Some(parent) = joint.parent else { continue };
                let above = &truth[parent];
                above.positions[frame] + above.rotations[frame] * (translation * motion.joints[parent].scale)
            }
        };
        if pose[index].0.distance_squared(place) > tolerance * tolerance {
            return false;
        }
    }
    true
}
