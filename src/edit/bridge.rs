//! Interpolates the frames of a gap.

use glam::Vec3;
use mocap_scene::math::quaternion::{exp, log};
use mocap_scene::pose::Trs;

/// Sets the frames from `first` to `last` by cubic Hermite interpolation. The two frames before the gap give the
/// position and the speed at its start. The two frames after the gap give the position and the speed at its end.
pub(super) fn bridge(track: &mut [Trs], first: usize, last: usize) {
    let (before, after) = (first - 1, last + 1);
    let (from, to) = (track[before], track[after]);
    let steps = (after - before) as f32;
    // Rotations are interpolated in the tangent space at the frame before the gap. If only one frame is before or after
    // the gap, this frame gives no speed. The mean speed over the gap then replaces the speed.
    let whole = log(from.rotation.inverse() * to.rotation);
    let turn_in = before.checked_sub(1).map_or(whole / steps, |earlier| {
        log(track[earlier].rotation.inverse() * from.rotation)
    });
    let turn_out = track
        .get(after + 1)
        .map_or(whole / steps, |later| log(to.rotation.inverse() * later.rotation));
    let offset = to.translation - from.translation;
    let move_in = before
        .checked_sub(1)
        .map_or(offset / steps, |earlier| from.translation - track[earlier].translation);
    let move_out = track
        .get(after + 1)
        .map_or(offset / steps, |later| later.translation - to.translation);
    for (index, trs) in track[first..=last].iter_mut().enumerate() {
        let t = (index + 1) as f32 / steps;
        let moves = from.translation != to.translation;
        let turns = from.rotation != to.rotation;
        if turns {
            trs.rotation = (from.rotation * exp(cubic(whole, turn_in, turn_out, steps, t))).normalize();
        }
        if moves {
            trs.translation = from.translation + cubic(offset, move_in, move_out, steps, t);
        }
    }
}

/// The value at `t` of the cubic Hermite curve from 0 to `whole` over `steps` frames. `t` is 0 at the start of the
/// curve and 1 at its end. `start` and `end` are the changes per frame at the two ends.
fn cubic(whole: Vec3, start: Vec3, end: Vec3, steps: f32, t: f32) -> Vec3 {
    let (t2, t3) = (t * t, t * t * t);
    whole * (3.0 * t2 - 2.0 * t3) + (start * (t3 - 2.0 * t2 + t) + end * (t3 - t2)) * steps
}
