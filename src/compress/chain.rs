//! One joint, given everything above it as a reader has it.
//!
//! Errors of a chain add up: a hand is off by what every joint above it is off. So a joint is not coded as the source
//! has it but as it has to be below the coded parent: turned so that its children stand where they belong although it
//! does not itself. What remains at the end of a chain is hardly more than what its last joint adds.

use std::ops::Range;

use glam::{Mat3, Quat, Vec3};

use super::code::{CodedRotation, CodedTranslation, RotationCode, TranslationCode, same_side};
use super::keys::{self, Grid};
use super::lanes::{self, SINGLES};
use super::motion::{Motion, World, mean_rotation};

pub(super) type Lanes = lanes::Lanes<f32, SINGLES>;
pub(super) type Vectors = lanes::Vectors<f32, SINGLES>;
pub(super) type Quaternions = lanes::Quaternions<f32, SINGLES>;

/// Points at this distance from a joint, in metres, must not be off either: a joint's turn about its own bone moves
/// none of the joints below it but the skin around it. The idea and the distance are those of the Animation Compression
/// Library.
pub(super) const SHELL: f32 = 0.03;

/// The lever arms of a joint's rotation.
pub(super) struct Arms {
    /// The ways to what stands still in it, in metres.
    pub(super) ways: Vec<Vec3>,
    /// The rows of a matrix: what to turn by for an error of the joint's own place, so that the children are off as
    /// little as possible in the sense of least squares.
    counter_turn: [[f32; 3]; 3],
    /// The longest way.
    pub(super) longest: f32,
    /// The length of the longest chain from the joint on.
    pub(super) reach: f32,
}

impl Arms {
    /// Those of all joints.
    pub(super) fn all(motion: &Motion) -> Vec<Self> {
        let reaches = reaches(motion).into_iter().enumerate();
        reaches.map(|(index, reach)| Self::new(motion, index, reach)).collect()
    }

    fn new(motion: &Motion, index: usize, reach: f32) -> Self {
        let mut ways = Vec::new();
        rigid_ways(motion, index, Vec3::ZERO, Quat::IDENTITY, &mut ways);
        Self {
            reach,
            ..Self::of(ways)
        }
    }

    /// Those to what stands still in a joint.
    pub(super) fn of(ways: Vec<Vec3>) -> Self {
        // Minimises sum |w x way + error|^2 + SHELL^2 |w|^2 over w.
        let mut normal = Mat3::from_diagonal(Vec3::splat(SHELL * SHELL));
        let mut sum = Vec3::ZERO;
        for &way in &ways {
            normal += Mat3::from_diagonal(Vec3::splat(way.length_squared()))
                - Mat3::from_cols(way * way.x, way * way.y, way * way.z);
            sum += way;
        }
        let cross = Mat3::from_cols(
            Vec3::new(0.0, sum.z, -sum.y),
            Vec3::new(-sum.z, 0.0, sum.x),
            Vec3::new(sum.y, -sum.x, 0.0),
        );
        let longest = ways.iter().map(|way| way.length()).fold(SHELL, f32::max);
        Self {
            counter_turn: (normal.inverse() * cross * -1.0).transpose().to_cols_array_2d(),
            ways,
            longest,
            reach: longest,
        }
    }

    /// The squares of [`Self::error`] at some frames; a turn is its axis, times its angle.
    #[inline(always)]
    pub(super) fn squares(&self, error: Vectors, turn: Vectors) -> Lanes {
        let around = turn.dot(turn) * Lanes::all(SHELL * SHELL);
        self.ways.iter().fold(around, |worst, way| {
            let off = error + turn.cross(Vectors::all(way.to_array()));
            worst.max(off.dot(off))
        })
    }

    /// How far off the children are, and points around the joint, where the joint is off by `error` and turned by
    /// `turn` too far; both in the joint's own space.
    fn error(&self, error: Vec3, turn: Quat) -> f32 {
        let turn = turn.xyz() * if turn.w < 0.0 { -2.0 } else { 2.0 };
        let around = turn.length_squared() * (SHELL * SHELL);
        let farthest = self.ways.iter().map(|way| (error + turn.cross(*way)).length_squared());
        farthest.fold(around, f32::max).sqrt()
    }
}

/// The length of the longest chain from every joint on, in metres. What moves in its parent counts as where it is at
/// first.
fn reaches(motion: &Motion) -> Vec<f32> {
    let mut reaches = vec![0f32; motion.joints.len()];
    for (index, joint) in motion.joints.iter().enumerate().rev() {
        if let Some(parent) = joint.parent {
            let way = joint.offset().length() * motion.joints[parent].scale;
            reaches[parent] = reaches[parent].max(reaches[index] + way);
        }
    }
    reaches
}

/// The ways to all joints that move with a joint as one body: its children, and theirs where a child does not turn.
fn rigid_ways(motion: &Motion, index: usize, start: Vec3, turn: Quat, ways: &mut Vec<Vec3>) {
    let joint = &motion.joints[index];
    for &child in &joint.children {
        let below = &motion.joints[child];
        if below.shifts() {
            continue;
        }
        let way = start + turn * (below.offset() * joint.scale);
        ways.push(way);
        if !below.turns() {
            rigid_ways(motion, child, way, turn * below.turn(), ways);
        }
    }
}

/// What a joint has to do, given where a reader has it and how it turns what the joint hangs on.
pub(super) struct Task<'a> {
    pub(super) arms: &'a Arms,
    pub(super) truth: &'a World,
    pub(super) positions: &'a [Vec3],
    pub(super) above: Option<&'a World>,
}

/// What it has to do at one frame.
struct Aim {
    /// The rotation to the coded parent that is best for the children.
    wanted: Quat,
    /// From a rotation to the coded parent to how much too far the joint is turned.
    to_turn: Quat,
    /// The error of the joint's own place, in its own space.
    error: Vec3,
}

impl Aim {
    /// The error that a rotation to the coded parent leaves.
    fn error(&self, arms: &Arms, rotation: Quat) -> f32 {
        arms.error(self.error, self.to_turn * rotation)
    }
}

/// [`Aim`] at some frames.
pub(super) struct Aims {
    pub(super) wanted: Quaternions,
    pub(super) to_turn: Quaternions,
    pub(super) error: Vectors,
}

impl Aims {
    fn at(&self, lane: usize) -> Aim {
        Aim {
            wanted: Quat::from_array(self.wanted.lane(lane)),
            to_turn: Quat::from_array(self.to_turn.lane(lane)),
            error: Vec3::from_array(self.error.lane(lane)),
        }
    }

    /// The largest error that coded rotations leave.
    #[inline(always)]
    pub(super) fn largest_error(&self, arms: &Arms, keys: &[CodedRotation]) -> f32 {
        let values = Quaternions::of(|lane| keys[lane.min(keys.len() - 1)].value.to_array());
        let turn = self.to_turn * values;
        let turn = turn.xyz() * Lanes::all(2.0).flipped(turn.w);
        arms.squares(self.error, turn).0.into_iter().fold(0.0, f32::max).sqrt()
    }
}

impl Task<'_> {
    /// At some frames, as many as there are lanes or fewer.
    #[inline(always)]
    pub(super) fn aims(&self, frames: &[u32]) -> Aims {
        let frame = |lane: usize| frames[lane.min(frames.len() - 1)] as usize;
        let positions = |from: &[Vec3]| Vectors::of(|lane| from[frame(lane)].to_array());
        let rotations = |from: &[Quat]| Quaternions::of(|lane| from[frame(lane)].to_array());
        let to_own = rotations(&self.truth.rotations).conjugate();
        let error = to_own * (positions(self.positions) - positions(&self.truth.positions));
        let to_turn = match self.above {
            None => to_own,
            Some(above) => to_own * rotations(&above.rotations),
        };
        let [x, y, z] = self.arms.counter_turn;
        let half = Lanes::all(0.5);
        let counter = Quaternions {
            x: Vectors::all(x).dot(error) * half,
            y: Vectors::all(y).dot(error) * half,
            z: Vectors::all(z).dot(error) * half,
            w: Lanes::ONE,
        };
        Aims {
            wanted: (to_turn.conjugate() * counter).normalize(),
            to_turn,
            error,
        }
    }

    /// At as many frames as there are, one after the other.
    fn each_aim(&self, frames: &[u32]) -> impl Iterator<Item = Aim> {
        frames.chunks(SINGLES).flat_map(|some| {
            let aims = self.aims(some);
            (0..some.len()).map(move |lane| aims.at(lane))
        })
    }

    fn all_aims(&self) -> Vec<Aim> {
        self.each_aim(&keys::all(self.positions.len())).collect()
    }

    /// One rotation for all frames, if it keeps every child within `tolerance`.
    pub(super) fn constant(&self, tolerance: f32) -> Option<Quat> {
        let last = self.positions.len().checked_sub(1)?;
        // Most joints move, and show it at once.
        let few: Vec<Aim> = self.each_aim(&[0, last.div_ceil(2) as u32, last as u32]).collect();
        let first = few[0].wanted;
        let add = |sum: Quat, aim: &Aim| sum + same_side(aim.wanted, first);
        let guess = few.iter().fold(first * 0.0, add).normalize();
        if few.iter().any(|aim| aim.error(self.arms, guess) > 2.0 * tolerance) {
            return None;
        }
        let aims = self.all_aims();
        let wanted: Vec<Quat> = aims.iter().map(|aim| aim.wanted).collect();
        let mean = mean_rotation(&wanted)?;
        let fits = aims.iter().all(|aim| aim.error(self.arms, mean) <= tolerance);
        fits.then_some(mean)
    }

    /// Keys as far apart as `tolerance` allows, without regard to other joints.
    pub(super) fn own_grid(&self, code: RotationCode, ticks: &[f64], tolerance: f32) -> Grid {
        let aims = self.all_aims();
        let coded = |frame: usize| code.nearest(aims[frame].wanted, None).value;
        keys::farthest(aims.len(), |from, to| {
            let (a, b) = (coded(from), coded(to));
            let mut inner = keys::inner(ticks, from, to);
            inner.all(|(frame, share)| aims[frame].error(self.arms, blend(a, b, share)) <= tolerance)
        })
    }

    /// The nearest keys on `grid`.
    pub(super) fn code(&self, code: RotationCode, grid: &[u32]) -> Vec<CodedRotation> {
        let mut keys: Vec<CodedRotation> = Vec::with_capacity(grid.len());
        for aim in self.each_aim(grid) {
            let key = code.nearest(aim.wanted, keys.last());
            keys.push(key);
        }
        keys
    }

    /// The nearest keys at some frames, each given the one before it.
    pub(super) fn code_after(
        &self,
        code: RotationCode,
        frames: &[u32],
        previous: &[CodedRotation],
    ) -> Vec<CodedRotation> {
        let nearest = |(aim, previous): (Aim, _)| code.nearest(aim.wanted, Some(previous));
        std::iter::zip(self.each_aim(frames), previous).map(nearest).collect()
    }
}

/// Puts a joint's axes where coded rotations turn them.
pub(super) fn turn(
    rotations: &mut [Quat],
    (keys, grid): (&[CodedRotation], &[u32]),
    ticks: &[f64],
    stretches: &[Range<usize>],
    above: Option<&World>,
) {
    keys::between(grid, ticks, stretches, |frame, key, share| {
        let own = match keys.get(key + 1) {
            Some(next) if share > 0.0 => blend(keys[key].value, next.value, share),
            _ => keys[key].value,
        };
        rotations[frame] = above.map_or(own, |above| above.rotations[frame] * own).normalize();
    });
}

/// How a joint that does not turn in its parent is turned.
pub(super) fn stand(rotations: &mut [Quat], still: Quat, stretches: &[Range<usize>], above: Option<&World>) {
    for frame in keys::frames(stretches) {
        rotations[frame] = above.map_or(still, |above| (above.rotations[frame] * still).normalize());
    }
}

/// Where a joint is that does not move in its parent; the way from there is in metres.
pub(super) fn carry(positions: &mut [Vec3], way: Vec3, stretches: &[Range<usize>], above: Option<&World>) {
    for frame in keys::frames(stretches) {
        positions[frame] = above.map_or(way, |above| above.positions[frame] + above.rotations[frame] * way);
    }
}

/// The translation to the coded parent that puts a joint where it belongs.
pub(super) fn wanted_translation(truth: &World, scale: f32, above: Option<&World>, frame: usize) -> Vec3 {
    above.map_or(truth.positions[frame], |above| {
        let way = truth.positions[frame] - above.positions[frame];
        above.rotations[frame].conjugate() * way / scale
    })
}

/// Keys as far apart as `tolerance`, in the joint's parent, allows.
pub(super) fn translation_grid(wanted: &[Vec3], ticks: &[f64], tolerance: f32) -> Grid {
    keys::farthest(wanted.len(), |from, to| {
        let mut inner = keys::inner(ticks, from, to);
        inner.all(|(frame, share)| wanted[from].lerp(wanted[to], share).distance(wanted[frame]) <= tolerance)
    })
}

/// A key whose numbers stay as they were before where that keeps the joint within `tolerance`.
pub(super) fn code_translation(
    wanted: Vec3,
    code: TranslationCode,
    previous: Option<&CodedTranslation>,
    tolerance: f32,
) -> CodedTranslation {
    let held = code.holding(wanted, previous);
    if held.value.distance(wanted) <= tolerance {
        held
    } else {
        code.nearest(wanted)
    }
}

/// Puts a joint where coded translations move it.
pub(super) fn place(
    positions: &mut [Vec3],
    (keys, grid): (&[CodedTranslation], &[u32]),
    ticks: &[f64],
    stretches: &[Range<usize>],
    scale: f32,
    above: Option<&World>,
) {
    keys::between(grid, ticks, stretches, |frame, key, share| {
        let own = match keys.get(key + 1) {
            Some(next) if share > 0.0 => keys[key].value.lerp(next.value, share),
            _ => keys[key].value,
        };
        positions[frame] = match above {
            None => own,
            Some(above) => above.positions[frame] + above.rotations[frame] * (own * scale),
        };
    });
}

/// Component by component, on the shorter way, and normalised: within a hundredth of a degree of slerp for keys a few
/// degrees apart. The measure at the end uses both.
pub(super) fn blend(from: Quat, to: Quat, share: f32) -> Quat {
    (from + (same_side(to, from) - from) * share).normalize()
}
