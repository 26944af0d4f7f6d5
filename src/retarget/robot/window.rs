//! The second pass: one problem over the frames of a window. The pose of each frame follows its goals, and the joints
//! move smoothly.
//!
//! It is Gauss-Newton over the terms of the first pass, with the changes of positions and of velocities from frame to
//! frame. Only frames with a distance of at most two share terms, joint by joint. So the normal equations are a band
//! matrix, which Cholesky decomposition solves. Limits of positions are a box, as in the first pass. Steps that are
//! longer than [`Steps`] allows are shortened, and a term limits them in the next round. A round solves only the frames
//! that still moved in the previous round, and frames near them. Windows overlap. The frames before a window are fixed,
//! and the frames at its end are solved again in the next window.

use std::ops::Range;

use glam::DVec3;
use mocap_scene::math::quaternion::rotation_vector;
use mocap_scene::scene::robot::Placement;

use super::band::Band;
use super::collision::Collisions;
use super::kinematics::Kinematics;
use super::motion::RobotMotion;
use super::solver::{Bounds, moved};
use super::speed::Steps;
use super::swing::LEAST;
use super::terms::{Goals, ROOT, Reach, Terms};
use super::touches::LinkSeparation;
use super::weights::Weights;
use mocap_figure::robot_bones::sole::SoleBall;

/// The number of frames of a window: some steps of a walk. Memory grows with it.
const FRAMES: usize = 192;

/// The number of frames of a window that the next window solves again. It exceeds the reach of the Gaussian filters of
/// accelerations: 0.18 s, which are 22 frames at 120 fps.
const OVERLAP: usize = 32;

/// The largest number of rounds of Gauss-Newton. Three are enough for a motion within its limits.
const ROUNDS: usize = 10;

/// The first round, counted from 0, that is compared with later rounds if the last round still moves frames. A link
/// between two others can move from one to the other in every round.
const COMPARED: usize = 4;

/// The number of rounds of a window in which one frame is new. The other frames were solved before.
const LIVE_ROUNDS: usize = 3;

/// The change in a round below which a frame is solved, in radians or metres: a millimetre is not visible.
pub const SMALL: f64 = 1e-3;

/// The time around a moving frame in which frames are solved again, in seconds: longer than the reach of the smoothing
/// Gaussians.
const NEAR: f64 = 0.2;

/// The weight of the angular acceleration of the base, as a multiple of the weight for a joint. The base rotates the
/// whole mass.
const TURN_OF_BASE: f64 = 10.0;

/// The largest step of a frame in a round, in radians or metres. The linear terms are not valid farther away.
const LARGEST: f64 = 0.5;

/// The fraction of a limit above which a step is limited by a term: 1, less the rounding of a step that was shortened.
const AT_LIMIT: f64 = 1.0 - 1e-9;

/// The reach of a Gaussian to either side, in standard deviations. Only 0.3 % of the Gaussian is beyond.
const REACH: f64 = 3.0;

/// The weight of the height of a foot that swings too low, as a fraction of the weight of penetrating links.
const SWING: f64 = 0.2;

/// The goals and limits of a motion.
pub(super) struct Bound<'a> {
    pub(super) goals: &'a [Goals],
    pub(super) limits: &'a Bounds,
    pub(super) steps: &'a Steps,
    /// The bodies of the feet, with their soles.
    pub(super) soles: &'a [(usize, Vec<SoleBall>)],
    pub(super) collisions: &'a Collisions,
}

/// Solves the windows of a motion.
#[derive(Clone, Debug)]
pub(super) struct Windows {
    terms: Terms,
    band: Band,
    touches: LinkSeparation,
    weights: Weights,
    /// The wanted acceleration of each unknown in each frame, per squared frame. It is the acceleration of the first
    /// pass, without changes that are faster than human motion.
    wanted: Vec<f64>,
}

impl Windows {
    pub(super) fn new(terms: Terms, weights: &Weights) -> Self {
        Self {
            terms,
            band: Band::default(),
            touches: LinkSeparation::new(weights.apart),
            weights: *weights,
            wanted: Vec::new(),
        }
    }

    /// Smooths a motion.
    pub(super) fn smooth(&mut self, kinematics: &Kinematics, bound: &Bound<'_>, motion: &mut RobotMotion) {
        let frames = motion.frames();
        self.want(bound, motion);
        let mut begin = 0;
        while begin < frames {
            let end = (begin + FRAMES).min(frames);
            self.window(kinematics, bound, motion, begin..end, ROUNDS);
            begin = if end == frames { frames } else { end - OVERLAP };
        }
    }

    /// Smooths the last frames of a motion, starting at `begin`, after a new frame has arrived. `first` is the result
    /// of the first pass for the same frames.
    pub(super) fn slide(
        &mut self,
        kinematics: &Kinematics,
        bound: &Bound<'_>,
        first: &RobotMotion,
        motion: &mut RobotMotion,
        begin: usize,
    ) {
        self.want(bound, first);
        let range = begin..motion.frames();
        self.window(kinematics, bound, motion, range, LIVE_ROUNDS);
    }

    /// Solves the frames of a window. The window starts with `range` and ends with the free part of the motion.
    fn window(
        &mut self,
        kinematics: &Kinematics,
        bound: &Bound<'_>,
        motion: &mut RobotMotion,
        range: Range<usize>,
        rounds: usize,
    ) {
        let mut parts = vec![range.clone()];
        let mut best: Option<(usize, FrameCopies)> = None;
        self.touches.begin();
        for round in 0..rounds {
            let before = FrameCopies::of(motion, range.clone());
            for part in parts {
                self.solve(kinematics, bound, motion, part, range.end);
            }
            self.keep(kinematics, bound, motion, range.clone());
            parts = near(&before.moved(motion, range.clone()), range.start, NEAR * motion.fps);
            if parts.is_empty() {
                return;
            }
            if round >= COMPARED {
                let colliding = bound.collisions.colliding_frames(kinematics, motion, range.clone());
                if best.as_ref().is_none_or(|(least, _)| colliding <= *least) {
                    best = Some((colliding, FrameCopies::of(motion, range.clone())));
                }
            }
        }
        if let Some((_, frames)) = best {
            frames.restore(motion, range);
        }
    }

    /// One step of Gauss-Newton for a part of a window that ends at `end`. Other frames are fixed.
    fn solve(
        &mut self,
        kinematics: &Kinematics,
        bound: &Bound<'_>,
        motion: &mut RobotMotion,
        part: Range<usize>,
        end: usize,
    ) {
        let size = self.terms.size();
        self.band.reset(size * part.len(), 2 * size);
        self.add_poses(kinematics, bound, motion, part.clone());
        // The two frames after the part share terms with the part.
        let rows = Rows {
            part: part.clone(),
            terms: part.start.max(1)..(part.end + 2).min(end),
        };
        self.add_root(motion, &rows);
        self.add_joints(bound, motion, &rows);
        self.fix(bound, motion, part.clone());
        self.band.solve();
        self.touches.settle(&self.band.right, part.start, size);
        self.apply(bound, motion, part);
    }

    /// Computes the wanted accelerations: the accelerations of the motion's steps, smoothed by Gaussians.
    fn want(&mut self, bound: &Bound<'_>, motion: &RobotMotion) {
        let (size, frames, count) = (self.terms.size(), motion.frames(), motion.dof_names.len());
        let mut steps = vec![0.0; frames * size];
        for frame in 1..frames {
            let (translation, turn) = root_step(motion, frame);
            let here = &mut steps[frame * size..(frame + 1) * size];
            here[..3].copy_from_slice(&translation.to_array());
            here[3..ROOT].copy_from_slice(&turn.to_array());
            for (step, &position) in here[ROOT..].iter_mut().zip(&self.terms.positions) {
                let at = |frame: usize| motion.dof_pos[frame * count + position];
                let most = bound.steps.most(frame, position);
                *step = (at(frame) - at(frame - 1)).max(-most).min(most);
            }
        }
        let mut smooth = vec![0.0; frames * size];
        for (part, deviation) in [
            (0..ROOT, self.weights.base_smoothing),
            (ROOT..size, self.weights.joint_smoothing),
        ] {
            smoothed(&steps, size, part, deviation * motion.fps, &mut smooth);
        }
        self.wanted = steps;
        for frame in 2..frames {
            for unknown in 0..size {
                let change = smooth[frame * size + unknown] - smooth[(frame - 1) * size + unknown];
                self.wanted[frame * size + unknown] = change;
            }
        }
    }

    /// Adds the terms of each pose.
    fn add_poses(&mut self, kinematics: &Kinematics, bound: &Bound<'_>, motion: &RobotMotion, range: Range<usize>) {
        let size = self.terms.size();
        let mut pose = kinematics.rest();
        for (index, frame) in range.enumerate() {
            motion.set(frame, kinematics, &mut pose);
            self.terms.assemble(kinematics, &bound.goals[frame], &pose);
            for ((body, balls), clearance) in bound.soles.iter().zip(bound.goals[frame].clearances) {
                for ball in balls {
                    let point = pose.bodies[*body].point(ball.centre);
                    // A swinging foot stays above `LEAST` as above the floor. Its full height has a smaller weight,
                    // because a low swing does less harm than penetrating links.
                    let floor = (LEAST.min(clearance), self.weights.foot_place);
                    let swing = (clearance > LEAST).then_some((clearance, SWING * self.weights.apart));
                    for (least, weight) in std::iter::once(floor).chain(swing) {
                        let target = DVec3::new(point.x, point.y, ball.radius + least);
                        if point.z < target.z {
                            let above = Reach {
                                body: *body,
                                point: ball.centre,
                                weight: DVec3::Z * weight,
                                target,
                            };
                            self.terms.add_reach(kinematics, &above, &pose);
                        }
                    }
                }
            }
            self.touches
                .add(kinematics, bound.collisions, frame, &pose, &mut self.terms);
            for row in 0..size {
                let values = &self.terms.normal[row * size..=row * size + row];
                self.band.add_row(index * size + row, index * size, values);
                self.band.right[index * size + row] += self.terms.gradient[row];
            }
        }
    }

    /// Adds the term `weight * (sum of factors * unknowns + error)^2` of one unknown in several frames. Frames outside
    /// the part are fixed.
    fn add(&mut self, part: &Range<usize>, unknown: usize, factors: &[(usize, f64)], weight: f64, error: f64) {
        let size = self.terms.size();
        let here = |frame: usize| part.contains(&frame).then(|| (frame - part.start) * size + unknown);
        for (offset, &(frame, factor)) in factors.iter().enumerate() {
            let Some(row) = here(frame) else { continue };
            self.band.right[row] -= weight * factor * error;
            for &(other, second) in &factors[..=offset] {
                if let Some(column) = here(other) {
                    self.band.add(row, column, weight * factor * second);
                }
            }
        }
    }

    fn add_root(&mut self, motion: &RobotMotion, rows: &Rows) {
        let fps = motion.fps;
        let velocity = self.weights.velocity * fps * fps;
        let accelerations = [self.weights.base_acceleration, TURN_OF_BASE * self.weights.acceleration];
        let [along, about] = accelerations.map(|weight| weight * fps.powi(4));
        let size = self.terms.size();
        let step = |frame: usize| root_step(motion, frame);
        for frame in rows.terms.clone() {
            let (translation, turn) = step(frame);
            let before = (frame > 1).then(|| step(frame - 1));
            for axis in 0..3 {
                let rates = [
                    (axis, self.weights.hips_place * velocity, along, translation[axis]),
                    (3 + axis, velocity, about, turn[axis]),
                ];
                for (unknown, velocity, acceleration, now) in rates {
                    let pair = [(frame - 1, -1.0), (frame, 1.0)];
                    self.add(&rows.part, unknown, &pair, velocity, now);
                    if let Some((translation, turn)) = before {
                        let was = if unknown < 3 { translation[axis] } else { turn[axis] };
                        let three = [(frame - 2, 1.0), (frame - 1, -2.0), (frame, 1.0)];
                        let wanted = self.wanted[frame * size + unknown];
                        self.add(&rows.part, unknown, &three, acceleration, now - was - wanted);
                    }
                }
            }
        }
    }

    fn add_joints(&mut self, bound: &Bound<'_>, motion: &RobotMotion, rows: &Rows) {
        let fps = motion.fps;
        let (velocity, acceleration) = (
            self.weights.velocity * fps * fps,
            self.weights.acceleration * fps.powi(4),
        );
        let count = motion.dof_names.len();
        for index in 0..self.terms.positions.len() {
            let position = self.terms.positions[index];
            let at = |frame: usize| motion.dof_pos[frame * count + position];
            let unknown = ROOT + index;
            for frame in rows.terms.clone() {
                let step = at(frame) - at(frame - 1);
                let pair = [(frame - 1, -1.0), (frame, 1.0)];
                self.add(&rows.part, unknown, &pair, velocity, step);
                let most = bound.steps.most(frame, position);
                if step.abs() >= most * AT_LIMIT {
                    let limit = self.weights.step_limit;
                    self.add(&rows.part, unknown, &pair, limit, step - most.copysign(step));
                }
                if frame > 1 {
                    let three = [(frame - 2, 1.0), (frame - 1, -2.0), (frame, 1.0)];
                    let change = step - (at(frame - 1) - at(frame - 2));
                    let wanted = self.wanted[frame * self.terms.size() + unknown];
                    self.add(&rows.part, unknown, &three, acceleration, change - wanted);
                }
            }
        }
    }

    /// Fixes joints that are at a limit and pull outwards.
    fn fix(&mut self, bound: &Bound<'_>, motion: &RobotMotion, range: Range<usize>) {
        let (size, count) = (self.terms.size(), motion.dof_names.len());
        for (index, frame) in range.enumerate() {
            for (offset, &position) in self.terms.positions.iter().enumerate() {
                let unknown = index * size + ROOT + offset;
                let (at, pull) = (motion.dof_pos[frame * count + position], self.band.right[unknown]);
                let (lower, upper) = (bound.limits.lower[position], bound.limits.upper[position]);
                if (at <= lower && pull < 0.0) || (at >= upper && pull > 0.0) {
                    self.band.fix(unknown);
                }
            }
        }
    }

    /// Moves the frames by the solution.
    fn apply(&mut self, bound: &Bound<'_>, motion: &mut RobotMotion, part: Range<usize>) {
        let (size, count) = (self.terms.size(), motion.dof_names.len());
        for (index, frame) in part.enumerate() {
            let step = &self.band.right[index * size..(index + 1) * size];
            let largest = step.iter().fold(0.0_f64, |largest, step| largest.max(step.abs()));
            let scale = (LARGEST / largest).min(1.0);
            motion.root[frame] = moved(&motion.root[frame], std::array::from_fn(|index| scale * step[index]));
            for (offset, &position) in self.terms.positions.iter().enumerate() {
                let at = &mut motion.dof_pos[frame * count + position];
                let (lower, upper) = (bound.limits.lower[position], bound.limits.upper[position]);
                *at = (*at + scale * step[ROOT + offset]).max(lower).min(upper);
            }
        }
    }

    /// Shortens the steps of a window that are too long.
    fn keep(&self, kinematics: &Kinematics, bound: &Bound<'_>, motion: &mut RobotMotion, range: Range<usize>) {
        let count = motion.dof_names.len();
        let mut values = Vec::with_capacity(range.len());
        for &position in &self.terms.positions {
            values.clear();
            values.extend(range.clone().map(|frame| motion.dof_pos[frame * count + position]));
            let before = range
                .start
                .checked_sub(1)
                .map(|frame| motion.dof_pos[frame * count + position]);
            bound.steps.keep(position, range.start, before, &mut values);
            for (frame, value) in range.clone().zip(&values) {
                motion.dof_pos[frame * count + position] = *value;
            }
        }
        if !kinematics.followers.is_empty() {
            let mut pose = kinematics.rest();
            for frame in range {
                motion.set(frame, kinematics, &mut pose);
                motion.dof_pos[frame * count..(frame + 1) * count].copy_from_slice(&pose.positions);
            }
        }
    }
}

/// The frames that a step solves, and the frames in its terms.
struct Rows {
    part: Range<usize>,
    terms: Range<usize>,
}

/// Copies of frames.
struct FrameCopies {
    root: Vec<Placement>,
    dof_pos: Vec<f64>,
}

impl FrameCopies {
    fn of(motion: &RobotMotion, range: Range<usize>) -> Self {
        let count = motion.dof_names.len();
        Self {
            root: motion.root[range.clone()].to_vec(),
            dof_pos: motion.dof_pos[range.start * count..range.end * count].to_vec(),
        }
    }

    /// Puts the frames back into the motion.
    fn restore(&self, motion: &mut RobotMotion, range: Range<usize>) {
        let count = motion.dof_names.len();
        motion.root[range.clone()].copy_from_slice(&self.root);
        motion.dof_pos[range.start * count..range.end * count].copy_from_slice(&self.dof_pos);
    }

    /// The largest change of each frame, in radians or metres.
    fn moved(&self, motion: &RobotMotion, range: Range<usize>) -> Vec<f64> {
        let count = motion.dof_names.len();
        let moved = |(index, frame): (usize, usize)| {
            let (was, is) = (&self.root[index], &motion.root[frame]);
            let far = (is.translation - was.translation).abs().max_element();
            let turned = rotation_vector(is.rotation * was.rotation.inverse()).length();
            let was = &self.dof_pos[index * count..(index + 1) * count];
            let joints = was.iter().zip(motion.dof_of(frame)).map(|(was, is)| (is - was).abs());
            joints.fold(far.max(turned), f64::max)
        };
        range.enumerate().map(moved).collect()
    }
}

/// The frames within `reach` of a frame that has moved, counted from the first.
pub fn near(moved: &[f64], first: usize, reach: f64) -> Vec<Range<usize>> {
    let reach = reach.ceil().max(2.0) as usize;
    let mut parts: Vec<Range<usize>> = Vec::new();
    for (index, _) in moved.iter().enumerate().filter(|(_, moved)| **moved >= SMALL) {
        let (begin, end) = (index.saturating_sub(reach), (index + reach + 1).min(moved.len()));
        match parts.last_mut() {
            Some(last) if first + begin <= last.end => last.end = first + end,
            _ => parts.push(first + begin..first + end),
        }
    }
    parts
}

/// Smooths columns of the frames' rows by a Gaussian. Its standard deviation is in frames. The first row is not a step,
/// and is ignored.
fn smoothed(steps: &[f64], size: usize, columns: Range<usize>, deviation: f64, smooth: &mut [f64]) {
    let frames = steps.len() / size;
    let reach = (REACH * deviation).ceil().min(frames as f64) as usize;
    let bell = |apart: usize| (-0.5 * (apart as f64 / deviation).powi(2)).exp();
    let bell: Vec<f64> = (0..=reach).map(bell).collect();
    let row = |frame: usize| frame * size + columns.start..frame * size + columns.end;
    for frame in 1..frames {
        let near = frame.saturating_sub(reach).max(1)..(frame + reach + 1).min(frames);
        let whole: f64 = near.clone().map(|other| bell[other.abs_diff(frame)]).sum();
        for other in near {
            let weight = bell[other.abs_diff(frame)] / whole;
            for (sum, step) in smooth[row(frame)].iter_mut().zip(&steps[row(other)]) {
                *sum += weight * step;
            }
        }
    }
}

/// The translation and the rotation of the base from the previous frame.
fn root_step(motion: &RobotMotion, frame: usize) -> (DVec3, DVec3) {
    let (from, to) = (&motion.root[frame - 1], &motion.root[frame]);
    let turn = rotation_vector(to.rotation * from.rotation.inverse());
    (to.translation - from.translation, turn)
}
