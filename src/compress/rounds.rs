//! One round after the other, until the bound is kept.

use std::ops::Range;
use std::sync::Arc;

use super::chain::Arms;
use super::draft::Draft;
use super::keys::{self, Amount, Grid};
use super::measure::{Errors, Measured, Proof};
use super::motion::{Motion, World};
use super::{Container, Fitted};
use crate::error::{Code, Diagnostic, Result};
use crate::scene::Scene;

/// How often to start again before giving up.
const ROUNDS: usize = 16;

/// The room for the next round, of what would do if errors shrank as it does; and the least share that one round takes
/// away to.
const LESS: f32 = 0.97;
const LEAST: f32 = 0.5;

// Shares of the bound, found by trying on the fixtures; none of them has to be right for the bound to hold.

/// How far the children of a root may be off, and those at the end of a chain.
const FIRST_ROOM: f32 = 0.75;
const LAST_ROOM: f32 = 0.97;

/// All that stays the same from round to round.
pub(super) struct Fitter<'a> {
    pub(super) motion: Motion<'a>,
    pub(super) truth: Vec<World>,
    pub(super) arms: Vec<Arms>,
    pub(super) times: Vec<f32>,
    /// How far the source may be off, being of 32-bit numbers, in metres.
    pub(super) rounding: f64,
    pub(super) bound: f64,
    pub(super) container: Container,
}

/// What a joint is given, from round to round.
pub(super) struct Means {
    /// How far its children may be off.
    pub(super) room: f32,
    /// The fewest bits of a rotation that may do.
    pub(super) bits: u32,
}

impl Fitter<'_> {
    /// Codes the motion until the bound is kept. `shared` has the keys of all joints, or each gets its own.
    pub(super) fn within_bound(&self, scene: &Scene, mut shared: Option<Arc<Grid>>) -> Result<Fitted> {
        let mut means = self.means();
        let mut best = Measured {
            max: f64::INFINITY,
            ..Measured::default()
        };
        for _ in 0..ROUNDS {
            let mut draft = self.draft(&mut means, shared.as_ref());
            if let Some(grid) = &mut shared {
                self.complete(&mut draft, &means, grid);
            }
            let mut errors = Errors::new(self.motion.frames());
            let mut measured = self.measure(&draft, &self.motion.everywhere(), &mut errors);
            for step in 0.. {
                let stretches = match &mut shared {
                    Some(grid) if measured.max > self.bound => {
                        self.refine(&mut draft, &means, grid, (&errors.frames, self.bound), step)
                    }
                    _ => Vec::new(),
                };
                if stretches.is_empty() {
                    break;
                }
                measured = self.measure(&draft, &stretches, &mut errors);
            }
            if measured.max <= self.bound {
                return Ok(Fitted {
                    tracks: draft.tracks,
                    ticks: self.motion.ticks.clone(),
                    measured,
                });
            }
            if measured.max < best.max {
                best = measured;
            }
            self.narrow(&mut means, &errors.of_nodes(self.motion.joints.len()));
        }
        let millimetres = |metres: f64| format!("{:.6} mm", metres * 1000.0);
        Err(Diagnostic::new(
            Code::ErrorBound,
            "no joint may be farther from its place than the bound, and this way of storing numbers cannot keep it",
        )
        .in_joint(&scene.nodes[best.node].name)
        .expected_found(millimetres(self.bound), millimetres(best.max))
        .help("allow a larger error, or store 32-bit floats")
        .into())
    }

    fn measure(&self, draft: &Draft, stretches: &[Range<usize>], errors: &mut Errors) -> Measured {
        let proof = Proof {
            motion: &self.motion,
            tracks: &draft.tracks,
            times: &self.times,
            rounding: self.rounding,
        };
        proof.measure(stretches, errors);
        errors.summary(&self.motion)
    }

    /// Gives less room to every joint above one that is too far off.
    fn narrow(&self, means: &mut [Means], errors: &[f64]) {
        let joints = &self.motion.joints;
        let mut shares = vec![1f32; joints.len()];
        for (index, error) in errors.iter().enumerate().rev() {
            if *error > self.bound {
                shares[index] = shares[index].min((self.bound / error) as f32 * LESS).max(LEAST);
            }
            means[index].room *= shares[index];
            if let Some(parent) = joints[index].parent {
                shares[parent] = shares[parent].min(shares[index]);
            }
        }
    }

    /// How far off a joint may be, and the children of a joint: less near the root, so that there is room left to
    /// make up for it further down.
    fn means(&self) -> Vec<Means> {
        let joints = &self.motion.joints;
        let weight = |index: usize| usize::from(joints[index].turns());
        let mut depth = vec![0usize; joints.len()];
        for index in 0..joints.len() {
            depth[index] = joints[index].parent.map_or(0, |parent| depth[parent]) + weight(index);
        }
        let mut deepest = depth.clone();
        for index in (0..joints.len()).rev() {
            if let Some(parent) = joints[index].parent {
                deepest[parent] = deepest[parent].max(deepest[index]);
            }
        }
        (0..joints.len())
            .map(|index| {
                let way = depth[index] as f32 / deepest[index].max(1) as f32;
                Means {
                    room: self.bound as f32 * (FIRST_ROOM + (LAST_ROOM - FIRST_ROOM) * way),
                    bits: 0,
                }
            })
            .collect()
    }

    /// Gives keys back until no frame is too far off, in single precision, which is enough to see where.
    fn complete(&self, draft: &mut Draft, means: &[Means], grid: &mut Arc<Grid>) {
        let mut errors = vec![0f32; self.motion.frames()];
        let mut stretches = self.motion.everywhere();
        for step in 0.. {
            self.rough_errors(&draft.coded, &stretches, &mut errors);
            stretches = self.refine(draft, means, grid, (&errors, self.bound as f32), step);
            if stretches.is_empty() {
                break;
            }
        }
    }

    /// The largest error at every frame of some stretches.
    fn rough_errors(&self, coded: &[World], stretches: &[Range<usize>], errors: &mut [f32]) {
        let frames = || keys::frames(stretches);
        frames().for_each(|frame| errors[frame] = 0.0);
        for (index, joint) in self.motion.joints.iter().enumerate() {
            match (joint.is_tip(), joint.parent) {
                (false, _) => {
                    let (truth, coded) = (&self.truth[index].positions, &coded[index].positions);
                    for frame in frames() {
                        errors[frame] = errors[frame].max(truth[frame].distance_squared(coded[frame]));
                    }
                }
                (true, Some(parent)) => {
                    let way = joint.offset() * self.motion.joints[parent].scale;
                    let (truth, coded) = (&self.truth[parent], &coded[parent]);
                    for frame in frames() {
                        let place = |world: &World| world.positions[frame] + world.rotations[frame] * way;
                        errors[frame] = errors[frame].max(place(truth).distance_squared(place(coded)));
                    }
                }
                // It stands where it stood.
                (true, None) => {}
            }
        }
        frames().for_each(|frame| errors[frame] = errors[frame].sqrt());
    }

    /// Gives keys back to frames that are farther off than a bound, and codes these. Gives the frames where that changes
    /// something. After some steps nothing is left out any more where it is not enough, so that there is an end.
    fn refine<T: Copy + PartialOrd>(
        &self,
        draft: &mut Draft,
        means: &[Means],
        grid: &mut Arc<Grid>,
        (errors, bound): (&[T], T),
        step: usize,
    ) -> Vec<Range<usize>> {
        let amount = if step < ROUNDS { Amount::Worst } else { Amount::All };
        let (insertions, stretches) = keys::refine(Arc::make_mut(grid), errors, bound, amount);
        if !insertions.is_empty() {
            self.insert(draft, means, grid, &insertions, &stretches);
        }
        stretches
    }
}
