//! Fewer keys and fewer bits for a motion, with a promise: no joint is farther from its place than a bound, at any
//! frame of the source, for a reader who decodes what the file says.
//!
//! 1. [`motion`]: where every joint is at every frame, by forward kinematics of the source.
//! 2. [`chain`]: joint by joint from the root on, each is coded as it has to be below the parent that a reader will
//!    have, not as the source has it. So errors do not add up along a chain.
//! 3. [`keys`]: which frames keep a key; for each joint alone, or for the whole pose.
//! 4. [`measure`]: both motions in double precision, at the 32-bit times of the file. Where the bound is not kept, the
//!    joints above the error get less room, frames get keys back, and it starts again.

mod chain;
mod choice;
mod code;
mod keys;
mod measure;
mod motion;
mod pose_grid;
mod stream;

use std::borrow::Cow;
use std::sync::Arc;

use glam::{Quat, Vec3};

use self::chain::{Arms, Task};
pub(crate) use self::code::{CodedRotation, CodedTranslation, RotationCode, TranslationCode};
use self::keys::Grid;
use self::measure::{Errors, Measured, measure};
use self::motion::{Motion, World};
use crate::error::{Code, Diagnostic, Result};
use crate::scene::{Animation, Scene};

/// What a file can hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Container {
    /// 32-bit floats, each joint with keys of its own.
    Float,
    /// Rotations of 16-bit normalised integers, each joint with keys of its own.
    Short,
    /// The filters of meshopt, and streams of differences, in which keys that all joints share are the smaller.
    Filtered,
}

/// An animation within its bound.
pub(crate) struct Fitted {
    /// One a node of the scene.
    pub(crate) tracks: Vec<FittedTrack>,
    /// The tick of every frame that a grid can name.
    pub(crate) ticks: Vec<f64>,
    pub(crate) measured: Measured,
}

/// What drives one node.
pub(crate) struct FittedTrack {
    pub(crate) translation: Translation,
    pub(crate) rotation: Rotation,
}

pub(crate) enum Translation {
    Still(Vec3),
    Moving {
        code: TranslationCode,
        grid: Arc<Grid>,
        keys: Vec<CodedTranslation>,
    },
}

pub(crate) enum Rotation {
    Still(Quat),
    Moving {
        code: RotationCode,
        grid: Arc<Grid>,
        keys: Vec<CodedRotation>,
    },
}

/// The most that the filter takes.
const MOST_BITS: u32 = 16;

/// How often to start again before giving up.
const ROUNDS: usize = 16;

/// The room for the next round, of what would do if errors shrank as it does; and the least share that one round takes
/// away to.
const LESS: f32 = 0.97;
const LEAST: f32 = 0.5;

// Shares of the bound, found by trying on the fixtures; none of them has to be right for the bound to hold.

/// For joints that move and turn so little that they can as well be still.
const FOR_STILLNESS: f32 = 0.2;
/// For leaving out keys of the whole pose; the rest is for rounding.
const FOR_KEYS: f32 = 0.8;
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

/// Share of the frames below which keys that all joints share can be worth the loss of room for rounding.
const WORTH_IT: f32 = 0.9;
/// Share of the keys below which they are smaller for sure, all keys being somewhat coarser.
const SURE: f32 = 0.85;

/// The share of the bound from which on a frame gets its key back: the next round rounds otherwise.
const NEARLY: f32 = 0.97;

/// Codes `animation` so that no joint is more than `bound` metres from its place.
///
/// # Errors
/// [`Code::ErrorBound`] where the container cannot keep the bound; [`Code::Unrepresentable`] where the motion scales.
pub(crate) fn fit(scene: &Scene, animation: &Animation, bound: f64, container: Container) -> Result<Fitted> {
    let mut motion = Motion::new(scene, animation)?;
    let truth = motion.world();
    motion.settle(bound as f32 * FOR_STILLNESS);
    let time = |tick: &f64| (tick / animation.ticks_per_second) as f32;
    let times: Vec<f32> = motion.ticks.iter().map(time).collect();
    if !times.is_sorted_by(|a, b| a < b) {
        let message = "32-bit times cannot tell its frames apart, so that no bound can be kept";
        return Err(Diagnostic::new(Code::LimitExceeded, message).into());
    }
    let farthest = |world: &World| world.positions.iter().map(|place| place.length()).fold(0.0, f32::max);
    let rounding = f64::from(truth.iter().map(farthest).fold(0.0, f32::max) * f32::EPSILON);
    let fitter = Fitter {
        truth,
        arms: Arms::all(&motion),
        motion,
        times,
        rounding,
        bound,
        container,
    };
    let full: Arc<Grid> = Arc::new(keys::all(fitter.motion.frames()));
    if container != Container::Filtered {
        return fitter.within_bound(scene, None);
    }
    let grid = pose_grid::choose(&fitter.motion, &fitter.truth, bound as f32 * FOR_KEYS);
    if grid.len() as f32 > WORTH_IT * full.len() as f32 {
        return fitter.within_bound(scene, Some(full));
    }
    match fitter.within_bound(scene, Some(Arc::new(grid))) {
        Ok(fewer) if (fewer.keys() as f32) < SURE * all_keys(&fewer, full.len()) as f32 => Ok(fewer),
        Ok(fewer) => {
            let all = fitter.within_bound(scene, Some(full))?;
            Ok(if fewer.stream_size() < all.stream_size() {
                fewer
            } else {
                all
            })
        }
        Err(_) => fitter.within_bound(scene, Some(full)),
    }
}

/// The keys that all tracks would have at every frame.
fn all_keys(fitted: &Fitted, frames: usize) -> usize {
    let moves = |track: &FittedTrack| {
        usize::from(matches!(track.translation, Translation::Moving { .. }))
            + usize::from(matches!(track.rotation, Rotation::Moving { .. }))
    };
    fitted.tracks.iter().map(moves).sum::<usize>() * frames
}

impl Fitted {
    /// The keys of all tracks.
    pub(crate) fn keys(&self) -> usize {
        let of_track = |track: &FittedTrack| {
            let translation = match &track.translation {
                Translation::Still(_) => 0,
                Translation::Moving { keys, .. } => keys.len(),
            };
            let rotation = match &track.rotation {
                Rotation::Still(_) => 0,
                Rotation::Moving { keys, .. } => keys.len(),
            };
            translation + rotation
        };
        self.tracks.iter().map(of_track).sum()
    }

    /// Bytes of the streams of all tracks and of the times, nearly.
    fn stream_size(&self) -> usize {
        let mut grids: Vec<&Arc<Grid>> = Vec::new();
        let mut size = 0;
        for track in &self.tracks {
            if let Translation::Moving { grid, keys, .. } = &track.translation {
                size += stream::size(keys.len(), |key| keys[key].code);
                grids.push(grid);
            }
            if let Rotation::Moving { grid, keys, .. } = &track.rotation {
                size += stream::size(keys.len(), |key| stream::words(keys[key].code));
                grids.push(grid);
            }
        }
        grids.dedup_by(|a, b| Arc::ptr_eq(a, b));
        let times = |grid: &&Arc<Grid>| {
            stream::size(grid.len(), |key| {
                [(self.ticks[grid[key] as usize] as f32 * 0.01).to_bits()]
            })
        };
        size + grids.iter().map(times).sum::<usize>()
    }
}

/// All that stays the same from round to round.
struct Fitter<'a> {
    motion: Motion<'a>,
    truth: Vec<World>,
    arms: Vec<Arms>,
    times: Vec<f32>,
    /// How far the source may be off, being of 32-bit numbers, in metres.
    rounding: f64,
    bound: f64,
    container: Container,
}

impl Fitter<'_> {
    /// Codes the motion until the bound is kept. `shared` has the keys of all joints, or each gets its own.
    fn within_bound(&self, scene: &Scene, mut shared: Option<Arc<Grid>>) -> Result<Fitted> {
        let mut room = self.room();
        let mut best = Measured {
            max: f64::INFINITY,
            ..Measured::default()
        };
        for _ in 0..ROUNDS {
            let (tracks, coded) = self.round(&room, shared.as_ref());
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
                self.narrow(&mut room, &nodes);
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
    fn narrow(&self, room: &mut [f32], errors: &[f64]) {
        let joints = &self.motion.joints;
        let mut shares = vec![1f32; joints.len()];
        for (index, error) in errors.iter().enumerate().rev() {
            if *error > self.bound {
                shares[index] = shares[index].min((self.bound / error) as f32 * LESS).max(LEAST);
            }
            room[index] *= shares[index];
            if let Some(parent) = joints[index].parent {
                shares[parent] = shares[parent].min(shares[index]);
            }
        }
    }

    /// How far off a joint may be, and the children of a joint: less near the root, so that there is room left to
    /// make up for it further down.
    fn room(&self) -> Vec<f32> {
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
                self.bound as f32 * (FIRST_ROOM + (LAST_ROOM - FIRST_ROOM) * way)
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
    fn round(&self, room: &[f32], shared: Option<&Arc<Grid>>) -> (Vec<FittedTrack>, Vec<World>) {
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
                let (translation, positions) = self.place(index, above, room[index], shared);
                let (rotation, rotations) = self.turn(index, &positions, above, room[index], shared);
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
        room: f32,
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
        if let Some(still) = task.constant(arms, room) {
            return stand(still);
        }
        let (code, grid, keys) = self.rotations(&task, arms, shared, room);
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
        room: f32,
    ) -> (RotationCode, Arc<Grid>, Vec<CodedRotation>) {
        let code = match self.container {
            Container::Float => RotationCode::Float,
            Container::Short => RotationCode::Short,
            Container::Filtered => {
                let steps = arms.longest / (room * ROTATION_STEP);
                RotationCode::Filtered((steps.log2().ceil() as i32 + 1).clamp(4, 16) as u32)
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
        let mut bits = fewest;
        loop {
            if bits == MOST_BITS || choice::may_suffice(task, arms, bits, &grid, room) {
                let frames = grid.iter().map(|frame| *frame as usize);
                let (keys, error) = choice::choose(task, arms, bits, frames, room);
                if bits == MOST_BITS || error <= room {
                    return (RotationCode::Filtered(bits), grid, keys);
                }
            }
            bits += 1;
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
