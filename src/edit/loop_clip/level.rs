//! Lets every joint go into the end of a loop as fast as out of its start.

use glam::Quat;

use crate::edit::frames::Frames;
use crate::math::quaternion::{exp, log};
use crate::pose::Trs;
use crate::scene::Scene;

/// How many frames change on each side of the seam.
const AROUND: usize = 2;

/// What of the acceleration at the seam is added two frames before it, one before, there, and after: a Hann window,
/// whose own acceleration takes it back.
const SHARES: [f32; 2 * AROUND + 1] = [0.5, 1.5, 2.0, 1.5, 0.5];

/// Takes the accelerations of joints at the seam out: those of their rotations in the world, and of their translations.
/// `rows` is a loop whose last row is its first one, moved onward by `carry`, which with `true` moves a row back.
pub(super) fn level(scene: &Scene, frames: &Frames, rows: &mut [Vec<Trs>], carry: impl Fn(&mut [Trs], bool)) {
    let last = rows.len() - 1;
    if last < 4 * AROUND {
        return;
    }
    let mut around = [last - 2, last - 1, 0, 1, 2].map(|row| rows[row].clone());
    around[..AROUND].iter_mut().for_each(|row| carry(row, true));
    // The second time for what is not linear.
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
    let places: [usize; SHARES.len()] = std::array::from_fn(|place| place);
    // The rotations of all nodes to the world, before and after.
    let (mut old, mut new): (Vec<Rotations>, Vec<Rotations>) = (Vec::new(), Vec::new());
    let mut held = frames.nodes().iter().enumerate().peekable();
    for (index, node) in scene.nodes.iter().enumerate() {
        let column = held.next_if(|(_, held)| held.index() == index);
        let parent = |all: &[Rotations], place: usize| match node.parent {
            Some(parent) => all[parent.index()][place],
            None => Quat::IDENTITY,
        };
        let rest = Trs::from_matrix(node.transform).rotation;
        let local = places.map(|place| column.map_or(rest, |(column, _)| around[place][column].rotation));
        let world = places.map(|place| (parent(&old, place) * local[place]).normalize());
        old.push(world);
        let Some((column, _)) = column else {
            new.push(places.map(|place| parent(&new, place) * local[place]));
            continue;
        };
        let seam = world[AROUND].inverse();
        let acceleration = log(world[AROUND + 1] * seam) + log(world[AROUND - 1] * seam);
        let [before, at, after] = [1, 2, 3].map(|place: usize| around[place][column].translation);
        let change = before + after - 2.0 * at;
        let corrected = places.map(|place| exp(SHARES[place] * acceleration) * world[place]);
        for place in places {
            let trs = &mut around[place][column];
            trs.rotation = (parent(&new, place).inverse() * corrected[place]).normalize();
            trs.translation += SHARES[place] * change;
        }
        new.push(corrected);
    }
}
