//! Reads the skeleton and the animations of a `.glb` or `.gltf` file. `meshes` reads meshes where they are asked for.
//!
//! | glTF | scene |
//! |---|---|
//! | the nodes of the default scene | nodes, depth-first; under a group where the scene has several |
//! | the transform of a node; in a file with motion that of its bind pose, where it has one (`bind`) | the rest pose |
//! | a node with a mesh and nothing else: no child, no joint, no motion | left out, where the file has joints |
//! | joints of skins; in a file without a skin, every node | joints |
//! | `extras.end_site` | an end site |
//! | `extras.source_name`, else `name` | the name |
//! | an animation | an animation, its seconds in ticks of the file's own frame time |
//!
//! Ticks: a file of this crate says its frame time. Elsewhere it is the distance of two keys where they are even, else
//! the usual frame rate on whose frames all keys stand, else the shortest distance of two keys. Keys farther than a
//! tenth of a second apart are not frames: there a whole number of frames, about thirty a second, lies between them.
//! Times within a float's rounding of a whole tick are that tick.

use std::collections::{HashMap, HashSet};

use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::limits::{self, FrameBudget};
use mocap_scene::pose::Pose;
use mocap_scene::scene::{
    Animation, Assumption, Channel, Format, GROUP_OF_ROOTS, HumanoidBone, Keys, Node, NodeId, NodeKind, Scene, Topic,
    UpAxis,
};

use super::bind;
use super::file::{File, NodePlace, implausible};
use super::humanoid::{self, VRM_ANIMATION};
use super::invalid::invalid;
use super::original;
use super::tracks::{Bend, CURVE_ERROR, Track, Values};
use crate::{Failure, ReadOptions, Source};

/// The largest distance of a time from a whole tick at which it becomes that tick, as a fraction of the time: twice the
/// rounding of a float.
const TIME_ROUNDING: f64 = 1.2e-7;

/// Frames per second that programs export with.
const USUAL_RATES: [f64; 13] = [
    24.0, 25.0, 30.0, 48.0, 50.0, 60.0, 90.0, 100.0, 120.0, 200.0, 240.0, 23.976, 29.97,
];

/// Frames per second at most where the file states no rate and its keys follow none.
const MOST_FRAMES_PER_SECOND: f64 = 240.0;

/// Seconds between keys from which on they are not frames.
const SPARSE: f64 = 0.1;

/// A scene, and where its parts are in the file.
pub(super) struct Placed {
    pub(super) scene: Scene,
    /// Each node of the file that has become one of the scene.
    pub(super) nodes: Vec<(usize, NodeId)>,
    /// What is wrong with the bones that the file states.
    pub(super) bones: Result<(), Failure>,
    /// The nodes of the scene as they stand in the file.
    in_file: Vec<Node>,
}

/// What the rest pose of a scene is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RestPose {
    /// The transforms of the nodes.
    Nodes,
    /// The bind pose of the joints that have one, in a file with motion.
    Bind,
}

/// Reads a file. A humanoid that it states wrongly is left out with a warning.
pub(super) fn read(source: &Source<'_>, options: &ReadOptions) -> Result<Scene> {
    let rest = match options.gltf_rest_of_nodes {
        true => RestPose::Nodes,
        false => RestPose::Bind,
    };
    let Placed {
        mut scene,
        nodes,
        bones,
        in_file,
        ..
    } = read_placed(source, options, rest)?;
    if let Err(wrong) = bones {
        for node in &mut scene.nodes {
            node.humanoid_bone = None;
        }
        scene.warnings.push(*wrong);
    }
    if !options.without_original
        && let Some((original, warnings)) = original::of(source, &scene, &nodes, in_file)?
    {
        scene.original = Some(original);
        scene.warnings.extend(warnings);
    }
    Ok(scene)
}

/// Reads a VRM animation, which is nothing without its humanoid.
pub(super) fn read_vrm_animation(source: &Source<'_>, options: &ReadOptions) -> Result<Scene> {
    let Placed { mut scene, bones, .. } = read_placed(source, options, RestPose::Nodes)?;
    bones?;
    if scene
        .nodes
        .iter()
        .all(|node| node.humanoid_bone != Some(HumanoidBone::Hips))
    {
        let pointer = format!("/extensions/{VRM_ANIMATION}/humanoid/humanBones");
        return Err(
            invalid(pointer, "no node is the bone hips, which a VRM animation must have")
                .help("read it as glTF: {from} gltf")
                .into(),
        );
    }
    scene.metadata.format = Some(Format::Vrma);
    Ok(scene)
}

/// Reads a file, and says which node of it became which of the scene.
pub(super) fn read_placed(source: &Source<'_>, options: &ReadOptions, rest: RestPose) -> Result<Placed> {
    let open = |beside: &std::path::Path| (source.open)(&source.name.with_file_name(beside));
    let mut file = File::read(source.bytes, &open, &options.limits)?;
    let mut scene = Scene {
        warnings: std::mem::take(&mut file.warnings),
        ..Scene::default()
    };
    scene.metadata.format = Some(Format::Gltf);
    scene.metadata.metres_per_unit = Some(1.0);
    scene.metadata.up = Some(UpAxis::Y);
    let mut clips = Vec::new();
    for (index, animation) in file.animations().enumerate() {
        clips.push((animation.name.clone().unwrap_or_default(), file.tracks(index)?));
    }
    let placed = build_nodes(&file, &clips, &mut scene)?;
    if options.gltf_meshes && !options.without_meshes {
        let ids = placed.iter().map(|(&index, placed)| (index, placed.id)).collect();
        super::meshes::read(source, &file, &ids, options, &mut scene);
    }
    let stated = file.provenance().unwrap_or_default();
    let frame_time = valid_frame_time(stated.frame_time, "/asset/extras")?;
    tell_bends(&clips, &mut scene);
    for (index, (_, tracks)) in clips.iter_mut().enumerate() {
        scene.warnings.extend(keep_one_pose(tracks, index));
    }
    let mut budget = FrameBudget::stated_by(&options.limits, source.bytes.len() as u64);
    for (index, (name, tracks)) in clips.into_iter().enumerate() {
        let own = file
            .provenance_of(index)
            .map_or(0.0, |provenance| provenance.frame_time);
        let own = valid_frame_time(own, &format!("/animations/{index}/extras"))?;
        // Clips may differ in their frame time.
        let of_clip = stated.clip_frame_times.get(index).copied().unwrap_or(0.0);
        let of_clip = valid_frame_time(of_clip, "/asset/extras")?.or(frame_time);
        let step = own.or(of_clip).filter(|step| fits(*step, &tracks));
        let step = step.unwrap_or_else(|| find_frame_time(&tracks));
        let values_a_frame: u64 = tracks.iter().map(|track| track.values.components()).sum();
        budget
            .frames(f64::from(end_of(&tracks)).max(0.0) / step, values_a_frame as usize)
            .map_err(|refusal| refusal.at_pointer(format!("/animations/{index}")))?;
        let mut animation = build_animation(name, tracks, step, &placed, &scene.nodes);
        for keys in scene.weight_keys().filter_map(|animations| animations.get_mut(index)) {
            animation.duration = animation.duration.max(put_at_ticks(keys, step));
        }
        if let Some(frame_rate) = options.retime {
            animation.ticks_per_second = frame_rate;
        }
        scene.animations.push(animation);
    }
    if scene.animations.is_empty() {
        scene
            .warnings
            .push(Diagnostic::new(Code::NoMotion, "the file has no animation"));
    }
    let nodes: Vec<_> = placed.iter().map(|(&index, placed)| (index, placed.id)).collect();
    let bones = humanoid::state(&file.root.extensions, &nodes, file.root.nodes.len(), &mut scene);
    let left_out = humanoid::state_face(&file.root.extensions, &nodes, &mut scene);
    scene.warnings.extend(left_out);
    let in_file = scene.nodes.clone();
    if rest == RestPose::Bind {
        bind::to_rest(&file, &placed, &mut scene);
    }
    Ok(Placed {
        scene,
        nodes,
        bones,
        in_file,
    })
}

/// A frame time that this crate has written at `pointer`; 0 stands for none, for the scene had no motion.
fn valid_frame_time(time: f64, pointer: &str) -> Result<Option<f64>, Failure> {
    if time == 0.0 {
        return Ok(None);
    }
    limits::frame_rate(Code::FrameTime, time.recip())
        .map(|_| Some(time))
        .map_err(|diagnostic| {
            let diagnostic = diagnostic.at_pointer(format!("{pointer}/mocap/frame_time"));
            let name = pointer.trim_start_matches('/').replace('/', ".");
            Box::new(diagnostic.help(format!("remove {name}.mocap, and the rate is found from the keys")))
        })
}

/// Says what was made of tracks that are not straight.
fn tell_bends(clips: &[(String, Vec<Track>)], scene: &mut Scene) {
    let tracks = clips.iter().flat_map(|(_, tracks)| tracks);
    let curves = tracks
        .filter(|track| matches!(track.bent, Some((Bend::Curve, _))))
        .count();
    if curves > 0 {
        scene.metadata.assumptions.push(Assumption {
            topic: Topic::Interpolation,
            choice: format!("{curves} tracks of cubic curves are sampled, at most {CURVE_ERROR:e} of their size off"),
            reason: "between the keys of a scene values change evenly".to_owned(),
            confidence: None,
        });
    }
}

/// Fills [`Scene::nodes`], and returns the index of each node of the file.
fn build_nodes(
    file: &File<'_>,
    clips: &[(String, Vec<Track>)],
    scene: &mut Scene,
) -> Result<HashMap<usize, NodePlace>, Failure> {
    let listed = file.nodes()?;
    let moved: HashSet<_> = clips
        .iter()
        .flat_map(|(_, tracks)| tracks.iter().map(|track| track.node))
        .collect();
    let joints: HashSet<_> = file.joints()?.into_iter().collect();
    let is_joint = |node: usize| joints.is_empty() || joints.contains(&node) || moved.contains(&node);
    let only_show = file.only_show()?;
    let kept = || {
        listed
            .iter()
            .enumerate()
            .filter(|(_, node)| !only_show.contains(&node.index))
    };
    if kept().filter(|(_, node)| node.parent.is_none()).count() > 1 {
        scene.nodes.push(Node {
            name: GROUP_OF_ROOTS.to_owned(),
            kind: NodeKind::Group,
            ..Node::default()
        });
    }
    let group = (!scene.nodes.is_empty()).then_some(NodeId(0));
    let mut ids = vec![None; listed.len()];
    let mut placed = HashMap::new();
    for (position, node) in kept() {
        let index = node.index;
        let transform = file.transform(index)?;
        let id = NodeId::new(scene.nodes.len());
        let parent = node.parent.and_then(|parent| ids[parent]).or(group);
        ids[position] = Some(id);
        scene.nodes.push(Node {
            name: file.source_name(index),
            kind: match is_joint(index) {
                _ if file.is_end_site(index) && !moved.contains(&index) && !file.has_children(index) => {
                    NodeKind::EndSite
                }
                true => NodeKind::Joint,
                false => NodeKind::Group,
            },
            parent,
            transform: transform.matrix,
            ..Node::default()
        });
        placed.insert(index, NodePlace { id, transform });
    }
    // Each number may be in bounds and their product not.
    let rest = Pose::rest(scene);
    for (_, node) in kept() {
        let node_to_world = rest.node_to_world[placed[&node.index].id.index()].to_cols_array();
        if let Some(number) = node_to_world.into_iter().find(|number| !number.is_finite()) {
            return Err(implausible(format!("/nodes/{}", node.index), number).into());
        }
    }
    Ok(placed)
}

/// Keeps the first keys of a motion that ends before the first frame of the highest rate: nothing could play or write
/// the others.
fn keep_one_pose(tracks: &mut [Track], animation: usize) -> Option<Diagnostic> {
    let end = f64::from(end_of(tracks));
    let is_too_short = end > 0.0 && end < key_distance();
    is_too_short.then(|| {
        tracks.iter_mut().for_each(Track::keep_first);
        let message =
            format!("the motion ends after {end:e} s, less than any frame lasts: its first keys alone were read");
        Diagnostic::new(Code::FrameTime, message)
            .at_pointer(format!("/animations/{animation}"))
            .help("export it again with times in seconds")
    })
}

/// The time of the last key, in seconds.
fn end_of(tracks: &[Track]) -> f32 {
    let ends = tracks.iter().filter_map(|track| track.times.last());
    ends.copied().fold(0.0, f32::max)
}

/// Collects the tracks of each node in one channel. A missing track becomes a constant one with the node's own value.
fn build_animation(
    name: String,
    tracks: Vec<Track>,
    step: f64,
    placed: &HashMap<usize, NodePlace>,
    nodes: &[Node],
) -> Animation {
    let end = end_of(&tracks);
    let mut channels: Vec<(NodeId, Channel)> = Vec::new();
    let mut slot_of = HashMap::new();
    for track in tracks {
        let Some(NodePlace { id, transform }) = placed.get(&track.node) else {
            continue;
        };
        let slot = *slot_of.entry(*id).or_insert_with(|| {
            let channel = Channel {
                node_name: nodes[id.index()].name.clone(),
                node: Some(*id),
                position_keys: Keys::constant(transform.translation),
                rotation_keys: Keys::constant(transform.rotation),
                scaling_keys: Keys::constant(transform.scale),
            };
            channels.push((*id, channel));
            channels.len() - 1
        });
        let ticks = ticks_of(&track.times, step);
        let channel = &mut channels[slot].1;
        match track.values {
            Values::Translations(values) => channel.position_keys = keys(values, ticks),
            Values::Rotations(values) => channel.rotation_keys = keys(values, ticks),
            Values::Scales(values) => channel.scaling_keys = keys(values, ticks),
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

/// A single key holds for all time, whenever it is.
fn keys<T>(values: Vec<T>, ticks: Vec<f64>) -> Keys<T> {
    match ticks.len() {
        1 => Keys::every_tick(values),
        _ => Keys::at_ticks(values, ticks),
    }
}

/// Whether keys can have a frame time that the file states: a motion within less than one frame was changed since.
fn fits(step: f64, tracks: &[Track]) -> bool {
    /// Of a frame: by so much times are rounded.
    const ROUNDING: f64 = 1e-3;
    let end = f64::from(end_of(tracks));
    end <= 0.0 || end >= step * (1.0 - ROUNDING)
}

/// The frame time of an animation that states none, in seconds.
fn find_frame_time(tracks: &[Track]) -> f64 {
    let step = key_step(tracks);
    if step <= SPARSE {
        return step;
    }
    // A whole number of frames from key to key.
    step / (step * 30.0).round().max(1.0)
}

/// How near two keys may be, in seconds: a tenth of a frame of the highest rate.
fn key_distance() -> f64 {
    MOST_FRAMES_PER_SECOND.recip() / 10.0
}

/// The time between two keys: that of the track with the most keys where they are even, else that of the usual frame
/// rate on whose frames all keys stand, else the shortest; a thirtieth of a second where no track has two.
fn key_step(tracks: &[Track]) -> f64 {
    let longest = tracks.iter().map(Track::key_times).max_by_key(|times| times.len());
    if let Some([first, .., last]) = longest {
        let times = longest.unwrap_or_default();
        // Single steps are rounded too coarsely for a long take; their mean is not.
        let mean = (f64::from(*last) - f64::from(*first)) / (times.len() - 1) as f64;
        let expected = (0..times.len()).map(|key| f64::from(*first) + key as f64 * mean);
        let is_even =
            std::iter::zip(times, expected).all(|(time, expected)| (f64::from(*time) - expected).abs() < 0.1 * mean);
        if is_even && mean >= key_distance() {
            return mean;
        }
    }
    let pairs = || tracks.iter().flat_map(|track| track.key_times().windows(2));
    let stands_on = |rate: &&f64| {
        let is_whole = |time: f32| {
            let frame = f64::from(time) * **rate;
            (frame - frame.round()).abs() < 0.01 + frame * TIME_ROUNDING
        };
        pairs().all(|pair| is_whole(pair[0]) && is_whole(pair[1]))
    };
    let shortest = pairs()
        .map(|pair| f64::from(pair[1]) - f64::from(pair[0]))
        .fold(f64::INFINITY, f64::min);
    if !shortest.is_finite() {
        return 1.0 / 30.0;
    }
    match USUAL_RATES.iter().find(stands_on) {
        Some(rate) => rate.recip(),
        None => shortest.max(MOST_FRAMES_PER_SECOND.recip()),
    }
}

/// Ticks for the times of keys, as strictly increasing as they are.
/// Puts keys that are at seconds at ticks, and returns the last tick.
fn put_at_ticks(keys: &mut Keys<f32>, step: f64) -> f64 {
    let times: Vec<f32> = (0..keys.len()).map(|key| keys.tick(key) as f32).collect();
    let ticks = ticks_of(&times, step);
    let last = ticks.last().copied().filter(|_| ticks.len() > 1).unwrap_or(0.0);
    *keys = self::keys(std::mem::take(&mut keys.values), ticks);
    last
}

fn ticks_of(times: &[f32], step: f64) -> Vec<f64> {
    let mut ticks: Vec<f64> = times.iter().map(|time| tick_of(*time, step)).collect();
    for key in (1..ticks.len()).rev() {
        if ticks[key - 1] >= ticks[key] {
            let between = f64::from(times[key]) - f64::from(times[key - 1]);
            ticks[key - 1] = ticks[key] - between / step;
        }
    }
    ticks
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
