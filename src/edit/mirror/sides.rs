//! Finds from the motion how the coordinate frames of joints on one side relate to the coordinate frames of their
//! partners on the other side.

use glam::{DQuat, DVec3};

use mocap_figure::{Humanoid, HumanoidBone};
use mocap_scene::pose::{Pose, Trs};
use mocap_scene::scene::{NodeId, Scene};

use crate::frames::Frames;

/// The largest number of frames of a motion that are examined.
const FRAMES: usize = 200;

/// The cosine of the largest angle between the offset of a child and the mirror image of its partner's offset: 15
/// degrees. Offsets are in the coordinate frames of the parents. The two offsets differ only if the two sides of a body
/// differ.
const OFFSET: f64 = 0.966;

/// The cosine of 5 degrees: within this angle, the relation is certain. Bones of ACCAD differ by up to 3 degrees.
const EXACT: f64 = 0.9962;

/// The length of the shortest offset of a child that gives a direction, as a fraction of the longest offset.
const SHORTEST: f64 = 0.01;

/// The largest deviation of a joint's mean posture from symmetry, in radians: 60 degrees.
const POSTURE: f64 = 1.05;

/// A relation replaces the relation of the reference pose only if it is nearer to the mean posture by this angle, in
/// radians: 45 degrees. If a bone is rolled by half a turn, the difference is 180 degrees.
const NEARER: f64 = 0.79;

/// The usual relations between the coordinate frames of two partners: a reflection along one of the axes, or the
/// inversion. Each relation is multiplied by -1. A reflection then becomes half a turn about its axis, and the
/// inversion becomes the identity.
const LAID: [DQuat; 4] = [
    DQuat::IDENTITY,
    DQuat::from_xyzw(1.0, 0.0, 0.0, 0.0),
    DQuat::from_xyzw(0.0, 1.0, 0.0, 0.0),
    DQuat::from_xyzw(0.0, 0.0, 1.0, 0.0),
];

/// The mean coordinate frame of each joint over the motion, in the coordinate frame of the hips.
struct Posture<'a> {
    scene: &'a Scene,
    partners: &'a [NodeId],
    /// For each node, its children and their partners. Only partners count that are children of the node's partner.
    children: Vec<Vec<[usize; 2]>>,
    /// The mean coordinate frame of each node below the hips; `None` for other nodes.
    mean: Vec<Option<DQuat>>,
    /// The direction from the right to the left hip joint, in the coordinate frame of the hips.
    left: DVec3,
    /// The longest offset of a node from its parent.
    longest: f64,
}

/// Rolls the bones of a reference pose so that the coordinate frames of both sides relate as in the motion. If the two
/// sides of a rest pose are not mirror images, the rest pose does not show the rolls of the bones. The mean posture of
/// the motion shows them, if it is nearer to one of [`LAID`] than to the reference pose. The mirrored motion gives the
/// same result.
pub(super) fn lay_as_in_motion(
    scene: &Scene,
    frames: &Frames,
    humanoid: &Humanoid,
    partners: &[NodeId],
    normal: DVec3,
    rotations: &mut [DQuat],
) {
    let Some(posture) = Posture::new(scene, frames, humanoid, partners) else {
        return;
    };
    let across = half_turn(normal);
    let known = |node: usize| rotations[partners[node].index()].inverse() * across * rotations[node];
    for (node, laid) in posture.laid(&known).into_iter().enumerate() {
        let (Some(laid), partner) = (laid, partners[node].index()) else {
            continue;
        };
        let sum = |is_middle: bool| -> [DVec3; 2] {
            let pairs = posture
                .children(node)
                .filter(|[own, other]| (own == other) == is_middle);
            let offsets = pairs.map(|pair| pair.map(|child| posture.offset(child)));
            offsets.fold([DVec3::ZERO; 2], |sums, pair| [sums[0] + pair[0], sums[1] + pair[1]])
        };
        if partner == node {
            let axis = sum(true)[0].try_normalize();
            let axis = axis.map_or(laid.xyz(), |along| laid.xyz().reject_from_normalized(along).normalize());
            let across = rotations[node] * axis;
            let across = across * across.dot(normal).signum();
            rotations[node] = DQuat::from_rotation_arc(across, normal) * rotations[node];
        } else if node > partner {
            // A small rotation makes the directions of the bones exact mirror images.
            let along = sum(false).map(DVec3::try_normalize);
            let exact = match along {
                [Some(own), Some(other)] => DQuat::from_rotation_arc(laid * own, -other),
                _ => DQuat::IDENTITY,
            };
            rotations[node] = (across * rotations[partner] * exact * laid).normalize();
        }
    }
}

fn half_turn(axis: DVec3) -> DQuat {
    DQuat::from_xyzw(axis.x, axis.y, axis.z, 0.0)
}

impl<'a> Posture<'a> {
    fn new(scene: &'a Scene, frames: &Frames, humanoid: &Humanoid, partners: &'a [NodeId]) -> Option<Self> {
        let [hips, left, right] = [
            HumanoidBone::Hips,
            HumanoidBone::LeftUpperLeg,
            HumanoidBone::RightUpperLeg,
        ]
        .map(|bone| humanoid.joint(bone));
        let (hips, left, right) = (hips?, left?, right?);
        let is_below = |node: usize| {
            let mut above = std::iter::successors(Some(NodeId::new(node)), |node| scene.nodes[node.index()].parent);
            above.any(|above| above == hips)
        };
        let mut sums: Vec<Option<DQuat>> = (0..scene.nodes.len())
            .map(|node| is_below(node).then(|| DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0)))
            .collect();
        let mut across = DVec3::ZERO;
        let mut pose = Pose::rest(scene);
        for frame in (0..frames.len()).step_by(frames.len().div_ceil(FRAMES).max(1)) {
            frames.pose(frame, &mut pose);
            let rotation = |node: usize| Trs::from_matrix(pose.node_to_world[node]).rotation.as_dquat();
            let to_hips = rotation(hips.index()).inverse();
            across += to_hips * (pose.position(left) - pose.position(right)).as_dvec3();
            for (node, sum) in sums.iter_mut().enumerate() {
                let Some(sum) = sum else { continue };
                let here = (to_hips * rotation(node)).normalize();
                *sum += if sum.dot(here) < 0.0 { -here } else { here };
            }
        }
        let mut children = vec![Vec::new(); scene.nodes.len()];
        let parent = |child: usize| scene.nodes[child].parent.map(NodeId::index);
        for (own, other) in partners.iter().copied().map(NodeId::index).enumerate() {
            if let (Some(above), Some(beside)) = (parent(own), parent(other))
                && partners[above].index() == beside
            {
                children[above].push([own, other]);
            }
        }
        let longest = scene.nodes.iter().map(|node| node.transform.w_axis.truncate().length());
        Some(Self {
            scene,
            partners,
            children,
            mean: sums.into_iter().map(|sum| Some(sum?.normalize())).collect(),
            left: across.try_normalize()?,
            longest: f64::from(longest.fold(0.0, f32::max)),
        })
    }

    /// For each node, the relation between its coordinate frame and the frame of its partner. The result is a relation
    /// of [`LAID`] if this relation is nearer to the mean posture than the relation of the reference pose. A joint with
    /// an asymmetric posture does not show its relation, and gets the relation of the next joint of its limb.
    fn laid(&self, known: &dyn Fn(usize) -> DQuat) -> Vec<Option<DQuat>> {
        let count = self.scene.nodes.len();
        let nearest: Vec<Option<(f64, DQuat)>> = (0..count).map(|node| self.nearest(node)).collect();
        let is_shown = |node: usize| self.children(node).any(|pair| self.is_long(pair));
        let better = |node: usize| {
            let (near, laid) = nearest[node]?;
            let is_certain = is_shown(node) && self.fits(node, laid, EXACT);
            let is_wrong = || !self.fits(node, known(node), OFFSET);
            let is_better = is_certain || is_wrong() || near + NEARER < self.off(node, known(node))?;
            is_better.then_some(laid)
        };
        let mut laid: Vec<Option<DQuat>> = (0..count).map(better).collect();
        let is_paired = |node: usize| self.partners[node].index() != node;
        let above = |node: usize| self.scene.nodes[node].parent.map(NodeId::index);
        let joined = |node: usize| Some((node, above(node).filter(|above| is_paired(*above) && is_paired(node))?));
        let down: Vec<(usize, usize)> = (0..count).filter_map(joined).collect();
        let up = down.iter().rev().map(|(node, above)| (*above, *node));
        for (node, next) in down.iter().copied().chain(up) {
            if (nearest[node].is_none() || !is_shown(node)) && laid[node].is_none() {
                laid[node] = laid[next].filter(|laid| self.mean[node].is_some() && self.fits(node, *laid, OFFSET));
            }
        }
        laid
    }

    /// Of the relations in [`LAID`] that fit a joint: the one nearest to the mean posture, with its deviation in
    /// radians. `None` if the posture is too asymmetric.
    fn nearest(&self, node: usize) -> Option<(f64, DQuat)> {
        let fitting = LAID.iter().filter(|laid| self.fits(node, **laid, OFFSET));
        let off = |laid: &DQuat| Some((self.off(node, *laid)?, *laid));
        let nearest = fitting.filter_map(off).min_by(|a, b| a.0.total_cmp(&b.0));
        nearest.filter(|(off, _)| *off < POSTURE)
    }

    /// The deviation in radians of the mean posture from a relation.
    fn off(&self, node: usize, stands: DQuat) -> Option<f64> {
        let partner = self.partners[node].index();
        let posture = self.mean[partner]?.inverse() * half_turn(self.left) * self.mean[node]?;
        Some(posture.angle_between(stands))
    }

    fn children(&self, node: usize) -> impl Iterator<Item = [usize; 2]> + '_ {
        self.children[node].iter().copied()
    }

    fn offset(&self, node: usize) -> DVec3 {
        self.scene.nodes[node].transform.w_axis.truncate().as_dvec3()
    }

    /// Whether a relation makes the offsets of the children of a joint mirror images of the offsets of its partner's
    /// children. The cosine of the angle between them must be above `within`.
    fn fits(&self, node: usize, laid: DQuat, within: f64) -> bool {
        // A joint in the middle of the body is its own partner, so its relation can only be a reflection.
        if self.partners[node].index() == node && laid == DQuat::IDENTITY {
            return false;
        }
        let mut shown = self.children(node).filter(|pair| self.is_long(*pair));
        shown.all(|pair| {
            let [own, other] = pair.map(|child| self.offset(child));
            -(laid * own).dot(other) > within * own.length() * other.length()
        })
    }

    /// Whether both offsets are long enough to give a direction.
    fn is_long(&self, pair: [usize; 2]) -> bool {
        pair.iter()
            .all(|child| self.offset(*child).length() >= SHORTEST * self.longest)
    }
}
