//! One joint, given everything above it as a reader has it.
//!
//! Errors of a chain add up: a hand is off by what every joint above it is off. So a joint is not coded as the source
//! has it but as it has to be below the coded parent: turned so that its children stand where they belong although it
//! does not itself. What remains at the end of a chain is hardly more than what its last joint adds.

use glam::{Mat3, Quat, Vec3};

use super::code::{CodedRotation, CodedTranslation, RotationCode, TranslationCode, same_side};
use super::keys::{self, Grid};
use super::motion::{Motion, World, mean_rotation};

/// Points at this distance from a joint, in metres, must not be off either: a joint's turn about its own bone moves
/// none of the joints below it but the skin around it. The idea and the distance are those of the Animation Compression
/// Library.
pub(super) const SHELL: f32 = 0.03;

/// The lever arms of a joint's rotation.
pub(super) struct Arms {
    /// The ways to what stands still in it, in metres.
    pub(super) ways: Vec<Vec3>,
    /// What to turn by for an error of the joint's own place, so that the children are off as little as possible in
    /// the sense of least squares.
    counter_turn: Mat3,
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
            counter_turn: normal.inverse() * cross * -1.0,
            ways,
            longest,
            reach,
        }
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

/// What a joint has to do at every frame.
pub(super) struct Task {
    /// The rotation to the coded parent that is best for the children.
    pub(super) wanted: Vec<Quat>,
    /// From a rotation to the coded parent to how much too far the joint is turned.
    pub(super) to_turn: Vec<Quat>,
    /// The error of the joint's own place, in its own space.
    pub(super) errors: Vec<Vec3>,
}

impl Task {
    pub(super) fn new(arms: &Arms, truth: &World, positions: &[Vec3], above: Option<&World>) -> Self {
        let frames = positions.len();
        let mut task = Self {
            wanted: Vec::with_capacity(frames),
            to_turn: Vec::with_capacity(frames),
            errors: Vec::with_capacity(frames),
        };
        for (frame, position) in positions.iter().enumerate() {
            let to_own = truth.rotations[frame].conjugate();
            let error = to_own * (*position - truth.positions[frame]);
            let to_turn = above.map_or(to_own, |above| to_own * above.rotations[frame]);
            let counter = arms.counter_turn * error * 0.5;
            let wanted = to_turn.conjugate() * Quat::from_xyzw(counter.x, counter.y, counter.z, 1.0);
            task.wanted.push(wanted.normalize());
            task.to_turn.push(to_turn);
            task.errors.push(error);
        }
        task
    }

    pub(super) fn error(&self, arms: &Arms, frame: usize, rotation: Quat) -> f32 {
        arms.error(self.errors[frame], self.to_turn[frame] * rotation)
    }

    /// One rotation for all frames, if it keeps every child within `tolerance`.
    pub(super) fn constant(&self, arms: &Arms, tolerance: f32) -> Option<Quat> {
        let first = *self.wanted.first()?;
        let middle = self.wanted[self.wanted.len() / 2];
        let last = *self.wanted.last()?;
        // Most joints move, and show it at once.
        let guess = (first + same_side(middle, first) + same_side(last, first)).normalize();
        for frame in [0, self.wanted.len() / 2, self.wanted.len() - 1] {
            if self.error(arms, frame, guess) > 2.0 * tolerance {
                return None;
            }
        }
        let mean = mean_rotation(&self.wanted)?;
        let fits = (0..self.wanted.len()).all(|frame| self.error(arms, frame, mean) <= tolerance);
        fits.then_some(mean)
    }

    /// Keys as far apart as `tolerance` allows, without regard to other joints.
    pub(super) fn own_grid(&self, arms: &Arms, code: RotationCode, ticks: &[f64], tolerance: f32) -> Grid {
        let coded = |frame: usize| code.nearest(self.wanted[frame], None).value;
        keys::farthest(self.wanted.len(), |from, to| {
            let (a, b) = (coded(from), coded(to));
            let span = ticks[to] - ticks[from];
            // From the middle outwards: the error is most often largest there.
            let middle = usize::midpoint(from, to);
            let inner = (middle..to).chain((from + 1..middle).rev());
            inner.into_iter().all(|frame| {
                let share = ((ticks[frame] - ticks[from]) / span) as f32;
                self.error(arms, frame, blend(a, b, share)) <= tolerance
            })
        })
    }

    /// The nearest keys on `grid`.
    pub(super) fn code(&self, code: RotationCode, grid: &[u32]) -> Vec<CodedRotation> {
        let mut keys: Vec<CodedRotation> = Vec::with_capacity(grid.len());
        for &frame in grid {
            let key = code.nearest(self.wanted[frame as usize], keys.last());
            keys.push(key);
        }
        keys
    }
}

/// Where coded rotations put a joint's axes at every frame.
pub(super) fn turned(keys: &[CodedRotation], grid: &[u32], ticks: &[f64], above: Option<&World>) -> Vec<Quat> {
    let mut rotations = Vec::with_capacity(ticks.len());
    keys::between(grid, ticks, |frame, key, share| {
        let own = match keys.get(key + 1) {
            Some(next) if share > 0.0 => blend(keys[key].value, next.value, share),
            _ => keys[key].value,
        };
        rotations.push(above.map_or(own, |above| above.rotations[frame] * own).normalize());
    });
    rotations
}

/// How a joint that does not turn in its parent is turned at every frame.
pub(super) fn stood(still: Quat, frames: usize, above: Option<&World>) -> Vec<Quat> {
    match above {
        None => vec![still; frames],
        Some(above) => {
            let turned = |above: &Quat| (*above * still).normalize();
            above.rotations.iter().map(turned).collect()
        }
    }
}

/// Where a joint that does not move in its parent is at every frame; the way from there is in metres.
pub(super) fn carried(way: Vec3, frames: usize, above: Option<&World>) -> Vec<Vec3> {
    match above {
        None => vec![way; frames],
        Some(above) => std::iter::zip(&above.positions, &above.rotations)
            .map(|(position, rotation)| *position + *rotation * way)
            .collect(),
    }
}

/// The translation to the coded parent at every frame that puts the joint where it belongs.
pub(super) fn wanted_translations(truth: &World, scale: f32, above: Option<&World>) -> Vec<Vec3> {
    match above {
        None => truth.positions.clone(),
        Some(above) => (0..truth.positions.len())
            .map(|frame| {
                let way = truth.positions[frame] - above.positions[frame];
                above.rotations[frame].conjugate() * way / scale
            })
            .collect(),
    }
}

/// Keys as far apart as `tolerance`, in the joint's parent, allows.
pub(super) fn translation_grid(wanted: &[Vec3], ticks: &[f64], tolerance: f32) -> Grid {
    keys::farthest(wanted.len(), |from, to| {
        let span = ticks[to] - ticks[from];
        (from + 1..to).all(|frame| {
            let share = ((ticks[frame] - ticks[from]) / span) as f32;
            wanted[from].lerp(wanted[to], share).distance(wanted[frame]) <= tolerance
        })
    })
}

/// The keys on `grid`: numbers stay as they are from key to key where that keeps the joint within `tolerance`.
pub(super) fn code_translations(
    wanted: &[Vec3],
    code: TranslationCode,
    grid: &[u32],
    tolerance: f32,
) -> Vec<CodedTranslation> {
    let mut keys: Vec<CodedTranslation> = Vec::with_capacity(grid.len());
    for &frame in grid {
        let (wanted, previous) = (wanted[frame as usize], keys.last());
        let held = code.holding(wanted, previous);
        keys.push(if held.value.distance(wanted) <= tolerance {
            held
        } else {
            code.nearest(wanted)
        });
    }
    keys
}

/// Where coded translations put a joint at every frame.
pub(super) fn moved(
    keys: &[CodedTranslation],
    grid: &[u32],
    ticks: &[f64],
    scale: f32,
    above: Option<&World>,
) -> Vec<Vec3> {
    let mut positions = Vec::with_capacity(ticks.len());
    keys::between(grid, ticks, |frame, key, share| {
        let own = match keys.get(key + 1) {
            Some(next) if share > 0.0 => keys[key].value.lerp(next.value, share),
            _ => keys[key].value,
        };
        positions.push(match above {
            None => own,
            Some(above) => above.positions[frame] + above.rotations[frame] * (own * scale),
        });
    });
    positions
}

/// Component by component, on the shorter way, and normalised: within a hundredth of a degree of slerp for keys a few
/// degrees apart. The measure at the end uses both.
pub(super) fn blend(from: Quat, to: Quat, share: f32) -> Quat {
    (from + (same_side(to, from) - from) * share).normalize()
}
