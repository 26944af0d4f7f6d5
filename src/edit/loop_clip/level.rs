//! Makes the velocity of every joint at the end of a loop equal to the velocity at its start.

use glam::Quat;
use mocap_scene::math::quaternion::{exp, log};
use mocap_scene::pose::Trs;
use mocap_scene::scene::Scene;

use crate::frames::Frames;

/// The number of frames before the seam, and of frames after it, that change.
const AROUND: usize = 2;

/// For the five frames around the seam, the shares of the acceleration at the seam that are added to the frame. The
/// shares form a Hann window, whose acceleration cancels the acceleration at the seam.
const SHARES: [f32; 2 * AROUND + 1] = [0.5, 1.5, 2.0, 1.5, 0.5];

/// Removes the accelerations of joints at the seam, for rotations in the world and for translations. The last row of
/// `rows` is the first row, moved by one cycle of the loop. `carry` moves a row to the next cycle, or with `true` to
/// the previous cycle.
pub(super) fn level(scene: &Scene, frames: &Frames, rows: &mut [Vec<Trs>], carry: impl Fn(&mut [Trs], bool)) {
    let last = rows.len() - 1;
    if last < 4 * AROUND {
        return;
    }
    let mut around = [last - 2, last - 1, 0, 1, 2].map(|row| rows[row].clone());
    around[..AROUND].iter_mut().for_each(|row| carry(row, true));
    // A second pass corrects the nonlinear part.
    for _ in 0..2 {
        correct(scene, frames, &mut around);
    }
    let mut end = around.clone();
    end[..=AROUND].iter_mut().for_each(|row| carry(row, false));
    rows[last - AROUND..].clone_from_slice(&end[..=AROUND]);
    rows[..=AROUND].clone_from_slice(&around[AROUND..]);
}

fn correct(scene: &Scene, frames: &Frames, around: &mut [Vec<Trs>; SHARES.len()]) {
    type Rotations = [Quat; SHARES.len()];
    let indices: [usize; SHARES.len()] = std::array::from_fn(|moment| moment);
    // The world rotations of all nodes, before and after the correction.
    let (mut old, mut new): (Vec<Rotations>, Vec<Rotations>) = (Vec::new(), Vec::new());
    let mut held = frames.nodes().iter().enumerate().peekable();
    for (index, node) in scene.nodes.iter().enumerate() {
        let column = held.next_if(|(_, held)| held.index() == index);
        let parent = |all: &[Rotations], moment: usize| match node.parent {
            Some(parent) => all[parent.index()][moment],
            None => Quat::IDENTITY,
        };
        let rest = Trs::from_matrix(node.transform).rotation;
        let local = indices.map(|moment| column.map_or(rest, |(column, _)| around[moment][column].rotation));
        let world = indices.map(|moment| (parent(&old, moment) * local[moment]).normalize());
        old.push(world);
        let Some((column, _)) = column else {
            new.push(indices.map(|moment| parent(&new, moment) * local[moment]));
            continue;
        };
        let seam = world[AROUND].inverse();
        let acceleration = log(world[AROUND + 1] * seam) + log(world[AROUND - 1] * seam);
        let [before, at, after] = [1, 2, 3].map(|moment: usize| around[moment][column].translation);
        let change = before + after - 2.0 * at;
        let corrected = indices.map(|moment| exp(SHARES[moment] * acceleration) * world[moment]);
        for moment in indices {
            let trs = &mut around[moment][column];
            trs.rotation = (parent(&new, moment).inverse() * corrected[moment]).normalize();
            trs.translation += SHARES[moment] * change;
        }
        new.push(corrected);
    }
}
