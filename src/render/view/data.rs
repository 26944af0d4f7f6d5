//! The data of a clip for a page: text as JSON, numbers as bytes.

use glam::{Quat, Vec3};
use serde::Serialize;

use super::super::euler;
use super::super::figure::{Clip, Side};
use crate::pose::{Binding, Trs};
use crate::scene::{Channel, Keys, Node, NodeKind, Scene, SourceLines, UpAxis};
use crate::skeleton::survey;

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Description<'a> {
    name: &'a str,
    facts: String,
    frames: u64,
    ticks_per_second: f64,
    metres_per_unit: f64,
    up: &'static str,
    /// Ids of the elements that hold the tracks and the GLB.
    data: String,
    glb: String,
    warnings: Vec<String>,
    assumptions: Vec<String>,
    nodes: Vec<NodeDescription<'a>>,
}

#[derive(Serialize)]
struct NodeDescription<'a> {
    name: &'a str,
    kind: NodeKind,
    /// -1 on the root.
    parent: i64,
    side: Side,
    lines: Option<SourceLines>,
    /// The axes of its Euler angles in the order of its channels: 0 for x, 1 for y, 2 for z.
    order: [usize; 3],
    /// Whether the file has rotation channels about these axes.
    turns: bool,
    /// Whether the file has position channels for it.
    moves: bool,
    translation: Track,
    rotation: Track,
    scale: Track,
}

/// The range of a track's values in the floats: one value, or one per tick.
#[derive(Serialize)]
struct Track {
    at: usize,
    keys: usize,
}

/// The numbers of all tracks.
#[derive(Default)]
pub(super) struct Floats(Vec<f32>);

impl Floats {
    pub(super) fn into_bytes(self) -> Vec<u8> {
        self.0.into_iter().flat_map(f32::to_le_bytes).collect()
    }

    /// One value for a constant or empty track, or else one for every whole tick.
    fn push_track<T: Copy, const N: usize>(
        &mut self,
        keys: &Keys<T>,
        rest: T,
        frames: u64,
        at_tick: impl Fn(&Keys<T>, f64) -> Option<T>,
        to_array: impl Fn(&T) -> [f32; N],
    ) -> Track {
        let at = self.0.len();
        let count = if keys.len() > 1 { frames.max(1) } else { 1 };
        for tick in 0..count {
            let value = at_tick(keys, tick as f64).unwrap_or(rest);
            self.0.extend(to_array(&value));
        }
        Track {
            at,
            keys: count as usize,
        }
    }
}

/// Appends the tracks of a clip to the floats, and returns their ranges.
pub(super) fn describe<'a>(clip: &Clip<'a>, index: usize, floats: &mut Floats) -> Description<'a> {
    let scene = clip.scene;
    let guesses = survey(scene);
    let channels = channels_of_nodes(scene);
    let nodes = std::iter::zip(&scene.nodes, channels);
    let frames = clip.frames();
    let root_offset = scene.metadata.root_offset.iter();
    let root_offset = root_offset.map(|used| format!("root OFFSET: {:?}, {}", used.policy, used.reason).to_lowercase());
    let noted = scene.metadata.assumptions.iter().cloned().chain(guesses.assumptions());
    let assumptions = noted.map(|note| format!("{}: {}, {}", note.topic, note.choice, note.explanation()));
    Description {
        name: clip.name,
        facts: clip.facts(),
        frames,
        ticks_per_second: clip.animation().map_or(1.0, |animation| animation.ticks_per_second),
        metres_per_unit: guesses.metres_per_unit,
        up: match guesses.up.value {
            UpAxis::Y => "+y",
            UpAxis::Z => "+z",
            UpAxis::NegY => "-y",
            UpAxis::NegZ => "-z",
        },
        data: format!("clip-{index}"),
        glb: format!("glb-{index}"),
        warnings: scene.warnings.iter().map(with_line).collect(),
        assumptions: root_offset.chain(assumptions).collect(),
        nodes: nodes
            .map(|(node, channel)| describe_node(node, channel, &scene.nodes, frames, floats))
            .collect(),
    }
}

fn with_line(warning: &crate::error::Diagnostic) -> String {
    match &warning.location {
        Some(location) => format!("line {}: {warning}", location.line),
        None => warning.to_string(),
    }
}

/// The channel of each node, if it has one.
fn channels_of_nodes(scene: &Scene) -> Vec<Option<&Channel>> {
    let mut channels = vec![None; scene.nodes.len()];
    if let Some(animation) = scene.animations.first() {
        for (node, channel) in Binding::new(scene, animation).driven() {
            channels[node.index()] = animation.channels.get(channel);
        }
    }
    channels
}

fn describe_node<'a>(
    node: &'a Node,
    channel: Option<&Channel>,
    nodes: &[Node],
    frames: u64,
    floats: &mut Floats,
) -> NodeDescription<'a> {
    let rest = Trs::from_matrix(node.transform);
    let still = Channel::default();
    let channel = channel.unwrap_or(&still);
    let parent = node.parent.map(|parent| &nodes[parent.index()]);
    let named_after = parent.filter(|_| node.kind == NodeKind::EndSite).unwrap_or(node);
    NodeDescription {
        name: &node.name,
        kind: node.kind,
        parent: node.parent.map_or(-1, |parent| parent.index() as i64),
        side: Side::of(&named_after.name),
        lines: node.source,
        order: euler::order_of(node).axes(),
        turns: node.rotation_order.is_some(),
        moves: channel.position_keys.len() > 1,
        translation: floats.push_track(
            &channel.position_keys,
            rest.translation,
            frames,
            Keys::<Vec3>::sample,
            Vec3::to_array,
        ),
        rotation: floats.push_track(
            &channel.rotation_keys,
            rest.rotation,
            frames,
            Keys::<Quat>::sample,
            Quat::to_array,
        ),
        scale: floats.push_track(
            &channel.scaling_keys,
            rest.scale,
            frames,
            Keys::<Vec3>::sample,
            Vec3::to_array,
        ),
    }
}
