//! Which of the codes around a rotation to take: one that keeps the children where they belong and costs little.
//!
//! A joint's turn about the way to its child hardly moves that child, so that among the codes around the wanted one
//! there are some that are far better than the nearest. That spares about a bit of every component. What is cheap is
//! said by the streams: differences to the code before, in 2, 4 or 8 bits each.

use glam::Vec3;

use super::chain::{Arms, SHELL, Task};
use super::code::{CodedRotation, FINE, Lattice, floor};

/// The bits of a difference of so many steps, nearly: see [`stream`](super::stream).
fn price(difference: i32) -> f32 {
    match difference.unsigned_abs() {
        0 => 0.0,
        1 => 2.0,
        2..=7 => 4.0,
        _ => 8.0,
    }
}

/// Bits that an error as large as the tolerance is worth, in the square: what is left of it has to be made up for
/// further down the chain. Found by trying on the fixtures.
const WORTH: f32 = 12.0;

/// The share of the tolerance, squared, beyond which a code is none: what is left is for rounding.
const MOST: f32 = 0.98;

/// The share of the tolerance by which readers may differ about one joint. It cannot be made up for, for only some of them
/// see it.
const DIFFERENCE: f32 = 0.15;

/// What a code costs that is off by more than the tolerance.
const TOO_FAR: f32 = 1000.0;

/// The most that the filter takes.
pub(super) const MOST_BITS: u32 = 16;

/// The corners of a cube of the grid.
const CORNERS: usize = 8;

/// The codes for some frames; none where so many bits leave one of them off by more than `tolerance`, unless they are
/// the most that there are.
pub(super) fn choose(
    task: &Task,
    arms: &Arms,
    bits: u32,
    frames: &[u32],
    tolerance: f32,
) -> Option<Vec<CodedRotation>> {
    let mut keys: Vec<CodedRotation> = Vec::with_capacity(frames.len());
    for &frame in frames {
        let frame = frame as usize;
        let around = Around::new(task, arms, bits, frame, keys.last(), tolerance);
        let (key, error) = around.best();
        if error > tolerance && bits < MOST_BITS {
            return None;
        }
        keys.push(key);
    }
    Some(keys)
}

/// Whether codes of so many bits can be near enough, by a look at some frames.
pub(super) fn may_suffice(task: &Task, arms: &Arms, bits: u32, frames: &[u32], tolerance: f32) -> bool {
    const EVERY: usize = 13;
    frames.iter().step_by(EVERY).all(|&frame| {
        let frame = frame as usize;
        let around = Around::new(task, arms, bits, frame, None, tolerance);
        around.best().1 <= tolerance
    })
}

/// A corner of a cube.
struct Found {
    stored: [i32; 3],
    /// Whether it is near enough, and all readers understand it alike.
    is_good: bool,
}

/// The codes around one rotation.
struct Around<'a> {
    task: &'a Task,
    arms: &'a Arms,
    frame: usize,
    lattice: Lattice,
    bits: u32,
    /// How much too far the wanted rotation turns it: the axis, times the angle.
    turn: Vec3,
    /// What a step of each component adds to that.
    turns: [Vec3; 3],
    /// The code before, if differences to it mean something.
    before: Option<[i32; 3]>,
    tolerance: f32,
}

impl<'a> Around<'a> {
    fn new(
        task: &'a Task,
        arms: &'a Arms,
        bits: u32,
        frame: usize,
        previous: Option<&CodedRotation>,
        tolerance: f32,
    ) -> Self {
        let lattice = Lattice::new(task.wanted[frame], bits, previous);
        let to_turn = task.to_turn[frame];
        let near = to_turn * lattice.rotation;
        let twice = if near.w < 0.0 { -2.0 } else { 2.0 };
        Self {
            task,
            arms,
            frame,
            bits,
            turn: near.xyz() * twice,
            turns: lattice.steps.map(|step| (to_turn * step).xyz() * twice),
            before: previous
                .filter(|previous| lattice.continues(previous))
                .map(|previous| [0, 1, 2].map(|slot| i32::from(previous.code[slot]))),
            lattice,
            tolerance,
        }
    }

    /// The best code, and the error that it leaves.
    fn best(&self) -> (CodedRotation, f32) {
        let base = self.lattice.exact.map(floor);
        let near = self.cheapest([(base, self.scores(base))]);
        let stored = if near.is_good {
            near.stored
        } else {
            // The eight cubes around the corner that is next to it.
            let cubes: [_; CORNERS] = std::array::from_fn(|corner| {
                let base = [0, 1, 2].map(|slot| base[slot] + if corner >> slot & 1 == 0 { -1 } else { 1 });
                (base, self.scores(base))
            });
            self.cheapest(cubes).stored
        };
        let key = self.lattice.code(stored);
        (key, self.task.error(self.arms, self.frame, key.value))
    }

    /// The cheapest of the corners of some cubes that all readers understand alike; if there is none, the one of those
    /// that are near enough about which they differ least.
    fn cheapest<const N: usize>(&self, mut cubes: [([i32; 3], [f32; CORNERS]); N]) -> Found {
        let mut least: Option<(Found, f32)> = None;
        loop {
            let mut best = (0, 0, f32::INFINITY);
            for (place, (_, scores)) in cubes.iter().enumerate() {
                for (corner, &score) in scores.iter().enumerate() {
                    if score < best.2 {
                        best = (place, corner, score);
                    }
                }
            }
            let (place, corner, score) = best;
            let stored = [0, 1, 2].map(|slot| cubes[place].0[slot] + (corner >> slot & 1) as i32);
            let is_near = score < TOO_FAR;
            let difference = if self.bits < FINE { 0.0 } else { self.difference(stored) };
            let is_good = is_near && difference <= DIFFERENCE * self.tolerance;
            let found = Found { stored, is_good };
            if is_good {
                return found;
            }
            if !is_near {
                return least.map_or(found, |least| least.0);
            }
            if least.as_ref().is_none_or(|least| difference < least.1) {
                least = Some((found, difference));
            }
            cubes[place].1[corner] = f32::INFINITY;
        }
    }

    /// How far readers may differ, in metres at the end of the chain: about the rounding of a code, and about a length
    /// that is not 1.
    fn difference(&self, stored: [i32; 3]) -> f32 {
        let key = self.lattice.code(stored);
        let stretch = (key.value.length_squared() - 1.0).abs();
        (stretch + key.doubt() as f32) * self.arms.reach
    }

    /// What each corner of a cube costs, in bits: those of its differences, and what its error is worth. To first
    /// order, for a step is a small turn.
    fn scores(&self, base: [i32; 3]) -> [f32; CORNERS] {
        // What the two values of each component add.
        let sides: [[(Vec3, f32); 2]; 3] = std::array::from_fn(|slot| {
            [0, 1].map(|side| {
                let stored = base[slot] + side;
                let turn = self.turns[slot] * (stored as f32 - self.lattice.exact[slot]);
                (turn, self.before.map_or(0.0, |before| price(stored - before[slot])))
            })
        });
        let mut turn = [[0f32; CORNERS]; 3];
        let mut scores = [0f32; CORNERS];
        for corner in 0..CORNERS {
            let [a, b, c] = [0, 1, 2].map(|slot| sides[slot][corner >> slot & 1]);
            let sum = self.turn + a.0 + b.0 + c.0;
            for axis in 0..3 {
                turn[axis][corner] = sum[axis];
            }
            scores[corner] = a.1 + b.1 + c.1;
        }
        let [x, y, z] = &turn;
        let mut worst = [0f32; CORNERS];
        for corner in 0..CORNERS {
            let square = x[corner] * x[corner] + y[corner] * y[corner] + z[corner] * z[corner];
            worst[corner] = square * (SHELL * SHELL);
        }
        let error = self.task.errors[self.frame];
        for way in &self.arms.ways {
            for corner in 0..CORNERS {
                let off_x = error.x + y[corner] * way.z - z[corner] * way.y;
                let off_y = error.y + z[corner] * way.x - x[corner] * way.z;
                let off_z = error.z + x[corner] * way.y - y[corner] * way.x;
                worst[corner] = worst[corner].max(off_x * off_x + off_y * off_y + off_z * off_z);
            }
        }
        let share = 1.0 / (self.tolerance * self.tolerance);
        for corner in 0..CORNERS {
            let share = worst[corner] * share;
            scores[corner] += WORTH * share + if share > MOST { TOO_FAR * share.sqrt() } else { 0.0 };
        }
        scores
    }
}
