//! Aligns the axes of joints with their bones.

use std::collections::BTreeMap;

use glam::{Mat3, Mat4, Quat, Vec3};
use mocap_scene::error::Result;
use mocap_scene::pose::{Pose, Trs};
use mocap_scene::process;
use mocap_scene::scene::report::{AppliedStep, StepRecord};
use mocap_scene::scene::{NodeId, NodeKind, Scene};
use serde::{Deserialize, Serialize};

use super::Conversion;
use crate::axes::bend_axis;
use crate::{Figure, Humanoid, HumanoidBone as Bone, HumanoidMap, Side};

/// The distance below which two joints coincide and have no direction between them, as a fraction of the skeleton's
/// size.
const COINCIDENT: f32 = 1e-4;

/// The smallest sine of the angle between a bone and its bending axis. If the sine is smaller, the component of the
/// axis across the bone is only rounding.
const ALONG: f32 = 1e-3;

/// The axis of a joint that points along its bone. [`Conversion::bone_axis`] has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum AlongBone {
    /// +Y, as Blender draws bones. The joint bends about +X.
    #[default]
    Y,
    /// +X, as in Unreal. The joint bends about +Z.
    X,
}

impl Conversion {
    /// Which axis of each joint points along its bone in the rest pose.
    ///
    /// Default: `None`, which keeps the axes of the file. The axes of a BVH file are the world axes, so every bone
    /// points up in Blender. Positions do not change, neither in the rest pose nor in the motion.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::convert::AlongBone;
    /// use mocap::{Conversion, Pose, scene::NodeId};
    ///
    /// let mut scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
    /// Conversion::new().bone_axis(Some(AlongBone::Y)).apply(&mut scene)?;
    /// let rest = Pose::rest(&scene);
    /// let to_elbow = rest.position(NodeId(1)) - rest.position(NodeId(0));
    /// assert!(rest.node_to_world[0].y_axis.truncate().angle_between(to_elbow) < 1e-3);
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[must_use]
    pub fn bone_axis(mut self, axis: Option<AlongBone>) -> Self {
        self.bone_axis = axis;
        self
    }
}

impl AlongBone {
    /// Rotates the axes of the joints of `scene`, which has the bones `humanoid`. The caller has stated the bones
    /// `stated`.
    ///
    /// # Errors
    /// If a node has a non-uniform scale; `scene` is then unchanged.
    #[doc(hidden)]
    pub fn turn_frames(self, scene: &mut Scene, humanoid: Humanoid, stated: &HumanoidMap) -> Result<()> {
        let figure = Figure::with_bones(scene, humanoid);
        let rest = Pose::rest(scene);
        let before: Vec<Quat> = rest.node_to_world.iter().map(rotation).collect();
        let along = directions(scene, &figure, &rest);
        let bends = bends(scene, &figure, &before);
        let left = figure.t_pose(scene).map_or(Vec3::X, |t_pose| t_pose.axes * Vec3::X);
        let mut wanted: Vec<Quat> = Vec::with_capacity(before.len());
        for (index, before) in before.into_iter().enumerate() {
            // A joint without a direction keeps its axes.
            let Some(here) = along[index] else {
                wanted.push(before);
                continue;
            };
            let parent = scene.nodes[index].parent.map(NodeId::index);
            let above = parent.and_then(|parent| Some((along[parent]?, wanted[parent] * self.bend_axis())));
            let as_above = above.map(|(above, bend)| Quat::from_rotation_arc(above, here) * bend);
            let bend = bends[index].filter(|bend| here.cross(*bend).length() > ALONG);
            wanted.push(self.frame(here, bend.or(as_above).unwrap_or(left)));
        }
        process::set_rest_rotations(scene, &wanted)?;
        scene.metadata.steps.push(AppliedStep::Edit {
            edit: StepRecord(serde_json::json!({ "step": "bone-axis", "axis": self })),
            with: None,
            bones: stated.bones.clone(),
        });
        Ok(())
    }

    /// The axis of a joint about which the bone bends.
    fn bend_axis(self) -> Vec3 {
        match self {
            Self::Y => Vec3::X,
            Self::X => Vec3::Z,
        }
    }

    /// The coordinate frame with one axis along a bone, and another along its bending axis.
    fn frame(self, along: Vec3, bend: Vec3) -> Quat {
        let across = Some(bend.reject_from_normalized(along)).filter(|across| across.length() > ALONG);
        let bend = across.and_then(Vec3::try_normalize);
        let bend = bend.unwrap_or_else(|| along.any_orthonormal_vector());
        let axes = match self {
            Self::Y => Mat3::from_cols(bend, along, bend.cross(along)),
            Self::X => Mat3::from_cols(along, bend.cross(along), bend),
        };
        Quat::from_mat3(&axes).normalize()
    }
}

/// The rotation in a matrix, without its scale.
fn rotation(matrix: &Mat4) -> Quat {
    Trs::from_matrix(*matrix).rotation
}

fn is_of_skeleton(scene: &Scene, index: usize) -> bool {
    matches!(scene.nodes[index].kind, NodeKind::Joint | NodeKind::EndSite)
}

/// The direction along the bone of each joint, in the world; `None` if nothing shows it.
fn directions(scene: &Scene, figure: &Figure, rest: &Pose) -> Vec<Option<Vec3>> {
    let mut children: Vec<Vec<NodeId>> = vec![Vec::new(); scene.nodes.len()];
    for (index, node) in scene.nodes.iter().enumerate() {
        if let Some(parent) = node.parent.filter(|_| is_of_skeleton(scene, index)) {
            children[parent.index()].push(NodeId::new(index));
        }
    }
    let positions = || (0..scene.nodes.len()).map(|index| rest.position(NodeId::new(index)));
    let (least, most) = positions().fold((Vec3::MAX, Vec3::MIN), |(a, b), here| (a.min(here), b.max(here)));
    let coincident = COINCIDENT * least.distance(most);
    let bones: BTreeMap<NodeId, Bone> = Bone::ALL
        .iter()
        .filter_map(|bone| Some((figure.humanoid.joint(*bone)?, *bone)))
        .collect();
    let is_below = |mut node: NodeId, above: NodeId| loop {
        match scene.nodes[node.index()].parent {
            _ if node == above => return true,
            Some(parent) => node = parent,
            None => return false,
        }
    };
    let mut own: Vec<Option<Vec3>> = vec![None; scene.nodes.len()];
    for index in (0..scene.nodes.len())
        .rev()
        .filter(|index| is_of_skeleton(scene, *index))
    {
        let (node, here) = (NodeId::new(index), rest.position(NodeId::new(index)));
        let offset = |child: &NodeId| Some(rest.position(*child) - here).filter(|offset| offset.length() > coincident);
        let children = &children[index];
        let on_chain = bones.get(&node).and_then(|bone| {
            let next = next(*bone)
                .into_iter()
                .find_map(|next| figure.humanoid.joint(next).filter(|next| is_below(*next, node)))?;
            let child = *children.iter().find(|child| is_below(next, **child))?;
            offset(&child).or(own[child.index()])
        });
        let mean = || {
            let offsets: Vec<Vec3> = children.iter().filter_map(offset).collect();
            let sum: Vec3 = offsets.iter().sum();
            Some(sum / offsets.len() as f32).filter(|mean| !offsets.is_empty() && mean.length() > coincident)
        };
        let in_one_place = || children.iter().find_map(|child| own[child.index()]);
        own[index] = on_chain
            .or_else(mean)
            .and_then(Vec3::try_normalize)
            .or_else(in_one_place);
    }
    for index in 0..own.len() {
        let above = scene.nodes[index].parent.and_then(|parent| own[parent.index()]);
        own[index] = own[index].or(above).filter(|_| is_of_skeleton(scene, index));
    }
    own
}

/// The bones towards which a bone may point, the nearest first.
fn next(bone: Bone) -> Vec<Bone> {
    const TRUNK: [Bone; 6] = [
        Bone::Hips,
        Bone::Spine,
        Bone::Chest,
        Bone::UpperChest,
        Bone::Neck,
        Bone::Head,
    ];
    if let Some(at) = TRUNK.iter().position(|other| *other == bone) {
        return TRUNK[at + 1..].to_vec();
    }
    if bone.on(Side::Left) == Bone::LeftHand {
        let side = bone.side().unwrap_or(Side::Left);
        return [
            Bone::LeftMiddleProximal,
            Bone::LeftRingProximal,
            Bone::LeftIndexProximal,
        ]
        .map(|knuckle| knuckle.on(side))
        .to_vec();
    }
    Bone::ALL
        .iter()
        .copied()
        .filter(|next| next.parent() == Some(bone))
        .collect()
}

/// The bending axis of each joint at rest, in the world; `None` if the figure does not show it.
fn bends(scene: &Scene, figure: &Figure, before: &[Quat]) -> Vec<Option<Vec3>> {
    let mut bends: Vec<Option<Vec3>> = vec![None; scene.nodes.len()];
    if let Some(t_pose) = figure.t_pose(scene) {
        for (bone, found) in &t_pose.bones {
            let joint = found.joint.index();
            let in_t_pose = rotation(&t_pose.pose.node_to_world[joint]);
            bends[joint] = Some(before[joint] * (in_t_pose.inverse() * (t_pose.axes * bend(*bone))));
        }
    }
    bends
}

/// The bending axis of a bone, in the coordinate frame of the T-pose. Hands and fingers bend towards the palm, which is
/// down.
fn bend(bone: Bone) -> Vec3 {
    let is_right = bone.side() == Some(Side::Right);
    match bone.on(Side::Left) {
        Bone::LeftShoulder => bend(Bone::LeftUpperArm.on(bone.side().unwrap_or(Side::Left))),
        Bone::LeftHand if is_right => Vec3::Z,
        Bone::LeftHand => Vec3::NEG_Z,
        _ if bone.is_finger() && is_right => Vec3::Z,
        _ if bone.is_finger() => Vec3::NEG_Z,
        _ => bend_axis(bone).unwrap_or(Vec3::X),
    }
}
