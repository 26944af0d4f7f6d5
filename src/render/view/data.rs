//! The data of a clip for a page: text as JSON, numbers as bytes.

use std::borrow::Cow;

use glam::Vec3;
use mocap_figure::{Axis, Confidence, Figure, Humanoid, HumanoidBone};
use mocap_scene::error::visible;
use mocap_scene::pose::{Binding, Trs};
use mocap_scene::scene::report::SourceLines;
use mocap_scene::scene::{Channel, Node, NodeKind, Scene, UpAxis};
use serde::Serialize;

use super::super::euler;
use super::super::figure::{Clip, DrawnClip, Side, body, links, shown as shown_nodes};
use super::PageClip;
use super::marks::{Contact, Limbs};
use super::morphs::MorphMotion;
use super::pack::{Part, Storage, Tracks};
use super::skin::Skin;

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Description {
    name: String,
    /// The name of the clip's file, if no step changed the motion.
    file: Option<String>,
    facts: String,
    frames: u64,
    ticks_per_second: f64,
    first_tick: u8,
    metres_per_unit: f64,
    up: &'static str,
    size: Size,
    /// The nodes whose centroid the camera follows.
    anchors: Vec<usize>,
    frames_per_block: usize,
    /// The ids of the elements with the blocks of keys.
    pub(super) blocks: Vec<String>,
    /// The largest distance in metres by which packing moved a joint; 0 if the keys are exact.
    packing_error: f64,
    /// The id of the element with the GLB.
    pub(super) glb: Option<String>,
    /// The unchanged source file.
    pub(super) source: Option<SourceFile>,
    pub(super) warnings: Vec<String>,
    assumptions: Vec<String>,
    /// Whether the skeleton is a humanoid.
    humanoid: bool,
    /// Whether the figure has a skin and faces -Z at rest, as VRM 0 requires. The page then shows the figure from its
    /// front.
    is_turned: bool,
    pub(super) skin: Option<Skin>,
    contacts: Vec<Contact>,
    pub(super) limbs: Option<Limbs>,
    pub(super) morphs: Option<MorphMotion>,
    nodes: Vec<NodeDescription>,
}

/// An unchanged file: its name, and the id of the element with its bytes.
#[derive(Serialize)]
pub(super) struct SourceFile {
    pub(super) id: String,
    name: String,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct NodeDescription {
    name: String,
    kind: NodeKind,
    /// The index of the parent; -1 for the root.
    parent: i64,
    side: Side,
    lines: Option<SourceLines>,
    /// The axes of the node's Euler angles in the order of its channels: 0 for x, 1 for y, 2 for z.
    order: [usize; 3],
    /// Whether the file has rotation channels for the node.
    turns: bool,
    /// Whether the file has position channels for the node.
    moves: bool,
    /// Whether the node belongs to the figure, and is not an ancestor of the figure.
    in_body: bool,
    /// Whether the node is drawn.
    is_shown: bool,
    /// Whether a link from the parent to the node is drawn.
    is_linked: bool,
    bone: Option<Bone>,
    translation: Track,
    rotation: Track,
    scale: Track,
}

/// The humanoid bone of a joint.
#[derive(Serialize)]
struct Bone {
    name: &'static str,
    side: Side,
    confidence: Confidence,
    reason: String,
}

/// A constant value, or the number of a track in the blocks.
#[derive(Serialize)]
#[serde(untagged)]
enum Track {
    Constant(Vec<f32>),
    Packed(usize),
}

/// The size of a figure, in metres, with +Y up.
#[derive(Clone, Copy, Serialize)]
struct Size {
    /// The largest distance of a joint from the centre of the figure: about half of a person's height.
    reach: f64,
    /// The height of the lowest joint.
    floor: f64,
}

/// The description of a clip, with the names of its blocks and of its GLB, and the blocks.
pub(super) fn describe(page: &PageClip<'_>, index: usize, storage: Storage) -> (Description, Vec<Vec<u8>>) {
    let PageClip {
        clip,
        figure,
        glb,
        source,
        ..
    } = page;
    let scene = clip.scene;
    let figure = figure.map_or_else(|| Cow::Owned(Figure::new(scene)), Cow::Borrowed);
    let guesses = &figure.survey;
    let frames = clip.frames();
    let root_offset = scene.metadata.root_offset.iter();
    let root_offset = root_offset.map(|used| format!("root OFFSET: {:?}, {}", used.policy, used.reason).to_lowercase());
    let noted = scene.metadata.assumptions.iter().cloned().chain(figure.assumptions());
    let assumptions = noted.map(|note| format!("{}: {}, {}", note.topic, note.choice, note.explanation()));
    let in_body = body(scene, &figure.humanoid);
    let size = measure(clip, &in_body, &figure);
    let mut tracks = Tracks::new(scene, frames);
    let still = Channel::default();
    let channels = channels_of_nodes(scene);
    let mut nodes: Vec<_> = (0..scene.nodes.len())
        .map(|node| describe_node(scene, node, channels[node].unwrap_or(&still), &mut tracks))
        .collect();
    for (bone, joint) in &figure.humanoid.bones {
        nodes[joint.joint.index()].bone = Some(Bone {
            name: bone.as_str(),
            side: bone.side().map_or(Side::Middle, Side::from),
            confidence: joint.confidence,
            reason: shown(&joint.reason),
        });
    }
    for (node, in_body) in nodes.iter_mut().zip(in_body) {
        node.in_body = in_body;
    }
    let links = links(scene, &figure.humanoid);
    for (node, is_shown) in nodes.iter_mut().zip(shown_nodes(scene, &figure.humanoid, &links)) {
        node.is_shown = is_shown;
    }
    for link in links {
        nodes[link.to].is_linked = true;
    }
    let has_skin = scene.own_meshes().next().is_some();
    let packed = tracks.pack(storage, size.reach / guesses.metres_per_unit, guesses.metres_per_unit);
    let origin = scene.metadata.origin.as_ref();
    let description = Description {
        name: shown(clip.name),
        file: origin
            .filter(|_| scene.metadata.steps.is_empty())
            .map(|origin| shown(&origin.name)),
        facts: clip.facts(),
        frames,
        ticks_per_second: clip.animation().map_or(1.0, |animation| animation.ticks_per_second),
        first_tick: guesses.first_frame_is_rest_pose.into(),
        metres_per_unit: guesses.metres_per_unit,
        up: match guesses.up.value {
            UpAxis::Y => "+y",
            UpAxis::Z => "+z",
            UpAxis::NegY => "-y",
            UpAxis::NegZ => "-z",
        },
        size,
        anchors: anchors(scene, &figure.humanoid),
        frames_per_block: packed.frames_per_block,
        blocks: (0..packed.blocks.len())
            .map(|block| format!("clip-{index}-{block}"))
            .collect(),
        packing_error: packed.max_error * guesses.metres_per_unit,
        glb: glb.map(|_| format!("glb-{index}")),
        source: source.map(|_| SourceFile {
            id: format!("source-{index}"),
            name: origin.map_or_else(|| format!("{}.bvh", shown(clip.name)), |origin| shown(&origin.name)),
        }),
        warnings: scene.warnings.iter().map(with_line).collect(),
        assumptions: root_offset.chain(assumptions).map(|text| shown(&text)).collect(),
        humanoid: figure.humanoid.found,
        is_turned: has_skin && guesses.up.value == UpAxis::Y && figure.facing.value == Axis::NegZ,
        skin: None,
        contacts: page.contacts.map(Contact::all).unwrap_or_default(),
        limbs: page
            .limb_angles
            .map(|angles| Limbs::new(angles, format!("limbs-{index}"))),
        morphs: None,
        nodes,
    };
    (description, packed.blocks)
}

/// A string of the file without characters that would affect the surrounding text.
fn shown(text: &str) -> String {
    visible(text).into_owned()
}

/// The hips of a humanoid, or else the joints without a parent joint: the root, or all markers.
fn anchors(scene: &Scene, humanoid: &Humanoid) -> Vec<usize> {
    if let Some(hips) = humanoid.joint(HumanoidBone::Hips) {
        return vec![hips.index()];
    }
    let is_joint = |node: &Node| node.kind == NodeKind::Joint;
    let hangs_on_joint = |node: &Node| node.parent.is_some_and(|parent| is_joint(&scene.nodes[parent.index()]));
    let nodes = scene.nodes.iter().enumerate();
    let free = nodes.filter(|(_, node)| is_joint(node) && !hangs_on_joint(node));
    let free: Vec<usize> = free.map(|(index, _)| index).collect();
    if free.is_empty() { vec![0] } else { free }
}

/// Measures the figure in a few dozen poses.
fn measure(clip: &Clip<'_>, in_body: &[bool], known: &Figure) -> Size {
    let metres_per_unit = known.survey.metres_per_unit;
    let mut figure = DrawnClip::of_figure(*clip, known);
    let mut reach = 0.0_f32;
    for tick in figure.ticks(48) {
        let positions = figure.positions(tick);
        let body = || {
            positions
                .iter()
                .zip(in_body)
                .filter(|(_, in_body)| **in_body)
                .map(|(position, _)| *position)
        };
        let low = body().fold(Vec3::INFINITY, Vec3::min);
        let high = body().fold(Vec3::NEG_INFINITY, Vec3::max);
        let middle = 0.5 * (low + high);
        reach = body().map(|position| position.distance(middle)).fold(reach, f32::max);
    }
    // A lone joint, and joints at one position, have no extent. They are shown as in a figure of one metre.
    let reach = f64::from(reach) * metres_per_unit;
    Size {
        reach: if reach > 0.0 && reach.is_finite() { reach } else { 1.0 },
        floor: f64::from(figure.floor) * metres_per_unit,
    }
}

fn with_line(warning: &mocap_scene::error::Diagnostic) -> String {
    shown(&match &warning.location {
        Some(location) => format!("line {}: {warning}", location.line),
        None => warning.to_string(),
    })
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

fn describe_node<'a>(scene: &'a Scene, index: usize, channel: &'a Channel, tracks: &mut Tracks<'a>) -> NodeDescription {
    let node = &scene.nodes[index];
    let rest = Trs::from_matrix(node.transform);
    let parent = node.parent.map(|parent| &scene.nodes[parent.index()]);
    let named_after = parent.filter(|_| node.kind == NodeKind::EndSite).unwrap_or(node);
    let first = channel.sample(0.0, rest);
    let mut track = |part, keys: usize, constant: &[f32]| match keys {
        0 | 1 => Track::Constant(constant.to_vec()),
        _ => Track::Packed(tracks.push(index, part, channel, rest)),
    };
    NodeDescription {
        name: shown(&node.name),
        kind: node.kind,
        parent: node.parent.map_or(-1, |parent| parent.index() as i64),
        side: Side::of(&named_after.name),
        lines: node.source,
        order: euler::order_of(node).axes(),
        turns: node.rotation_order.is_some(),
        moves: channel.position_keys.len() > 1,
        in_body: false,
        is_shown: false,
        is_linked: false,
        bone: None,
        translation: track(
            Part::Translation,
            channel.position_keys.len(),
            &first.translation.to_array(),
        ),
        rotation: track(Part::Rotation, channel.rotation_keys.len(), &first.rotation.to_array()),
        scale: track(Part::Scale, channel.scaling_keys.len(), &first.scale.to_array()),
    }
}
