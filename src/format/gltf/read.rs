//! Reads the skeleton and the animations of a `.glb` or `.gltf` file. Meshes, materials and cameras are not read.
//!
//! | glTF | scene |
//! |---|---|
//! | the nodes of the default scene | nodes, depth-first; under a group where the scene has several |
//! | a node with a mesh and nothing else: no child, no joint, no motion | left out |
//! | joints of skins; in a file without a skin, every node | joints |
//! | `extras.end_site` | an end site |
//! | `extras.source_name`, else `name` | the name |
//! | an animation | an animation, its seconds in ticks of the file's own frame time |
//!
//! Ticks: a file of this crate states its frame time; for others it is the shortest step between two keys. Times within
//! a float's rounding of a whole tick become that tick.

use std::collections::{HashMap, HashSet};
use std::ops::RangeInclusive;

use glam::{Mat4, Quat, Vec3, Vec4};

use super::file::{File, Track, Values, invalid};
use crate::error::{Code, Diagnostic, Result};
use crate::format::{ReadOptions, Source};
use crate::limits::limit_exceeded;
use crate::scene::{Animation, Channel, Format, GROUP_OF_ROOTS, Keys, Node, NodeId, NodeKind, Scene, UpAxis};

/// The largest distance of a time from a whole tick at which it becomes that tick, as a share of the time: twice the
/// rounding of a float.
const TIME_ROUNDING: f64 = 1.2e-7;

/// The range of valid frame times, in seconds.
const PLAUSIBLE_FRAME_TIMES: RangeInclusive<f64> = 1e-6..=1e6;

pub(super) fn read(source: &Source<'_>, options: &ReadOptions) -> Result<Scene> {
    let file = File::read(source.bytes, &|beside| {
        (source.open)(&source.name.with_file_name(beside))
    })?;
    let listed = file.nodes()?;
    let limits = &options.limits;
    if listed.len() > limits.max_nodes {
        let expected = format!("at most {} nodes", limits.max_nodes);
        return Err(limit_exceeded(expected, format!("{}", listed.len())).into());
    }
    let mut clips = Vec::new();
    for animation in file.document.animations() {
        clips.push((
            animation.name().unwrap_or_default().to_owned(),
            file.tracks(&animation)?,
        ));
    }
    let mut scene = Scene::default();
    scene.metadata.format = Some(Format::Gltf);
    scene.metadata.metres_per_unit = Some(1.0);
    scene.metadata.up = Some(UpAxis::Y);
    let node_of = build_nodes(&file, &listed, &clips, &mut scene)?;
    let frame_time = file.provenance().map(|provenance| provenance.frame_time);
    let frame_time = frame_time.filter(|time| PLAUSIBLE_FRAME_TIMES.contains(time));
    for (name, tracks) in clips {
        let bent = tracks.iter().filter(|track| track.is_bent).count();
        if bent > 0 {
            let message = "a track has STEP or CUBICSPLINE interpolation; it was read as LINEAR";
            scene
                .warnings
                .push(Diagnostic::new(Code::Interpolation, message).times(bent as u64));
        }
        let step = frame_time.unwrap_or_else(|| shortest_step(&tracks));
        let values_a_frame: u64 = tracks.iter().map(|track| track.values.components()).sum();
        let mut animation = build_animation(name, tracks, step, &node_of, &scene.nodes);
        let frames = animation.frame_count() as u64;
        let most = limits.expanded_values(source.bytes);
        if frames.saturating_mul(values_a_frame) > most {
            let found = format!("{frames} frames of {values_a_frame}");
            let expected = format!("at most {most} values in a file of this size");
            return Err(limit_exceeded(expected, found).into());
        }
        if let Some(frame_rate) = options.frame_rate {
            animation.ticks_per_second = frame_rate;
        }
        scene.animations.push(animation);
    }
    if scene.animations.is_empty() {
        scene
            .warnings
            .push(Diagnostic::new(Code::NoMotion, "the file has no animation"));
    }
    Ok(scene)
}

/// Fills [`Scene::nodes`], and returns the index of each node of the file.
fn build_nodes(
    file: &File,
    listed: &[(gltf::Node<'_>, Option<usize>)],
    clips: &[(String, Vec<Track>)],
    scene: &mut Scene,
) -> Result<HashMap<usize, NodeId>> {
    let moved: HashSet<_> = clips
        .iter()
        .flat_map(|(_, tracks)| tracks.iter().map(|track| track.node))
        .collect();
    let joints: HashSet<_> = file
        .document
        .skins()
        .flat_map(|skin| skin.joints())
        .map(|joint| joint.index())
        .collect();
    let is_joint =
        |node: &gltf::Node| joints.is_empty() || joints.contains(&node.index()) || moved.contains(&node.index());
    let only_shows = |node: &gltf::Node| {
        let shows = node.mesh().is_some() || node.camera().is_some();
        shows
            && node.children().len() == 0
            && !joints.contains(&node.index())
            && !moved.contains(&node.index())
            && !joints.is_empty()
    };
    let kept = || listed.iter().enumerate().filter(|(_, (node, _))| !only_shows(node));
    if kept().filter(|(_, (_, parent))| parent.is_none()).count() > 1 {
        scene.nodes.push(Node {
            name: GROUP_OF_ROOTS.to_owned(),
            kind: NodeKind::Group,
            ..Node::default()
        });
    }
    let group = (!scene.nodes.is_empty()).then_some(NodeId(0));
    let mut ids = vec![None; listed.len()];
    let mut node_of = HashMap::new();
    for (place, (node, parent)) in kept() {
        let transform = Mat4::from_cols_array_2d(&node.transform().matrix());
        if !transform.is_finite() || transform.row(3) != Vec4::W {
            return Err(invalid(format!(
                "the transform of node {} is not finite, or has a scale of 0",
                node.index()
            )));
        }
        let id = NodeId::new(scene.nodes.len());
        ids[place] = Some(id);
        node_of.insert(node.index(), id);
        scene.nodes.push(Node {
            name: file.source_name(node),
            kind: match is_joint(node) {
                _ if file.is_end_site(node) && !moved.contains(&node.index()) => NodeKind::EndSite,
                true => NodeKind::Joint,
                false => NodeKind::Group,
            },
            parent: parent.and_then(|parent| ids[parent]).or(group),
            transform,
            ..Node::default()
        });
    }
    Ok(node_of)
}

/// Collects the tracks of each node in one channel. A missing track becomes a constant one with the node's own value.
fn build_animation(
    name: String,
    tracks: Vec<Track>,
    step: f64,
    node_of: &HashMap<usize, NodeId>,
    nodes: &[Node],
) -> Animation {
    let end = tracks
        .iter()
        .filter_map(|track| track.times.last())
        .copied()
        .fold(0.0, f32::max);
    let mut channels: Vec<(NodeId, Channel)> = Vec::new();
    let mut place_of = HashMap::new();
    for track in tracks {
        let Some(&id) = node_of.get(&track.node) else { continue };
        let place = *place_of.entry(id).or_insert_with(|| {
            let node = &nodes[id.index()];
            let (scale, rotation, translation) = node.transform.to_scale_rotation_translation();
            let channel = Channel {
                node_name: node.name.clone(),
                node: Some(id),
                position_keys: Keys::constant(translation),
                rotation_keys: Keys::constant(unit(rotation)),
                scaling_keys: Keys::constant(if scale.is_finite() { scale } else { Vec3::ONE }),
            };
            channels.push((id, channel));
            channels.len() - 1
        });
        let ticks = track.times.iter().map(|time| tick_of(*time, step)).collect();
        let channel = &mut channels[place].1;
        match track.values {
            Values::Translations(values) => channel.position_keys = Keys::at_ticks(values, ticks),
            Values::Rotations(values) => {
                channel.rotation_keys = Keys::at_ticks(values.into_iter().map(unit).collect(), ticks);
            }
            Values::Scales(values) => channel.scaling_keys = Keys::at_ticks(values, ticks),
        }
    }
    channels.sort_by_key(|(id, _)| *id);
    Animation {
        name,
        ticks_per_second: step.recip(),
        duration: tick_of(end, step),
        channels: channels.into_iter().map(|(_, channel)| channel).collect(),
    }
}

/// The frame time: the step of the track with the most keys if it is even, or else the shortest step of all; 1/30 s if
/// no track has two keys.
fn shortest_step(tracks: &[Track]) -> f64 {
    let longest = tracks
        .iter()
        .map(|track| track.times.as_slice())
        .max_by_key(|times| times.len())
        .unwrap_or_default();
    if let [first, .., last] = longest {
        // Single steps are rounded too coarsely for a long take; their mean is not.
        let mean = (f64::from(*last) - f64::from(*first)) / (longest.len() - 1) as f64;
        let expected = (0..longest.len()).map(|key| f64::from(*first) + key as f64 * mean);
        let is_even = longest
            .iter()
            .zip(expected)
            .all(|(time, expected)| (f64::from(*time) - expected).abs() < 0.1 * mean);
        if is_even {
            return mean;
        }
    }
    let steps = tracks
        .iter()
        .flat_map(|track| track.times.windows(2))
        .map(|pair| f64::from(pair[1]) - f64::from(pair[0]));
    let shortest = steps.fold(f64::INFINITY, f64::min);
    if shortest.is_finite() { shortest } else { 1.0 / 30.0 }
}

fn tick_of(time: f32, step: f64) -> f64 {
    let tick = f64::from(time) / step;
    let whole = tick.round();
    if (tick - whole).abs() <= whole.abs() * TIME_ROUNDING {
        whole
    } else {
        tick
    }
}

/// In double precision, because the squares of tiny components underflow in single.
fn unit(rotation: Quat) -> Quat {
    let rotation = rotation.as_dquat().normalize().as_quat();
    if rotation.is_finite() { rotation } else { Quat::IDENTITY }
}
