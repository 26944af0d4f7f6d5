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
mod code;
mod keys;
mod measure;
mod motion;
mod pose_grid;
mod stream;

use std::sync::Arc;

use glam::{Quat, Vec3};

use self::chain::{Arms, Task};
pub(crate) use self::code::{CodedRotation, CodedTranslation, RotationCode, TranslationCode};
use self::keys::Grid;
use self::measure::{Measured, Way, measure};
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

/// How often to start again before giving up.
const ROUNDS: usize = 12;

/// After so many rounds the room is halved, however near the bound is.
const PATIENCE: usize = 4;

// Shares of the bound, found by trying on the fixtures; none of them has to be right for the bound to hold.

/// For leaving out keys of the whole pose; the rest is for rounding.
const FOR_KEYS: f32 = 0.5;
/// How far the children of a root may be off, and those at the end of a chain.
const FIRST_ROOM: f32 = 0.5;
const LAST_ROOM: f32 = 0.97;
/// For the translations of a joint that moves in its parent.
const FOR_TRANSLATIONS: f32 = 0.7;
/// The step of a rotation, at the end of its longest lever, in its room; likewise that of a translation.
const ROTATION_STEP: f32 = 0.7;
const TRANSLATION_STEP: f32 = 2.0;

/// How many steps a component may be off before it is changed.
const HOLD: f32 = 1.0;
/// As [`HOLD`], for translations.
const TRANSLATION_HOLD: f32 = 0.7;

/// Share of the frames below which keys that all joints share can be worth the loss of room for rounding.
const WORTH_IT: f32 = 0.9;

/// Codes `animation` so that no joint is more than `bound` metres from its place.
///
/// # Errors
/// [`Code::ErrorBound`] where the container cannot keep the bound; [`Code::Unrepresentable`] where the motion scales.
pub(crate) fn fit(scene: &Scene, animation: &Animation, bound: f64, container: Container) -> Result<Fitted> {
    let motion = Motion::new(scene, animation)?;
    let seconds: Vec<f64> = motion
        .ticks
        .iter()
        .map(|tick| tick / animation.ticks_per_second)
        .collect();
    let times: Vec<f32> = seconds.iter().map(|second| *second as f32).collect();
    if !times.is_sorted_by(|a, b| a < b) {
        let message = "32-bit times cannot tell its frames apart, so that no bound can be kept";
        return Err(Diagnostic::new(Code::LimitExceeded, message).into());
    }
    let fitter = Fitter {
        truth: motion.world(),
        arms: (0..motion.joints.len())
            .map(|index| Arms::new(&motion, index))
            .collect(),
        motion,
        times,
        seconds,
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
        // Half the keys are less than half the bytes that all of them would take.
        Ok(fewer) if fewer.keys() * 2 < all_keys(&fewer, full.len()) => Ok(fewer),
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
    seconds: Vec<f64>,
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
        for round in 0..ROUNDS {
            let tracks = self.round(&room, shared.as_ref());
            let measured = self.measured(&tracks);
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
            if let Some(grid) = &mut shared
                && let Err(place) = grid.binary_search(&frame)
            {
                Arc::make_mut(grid).insert(place, frame);
            }
            let ratio = (self.bound / measured.max) as f32;
            let mut above = Some(measured.node);
            while let Some(index) = above {
                room[index] *= if round < PATIENCE { (ratio * 0.97).max(0.5) } else { 0.5 };
                above = self.motion.joints[index].parent;
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

    /// The larger of what the two ways from key to key give. Where every frame has a key they are one.
    fn measured(&self, tracks: &[FittedTrack]) -> Measured {
        let by = |way| measure(&self.motion, tracks, &self.times, &self.seconds, way);
        let arc = by(Way::Arc);
        let has_all = |grid: &Grid| grid.len() == self.motion.frames();
        let is_full = |track: &FittedTrack| match &track.rotation {
            Rotation::Still(_) => true,
            Rotation::Moving { grid, .. } => has_all(grid),
        };
        if arc.max > self.bound || tracks.iter().all(is_full) {
            return arc;
        }
        let chord = by(Way::Chord);
        if chord.max > arc.max { chord } else { arc }
    }

    /// How far off a joint may be, and the children of a joint: less near the root, so that there is room left to
    /// make up for it further down.
    fn room(&self) -> Vec<f32> {
        let joints = &self.motion.joints;
        let weight = |index: usize| usize::from(joints[index].rotation.moves());
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

    fn round(&self, room: &[f32], shared: Option<&Arc<Grid>>) -> Vec<FittedTrack> {
        let (motion, ticks) = (&self.motion, &self.motion.ticks);
        let frames = motion.frames();
        let mut coded: Vec<World> = Vec::with_capacity(motion.joints.len());
        let mut tracks = Vec::with_capacity(motion.joints.len());
        for (index, joint) in motion.joints.iter().enumerate() {
            let above = joint.parent.map(|parent| &coded[parent]);
            let scale = joint.parent.map_or(1.0, |parent| motion.joints[parent].scale);
            let mut world = World::default();
            let mut track = FittedTrack {
                translation: Translation::Still(joint.translation.at(0)),
                rotation: Rotation::Still(joint.rotation.at(0)),
            };
            if joint.is_tip() {
                coded.push(world);
                tracks.push(track);
                continue;
            }
            let truth = &self.truth[index];
            if joint.translation.moves() {
                let wanted = chain::wanted_translations(truth, scale, above);
                let own_room = room[index] * FOR_TRANSLATIONS;
                let code = self.translation_code(&wanted, own_room / scale);
                let grid = shared
                    .cloned()
                    .unwrap_or_else(|| self.own(chain::translation_grid(&wanted, ticks, own_room / scale), 12));
                let keys = chain::code_translations(&wanted, code, &grid, TRANSLATION_HOLD);
                world.positions = chain::moved(&keys, &grid, ticks, scale, above);
                track.translation = Translation::Moving { code, grid, keys };
            } else {
                world.positions = chain::carried(joint, scale, frames, above);
            }
            let arms = &self.arms[index];
            if !joint.rotation.moves() {
                let still = joint.rotation.at(0);
                world.rotations = match above {
                    None => vec![still; frames],
                    Some(above) => above
                        .rotations
                        .iter()
                        .map(|above| (*above * still).normalize())
                        .collect(),
                };
            } else {
                let task = Task::new(arms, truth, &world.positions, above);
                if let Some(still) = task.constant(arms, room[index]) {
                    world.rotations = match above {
                        None => vec![still; frames],
                        Some(above) => above
                            .rotations
                            .iter()
                            .map(|above| (*above * still).normalize())
                            .collect(),
                    };
                    track.rotation = Rotation::Still(still);
                } else {
                    let code = self.rotation_code(arms, room[index]);
                    let grid = shared
                        .cloned()
                        .unwrap_or_else(|| self.own(task.own_grid(arms, code, ticks, room[index]), code.bytes()));
                    let keys = task.code(arms, code, &grid, room[index], HOLD);
                    world.rotations = chain::turned(&keys, &grid, ticks, above);
                    track.rotation = Rotation::Moving { code, grid, keys };
                }
            }
            coded.push(world);
            tracks.push(track);
        }
        tracks
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

    fn rotation_code(&self, arms: &Arms, room: f32) -> RotationCode {
        match self.container {
            Container::Float => RotationCode::Float,
            Container::Short => RotationCode::Short,
            Container::Filtered => {
                let steps = arms.longest / (room * ROTATION_STEP);
                RotationCode::Filtered((steps.log2().ceil() as i32 + 1).clamp(5, 16) as u32)
            }
        }
    }
}
