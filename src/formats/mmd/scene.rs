//! Makes nodes from bones and morphs, and computes the motion at every frame.

use std::collections::HashMap;

use glam::{DQuat, DVec3, Mat4, Quat, Vec3};
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::limits::FrameBudget;
use mocap_scene::scene::report::DataKind;
use mocap_scene::scene::{
    Animation, Assumption, Channel, Confidence, Face, Format, GROUP_OF_ROOTS, HumanoidBone, Keys, MmdInherits,
    MmdModel, Node, NodeId, NodeKind, Scene, Topic, UNNAMED_MOTION, UpAxis,
};

use super::bezier::ease;
use super::model::Model;
use super::motion::{BoneKey, Motion};
use super::pose::{Local, ModelPose};
use super::tracks::{check_moves, tracks};
use super::{FRAME_RATE, METRES_PER_UNIT, names};
use crate::depth_first::{depth_first, sorted};
use crate::warnings::Warnings;
use crate::{Failure, ReadOptions};

/// A model, and the reason for its choice.
pub(super) struct Skeleton {
    model: Model,
    choice: String,
    reason: String,
}

impl Skeleton {
    pub(super) fn of(model: Model, choice: String, reason: String) -> Self {
        Self { model, choice, reason }
    }
}

/// The rest pose of a model, with a node for each morph.
pub(super) fn of_model(model: &Model) -> Scene {
    let (mut scene, _) = bones(model, Format::Pmx);
    for morph in &model.morphs {
        add_face(&mut scene, morph);
    }
    scene.lose(DataKind::Meshes, usize::from(model.vertices > 0));
    if model.vertices > 0 {
        scene.metadata.assumptions.push(Assumption {
            topic: Topic::Meshes,
            choice: "left out".to_owned(),
            reason: format!(
                "mocap reads only the skeleton of a model, and this model has a mesh of {} vertices",
                model.vertices
            ),
            confidence: None,
        });
    }
    scene
}

/// A motion on a model. `bytes` is the size of the files.
pub(super) fn of_motion(
    motion: &Motion,
    skeleton: &Skeleton,
    bytes: u64,
    options: &ReadOptions,
    warnings: &mut Warnings,
) -> Result<Scene, Failure> {
    let model = &skeleton.model;
    let (mut scene, node_of) = bones(model, Format::Vmd);
    scene.metadata.assumptions.push(Assumption {
        topic: Topic::Body,
        choice: skeleton.choice.clone(),
        reason: skeleton.reason.clone(),
        confidence: None,
    });
    scene.lose(DataKind::Cameras, motion.cameras);
    scene.lose(DataKind::Lights, motion.lights);
    if motion.others > 0 {
        scene.metadata.assumptions.push(Assumption {
            topic: Topic::Other,
            choice: format!("{} keys of cameras, lights and shadows were dropped", motion.others),
            reason: "a scene has only motion".to_owned(),
            confidence: None,
        });
    }
    let tracks = tracks(motion, model, warnings);
    let Some(last) = motion.last() else {
        warnings.push(Code::NoMotion, || {
            let message = "the file has no keys of bones or morphs: the scene has a skeleton and no animation";
            Diagnostic::new(Code::NoMotion, message)
        });
        return Ok(scene);
    };
    check_moves(motion, model, &tracks)?;
    let moving = moving(model, &tracks);
    // Every bone is posed at every frame, even a static one.
    let posed = model.bones.len() + motion.morphs.len();
    let frames = FrameBudget::stated_by(&options.limits, bytes).frames(last.into(), posed)? as u64;
    let most = options.limits.expanded_values(bytes);
    let rows = rows(motion, model, &tracks, &moving, frames, most)?;
    let mut channels: Vec<Channel> = Vec::with_capacity(model.bones.len());
    let mut by_node: Vec<usize> = (0..model.bones.len()).collect();
    by_node.sort_by_key(|bone| node_of[*bone]);
    for bone in by_node {
        channels.push(channel(&scene, NodeId::new(node_of[bone]), &rows[bone]));
    }
    add_morphs(&mut scene, motion, last, &mut channels);
    scene.metadata.assumptions.push(Assumption {
        topic: Topic::Interpolation,
        choice: format!("curves and IK were sampled, {FRAME_RATE} times a second"),
        reason: "keys of MMD have Bezier curves between them".to_owned(),
        confidence: None,
    });
    scene.animations.push(Animation {
        name: UNNAMED_MOTION.to_owned(),
        ticks_per_second: options.retime.unwrap_or(FRAME_RATE),
        duration: f64::from(last),
        channels,
    });
    Ok(scene)
}

/// The bone that rotates the legs, in every model.
pub(super) const LOWER: &str = "下半身";
const UPPER: &str = "上半身";

/// A bone with another parent in the scene than in the model: the trunk, a child of the hips.
///
/// In MMD trunk and hips are siblings and rotate independently. In a humanoid the trunk is a child of the hips.
#[derive(Clone, Copy)]
struct BoneParent {
    trunk: usize,
    hips: usize,
}

impl BoneParent {
    fn of(model: &Model) -> Option<Self> {
        let (trunk, hips) = (model.find(UPPER)?, model.find(LOWER)?);
        (model.bones[trunk].parent == model.bones[hips].parent).then_some(Self { trunk, hips })
    }

    /// The trunk relative to the hips. Its translation is relative to its rest position.
    fn local(self, posed: &ModelPose<'_>) -> Local {
        let (trunk, hips) = (posed.world(self.trunk), posed.world(self.hips));
        let rest = posed.model.bones[self.trunk].position - posed.model.bones[self.hips].position;
        Local {
            translation: hips.1.inverse() * (trunk.0 - hips.0) - rest,
            rotation: (hips.1.inverse() * trunk.1).normalize(),
        }
    }
}

/// The nodes of a model, and the node of each bone.
fn bones(model: &Model, format: Format) -> (Scene, Vec<usize>) {
    let rehung = BoneParent::of(model);
    let nodes: Vec<Node> = (model.bones.iter().enumerate())
        .map(|(index, bone)| {
            let trunk = rehung.filter(|rehung| rehung.trunk == index);
            let parent = trunk.map_or(bone.parent, |rehung| Some(rehung.hips));
            let offset = bone.position - parent.map_or(DVec3::ZERO, |above| model.bones[above].position);
            Node {
                name: bone.name.clone(),
                parent: parent.map(NodeId::new),
                transform: Mat4::from_translation(offset.as_vec3()),
                ..Node::default()
            }
        })
        .collect();
    let order = depth_first(&nodes);
    let mut nodes = sorted(nodes, &order);
    let mut node_of = order;
    if nodes.iter().filter(|node| node.parent.is_none()).count() > 1 {
        for node in &mut nodes {
            node.parent = Some(node.parent.map_or(NodeId(0), |parent| NodeId(parent.0 + 1)));
        }
        nodes.insert(
            0,
            Node {
                name: GROUP_OF_ROOTS.to_owned(),
                kind: NodeKind::Group,
                ..Node::default()
            },
        );
        node_of.iter_mut().for_each(|node| *node += 1);
    }
    let mut scene = Scene {
        nodes,
        ..Scene::default()
    };
    state_bones(&mut scene.nodes);
    scene.metadata.mmd = Some(Box::new(told(model)));
    scene.metadata.format = Some(format);
    scene.metadata.metres_per_unit = Some(METRES_PER_UNIT);
    scene.metadata.up = Some(UpAxis::Y);
    scene.metadata.assumptions.push(Assumption {
        topic: Topic::Unit,
        choice: format!("a unit of length is {METRES_PER_UNIT} m"),
        reason: "MMD files state no unit; a usual model of 20 units is 1.6 m tall".to_owned(),
        confidence: Some(Confidence::Likely),
    });
    (scene, node_of)
}

/// The properties of the model that its motions depend on.
fn told(model: &Model) -> MmdModel {
    let name = |bone: usize| model.bones[bone].name.clone();
    let inherits = model.bones.iter().filter_map(|bone| {
        bone.inherits.map(|inherits| MmdInherits {
            bone: bone.name.clone(),
            source: name(inherits.source),
            ratio: inherits.ratio,
            rotation: inherits.rotation,
            position: inherits.position,
        })
    });
    MmdModel {
        name: model.name.clone(),
        inherits: inherits.collect(),
        ik: model
            .bones
            .iter()
            .filter(|bone| bone.ik.is_some())
            .map(|bone| bone.name.clone())
            .collect(),
        trunk: BoneParent::of(model).map_or_else(String::new, |rehung| name(rehung.trunk)),
    }
}

/// Sets the humanoid bones of the nodes by name. The hips are the common parent of legs and trunk.
fn state_bones(nodes: &mut [Node]) {
    let mut found: HashMap<HumanoidBone, usize> = HashMap::new();
    for (index, node) in nodes.iter().enumerate() {
        if let Some(bone) = names::bone(&node.name) {
            found.entry(bone).or_insert(index);
        }
    }
    let has_all = HumanoidBone::REQUIRED
        .iter()
        .all(|bone| *bone == HumanoidBone::Hips || found.contains_key(bone));
    if !has_all {
        return;
    }
    let above = |nodes: &[Node], bone: HumanoidBone| -> Vec<usize> {
        let parent = |index: &usize| nodes[*index].parent.map(NodeId::index);
        std::iter::successors(parent(&found[&bone]), parent).collect()
    };
    let legs = [HumanoidBone::LeftUpperLeg, HumanoidBone::RightUpperLeg].map(|bone| above(nodes, bone));
    let spine = above(nodes, HumanoidBone::Spine);
    let hips = spine.into_iter().find(|node| legs.iter().all(|leg| leg.contains(node)));
    let Some(hips) = hips.filter(|hips| nodes[*hips].kind == NodeKind::Joint) else {
        return;
    };
    nodes[hips].humanoid_bone = Some(HumanoidBone::Hips);
    for (bone, index) in found {
        nodes[index].humanoid_bone = Some(bone);
    }
}

/// Adds the node of a morph, and returns its index. The X of the node's translation is the weight of the morph.
fn add_face(scene: &mut Scene, morph: &str) -> usize {
    let own = names::face(morph);
    // Several morphs may have the same custom name.
    let is_preset = matches!(own, Face::Preset(_));
    let is_taken = is_preset && scene.nodes.iter().any(|node| node.face.as_ref() == Some(&own));
    scene.nodes.push(Node {
        name: morph.to_owned(),
        kind: NodeKind::Group,
        parent: Some(NodeId(0)),
        face: Some(if is_taken { Face::Custom(morph.to_owned()) } else { own }),
        ..Node::default()
    });
    scene.nodes.len() - 1
}

impl BoneKey {
    /// The pose at a frame between this key and the next.
    fn to(&self, next: &Self, frame: u32) -> Local {
        let time = f64::from(frame - self.frame) / f64::from(next.frame - self.frame);
        let [x, y, z, turn] = next.curves.map(|curve| ease(curve, time));
        let step = next.position - self.position;
        Local {
            translation: self.position + step * DVec3::new(x, y, z),
            rotation: self.rotation.slerp(next.rotation, turn),
        }
    }
}

/// The bones that may move: bones with keys, bones that IK rotates, and bones that inherit.
fn moving(model: &Model, tracks: &[Option<&[BoneKey]>]) -> Vec<bool> {
    let mut moving: Vec<bool> = tracks.iter().map(Option::is_some).collect();
    for (index, bone) in model.bones.iter().enumerate() {
        moving[index] |= bone.inherits.is_some();
        for link in bone.ik.iter().flat_map(|ik| &ik.links) {
            moving[link.bone] = true;
        }
    }
    if let Some(BoneParent { trunk, hips }) = BoneParent::of(model) {
        moving[trunk] |= moving[hips];
    }
    moving
}

/// The cost of an IK step in values, because the links are posed again, starting at the root.
const STEP: u64 = 4;

/// The pose of each bone at each frame. A static bone has only the first frame.
fn rows(
    motion: &Motion,
    model: &Model,
    tracks: &[Option<&[BoneKey]>],
    moving: &[bool],
    frames: u64,
    budget: u64,
) -> Result<Vec<Vec<Local>>, Failure> {
    let mut posed = ModelPose::new(model);
    let mut rows: Vec<Vec<Local>> = vec![Vec::new(); model.bones.len()];
    let (mut budget, mut next) = (budget / STEP, vec![0; tracks.len()]);
    let ik_names: Vec<Option<Vec<u8>>> = model.bones.iter().map(|bone| names::encode(&bone.name)).collect();
    let mut is_on = vec![true; model.bones.len()];
    let mut states = motion.states.iter().peekable();
    let rehung = BoneParent::of(model);
    for frame in 0..u32::try_from(frames).unwrap_or(u32::MAX) {
        while let Some((_, state)) = states.next_if(|(from, _)| *from <= frame) {
            for (bone, name) in ik_names
                .iter()
                .enumerate()
                .filter(|(bone, _)| model.bones[*bone].ik.is_some())
            {
                let said = name.as_ref().and_then(|name| state.get(name));
                is_on[bone] = said.copied().unwrap_or(is_on[bone]);
            }
        }
        for (bone, keys) in tracks.iter().enumerate() {
            let Some(keys) = keys else { continue };
            while keys.get(next[bone]).is_some_and(|key| key.frame <= frame) {
                next[bone] += 1;
            }
            posed.own[bone] = match (next[bone].checked_sub(1), keys.get(next[bone])) {
                (Some(before), Some(after)) => keys[before].to(after, frame),
                (Some(last), None) => keys[last].pose(),
                (None, first) => first.map(BoneKey::pose).unwrap_or_default(),
            };
        }
        for (own, bone) in posed.own.iter_mut().zip(&model.bones) {
            if let Some(axis) = bone.axis {
                own.rotation = about(axis, own.rotation);
            }
        }
        posed.pose(&is_on, &mut budget)?;
        for (bone, row) in rows.iter_mut().enumerate() {
            if moving[bone] || frame == 0 {
                let trunk = rehung.filter(|rehung| rehung.trunk == bone);
                row.push(trunk.map_or_else(|| posed.local(bone), |rehung| rehung.local(&posed)));
            }
        }
    }
    Ok(rows)
}

/// The rotation about an axis with the angle of another rotation, in the sense in which that rotation turns about the
/// axis. Twist bones rotate only about this axis, whatever their keys.
fn about(axis: DVec3, rotation: DQuat) -> DQuat {
    let turn = rotation.to_scaled_axis();
    let angle = if turn.dot(axis) < 0.0 {
        -turn.length()
    } else {
        turn.length()
    };
    DQuat::from_axis_angle(axis, angle)
}

impl BoneKey {
    fn pose(&self) -> Local {
        Local {
            translation: self.position,
            rotation: self.rotation,
        }
    }
}

fn channel(scene: &Scene, node: NodeId, rows: &[Local]) -> Channel {
    let own = &scene.nodes[node.index()];
    let rest = own.transform.w_axis.truncate();
    let mut rotations: Vec<Quat> = rows.iter().map(|row| row.rotation.as_quat().normalize()).collect();
    let mut positions: Vec<Vec3> = rows.iter().map(|row| rest + row.translation.as_vec3()).collect();
    if rotations.iter().all(|rotation| *rotation == rotations[0]) {
        rotations.truncate(1);
    }
    if positions.iter().all(|position| *position == positions[0]) {
        positions.truncate(1);
    }
    Channel {
        node_name: own.name.clone(),
        node: Some(node),
        position_keys: Keys::every_tick(positions),
        rotation_keys: Keys::every_tick(rotations),
        scaling_keys: Keys::constant(Vec3::ONE),
    }
}

/// Adds the morphs with a weight other than 0 in any frame. Their weights are linear between keys.
fn add_morphs(scene: &mut Scene, motion: &Motion, last: u32, channels: &mut Vec<Channel>) {
    for (name, keys) in &motion.morphs {
        if keys.iter().all(|(_, weight)| *weight == 0.0) {
            continue;
        }
        let node = add_face(scene, &names::decode(name));
        let weight = |frame: u32| {
            let after = keys.partition_point(|(at, _)| *at <= frame);
            match (after.checked_sub(1).map(|before| keys[before]), keys.get(after)) {
                (Some((from, a)), Some((to, b))) => a + (b - a) * f64::from(frame - from) / f64::from(to - from),
                (Some((_, weight)), None) => weight,
                (None, first) => first.map_or(0.0, |(_, weight)| *weight),
            }
        };
        let positions = (0..=last).map(|frame| Vec3::X * weight(frame) as f32);
        channels.push(Channel {
            node_name: scene.nodes[node].name.clone(),
            node: Some(NodeId::new(node)),
            position_keys: Keys::every_tick(positions.collect()),
            rotation_keys: Keys::constant(Quat::IDENTITY),
            scaling_keys: Keys::constant(Vec3::ONE),
        });
    }
}
