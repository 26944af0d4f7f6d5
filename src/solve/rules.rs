//! The rule by which the rotation of each joint is found.

use mocap_scene::scene::{HumanoidBone as Bone, Side};

use super::points::Points;
use super::rest;
use super::set::{JointSet, Mark};

/// The up line of a trunk joint.
#[derive(Clone, Copy, Debug)]
pub(super) enum Up {
    /// From one joint to another.
    Line(usize, usize),
    /// The up direction of the pelvis.
    Pelvis,
    /// From the midpoint of the line across to the joint.
    FromMiddle,
    /// From the joint to the midpoint of the line across.
    ToMiddle,
}

/// The rule that determines the rotation of a joint.
#[derive(Clone, Copy, Debug)]
pub(super) enum Rule {
    /// The line across, from right to left, and the line up.
    Trunk { left: usize, right: usize, up: Up },
    /// The direction to the child, and this fraction of the twist between hips and chest.
    Spine { child: usize, chest: usize, fraction: f32 },
    /// The direction to the child, and the hinge at the child. `end` is the far end of the bone after the hinge.
    Upper { child: usize, end: usize },
    /// The direction to the child, and the hinge of the parent joint.
    Lower { child: usize },
    /// The direction to the child, if there is one, and a roll mark.
    Marked { child: Option<usize>, mark: Mark },
    /// The direction to the child, with the least twist from the parent.
    Aim { child: usize },
    /// The direction to the child, and the direction to a second child beside it.
    Pair { child: usize, second: usize },
    /// The rotation of the parent.
    Follow,
}

#[derive(Debug)]
pub(super) struct Rules {
    pub(super) of: Vec<Rule>,
    /// The hips joint, or otherwise the root.
    pub(super) hips: usize,
}

impl Rules {
    pub(super) fn new(set: &JointSet, points: &Points) -> Self {
        let root = set.joints.iter().position(|joint| joint.parent.is_none()).unwrap_or(0);
        let hips = set.joint(Bone::Hips).unwrap_or(root);
        let mut of: Vec<Rule> = (0..set.joints.len()).map(|joint| plain(set, joint)).collect();
        for (joint, rule) in of.iter_mut().enumerate() {
            if let Rule::Aim { child } = *rule
                && let Some(second) = beside(set, points, joint, child)
            {
                *rule = Rule::Pair { child, second };
            }
        }
        if let Some(rule) = trunk(set, points, hips, [Bone::LeftUpperLeg, Bone::LeftShoulder]) {
            of[hips] = rule;
        }
        let chest = chest(set).filter(|chest| *chest != hips);
        if let Some((chest, rule)) = chest.and_then(|chest| {
            Some((
                chest,
                trunk(set, points, chest, [Bone::LeftShoulder, Bone::LeftUpperArm])?,
            ))
        }) {
            of[chest] = rule;
            share_twist(set, &mut of, hips, chest);
        }
        Self { of, hips }
    }
}

/// The child whose direction differs most from the direction of `child`. `None` if the angle is too small to determine
/// a roll.
fn beside(set: &JointSet, points: &Points, joint: usize, child: usize) -> Option<usize> {
    /// The smallest angle in degrees at which two directions determine a roll.
    const LEAST: f32 = 10.0;
    let angle = |second: &usize| {
        points.median(|frame| {
            let first = rest::vector(points, joint, child, frame).normalize_or_zero();
            let second = rest::vector(points, joint, *second, frame).normalize_or_zero();
            first.cross(second).length().asin().to_degrees()
        })
    };
    let others = set.children(joint).into_iter().filter(|other| *other != child);
    let angles = others.map(|other| (other, angle(&other)));
    let most = angles.max_by(|a, b| a.1.total_cmp(&b.1))?;
    (most.1 >= LEAST).then_some(most.0)
}

/// The common parent of both arms.
fn chest(set: &JointSet) -> Option<usize> {
    let parent = |bone: Bone| set.joints[set.joint(bone)?].parent;
    [
        [Bone::LeftShoulder, Bone::RightShoulder],
        [Bone::LeftUpperArm, Bone::RightUpperArm],
    ]
    .into_iter()
    .find_map(|[left, right]| parent(left).filter(|chest| parent(right) == Some(*chest)))
}

/// The rule of a joint with a left and a right child. The children are the first bone of `sides` that exists on both
/// sides.
fn trunk(set: &JointSet, points: &Points, joint: usize, sides: [Bone; 2]) -> Option<Rule> {
    /// The fraction of the line across below which two joints are too close to give a direction.
    const NEAR: f32 = 0.1;
    /// The distance of a joint from the midpoint of the line across, as a fraction of that line, above which the
    /// direction is more than noise.
    const FAR: f32 = 0.3;
    let child = |bone: Bone| set.joint(bone).filter(|child| set.joints[*child].parent == Some(joint));
    let pair = |bone: Bone| Some((child(bone)?, child(bone.on(Side::Right))?));
    let (left, right) = sides.into_iter().find_map(pair)?;
    let trunk = [Bone::Spine, Bone::Chest, Bone::UpperChest, Bone::Neck, Bone::Head];
    let above = trunk.into_iter().find_map(child);
    let is_far = |above: &usize| rest::length(points, joint, *above) > NEAR * rest::length(points, right, left);
    let to_middle = points.median(|frame| {
        let [own, left, right] = [joint, left, right].map(|joint| points.tracks[joint][frame]);
        own.distance(left.midpoint(right)) / left.distance(right).max(f32::MIN_POSITIVE)
    });
    let up = match (above.filter(is_far), set.joints[joint].parent) {
        (_, None) if !points.pelvis_up.is_empty() => Up::Pelvis,
        (Some(above), _) => Up::Line(joint, above),
        // If the midpoint of the shoulders is far from the joint, the line to the midpoint points up. If the midpoint
        // is nearer, the direction of this line is noise, and the line from the parent counts.
        (None, Some(_)) if to_middle > FAR => Up::ToMiddle,
        (None, Some(parent)) => Up::Line(parent, joint),
        // Hips that are higher than the leg joints show the up direction, however the spine bends.
        (None, None) if to_middle > NEAR => Up::FromMiddle,
        (None, None) => Up::Line(
            joint,
            trunk.into_iter().filter_map(|bone| set.joint(bone)).find(is_far)?,
        ),
    };
    Some(Rule::Trunk { left, right, up })
}

/// The rule of a joint that its bone and its children determine.
fn plain(set: &JointSet, joint: usize) -> Rule {
    let children = set.children(joint);
    let bone = set.joints[joint].bone;
    let mark = set.marks.iter().find(|mark| mark.joint == joint);
    let child_bone = bone.and_then(next).and_then(|next| set.joint(next));
    let child = child_bone
        .filter(|child| children.contains(child))
        .or(match children.as_slice() {
            [only] => Some(*only),
            // The middle finger, or the child in the middle.
            [] => None,
            several => Some(middle(set, several)),
        });
    match (bone.map(|bone| bone.on(Side::Left)), child, mark) {
        (_, child, Some(mark)) => Rule::Marked { child, mark: *mark },
        (Some(Bone::LeftUpperArm | Bone::LeftUpperLeg), Some(child), _) => {
            let below = set.joints[child].bone.and_then(next).and_then(|end| set.joint(end));
            match below {
                Some(end) => Rule::Upper { child, end },
                None => Rule::Aim { child },
            }
        }
        (Some(Bone::LeftLowerArm | Bone::LeftLowerLeg), Some(child), _) => Rule::Lower { child },
        (_, Some(child), _) => Rule::Aim { child },
        (_, None, _) => Rule::Follow,
    }
}

fn middle(set: &JointSet, children: &[usize]) -> usize {
    let is_middle = |child: &&usize| {
        let bone = set.joints[**child].bone.map(|bone| bone.on(Side::Left));
        bone == Some(Bone::LeftMiddleProximal) || set.joints[**child].name.to_lowercase().contains("middle")
    };
    children.iter().find(is_middle).copied().unwrap_or(children[0])
}

/// The bone that starts at the end of a bone.
fn next(bone: Bone) -> Option<Bone> {
    let next = match bone.on(Side::Left) {
        Bone::Neck => return Some(Bone::Head),
        Bone::LeftUpperArm => Bone::LeftLowerArm,
        Bone::LeftLowerArm => Bone::LeftHand,
        Bone::LeftUpperLeg => Bone::LeftLowerLeg,
        Bone::LeftLowerLeg => Bone::LeftFoot,
        Bone::LeftFoot => Bone::LeftToes,
        _ => return None,
    };
    Some(bone.side().map_or(next, |side| next.on(side)))
}

/// Gives the joints between hips and chest their fractions of the twist.
fn share_twist(set: &JointSet, of: &mut [Rule], hips: usize, chest: usize) {
    let parents = std::iter::successors(set.joints[chest].parent, |joint| set.joints[*joint].parent);
    let between: Vec<usize> = parents.take_while(|joint| *joint != hips).collect();
    let parts = between.len() as f32 + 1.0;
    for (index, joint) in between.iter().rev().enumerate() {
        let fraction = (index as f32 + 1.0) / parts;
        let child = std::iter::successors(Some(chest), |above| set.joints[*above].parent)
            .find(|above| set.joints[*above].parent == Some(*joint));
        if let Some(child) = child {
            of[*joint] = Rule::Spine { child, chest, fraction };
        }
    }
}
