//! The world rotations of all joints, from the root outwards.

use glam::{Mat3, Quat, Vec3};
use mocap_scene::math::directions::arc;
use mocap_scene::scene::{HumanoidBone as Bone, Side};

use super::points::Points;
use super::rest::{self, Rest, bend_axis, foot_direction, limb_direction, median_offset, vector};
use super::roll::{self, Limb};
use super::rules::{Rule, Rules, Up};
use super::set::{JointSet, Mark};

/// The rest pose, and the world rotations, indexed by joint, then frame.
pub(super) fn turn(set: &JointSet, rules: &Rules, points: &Points) -> (Rest, Vec<Vec<Quat>>) {
    let count = set.joints.len();
    let mut solver = Solver {
        set,
        points,
        world: vec![Vec::new(); count],
        // The T-pose direction to the only child, for joints whose rule sets it.
        directions: vec![None; count],
    };
    // Hips and chest are solved first, because they depend on no other joint.
    for joint in 0..count {
        if let Rule::Trunk { left, right, up } = rules.of[joint] {
            solver.world[joint] = solver.trunk(joint, left, right, up);
        }
    }
    let order = set.depth_first();
    for &joint in &order {
        solver.turn_joint(joint, rules);
    }
    let mut offsets = vec![Vec3::ZERO; count];
    for &joint in &order {
        for child in set.children(joint) {
            offsets[child] = match solver.directions[joint] {
                Some((own, direction)) if own == child => direction * rest::length(points, joint, child),
                _ => median_offset(points, joint, child, &solver.world[joint]),
            };
        }
    }
    // The root height puts its lowest joint on the ground.
    let lowest = order
        .iter()
        .fold((0.0_f32, vec![0.0_f32; count]), |(lowest, mut heights), joint| {
            let above = set.joints[*joint].parent.map_or(0.0, |parent| heights[parent]);
            heights[*joint] = above + offsets[*joint].y;
            (lowest.min(heights[*joint]), heights)
        });
    if let Some(root) = order.first() {
        offsets[*root] = Vec3::new(0.0, -lowest.0, 0.0);
    }
    (Rest { offsets }, solver.world)
}

struct Solver<'s> {
    set: &'s JointSet,
    points: &'s Points,
    world: Vec<Vec<Quat>>,
    directions: Vec<Option<(usize, Vec3)>>,
}

impl Solver<'_> {
    fn turn_joint(&mut self, joint: usize, rules: &Rules) {
        let parent = self.set.joints[joint].parent;
        let above = match parent {
            Some(parent) => self.world[parent].clone(),
            None => vec![Quat::IDENTITY; self.points.frames],
        };
        let bone = self.set.joints[joint].bone;
        self.world[joint] = match rules.of[joint] {
            // The first loop has set this rotation.
            Rule::Trunk { .. } => return,
            Rule::Follow => above,
            Rule::Spine { child, chest, fraction } => {
                let (hips, chest) = (&self.world[rules.hips], &self.world[chest]);
                let shared: Vec<Quat> = std::iter::zip(hips, chest)
                    .map(|(hips, chest)| hips.slerp(*chest, fraction))
                    .collect();
                self.aim(joint, child, shared, None)
            }
            Rule::Upper { child, end } => match bone.and_then(|bone| limb_direction(bone).zip(bend_axis(bone))) {
                Some((direction, axis)) => self.upper(joint, child, end, &above, direction, axis),
                None => self.aim(joint, child, above, None),
            },
            Rule::Lower { child } => match bone.and_then(|bone| limb_direction(bone).zip(bend_axis(bone))) {
                Some((direction, axis)) => self.lower(joint, child, &above, direction, axis),
                None => self.aim(joint, child, above, None),
            },
            Rule::Marked { child, mark } => self.marked(joint, child, &mark, above),
            Rule::Pair { child, second } => {
                let direction = bone.and_then(|bone| self.direction(bone, joint, child));
                self.pair(joint, child, second, above, direction)
            }
            Rule::Aim { child } => {
                let direction = bone.and_then(|bone| self.direction(bone, joint, child));
                self.aim(joint, child, above, direction)
            }
        };
    }

    /// The T-pose direction of a bone, if it is known beforehand.
    fn direction(&self, bone: Bone, joint: usize, child: usize) -> Option<Vec3> {
        match bone.on(Side::Left) {
            Bone::LeftFoot => Some(foot_direction(self.points, joint, child)),
            _ => limb_direction(bone),
        }
    }

    /// The line across, and the component of the line up at right angles to it.
    fn trunk(&self, joint: usize, left: usize, right: usize, up: Up) -> Vec<Quat> {
        let mut before = Quat::IDENTITY;
        let rotation = |frame: usize| {
            let across = vector(self.points, right, left, frame);
            let to_joint = || vector(self.points, left, joint, frame) + vector(self.points, right, joint, frame);
            let up = match up {
                Up::Line(from, to) => vector(self.points, from, to, frame),
                Up::Pelvis => self.points.pelvis_up[frame],
                Up::FromMiddle => to_joint(),
                Up::ToMiddle => -to_joint(),
            };
            fitted(across, up, Vec3::X, Vec3::Y)
        };
        (0..self.points.frames)
            .map(|frame| {
                before = rotation(frame).unwrap_or(before);
                before
            })
            .collect()
    }

    /// The direction to the child, with minimal twist from `above`. Without a T-pose direction, the median of the
    /// motion is used.
    fn aim(&mut self, joint: usize, child: usize, above: Vec<Quat>, direction: Option<Vec3>) -> Vec<Quat> {
        let median = || median_offset(self.points, joint, child, &above).normalize_or_zero();
        let direction = direction.unwrap_or_else(median);
        self.directions[joint] = Some((child, direction));
        let aimed = |(frame, above): (usize, &Quat)| {
            (arc(*above * direction, vector(self.points, joint, child, frame)) * *above).normalize()
        };
        above.iter().enumerate().map(aimed).collect()
    }

    /// Like [`aim`](Self::aim), with the roll that puts a second child at its median position in the motion.
    fn pair(
        &mut self,
        joint: usize,
        child: usize,
        second: usize,
        above: Vec<Quat>,
        direction: Option<Vec3>,
    ) -> Vec<Quat> {
        let aimed = self.aim(joint, child, above, direction);
        let direction = self.directions[joint].map_or(Vec3::X, |(_, direction)| direction);
        let beside = median_offset(self.points, joint, second, &aimed);
        let to = |child: usize, frame: usize| vector(self.points, joint, child, frame);
        let rotation = |(frame, aimed): (usize, &Quat)| {
            fitted(to(child, frame), to(second, frame), direction, beside).unwrap_or(*aimed)
        };
        aimed.iter().enumerate().map(rotation).collect()
    }

    /// The rotation toward the child, with the roll from the hinge at the child.
    fn upper(
        &mut self,
        joint: usize,
        child: usize,
        end: usize,
        above: &[Quat],
        direction: Vec3,
        axis: Vec3,
    ) -> Vec<Quat> {
        self.directions[joint] = Some((child, direction));
        let (mut upper, mut lower) = (direction, direction);
        let limbs: Vec<Limb> = (0..self.points.frames)
            .map(|frame| {
                let back = above[frame].inverse();
                upper = (back * vector(self.points, joint, child, frame))
                    .try_normalize()
                    .unwrap_or(upper);
                lower = (back * vector(self.points, child, end, frame))
                    .try_normalize()
                    .unwrap_or(lower);
                Limb { upper, lower }
            })
            .collect();
        let axes = roll::axes(&limbs, direction, axis);
        (0..self.points.frames)
            .map(|frame| {
                let own = fitted(limbs[frame].upper, axes[frame], direction, axis).unwrap_or(Quat::IDENTITY);
                (above[frame] * own).normalize()
            })
            .collect()
    }

    /// The direction to the child, with the hinge axis of the parent joint.
    fn lower(&mut self, joint: usize, child: usize, above: &[Quat], direction: Vec3, axis: Vec3) -> Vec<Quat> {
        self.directions[joint] = Some((child, direction));
        let rotation = |(frame, above): (usize, &Quat)| {
            let to = vector(self.points, joint, child, frame);
            fitted(to, *above * axis, direction, axis).unwrap_or(*above)
        };
        above.iter().enumerate().map(rotation).collect()
    }

    /// The direction to the child, and the line between two points. On a head the line runs from right to left, and on
    /// a foot to the left. On a hand it runs from the little finger to the index finger, which is forward in the
    /// T-pose.
    fn marked(&mut self, joint: usize, child: Option<usize>, mark: &Mark, above: Vec<Quat>) -> Vec<Quat> {
        let line = |frame: usize| self.points.all[mark.to][frame] - self.points.all[mark.from][frame];
        let is_hand = self.set.joints[joint]
            .bone
            .is_some_and(|bone| bone.on(Side::Left) == Bone::LeftHand);
        // The big toe is on the inside. So left is the direction from small toe to big toe on the right foot, and from
        // big toe to small toe on the left foot.
        let axis = if is_hand { Vec3::Z } else { Vec3::X };
        let Some(child) = child else {
            let rotation = |(frame, above): (usize, &Quat)| (arc(*above * axis, line(frame)) * *above).normalize();
            return above.iter().enumerate().map(rotation).collect();
        };
        let bone = self.set.joints[joint].bone;
        let direction = bone.and_then(|bone| self.direction(bone, joint, child));
        let aimed = self.aim(joint, child, above, direction);
        let direction = self.directions[joint].map_or(Vec3::X, |(_, direction)| direction);
        let rotation = |(frame, aimed): (usize, &Quat)| {
            let to = vector(self.points, joint, child, frame);
            fitted(to, line(frame), direction, axis).unwrap_or(*aimed)
        };
        aimed.iter().enumerate().map(rotation).collect()
    }
}

/// The rotation that brings `from_first` to `first` exactly, and `from_second` as near to `second` as possible. `None`
/// if a vector has no length, or both have one direction.
fn fitted(first: Vec3, second: Vec3, from_first: Vec3, from_second: Vec3) -> Option<Quat> {
    let frame = |first: Vec3, second: Vec3| {
        let first = first.try_normalize()?;
        let second = (second - first * first.dot(second)).try_normalize()?;
        Some(Mat3::from_cols(first, second, first.cross(second)))
    };
    let rotation = frame(first, second)? * frame(from_first, from_second)?.transpose();
    Some(Quat::from_mat3(&rotation).normalize()).filter(|rotation| rotation.is_finite())
}
