//! Repairs sudden rolls. In a sudden roll, a bone rotates about its own axis between two frames, and does not rotate
//! back. Camera-based capture cannot see the roll of an arm while its elbow is straight. A roll moves no joint, so the
//! repair spreads it over several frames before and after. Joints below the bone keep their rotation in the world.

use std::f32::consts::{PI, TAU};
use std::ops::Range;

use glam::{Quat, Vec3};
use mocap_scene::math::quaternion::{in_hemisphere_of, log};
use mocap_scene::pose::Trs;
use mocap_scene::scene::{NodeId, NodeKind, Scene};

use super::frames::Frames;

/// A roll is spread over this time before it and after it, in seconds.
const SPREAD: f64 = 0.2;
/// The largest number of frames on either side over which a roll is spread. With this limit, the running time is
/// proportional to the number of frames.
const MOST_FRAMES: usize = 500;
/// A jump counts as a roll if its rotation about other axes is at most this fraction of the roll.
const ASIDE: f32 = 0.4;
/// The smallest rotation of a joint below the bone that counts as a jump, in degrees.
const CALM: f32 = 20.0;

/// A joint that rolls about its bone.
struct TwistedJoint {
    column: usize,
    bone: Vec3,
    /// The angle in radians.
    angle: f32,
}

/// Spreads the jump of a joint between `frame - 1` and `frame` over several frames. The jump must be a roll about the
/// joint's bone, and jumps of the joints below must be rolls, too. Returns the changed columns and frames; no columns
/// if one of these jumps is no roll.
pub(super) fn spread(scene: &Scene, frames: &mut Frames, column: usize, frame: usize) -> (Vec<usize>, Range<usize>) {
    let width = ((SPREAD * frames.rate).round() as usize).clamp(2, MOST_FRAMES);
    let within = frame.saturating_sub(width)..(frame + width).min(frames.len());
    let Some(turns) = turns(scene, frames, column, frame) else {
        return (Vec::new(), within);
    };
    let mut changed = Vec::new();
    for turn in &turns {
        let child = only_child(scene, frames.nodes()[turn.column]).and_then(|child| frames.column(child));
        let child = child.filter(|child| !is_end(scene, frames.nodes()[*child]));
        for at in within.clone() {
            let weight = eased(at, frame, width) - f32::from(at >= frame);
            let off = Quat::from_axis_angle(turn.bone, weight * turn.angle);
            rotate(frames, turn.column, at, |rotation| rotation * off);
            if let Some(child) = child {
                rotate(frames, child, at, |rotation| off.inverse() * rotation);
            }
        }
        changed.extend(std::iter::once(turn.column).chain(child));
    }
    changed.sort_unstable();
    changed.dedup();
    (changed, within)
}

/// Spreads the rotation of a joint between `frame - 1` and `frame` over frames before and after it. Returns the changed
/// frames.
pub(super) fn ease(frames: &mut Frames, column: usize, frame: usize) -> Range<usize> {
    let width = ((SPREAD * frames.rate).round() as usize).clamp(2, MOST_FRAMES);
    let within = frame.saturating_sub(width)..(frame + width).min(frames.len());
    let [before, after] = [frame - 1, frame].map(|frame| frames.at(frame, column).rotation);
    let step = in_hemisphere_of(Quat::IDENTITY, before.inverse() * after);
    for at in within.clone() {
        let weight = eased(at, frame, width) - f32::from(at >= frame);
        let off = Quat::from_scaled_axis(weight * step.to_scaled_axis());
        rotate(frames, column, at, |rotation| rotation * off);
    }
    within
}

/// The fraction of a jump at `frame` that is already done at the frame `at`, if the jump is spread over `width` frames
/// on either side.
fn eased(at: usize, frame: usize, width: usize) -> f32 {
    let along = (at as f32 + 0.5 - frame as f32) / width as f32;
    let fraction = (0.5 + 0.5 * along).clamp(0.0, 1.0);
    fraction * fraction * (3.0 - 2.0 * fraction)
}

/// The joint, and the chain of joints below it that jump too, each with its roll. `None` if one of these jumps is no
/// roll.
fn turns(scene: &Scene, frames: &Frames, column: usize, frame: usize) -> Option<Vec<TwistedJoint>> {
    let at = |column: usize| [frame - 1, frame].map(|frame| frames.at(frame, column));
    let [before, after] = at(column);
    let mut jump = before.rotation.inverse() * after.rotation;
    let (mut column, mut turns) = (column, Vec::new());
    loop {
        let child = only_child(scene, frames.nodes()[column])?;
        let below = frames.column(child);
        let rest = Trs::from_matrix(scene.nodes[child.index()].transform).translation;
        let bone = below.map_or(rest, |below| frames.at(frame, below).translation);
        let bone = bone.try_normalize()?;
        let angle = 2.0 * Vec3::new(jump.x, jump.y, jump.z).dot(bone).atan2(jump.w);
        let angle = angle - TAU * ((angle + PI) / TAU).floor();
        let turn = Quat::from_axis_angle(bone, angle);
        if log(jump * turn.inverse()).length() > ASIDE * angle.abs() {
            return None;
        }
        turns.push(TwistedJoint { column, bone, angle });
        let Some(below) = below.filter(|_| !is_end(scene, child)) else {
            return Some(turns);
        };
        let [before, after] = at(below);
        jump = before.rotation.inverse() * turn * after.rotation;
        if log(jump).length() < CALM.to_radians() {
            return Some(turns);
        }
        column = below;
    }
}

/// The child of a joint, if it has exactly one.
fn only_child(scene: &Scene, joint: NodeId) -> Option<NodeId> {
    let mut children = (0..scene.nodes.len()).filter(|node| scene.nodes[*node].parent == Some(joint));
    let child = children.next()?;
    children.next().is_none().then(|| NodeId::new(child))
}

/// Whether no joint is below a node. Such a node may turn with its parent when the repair turns the parent.
fn is_end(scene: &Scene, joint: NodeId) -> bool {
    let is_below = |node: &&mocap_scene::scene::Node| node.parent == Some(joint);
    scene
        .nodes
        .iter()
        .filter(is_below)
        .all(|node| node.kind == NodeKind::EndSite)
}

fn rotate(frames: &mut Frames, column: usize, frame: usize, by: impl Fn(Quat) -> Quat) {
    let trs = frames.at(frame, column);
    let rotation = in_hemisphere_of(trs.rotation, by(trs.rotation).normalize());
    frames.set(frame, frames.nodes()[column], Trs { rotation, ..trs });
}
