//! Describes a scene for JavaScript: names and numbers as JSON, keys and matrices as addresses.

use mocap::scene::report::SourceLines;
use mocap::scene::{Assumption, Face, HumanoidBone, Metadata, NodeId, NodeKind, RotationOrder};
use mocap::{Diagnostic, Scene};
use serde::Serialize;

use crate::keys::KeysAt;
use crate::scenes::Entry;

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct SceneAt<'a> {
    scene: u32,
    nodes: Vec<NodeAt<'a>>,
    /// Rest transforms relative to the parents: 16 numbers per node, in column-major order.
    transforms: usize,
    animations: Vec<AnimationAt<'a>>,
    meshes: usize,
    metadata: &'a Metadata,
    warnings: &'a [Diagnostic],
    /// The assumptions about this scene.
    assumptions: &'a [Assumption],
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct NodeAt<'a> {
    name: &'a str,
    kind: NodeKind,
    parent: Option<u32>,
    rotation_order: Option<RotationOrder>,
    source: Option<SourceLines>,
    humanoid_bone: Option<HumanoidBone>,
    face: Option<&'a Face>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct AnimationAt<'a> {
    name: &'a str,
    ticks_per_second: f64,
    duration: f64,
    channels: Vec<ChannelAt<'a>>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct ChannelAt<'a> {
    node_name: &'a str,
    node: Option<u32>,
    positions: KeysAt,
    rotations: KeysAt,
    scales: KeysAt,
}

impl<'a> SceneAt<'a> {
    pub(crate) fn new(number: u32, entry: &'a Entry, assumptions: &'a [Assumption]) -> Self {
        let scene = &entry.scene;
        Self {
            scene: number,
            nodes: nodes(scene),
            transforms: entry.rest().as_ptr().addr(),
            animations: animations(scene),
            meshes: scene.meshes.len(),
            metadata: &scene.metadata,
            warnings: &scene.warnings,
            assumptions,
        }
    }
}

fn nodes(scene: &Scene) -> Vec<NodeAt<'_>> {
    let nodes = scene.nodes.iter().map(|node| NodeAt {
        name: &node.name,
        kind: node.kind,
        parent: node.parent.map(|NodeId(parent)| parent),
        rotation_order: node.rotation_order,
        source: node.source,
        humanoid_bone: node.humanoid_bone,
        face: node.face.as_ref(),
    });
    nodes.collect()
}

fn animations(scene: &Scene) -> Vec<AnimationAt<'_>> {
    let animations = scene.animations.iter().map(|animation| AnimationAt {
        name: &animation.name,
        ticks_per_second: animation.ticks_per_second,
        duration: animation.duration,
        channels: animation
            .channels
            .iter()
            .map(|channel| ChannelAt {
                node_name: &channel.node_name,
                node: channel.node.map(|NodeId(node)| node),
                positions: KeysAt::new(&channel.position_keys),
                rotations: KeysAt::new(&channel.rotation_keys),
                scales: KeysAt::new(&channel.scaling_keys),
            })
            .collect(),
    });
    animations.collect()
}
