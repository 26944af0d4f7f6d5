//! A motion coded, joint by joint from the root on, and where a reader of that has all joints.

use std::ops::Range;
use std::sync::Arc;

use glam::{Quat, Vec3};

use super::chain::{self, Arms, Task};
use super::choice::{self, MOST_BITS};
use super::code::{self, CodedRotation, CodedTranslation, RotationCode, TranslationCode};
use super::keys::{self, Grid, Insertion};
use super::motion::{Joint, World};
use super::rounds::{Fitter, Means};
use super::{Container, FittedTrack, Rotation, TIME_BYTES, Translation};

// Shares of the bound, found by trying on the fixtures; none of them has to be right for the bound to hold.

/// For the translations of a joint that moves in its parent.
const FOR_TRANSLATIONS: f32 = 0.8;

/// The largest step of a rotation to try, at the end of its longest lever, in its room.
const ROTATION_STEP: f32 = 1.5;
/// The step of a translation in its room: half the diagonal of a cube of such steps is as long as the room.
const TRANSLATION_STEP: f32 = 1.15;

/// What the numbers that stand for all frames are rounded to: a share of the bound that nobody misses. They stand in
/// the JSON of a file, where every digit takes a byte.
const DIGIT: f64 = 1e-3;

/// A motion coded, and where that puts all joints.
pub(super) struct Draft {
    pub(super) tracks: Vec<FittedTrack>,
    pub(super) coded: Vec<World>,
}

/// One joint, below what it hangs on as a reader has it.
struct Spot<'a> {
    joint: &'a Joint<'a>,
    arms: &'a Arms,
    truth: &'a World,
    ticks: &'a [f64],
    above: Option<&'a World>,
    /// Length in the world of a unit of the joint's translation.
    scale: f32,
}

impl<'a> Spot<'a> {
    fn wanted_translation(&self, frame: usize) -> Vec3 {
        chain::wanted_translation(self.truth, self.scale, self.above, frame)
    }

    fn task(&self, positions: &'a [Vec3]) -> Task<'a> {
        Task {
            arms: self.arms,
            truth: self.truth,
            positions,
            above: self.above,
        }
    }

    /// Where the joint is in some stretches.
    fn place(&self, translation: &Translation, positions: &mut [Vec3], stretches: &[Range<usize>]) {
        match translation {
            Translation::Still(still) => chain::carry(positions, *still * self.scale, stretches, self.above),
            Translation::Moving { grid, keys, .. } => {
                chain::place(positions, (keys, grid), self.ticks, stretches, self.scale, self.above);
            }
        }
    }

    /// How its axes are turned there.
    fn turn(&self, rotation: &Rotation, rotations: &mut [Quat], stretches: &[Range<usize>]) {
        match rotation {
            Rotation::Still(still) => chain::stand(rotations, *still, stretches, self.above),
            Rotation::Moving { grid, keys, .. } => {
                chain::turn(rotations, (keys, grid), self.ticks, stretches, self.above);
            }
        }
    }
}

impl Fitter<'_> {
    /// The tracks, and where they put all joints.
    pub(super) fn draft(&self, means: &mut [Means], shared: Option<&Arc<Grid>>) -> Draft {
        let motion = &self.motion;
        let frames = motion.frames();
        let everywhere = motion.everywhere();
        let mut coded: Vec<World> = Vec::with_capacity(motion.joints.len());
        let mut tracks = Vec::with_capacity(motion.joints.len());
        for (index, joint) in motion.joints.iter().enumerate() {
            if joint.is_tip() {
                coded.push(World::default());
                tracks.push(FittedTrack {
                    translation: Translation::Still(self.short_vector(joint.offset())),
                    rotation: Rotation::Still(self.short_rotation(joint.turn())),
                });
                continue;
            }
            let spot = self.spot(index, joint.parent.map(|parent| &coded[parent]));
            let mut world = World {
                positions: vec![Vec3::ZERO; frames],
                rotations: vec![Quat::IDENTITY; frames],
            };
            let translation = self.translation(&spot, means[index].room, shared);
            spot.place(&translation, &mut world.positions, &everywhere);
            let rotation = self.rotation(&spot, &world.positions, &mut means[index], shared);
            spot.turn(&rotation, &mut world.rotations, &everywhere);
            tracks.push(FittedTrack { translation, rotation });
            coded.push(world);
        }
        Draft { tracks, coded }
    }

    fn spot<'s>(&'s self, index: usize, above: Option<&'s World>) -> Spot<'s> {
        let joint = &self.motion.joints[index];
        Spot {
            joint,
            arms: &self.arms[index],
            truth: &self.truth[index],
            ticks: &self.motion.ticks,
            above,
            scale: self.motion.unit(joint),
        }
    }

    /// How a joint moves in its parent.
    fn translation(&self, spot: &Spot, room: f32, shared: Option<&Arc<Grid>>) -> Translation {
        if !spot.joint.shifts() {
            return Translation::Still(self.short_vector(spot.joint.offset()));
        }
        let wanted: Vec<Vec3> = (0..self.motion.frames())
            .map(|frame| spot.wanted_translation(frame))
            .collect();
        let tolerance = room * FOR_TRANSLATIONS / spot.scale;
        let code = self.translation_code(&wanted, tolerance);
        let grid = shared.cloned().unwrap_or_else(|| {
            self.own(
                chain::translation_grid(&wanted, spot.ticks, tolerance),
                TranslationCode::BYTES,
            )
        });
        let mut keys: Vec<CodedTranslation> = Vec::with_capacity(grid.len());
        for &frame in grid.iter() {
            let key = chain::code_translation(wanted[frame as usize], code, keys.last(), tolerance);
            keys.push(key);
        }
        Translation::Moving { code, grid, keys }
    }

    /// How a joint turns in its parent.
    fn rotation(&self, spot: &Spot, positions: &[Vec3], means: &mut Means, shared: Option<&Arc<Grid>>) -> Rotation {
        let stand = |still: Quat| Rotation::Still(self.short_rotation(still));
        if !spot.joint.turns() {
            return stand(spot.joint.turn());
        }
        let task = spot.task(positions);
        if let Some(still) = task.constant(means.room) {
            return stand(still);
        }
        let (code, grid, keys) = self.rotations(&task, shared, means);
        Rotation::Moving { code, grid, keys }
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
        shared: Option<&Arc<Grid>>,
        means: &mut Means,
    ) -> (RotationCode, Arc<Grid>, Vec<CodedRotation>) {
        let room = means.room;
        let code = match self.container {
            Container::Float => RotationCode::Float,
            Container::Short => RotationCode::Short,
            Container::Filtered => {
                let steps = task.arms.longest / (room * ROTATION_STEP);
                RotationCode::Filtered((steps.log2().ceil() as i32 + 1).clamp(4, MOST_BITS as i32) as u32)
            }
        };
        let ticks = &self.motion.ticks;
        let grid = shared
            .cloned()
            .unwrap_or_else(|| self.own(task.own_grid(code, ticks, room), code.bytes()));
        let RotationCode::Filtered(fewest) = code else {
            let keys = task.code(code, &grid);
            return (code, grid, keys);
        };
        // What was too little in the round before is not tried again.
        let (bits, keys) = choice::choose(task, fewest.max(means.bits), &grid, room);
        means.bits = bits;
        (RotationCode::Filtered(bits), grid, keys)
    }

    /// The grid of one joint; every frame where its own times would cost more than they spare. `bytes` are those of a key
    /// beside its time.
    fn own(&self, grid: Grid, bytes: usize) -> Arc<Grid> {
        let frames = self.motion.frames();
        Arc::new(if grid.len() * (bytes + TIME_BYTES) < frames * bytes {
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

    /// Codes the keys that a grid, which all joints share, has got, and puts the joints where these have them, in the
    /// stretches around them. All other keys stay as they are.
    pub(super) fn insert(
        &self,
        draft: &mut Draft,
        means: &[Means],
        grid: &Arc<Grid>,
        insertions: &[Insertion],
        stretches: &[Range<usize>],
    ) {
        let frames: Vec<u32> = insertions.iter().map(|insertion| insertion.frame as u32).collect();
        for (index, joint) in self.motion.joints.iter().enumerate() {
            if joint.is_tip() {
                continue;
            }
            let (before, rest) = draft.coded.split_at_mut(index);
            let spot = self.spot(index, joint.parent.map(|parent| &before[parent]));
            let track = &mut draft.tracks[index];
            if let Translation::Moving { code, grid: own, keys } = &mut track.translation {
                let tolerance = means[index].room * FOR_TRANSLATIONS / spot.scale;
                let new = insertions.iter().map(|insertion| {
                    let (wanted, previous) = (spot.wanted_translation(insertion.frame), &keys[insertion.after]);
                    chain::code_translation(wanted, *code, Some(previous), tolerance)
                });
                let new: Vec<CodedTranslation> = new.collect();
                keys::insert(keys, insertions, &new);
                *own = Arc::clone(grid);
            }
            spot.place(&track.translation, &mut rest[0].positions, stretches);
            if let Rotation::Moving { code, grid: own, keys } = &mut track.rotation {
                let task = spot.task(&rest[0].positions);
                let previous: Vec<CodedRotation> = insertions.iter().map(|insertion| keys[insertion.after]).collect();
                let new = match code {
                    RotationCode::Filtered(bits) => {
                        choice::choose_after(&task, *bits, &frames, &previous, means[index].room)
                    }
                    code => task.code_after(*code, &frames, &previous),
                };
                keys::insert(keys, insertions, &new);
                *own = Arc::clone(grid);
            }
            spot.turn(&track.rotation, &mut rest[0].rotations, stretches);
        }
    }
}
