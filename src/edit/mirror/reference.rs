//! Finds a reference pose in which both sides of a figure are mirror images.

use glam::{DQuat, DVec3, Vec3};

use mocap_figure::{Axis, Humanoid, HumanoidBone, Side};
use mocap_scene::pose::{Pose, Trs};
use mocap_scene::scene::{NodeId, Scene};

/// The cosine of 45 degrees: the largest angle between the mirror image of a bone and its partner at which the bone is
/// corrected.
const NEAR: f64 = 0.7;

/// The sine of the smallest bend that counts. If a knee or an elbow is bent in the rest pose, the bend shows the axis
/// of the joint.
const BENT: f64 = 0.2;

/// The largest distance of a bone from its partner's mirror image in a symmetric rest pose, as a fraction of the
/// distance from the hips to the farthest bone. The arms of the CMU skeleton reach 4 %.
const ALIKE: f64 = 0.05;

/// The smallest mean distance of a bone from its partner in a symmetric rest pose, as a fraction of the distance from
/// the hips to the farthest bone. In a rest pose without rotations, all bones may be on one line.
const APART: f64 = 0.1;

/// The bones of an arm and of a leg. The first two bones of a limb bend about the same axis.
const LIMBS: [[HumanoidBone; 3]; 2] = [
    [
        HumanoidBone::LeftUpperLeg,
        HumanoidBone::LeftLowerLeg,
        HumanoidBone::LeftFoot,
    ],
    [
        HumanoidBone::LeftUpperArm,
        HumanoidBone::LeftLowerArm,
        HumanoidBone::LeftHand,
    ],
];

/// The direction to the left of the figure in the rest pose, if both sides of the rest pose are mirror images.
pub(super) fn left_at_rest(rest: &Pose, humanoid: &Humanoid, hips: NodeId) -> Option<DVec3> {
    let at = |bone: HumanoidBone| Some((rest.position(humanoid.joint(bone)?) - rest.position(hips)).as_dvec3());
    let bones = || humanoid.bones.keys().copied();
    let left_ones = bones().filter(|bone| bone.side() == Some(Side::Left));
    let pairs: Vec<[DVec3; 2]> = left_ones
        .filter_map(|bone| Some([at(bone)?, at(bone.mirrored())?]))
        .collect();
    let middle: Vec<DVec3> = bones().filter(|bone| bone.side().is_none()).filter_map(at).collect();
    let all = pairs.iter().flatten().chain(&middle);
    let size = all.map(|at| at.length()).fold(0.0, f64::max);
    let left = along_axis(pairs.iter().map(|[left, right]| *left - *right).sum())?;
    let is_near = |at: DVec3, other: DVec3| (at - 2.0 * at.dot(left) * left).distance(other) < ALIKE * size;
    let apart: f64 = pairs.iter().map(|[left, right]| left.distance(*right)).sum();
    let is_mirrored = pairs.iter().all(|[left, right]| is_near(*left, *right))
        && middle.iter().all(|at| is_near(*at, *at))
        && apart > APART * size * pairs.len() as f64;
    is_mirrored.then_some(left)
}

/// The direction, or the coordinate axis within 8 degrees of it.
pub(super) fn along_axis(direction: DVec3) -> Option<DVec3> {
    let direction = direction.try_normalize()?;
    let axes = [Axis::X, Axis::Y, Axis::Z, Axis::NegX, Axis::NegY, Axis::NegZ];
    let mut axes = axes.into_iter().filter_map(Axis::direction).map(Vec3::as_dvec3);
    Some(axes.find(|axis| axis.dot(direction) > 0.99).unwrap_or(direction))
}

/// The rotation of a node in the world.
fn rotation(pose: &Pose, node: usize) -> DQuat {
    let rotation = Trs::from_matrix(pose.node_to_world[node]).rotation;
    rotation.as_dquat().normalize()
}

/// The rotations of all nodes in the world.
pub(super) fn rotations(pose: &Pose) -> Vec<DQuat> {
    (0..pose.node_to_world.len()).map(|node| rotation(pose, node)).collect()
}

/// The world rotations of the T-pose `pose`, corrected so that both sides are mirror images. Each bone gets the
/// direction of its partner's mirror image, and bends about the mirror image of its partner's axis. The correction is
/// necessary if, for example, one leg is in front in the rest pose. Both legs of the T-pose then point down, but have
/// different rolls.
pub(super) fn symmetric(
    scene: &Scene,
    humanoid: &Humanoid,
    pose: &Pose,
    partners: &[NodeId],
    normal: DVec3,
) -> Vec<DQuat> {
    let count = scene.nodes.len();
    let mut rotations = rotations(pose);
    let at = |node: usize| pose.position(NodeId::new(node)).as_dvec3();
    let reflect = |vector: DVec3| vector - 2.0 * vector.dot(normal) * normal;
    let axes = axes(scene, humanoid, &|rest, node| {
        rotations[node] * rotation(rest, node).inverse()
    });
    let mut children: Vec<Vec<usize>> = vec![Vec::new(); count];
    for (node, parent) in scene
        .nodes
        .iter()
        .enumerate()
        .filter_map(|(node, it)| Some((node, it.parent?)))
    {
        children[parent.index()].push(node);
    }
    let mut turns = vec![DQuat::IDENTITY; count];
    for node in 0..count {
        let partner = partners[node].index();
        if partner == node {
            // A bone in the middle of the body is in the mirror plane. A pair of joints at its sides is perpendicular
            // to the plane.
            let in_middle = children[node]
                .iter()
                .filter(|child| partners[**child].index() == **child);
            let along = in_middle
                .map(|child| at(*child) - at(node))
                .max_by(|a, b| a.length().total_cmp(&b.length()))
                .and_then(DVec3::try_normalize);
            let across: DVec3 = children[node]
                .iter()
                .map(|child| {
                    let offset = at(*child) - at(partners[*child].index());
                    offset * offset.dot(normal).signum()
                })
                .sum();
            let across = across.try_normalize().filter(|across| across.dot(normal) > NEAR);
            let in_plane = along.and_then(|along| along.reject_from_normalized(normal).try_normalize());
            let turn = match (along.zip(in_plane), across) {
                (Some((along, in_plane)), across) if along.dot(in_plane) > NEAR => {
                    let turn = DQuat::from_rotation_arc(along, in_plane);
                    let across = across.map(|across| (turn * across).reject_from_normalized(in_plane));
                    let across = across.and_then(DVec3::try_normalize);
                    across.map_or(turn, |across| DQuat::from_rotation_arc(across, normal) * turn)
                }
                (_, Some(across)) => DQuat::from_rotation_arc(across, normal),
                _ => DQuat::IDENTITY,
            };
            rotations[node] = turn * rotations[node];
        } else if node < partner {
            let is_pair = |child: &&usize| scene.nodes[partners[**child].index()].parent == Some(partners[node]);
            let pairs: Vec<[DVec3; 2]> = children[node]
                .iter()
                .filter(is_pair)
                .map(|child| [at(*child) - at(node), at(partners[*child].index()) - at(partner)])
                .collect();
            // A bone points to the mean of its children. One child alone, such as a thumb, may not show the direction
            // of a hand.
            let sums = [0, 1].map(|side: usize| pairs.iter().map(|pairs| pairs[side]).sum::<DVec3>().try_normalize());
            let [Some(own), Some(other)] = sums else {
                continue;
            };
            // Rotates only the partner: this is enough to make both bones mirror images.
            let along = reflect(own);
            // A joint that is no bone of the T-pose rotates with the bone above.
            let above = scene.nodes[partner]
                .parent
                .map_or(DQuat::IDENTITY, |parent| turns[parent.index()]);
            let start = if (above * other).dot(along) > other.dot(along) {
                above
            } else {
                DQuat::IDENTITY
            };
            if (start * other).dot(along) < NEAR {
                continue;
            }
            let mut turn = DQuat::from_rotation_arc(start * other, along) * start;
            // The hinge axis of a bone determines its roll. For a bone without a hinge axis, a child beside the bone,
            // such as a finger, determines the roll.
            let beside = |pairs: &&[DVec3; 2]| {
                let off = |along: &DVec3, offset: DVec3| {
                    offset.reject_from_normalized(*along).length() > BENT * offset.length()
                };
                [own, other]
                    .iter()
                    .zip(**pairs)
                    .all(|(along, offset)| off(along, offset))
            };
            let second = match (axes[node], axes[partner]) {
                // The mirror image of a rotation axis also changes its sign.
                (Some(axis), Some(other)) => Some([axis, -other]),
                _ => pairs
                    .iter()
                    .filter(beside)
                    .max_by(|a, b| a[0].length().total_cmp(&b[0].length()))
                    .copied(),
            };
            if let Some([second, other]) = second {
                let wanted = reflect(second).reject_from_normalized(along);
                let found = (turn * other).reject_from_normalized(along);
                let angle = found.cross(wanted).dot(along).atan2(found.dot(wanted));
                turn = DQuat::from_axis_angle(along, angle) * turn;
            }
            turns[partner] = turn;
            rotations[partner] = turn * rotations[partner];
        }
    }
    rotations
}

/// The axes about which the bones of limbs bend, in the world of the T-pose, if the rest pose shows them. `to_pose`
/// gives the rotation of a node from the rest pose to the T-pose.
fn axes(scene: &Scene, humanoid: &Humanoid, to_pose: &dyn Fn(&Pose, usize) -> DQuat) -> Vec<Option<DVec3>> {
    let rest = Pose::rest(scene);
    let mut axes = vec![None; scene.nodes.len()];
    for limb in LIMBS
        .into_iter()
        .flat_map(|limb| [limb, limb.map(HumanoidBone::mirrored)])
    {
        let [Some(upper), Some(lower), Some(end)] = limb.map(|bone| humanoid.joint(bone)) else {
            continue;
        };
        let at = |node: NodeId| rest.position(node).as_dvec3();
        let (thigh, shin) = (at(lower) - at(upper), at(end) - at(lower));
        let axis = thigh.cross(shin);
        if axis.length() > BENT * thigh.length() * shin.length() {
            for node in [upper, lower] {
                axes[node.index()] = Some(to_pose(&rest, node.index()) * axis.normalize());
            }
        }
    }
    axes
}
