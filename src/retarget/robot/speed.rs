//! The limits of joint steps between frames: by the robot's file, and by the rotations of the source.

use mocap_scene::math::quaternion::rotation_vector;
use mocap_scene::scene::robot::JointKind;

use super::kinematics::Kinematics;
use super::motion::RobotMotion;
use super::source_rotations::{LIMBS, SourceRotations, limb};
use super::terms::Goals;
use super::twin::StandIn;

/// The largest step of a joint within [`WINDOW`] that is not a jump, in radians or metres: 15 rad/s, faster than human
/// limbs.
pub(super) const JUMP: f64 = 0.5;

/// The time window of a jump, in seconds: a frame of film.
pub(super) const WINDOW: f64 = 1.0 / 30.0;

/// The fraction of [`JUMP`] by which the limb of the source must rotate to explain a jump.
pub(super) const EXPLAINED: f64 = 0.5;

/// The fraction of [`JUMP`] that a step may use.
const WITHIN: f64 = 0.9;

/// The velocity limits of all positions, in rad/s or m/s: infinite without a limit.
pub(super) fn velocities(kinematics: &Kinematics) -> Vec<f64> {
    let limit = |velocity: Option<f64>| velocity.filter(|most| *most > 0.0).unwrap_or(f64::INFINITY);
    let bodies = kinematics.bodies[1..].iter();
    let mut velocities: Vec<f64> = bodies.map(|body| limit(body.limits.velocity)).collect();
    for follower in &kinematics.followers {
        let own = velocities[follower.position] / follower.multiplier.abs();
        velocities[follower.leader] = velocities[follower.leader].min(own);
    }
    velocities
}

/// The largest steps of the joints.
#[derive(Clone, Debug)]
pub(super) struct Steps {
    /// The limb of each position.
    limb_of: Vec<usize>,
    /// The largest steps by the velocities in the file.
    by_file: Vec<f64>,
    /// For each frame and each limb, the rotation in the source since the previous frame, in radians.
    turned: Vec<[f64; LIMBS]>,
    source: SourceRotations,
    /// The largest step of a joint per frame that is allowed without a corresponding rotation in the source, in radians
    /// or metres.
    free: f64,
}

impl Steps {
    pub(super) fn new(
        kinematics: &Kinematics,
        twin: &StandIn,
        goals: &[Goals],
        source: SourceRotations,
        fps: f64,
    ) -> Self {
        let mut limb_of = vec![0; kinematics.bodies.len() - 1];
        for bone in &twin.bones {
            for &joint in &bone.joints {
                if let Some(position) = kinematics.body_of(joint).0.checked_sub(1) {
                    limb_of[position] = limb(bone.bone);
                }
            }
        }
        let by_file = velocities(kinematics).into_iter().map(|most| most / fps).collect();
        let mut turned = turned(twin, goals);
        for (frame, turned) in turned.iter_mut().enumerate().skip(1) {
            *turned = least(*turned, source.between(frame - 1, frame));
        }
        Self {
            limb_of,
            by_file,
            turned,
            source,
            free: WITHIN * JUMP / (WINDOW * fps),
        }
    }

    /// The steps of a path that is later played at `speed` times its speed.
    pub(super) fn later_at(mut self, speed: f64) -> Self {
        self.by_file.iter_mut().for_each(|most| *most /= speed);
        self
    }

    /// The fraction of frames after which a joint jumps without a cause in the source.
    pub(super) fn fraction_of_jumps(&self, kinematics: &Kinematics, motion: &RobotMotion) -> f64 {
        let window = (WINDOW * motion.fps).round().max(1.0) as usize;
        let (frames, count) = (motion.frames().saturating_sub(window), motion.dof_names.len());
        let jumps = |frame: usize| {
            let by_file = self.source.between(frame, frame + window);
            let turned = |limb: usize| -> f64 {
                let passed = self.turned[frame + 1..=frame + window].iter();
                let passed: f64 = passed.map(|turned| turned[limb].max(turned[0])).sum();
                passed.min(by_file[limb].max(by_file[0]))
            };
            (0..count).any(|position| {
                let at = |frame: usize| motion.dof_pos[frame * count + position];
                let moved = (at(frame + window) - at(frame)).abs();
                moved > JUMP
                    && kinematics.bodies[position + 1].kind != JointKind::Slide
                    && turned(self.limb_of[position]) < EXPLAINED * moved
            })
        };
        (0..frames).filter(|frame| jumps(*frame)).count() as f64 / frames.max(1) as f64
    }

    /// The largest step of a position from the previous frame to a frame.
    pub(super) fn most(&self, frame: usize, position: usize) -> f64 {
        let turned = &self.turned[frame];
        let explained = WITHIN / EXPLAINED * turned[self.limb_of[position]].max(turned[0]);
        self.by_file[position].min(self.free.max(explained))
    }

    /// Shortens steps that are too long. The result is the mean of two motions with short enough steps: the largest
    /// motion below `values` and the smallest motion above. So earlier and later frames meet in the middle. `values`
    /// has the frames that start at `first`. `before` is the value of the previous frame, which does not change.
    pub(super) fn keep(&self, position: usize, first: usize, before: Option<f64>, values: &mut [f64]) {
        let most = |index: usize| self.most(first + index, position);
        let is_kept = |from: f64, to: f64, index: usize| (to - from).abs() <= most(index);
        let starts = before.is_none_or(|before| values.first().is_none_or(|first| is_kept(before, *first, 0)));
        if starts
            && values
                .windows(2)
                .enumerate()
                .all(|(index, pair)| is_kept(pair[0], pair[1], index + 1))
        {
            return;
        }
        if let Some(before) = before {
            let mut reach = 0.0;
            for (index, value) in values.iter_mut().enumerate() {
                reach += most(index);
                *value = value.clamp(before - reach, before + reach);
            }
        }
        within_steps(values, most);
    }
}

/// Limits the steps between successive values: the step between the indices i - 1 and i is at most `most(i)`. The
/// result is the mean of two sequences with such steps: the largest one that is nowhere above the values, and the
/// smallest one that is nowhere below.
pub(super) fn within_steps(values: &mut [f64], most: impl Fn(usize) -> f64) {
    let (mut above, mut below) = (values.to_vec(), values.to_vec());
    let steps = (1..values.len()).map(|index| (index - 1, index, index));
    let back = (1..values.len()).rev().map(|index| (index, index - 1, index));
    for (from, to, index) in steps.chain(back) {
        above[to] = above[to].min(above[from] + most(index));
        below[to] = below[to].max(below[from] - most(index));
    }
    for (value, (above, below)) in values.iter_mut().zip(above.into_iter().zip(below)) {
        *value = 0.5 * (above + below);
    }
}

fn least(a: [f64; LIMBS], b: [f64; LIMBS]) -> [f64; LIMBS] {
    std::array::from_fn(|limb| a[limb].min(b[limb]))
}

/// The largest rotation of a bone of each limb relative to its parent bone from frame to frame. For the trunk, the
/// rotation of the hips counts too.
fn turned(twin: &StandIn, goals: &[Goals]) -> Vec<[f64; LIMBS]> {
    let parent_of = |index: usize| {
        let mut node = twin.scene.nodes[twin.bones[index].node.index()].parent;
        while let Some(here) = node {
            if let Some(parent) = twin.bones.iter().position(|bone| bone.node == here) {
                return Some(parent);
            }
            node = twin.scene.nodes[here.index()].parent;
        }
        None
    };
    let parents: Vec<Option<usize>> = (0..twin.bones.len()).map(parent_of).collect();
    let mut found = vec![[0.0; LIMBS]; goals.len()];
    for (frame, pair) in goals.windows(2).enumerate() {
        for (index, bone) in twin.bones.iter().enumerate() {
            let rotation = |goals: &Goals| {
                let own = goals.rotations[index].target;
                parents[index].map_or(own, |parent| goals.rotations[parent].target.inverse() * own)
            };
            let turn = rotation_vector(rotation(&pair[1]) * rotation(&pair[0]).inverse()).length();
            let most: &mut f64 = &mut found[frame + 1][limb(bone.bone)];
            *most = most.max(turn);
        }
    }
    found
}
