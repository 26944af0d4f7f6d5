//! One round after the other, until the bound is kept.

use std::borrow::Cow;
use std::sync::Arc;

use glam::{Quat, Vec3};

use super::chain::{self, Arms, Task};
use super::choice::{self, MOST_BITS};
use super::code::{self, CodedRotation, RotationCode, TranslationCode};
use super::keys::{self, Grid};
use super::measure::{Errors, Measured, measure};
use super::motion::{Motion, World};
use super::{Container, Fitted, FittedTrack, Rotation, Translation};
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
/// For the translations of a joint that moves in its parent.
const FOR_TRANSLATIONS: f32 = 0.8;

/// The largest step of a rotation to try, at the end of its longest lever, in its room.
const ROTATION_STEP: f32 = 1.5;
/// The step of a translation in its room: half the diagonal of a cube of such steps is as long as the room.
const TRANSLATION_STEP: f32 = 1.15;

/// What the numbers that stand for all frames are rounded to: a share of the bound that nobody misses. They stand in
/// the JSON of a file, where every digit takes a byte.
const DIGIT: f64 = 1e-3;

/// The share of the bound from which on a frame gets its key back: the next round rounds otherwise.
const NEARLY: f32 = 0.97;

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
struct Means {
    /// How far its children may be off.
    room: f32,
    /// The fewest bits of a rotation that may do.
    bits: u32,
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
            let (tracks, coded) = self.round(&mut means, shared.as_ref());
            // In single precision, for the double costs as much as the round itself.
            if let Some(grid) = &mut shared
                && keys::refine(
                    Arc::make_mut(grid),
                    &self.rough_errors(&coded),
                    self.bound as f32 * NEARLY,
                )
            {
                continue;
            }
            let Errors {
                measured,
                frames,
                nodes,
            } = measure(&self.motion, &tracks, &self.times, self.rounding);
            if measured.max <= self.bound {
                return Ok(Fitted {
                    tracks,
                    ticks: self.motion.ticks.clone(),
                    measured,
                });
            }
            if measured.max < best.max {
                best = measured;
            }
            let frame = self.motion.ticks.partition_point(|tick| *tick < measured.tick) as u32;
            let is_key = match &mut shared {
                Some(grid) => {
                    let is_key = grid.binary_search(&frame).is_ok();
                    keys::refine(Arc::make_mut(grid), &frames, self.bound);
                    is_key
                }
                None => true,
            };
            if is_key {
                self.narrow(&mut means, &nodes);
            }
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

    /// The largest error at every frame.
    fn rough_errors(&self, coded: &[World]) -> Vec<f32> {
        let mut errors = vec![0f32; self.motion.frames()];
        for (index, joint) in self.motion.joints.iter().enumerate() {
            let (truth, coded) = match joint.parent.filter(|_| joint.is_tip()) {
                None => (
                    Cow::Borrowed(&self.truth[index].positions),
                    Cow::Borrowed(&coded[index].positions),
                ),
                Some(parent) => {
                    let way = joint.offset() * self.motion.joints[parent].scale;
                    let carried = |world| Cow::Owned(chain::carried(way, errors.len(), Some(world)));
                    (carried(&self.truth[parent]), carried(&coded[parent]))
                }
            };
            for (error, (truth, coded)) in std::iter::zip(&mut errors, std::iter::zip(truth.iter(), coded.iter())) {
                *error = error.max(truth.distance_squared(*coded));
            }
        }
        errors.iter_mut().for_each(|error| *error = error.sqrt());
        errors
    }

    /// The tracks, and where they put all joints.
    fn round(&self, means: &mut [Means], shared: Option<&Arc<Grid>>) -> (Vec<FittedTrack>, Vec<World>) {
        let motion = &self.motion;
        let mut coded: Vec<World> = Vec::with_capacity(motion.joints.len());
        let mut tracks = Vec::with_capacity(motion.joints.len());
        for (index, joint) in motion.joints.iter().enumerate() {
            let above = joint.parent.map(|parent| &coded[parent]);
            let (track, world) = if joint.is_tip() {
                let track = FittedTrack {
                    translation: Translation::Still(self.short_vector(joint.offset())),
                    rotation: Rotation::Still(self.short_rotation(joint.turn())),
                };
                (track, World::default())
            } else {
                let (translation, positions) = self.place(index, above, means[index].room, shared);
                let (rotation, rotations) = self.turn(index, &positions, above, &mut means[index], shared);
                let track = FittedTrack { translation, rotation };
                (track, World { positions, rotations })
            };
            coded.push(world);
            tracks.push(track);
        }
        (tracks, coded)
    }

    /// How a joint moves in its parent, and where that puts it at every frame.
    fn place(
        &self,
        index: usize,
        above: Option<&World>,
        room: f32,
        shared: Option<&Arc<Grid>>,
    ) -> (Translation, Vec<Vec3>) {
        let (joint, ticks) = (&self.motion.joints[index], &self.motion.ticks);
        let scale = joint.parent.map_or(1.0, |parent| self.motion.joints[parent].scale);
        if !joint.shifts() {
            let still = self.short_vector(joint.offset());
            let positions = chain::carried(still * scale, self.motion.frames(), above);
            return (Translation::Still(still), positions);
        }
        let wanted = chain::wanted_translations(&self.truth[index], scale, above);
        let tolerance = room * FOR_TRANSLATIONS / scale;
        let code = self.translation_code(&wanted, tolerance);
        let grid = shared
            .cloned()
            .unwrap_or_else(|| self.own(chain::translation_grid(&wanted, ticks, tolerance), 12));
        let keys = chain::code_translations(&wanted, code, &grid, tolerance);
        let positions = chain::moved(&keys, &grid, ticks, scale, above);
        (Translation::Moving { code, grid, keys }, positions)
    }

    /// How a joint turns in its parent, and how that turns its axes at every frame.
    fn turn(
        &self,
        index: usize,
        positions: &[Vec3],
        above: Option<&World>,
        means: &mut Means,
        shared: Option<&Arc<Grid>>,
    ) -> (Rotation, Vec<Quat>) {
        let (joint, arms) = (&self.motion.joints[index], &self.arms[index]);
        let frames = self.motion.frames();
        let stand = |still: Quat| {
            let still = self.short_rotation(still);
            (Rotation::Still(still), chain::stood(still, frames, above))
        };
        if !joint.turns() {
            return stand(joint.turn());
        }
        let task = Task::new(arms, &self.truth[index], positions, above);
        if let Some(still) = task.constant(arms, means.room) {
            return stand(still);
        }
        let (code, grid, keys) = self.rotations(&task, arms, shared, means);
        let rotations = chain::turned(&keys, &grid, &self.motion.ticks, above);
        (Rotation::Moving { code, grid, keys }, rotations)
    }

    /// A number that stands for all frames, with no more digits than it needs.
    fn short(&self, value: f32) -> f32 {
        if self.container == Container::Float {
            return value;
        }
        let digits = 10f64.powi((self.bound * DIGIT).log10().floor().clamp(-9.0, -1.0).abs() as i32);
        ((f64::from(value) * digits).round() / digits) as f32
    }

    fn short_vector(&self, value: Vec3) -> Vec3 {
        Vec3::from_array(value.to_array().map(|axis| self.short(axis)))
    }

    fn short_rotation(&self, value: Quat) -> Quat {
        Quat::from_array(value.to_array().map(|component| self.short(component)))
    }

    /// The keys of a joint that turns.
    fn rotations(
        &self,
        task: &Task,
        arms: &Arms,
        shared: Option<&Arc<Grid>>,
        means: &mut Means,
    ) -> (RotationCode, Arc<Grid>, Vec<CodedRotation>) {
        let room = means.room;
        let code = match self.container {
            Container::Float => RotationCode::Float,
            Container::Short => RotationCode::Short,
            Container::Filtered => {
                let steps = arms.longest / (room * ROTATION_STEP);
                RotationCode::Filtered((steps.log2().ceil() as i32 + 1).clamp(4, MOST_BITS as i32) as u32)
            }
        };
        let ticks = &self.motion.ticks;
        let grid = shared
            .cloned()
            .unwrap_or_else(|| self.own(task.own_grid(arms, code, ticks, room), code.bytes()));
        let RotationCode::Filtered(fewest) = code else {
            let keys = task.code(code, &grid);
            return (code, grid, keys);
        };
        // What was too little in the round before is not tried again.
        means.bits = fewest.max(means.bits);
        loop {
            let bits = means.bits;
            if (bits == MOST_BITS || choice::may_suffice(task, arms, bits, &grid, room))
                && let Some(keys) = choice::choose(task, arms, bits, &grid, room)
            {
                return (RotationCode::Filtered(bits), grid, keys);
            }
            means.bits += 1;
        }
    }

    /// The grid of one joint; every frame where its own times would cost more than they spare. `bytes` are those of a key
    /// beside its time.
    fn own(&self, grid: Grid, bytes: usize) -> Arc<Grid> {
        let frames = self.motion.frames();
        Arc::new(if grid.len() * (bytes + 4) < frames * bytes {
            grid
        } else {
            keys::all(frames)
        })
    }

    fn translation_code(&self, wanted: &[Vec3], room: f32) -> TranslationCode {
        if self.container != Container::Filtered {
            return TranslationCode::Float;
        }
        let largest = wanted.iter().map(|value| value.abs().max_element()).fold(0.0, f32::max);
        let fine = (room * TRANSLATION_STEP).log2().floor();
        let range = (largest / code::MANTISSA).log2().ceil();
        TranslationCode::Filtered(fine.max(range).clamp(-100.0, 100.0) as i32)
    }
}
