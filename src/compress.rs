//! Fewer keys and fewer bits for a motion, with a promise: no joint is farther from its place than a bound, at any
//! frame of the source, for a reader who decodes what the file says.
//!
//! 1. [`motion`]: where every joint is at every frame, by forward kinematics of the source.
//! 2. [`draft`]: joint by joint from the root on, each is coded as it has to be below the parent that a reader will
//!    have, not as the source has it, so that errors do not add up along a [`chain`].
//!    Of the codes [`around`] what it has to be, [`choice`] takes one that costs little.
//! 3. [`keys`]: which frames keep a key; for each joint alone, or for the whole pose.
//! 4. [`measure`]: both motions in double precision, at the 32-bit times of the file, as [`play`] has them.
//! 5. [`rounds`]: where the bound is not kept, frames get keys back, which are coded in between; where a frame has its
//!    key, the joints above the error get less room, and it starts again.

mod around;
mod chain;
mod choice;
mod code;
mod draft;
mod keys;
mod lanes;
mod measure;
mod motion;
mod play;
mod pose_grid;
mod rounds;
mod stream;

use std::sync::Arc;

use glam::{Quat, Vec3};

use self::chain::Arms;
pub(crate) use self::code::{CodedRotation, CodedTranslation, RotationCode, TranslationCode};
pub(crate) use self::keys::Grid;
use self::measure::Measured;
use self::motion::{Motion, World};
use self::rounds::Fitter;
use crate::error::{Code, Diagnostic, Result};
use crate::scene::{Animation, Scene};

/// What a file can hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Container {
    /// 32-bit floats.
    Float,
    /// Rotations of 16-bit normalised integers.
    Short,
    /// The filters of meshopt, and streams of differences.
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

// Shares of the bound, found by trying on the fixtures; none of them has to be right for the bound to hold.

/// For joints that move and turn so little that they can as well be still.
const FOR_STILLNESS: f32 = 0.2;
/// For leaving out keys of the whole pose; the rest is for rounding. Where little is rounded there is more.
const FOR_KEYS: f32 = 0.8;
const FOR_KEYS_ALONE: f32 = 0.97;

/// A time is a 32-bit float.
const TIME_BYTES: usize = size_of::<f32>();
/// What an accessor of times takes in the JSON of a file, nearly.
const CLOCK_BYTES: usize = 120;

/// Share of the frames below which keys that all joints share can be worth the loss of room for rounding.
const WORTH_IT: f32 = 0.9;
/// Share of the keys below which they are smaller for sure, all keys being somewhat coarser.
const SURE: f32 = 0.85;

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
    match container {
        Container::Filtered => in_streams(&fitter, scene),
        Container::Float | Container::Short => as_numbers(&fitter, scene),
    }
}

/// With keys that each joint has for itself, or that the pose shares, whichever is smaller.
fn as_numbers(fitter: &Fitter, scene: &Scene) -> Result<Fitted> {
    let own = fitter.within_bound(scene, None)?;
    let grid = pose_grid::choose(&fitter.motion, &fitter.truth, fitter.bound as f32 * FOR_KEYS_ALONE);
    // Keys that have to come back only add to that.
    let least = own.grids().map(|(_, bytes)| grid.len() * bytes).sum::<usize>();
    if least >= own.size() {
        return Ok(own);
    }
    match fitter.within_bound(scene, Some(Arc::new(grid))) {
        Ok(shared) if shared.size() < own.size() => Ok(shared),
        _ => Ok(own),
    }
}

/// With keys that the pose shares, or all keys, whichever is smaller. Keys that each joint has for itself are not tried:
/// they need times of their own, which hardly shrink in a stream, and took 1.4 to 3.2 times the bytes of five real
/// clips within 1, 5, 10 and 25 mm.
fn in_streams(fitter: &Fitter, scene: &Scene) -> Result<Fitted> {
    let full: Arc<Grid> = Arc::new(keys::all(fitter.motion.frames()));
    let grid = pose_grid::choose(&fitter.motion, &fitter.truth, fitter.bound as f32 * FOR_KEYS);
    if grid.len() as f32 > WORTH_IT * full.len() as f32 {
        return fitter.within_bound(scene, Some(full));
    }
    match fitter.within_bound(scene, Some(Arc::new(grid))) {
        Ok(fewer) if (fewer.keys() as f32) < SURE * (fewer.grids().count() * full.len()) as f32 => Ok(fewer),
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

impl Fitted {
    /// The grids of all tracks that move, and the bytes of a key where they are not in a stream.
    fn grids(&self) -> impl Iterator<Item = (&Arc<Grid>, usize)> {
        self.tracks.iter().flat_map(|track| {
            let translation = match &track.translation {
                Translation::Still(_) => None,
                Translation::Moving { grid, .. } => Some((grid, TranslationCode::BYTES)),
            };
            let rotation = match &track.rotation {
                Rotation::Still(_) => None,
                Rotation::Moving { grid, code, .. } => Some((grid, code.bytes())),
            };
            translation.into_iter().chain(rotation)
        })
    }

    /// Each grid once: tracks that have the same share their times.
    fn clocks(&self) -> Vec<&Arc<Grid>> {
        let mut clocks: Vec<&Arc<Grid>> = Vec::new();
        for (grid, _) in self.grids() {
            if !clocks.contains(&grid) {
                clocks.push(grid);
            }
        }
        clocks
    }

    /// The keys of all tracks.
    pub(crate) fn keys(&self) -> usize {
        self.grids().map(|(grid, _)| grid.len()).sum()
    }

    /// Bytes of all tracks and of the times where they are not in streams.
    fn size(&self) -> usize {
        let tracks: usize = self.grids().map(|(grid, bytes)| grid.len() * bytes).sum();
        let clocks = self.clocks().into_iter();
        let times: usize = clocks.map(|grid| CLOCK_BYTES + grid.len() * TIME_BYTES).sum();
        tracks + times
    }

    /// Bytes of the streams of all tracks and of the times, nearly.
    fn stream_size(&self) -> usize {
        let mut size = 0;
        for track in &self.tracks {
            if let Translation::Moving { keys, .. } = &track.translation {
                size += stream::size(keys.len(), |key| keys[key].code);
            }
            if let Rotation::Moving { keys, .. } = &track.rotation {
                size += stream::size(keys.len(), |key| stream::words(keys[key].code));
            }
        }
        let times = |grid: &&Arc<Grid>| {
            stream::size(grid.len(), |key| {
                [(self.ticks[grid[key] as usize] as f32 * 0.01).to_bits()]
            })
        };
        size + self.clocks().iter().map(times).sum::<usize>()
    }
}
