//! The MMD bone of each node, and its keys.
//!
//! An MMD bone has no rotation at rest, so its model-space rotation is `Q = G W^-1 C^-1`. `G` is the node's rotation in
//! the pose, and `W` its rotation at rest. `C` is the rotation from the rest pose of the scene's skeleton to the rest
//! pose of the model. For example, the arms of the model may be lowered while the arms of the skeleton are horizontal.
//! A key is `Q` relative to the parent's `Q`.

use std::collections::HashMap;

use glam::{DQuat, DVec3};
use mocap_scene::math::quaternion::rotation_vector;
use mocap_scene::pose::Pose;
use mocap_scene::scene::{HumanoidBone, MmdModel, NodeId, NodeKind, Scene};

use super::super::{generic, names, scene};
use super::BoneTrack;

/// The bone that carries the body.
const CENTRE: &str = "センター";

/// The written bones, each after its parent.
pub(super) struct Bones {
    /// The name of the model.
    pub(super) model: String,
    /// The IK that is turned off.
    pub(super) ik: Vec<String>,
    bones: Vec<Bone>,
    /// The bone that carries the motion of the hips, and the bone of the hips, if the two differ.
    carried: Option<[usize; 2]>,
    /// The factor for lengths of the scene that makes the legs of its figure as long as the legs of the model.
    scale: f64,
}

struct Bone {
    name: String,
    node: usize,
    parent: Option<usize>,
    /// The rotation from the rest pose of the model to the rest pose of the node.
    to_node_rest: DQuat,
    /// Whether the bone has its own offset.
    moves: bool,
    /// Whether the bone rotates.
    turns: bool,
    inherits: Option<Inherited>,
}

struct Inherited {
    source: usize,
    ratio: f64,
    rotation: bool,
    position: bool,
}

/// Model-space positions in units, and rotations, of the bones.
pub(super) struct Placed(Vec<(DVec3, DQuat)>);

impl Bones {
    /// The bones for the joints of a scene that was read from an MMD model.
    pub(super) fn of_model(scene: &Scene, model: &MmdModel) -> Self {
        let is_bone = |index: &usize| {
            let node = &scene.nodes[*index];
            node.kind == NodeKind::Joint && node.face.is_none()
        };
        let nodes: Vec<usize> = (0..scene.nodes.len()).filter(is_bone).collect();
        let place: HashMap<usize, usize> = nodes.iter().enumerate().map(|(place, node)| (*node, place)).collect();
        let above = |node: usize| {
            let parent = |node: &usize| scene.nodes[*node].parent.map(NodeId::index);
            std::iter::successors(parent(&node), parent).find_map(|node| place.get(&node).copied())
        };
        let mut bones: Vec<Bone> = (nodes.iter())
            .map(|node| Bone {
                name: scene.nodes[*node].name.clone(),
                node: *node,
                parent: above(*node),
                to_node_rest: DQuat::IDENTITY,
                moves: true,
                turns: true,
                inherits: None,
            })
            .collect();
        let find = |bones: &[Bone], name: &str| bones.iter().position(|bone| bone.name == name);
        let (hips, centre) = (find(&bones, scene::LOWER), find(&bones, CENTRE));
        // The reader made the trunk a child of the hips. In the model, trunk and hips are siblings.
        if let (Some(hips), Some(trunk)) = (hips, find(&bones, &model.trunk))
            && bones[trunk].parent == Some(hips)
        {
            bones[trunk].parent = bones[hips].parent;
        }
        for inherits in &model.inherits {
            let (bone, source) = (find(&bones, &inherits.bone), find(&bones, &inherits.source));
            if let (Some(bone), Some(source)) = (bone, source) {
                bones[bone].inherits = is_driven(scene, bones[bone].node).then_some(Inherited {
                    source,
                    ratio: inherits.ratio,
                    rotation: inherits.rotation,
                    position: inherits.position,
                });
            }
        }
        Self {
            model: model.name.clone(),
            ik: model.ik.clone(),
            carried: centre.zip(hips).map(|(centre, hips)| [centre, hips]),
            bones,
            scale: 1.0,
        }
    }

    /// The usual bones, for a humanoid in its T-pose.
    pub(super) fn of_humanoid(humanoid: &Scene) -> Self {
        let node = |bone: HumanoidBone| humanoid.nodes.iter().position(|node| node.humanoid_bone == Some(bone));
        let generic = generic::model();
        let mut bones: Vec<Bone> = Vec::new();
        let mut place: HashMap<usize, usize> = HashMap::new();
        for (index, bone) in generic.bones.iter().enumerate() {
            let parent = std::iter::successors(bone.parent, |above| generic.bones[*above].parent);
            let parent = parent.into_iter().find_map(|above| place.get(&above).copied());
            let (own, moves) = match bone.name.as_str() {
                // The hips rotate about the waist.
                CENTRE => (Some(HumanoidBone::Spine), true),
                scene::LOWER => (Some(HumanoidBone::Hips), false),
                name => (names::bone(name), false),
            };
            // The last trunk bone that the humanoid has.
            let last = own
                .filter(|own| *own == HumanoidBone::Chest)
                .and(node(HumanoidBone::UpperChest));
            let Some((own, node)) = own.and_then(|own| Some((own, last.or_else(|| node(own))?))) else {
                continue;
            };
            place.insert(index, bones.len());
            bones.push(Bone {
                name: bone.name.clone(),
                node,
                parent,
                to_node_rest: match own.side().filter(|_| generic::is_of_arm(own)) {
                    Some(side) => generic::hanging(side).inverse(),
                    None => DQuat::IDENTITY,
                },
                moves,
                // The centre moves, but does not rotate.
                turns: !moves,
                inherits: None,
            });
        }
        let ik = generic.bones.iter().filter(|bone| bone.ik.is_some());
        Self {
            model: generic.name.clone(),
            ik: ik.map(|bone| bone.name.clone()).collect(),
            bones,
            carried: None,
            scale: generic::leg() / leg(humanoid).unwrap_or_else(generic::leg),
        }
    }

    pub(super) fn count(&self) -> usize {
        self.bones.len()
    }

    pub(super) fn tracks(&self) -> Vec<BoneTrack> {
        let track = |bone: &Bone| BoneTrack {
            name: bone.name.clone(),
            keys: Vec::new(),
        };
        self.bones.iter().map(track).collect()
    }

    /// The placement of the bones in a pose.
    pub(super) fn placed(&self, pose: &Pose, units: f64) -> Placed {
        let place = |bone: &Bone| {
            let (_, rotation, position) = pose.node_to_world[bone.node].as_dmat4().to_scale_rotation_translation();
            (position * units, rotation)
        };
        Placed(self.bones.iter().map(place).collect())
    }

    /// The keys of a pose.
    pub(super) fn keys(&self, Placed(rest): &Placed, Placed(posed): &Placed) -> Vec<(DVec3, DQuat)> {
        let in_model: Vec<DQuat> = (self.bones.iter().enumerate())
            .map(|(index, bone)| match bone.turns {
                true => (posed[index].1 * rest[index].1.inverse() * bone.to_node_rest).normalize(),
                false => DQuat::IDENTITY,
            })
            .collect();
        let mut keys: Vec<(DVec3, DQuat)> = (self.bones.iter().enumerate())
            .map(|(index, bone)| {
                let above = bone.parent.map_or(DQuat::IDENTITY, |parent| in_model[parent]);
                let from = |placed: &[(DVec3, DQuat)]| {
                    placed[index].0 - bone.parent.map_or(DVec3::ZERO, |parent| placed[parent].0)
                };
                let offset = match bone.moves {
                    true => (above.inverse() * from(posed) - from(rest)) * self.scale,
                    false => DVec3::ZERO,
                };
                (offset, (above.inverse() * in_model[index]).normalize())
            })
            .collect();
        self.carry(&mut keys, &in_model);
        self.leave_inherited(&mut keys);
        keys
    }

    /// Moves the centre with the hips, because models do not move their hips.
    fn carry(&self, keys: &mut [(DVec3, DQuat)], in_model: &[DQuat]) {
        let Some([centre, hips]) = self.carried else { return };
        let above = |bone: usize| {
            self.bones[bone]
                .parent
                .map_or(DQuat::IDENTITY, |parent| in_model[parent])
        };
        let parent = |bone: &usize| self.bones[*bone].parent;
        if !std::iter::successors(parent(&hips), parent).any(|above| above == centre) {
            return;
        }
        let offset = std::mem::take(&mut keys[hips].0);
        let in_world = above(hips) * offset;
        keys[centre].0 += above(centre).inverse() * in_world;
        // The offset of the hips is now in the centre, which also moves the siblings of the hips. Subtract the offset
        // from the trunk.
        let beside = |bone: &usize| *bone != hips && self.bones[*bone].parent == self.bones[hips].parent;
        for bone in (0..keys.len()).filter(beside) {
            let is_trunk = names::bone(&self.bones[bone].name) == Some(HumanoidBone::Spine);
            if is_trunk {
                keys[bone].0 -= offset;
            }
        }
    }

    /// Subtracts the inherited motion, which the model adds.
    fn leave_inherited(&self, keys: &mut [(DVec3, DQuat)]) {
        let whole = keys.to_vec();
        for (index, bone) in self.bones.iter().enumerate() {
            let Some(inherited) = &bone.inherits else { continue };
            let (offset, rotation) = whole[inherited.source];
            if inherited.rotation {
                let turn = DQuat::from_scaled_axis(rotation_vector(rotation) * inherited.ratio);
                keys[index].1 = (keys[index].1 * turn.inverse()).normalize();
            }
            if inherited.position {
                keys[index].0 -= offset * inherited.ratio;
            }
        }
    }
}

/// Whether the motion moves or rotates a node away from its rest pose.
fn is_driven(scene: &Scene, node: usize) -> bool {
    let (_, rotation, position) = scene.nodes[node].transform.to_scale_rotation_translation();
    let channels = scene.animations.iter().flat_map(|animation| &animation.channels);
    let mut own = channels.filter(|channel| channel.node.is_some_and(|id| id.index() == node));
    own.any(|channel| {
        let turns = channel
            .rotation_keys
            .values
            .iter()
            .any(|key| key.dot(rotation).abs() < 1.0 - ROUNDED);
        turns
            || channel
                .position_keys
                .values
                .iter()
                .any(|key| key.distance(position) > ROUNDED)
    })
}

/// The largest difference between equal numbers of the model: rounding.
const ROUNDED: f32 = 1e-6;

/// The leg length of a humanoid in metres, converted to units.
fn leg(humanoid: &Scene) -> Option<f64> {
    let rest = Pose::rest(humanoid);
    let at = |bone: HumanoidBone| {
        let node = humanoid
            .nodes
            .iter()
            .position(|node| node.humanoid_bone == Some(bone))?;
        Some(rest.node_to_world[node].w_axis.truncate().as_dvec3())
    };
    let hip = at(HumanoidBone::LeftUpperLeg)?;
    let (knee, foot) = (at(HumanoidBone::LeftLowerLeg)?, at(HumanoidBone::LeftFoot)?);
    let length = (hip.distance(knee) + knee.distance(foot)) / super::METRES_PER_UNIT;
    (length > 0.0).then_some(length)
}
