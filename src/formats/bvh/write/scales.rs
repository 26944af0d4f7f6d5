//! Stores scales, for which BVH has no channels, in the positions of descendant joints.

use glam::{DMat4, DQuat, DVec3, Vec3};
use mocap_scene::scene::{Animation, Channel};

use super::motion::Motion;

/// The largest difference, as a fraction, between scales that count as equal. Rest transforms are decomposed matrices,
/// so their scales have rounding errors.
pub(super) const SAME_SCALE: f32 = 1e-5;

/// The position of each node relative to its parent in every frame, for nodes without scales and with unchanged
/// rotations. `None` if all scales are constant and even: then a factor for the lengths of descendants suffices.
pub(super) fn places(motion: &Motion<'_>) -> Option<Vec<Vec<Vec3>>> {
    let mut transforms = motion.rest();
    motion.sample(0, &mut transforms);
    let start: Vec<Vec3> = transforms.iter().map(|transform| transform.scale).collect();
    let is_same =
        |scale: Vec3, other: Vec3| (scale - other).abs().max_element() <= SAME_SCALE * other.abs().max_element();
    let is_even = |scale: &Vec3| is_same(*scale, Vec3::splat(scale.x));
    let stays = |channel: &&Channel| {
        let keys = &channel.scaling_keys.values;
        keys.iter().all(|key| is_same(*key, keys[0]))
    };
    if start.iter().all(is_even) && motion.channels.iter().flatten().all(stays) {
        return None;
    }
    let frames = motion.animation.map_or(1, Animation::frame_count);
    let mut scaled = vec![DMat4::IDENTITY; transforms.len()];
    let mut turned = vec![DQuat::IDENTITY; transforms.len()];
    let in_frame = |frame: usize| {
        motion.sample(frame, &mut transforms);
        let mut places = vec![Vec3::ZERO; transforms.len()];
        for node in motion.written() {
            let transform = transforms[node];
            let (above, turn) = motion
                .parent(node)
                .map_or((DMat4::IDENTITY, DQuat::IDENTITY), |parent| {
                    (scaled[parent], turned[parent])
                });
            scaled[node] = above * transform.matrix().as_dmat4();
            turned[node] = turn * transform.rotation.as_dquat();
            let from_parent: DVec3 = (scaled[node].w_axis - above.w_axis).truncate();
            places[node] = (turn.inverse() * from_parent).as_vec3();
        }
        places
    };
    Some((0..frames).map(in_frame).collect())
}
