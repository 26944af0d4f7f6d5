//! Reads the skeleton and the animations of a `.glb` or `.gltf` file. `meshes` reads meshes on request.
//!
//! | glTF | scene |
//! |---|---|
//! | the nodes of the default scene | nodes, depth-first; under a group if there are several roots |
//! | the transform of a node; in a file with motion, its bind pose if it has one (`bind`) | the rest pose |
//! | a node with only a mesh: no child, no joint, no motion | skipped if the file has joints |
//! | joints of skins; in a file without a skin, every node | joints |
//! | `extras.end_site` | an end site |
//! | `extras.source_name`, else `name` | the name |
//! | an animation | an animation, its seconds in ticks of the file's own frame time |
//!
//! `frame_time` determines the ticks.

use std::collections::{HashMap, HashSet};

use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::limits::FrameBudget;
use mocap_scene::pose::Pose;
use mocap_scene::scene::{
    Animation, Assumption, Channel, Format, GROUP_OF_ROOTS, HumanoidBone, Keys, MorphCurves, Node, NodeId, NodeKind,
    Scene, Topic, UpAxis,
};

use super::bind;
use super::file::{File, NodePlace, implausible, own_extras};
use super::frame_time::{
    end_of, find_frame_time, fits, keep_one_pose, keys, put_at_ticks, tick_of, ticks_of, valid_frame_time,
};
use super::humanoid::{self, VRM_ANIMATION};
use super::invalid::invalid;
use super::meshes::TargetPlace;
use super::original;
use super::tracks::{Bend, CURVE_ERROR, Track, Values};
use crate::{Failure, ReadOptions, Source};

/// A scene, and the places of its parts in the file.
pub(super) struct Placed {
    pub(super) scene: Scene,
    /// The file nodes that became scene nodes.
    pub(super) nodes: Vec<(usize, NodeId)>,
    /// The error in the bones that the file states.
    pub(super) bones: Result<(), Failure>,
    /// The nodes of the scene with their transforms in the file.
    in_file: Vec<Node>,
    morphs: Vec<MorphCurves>,
    /// The scene places of the file's morph targets.
    pub(super) targets: Vec<TargetPlace>,
}

/// The source of the rest pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RestPose {
    /// The transforms of the nodes.
    Nodes,
    /// The bind pose of the joints that have one, in a file with motion.
    Bind,
}

/// Reads a file. An invalid humanoid is skipped with a warning.
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
        morphs,
        ..
    } = read_placed(source, options, rest)?;
    if let Err(wrong) = bones {
        for node in &mut scene.nodes {
            node.humanoid_bone = None;
        }
        scene.warnings.push(*wrong);
    }
    if !options.without_original
        && let Some((mut original, warnings)) = original::of(source, &scene, &nodes, in_file)?
    {
        original.morphs = morphs;
        scene.original = Some(original);
        scene.warnings.extend(warnings);
    }
    Ok(scene)
}

/// Reads a VRM animation, which is invalid without its humanoid or its face.
pub(super) fn read_vrm_animation(source: &Source<'_>, options: &ReadOptions) -> Result<Scene> {
    let Placed { mut scene, bones, .. } = read_placed(source, options, RestPose::Nodes)?;
    bones?;
    let has = |is_it: &dyn Fn(&Node) -> bool| scene.nodes.iter().any(is_it);
    let has_bones = has(&|node| node.humanoid_bone.is_some());
    if !has(&|node| node.humanoid_bone == Some(HumanoidBone::Hips)) && (has_bones || !has(&|node| node.face.is_some()))
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

/// Reads a file, and returns the scene node of each file node.
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
    scene.metadata.lost = super::unread::unread(source.bytes, options);
    let mut clips = Vec::new();
    for (index, animation) in file.animations().enumerate() {
        clips.push((animation.name.clone().unwrap_or_default(), file.tracks(index)?));
    }
    let placed = build_nodes(&file, &clips, &mut scene)?;
    let mut targets = Vec::new();
    if options.gltf_meshes && !options.without_meshes {
        let ids = placed.iter().map(|(&index, placed)| (index, placed.id)).collect();
        targets = super::meshes::read(source, &file, &ids, options, &mut scene);
    }
    let mut morphs = match options.without_original {
        true => Vec::new(),
        false => file.all_weights(source.bytes, &mut scene.warnings)?,
    };
    let stated = file.provenance().unwrap_or_default();
    scene.metadata.attribution.clone_from(&stated.attribution);
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
        // Clips may have different frame times.
        let of_clip = stated.clip_frame_times.get(index).copied().unwrap_or(0.0);
        let of_clip = valid_frame_time(of_clip, "/asset/extras")?.or(frame_time);
        let weights = weights_of(&mut scene, &mut morphs, index);
        let own_or_stated = own.or(of_clip).filter(|step| fits(*step, &tracks));
        let step = own_or_stated.unwrap_or_else(|| find_frame_time(&tracks, &weights));
        let moving = weights.iter().filter(|keys| keys.len() > 1).count() as u64;
        let values_a_frame = moving + tracks.iter().map(|track| track.values.components()).sum::<u64>();
        let ends = weights
            .iter()
            .filter_map(|keys| keys.len().checked_sub(1).map(|last| keys.tick(last)));
        let end = ends.fold(f64::from(end_of(&tracks)), f64::max);
        budget
            .frames(end / step, values_a_frame as usize)
            .map_err(|refusal| refusal.at_pointer(format!("/animations/{index}")))?;
        let mut animation = build_animation(name, tracks, step, &placed, &scene.nodes);
        for keys in weights_of(&mut scene, &mut morphs, index) {
            animation.duration = animation.duration.max(put_at_ticks(keys, step));
        }
        if let Some(frame_rate) = options.retime {
            animation.ticks_per_second = frame_rate;
        }
        scene.animations.push(animation);
    }
    for (index, animation) in file.animations().enumerate() {
        scene.set_clip_extras(index, own_extras(animation.extras.as_ref()));
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
        morphs,
        targets,
    })
}

/// Records how tracks with other than linear interpolation were converted.
fn tell_bends(clips: &[(String, Vec<Track>)], scene: &mut Scene) {
    let tracks = clips.iter().flat_map(|(_, tracks)| tracks);
    let curves = tracks
        .filter(|track| matches!(track.bent, Some((Bend::Curve, _))))
        .count();
    if curves > 0 {
        scene.metadata.assumptions.push(Assumption {
            topic: Topic::Interpolation,
            choice: format!(
                "{curves} cubic spline tracks were sampled, with a relative error of at most {CURVE_ERROR:e}"
            ),
            reason: "a scene interpolates linearly between keys".to_owned(),
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
    // Each number may be in bounds, but their product may not.
    let rest = Pose::rest(scene);
    for (_, node) in kept() {
        let node_to_world = rest.node_to_world[placed[&node.index].id.index()].to_cols_array();
        if let Some(number) = node_to_world.into_iter().find(|number| !number.is_finite()) {
            return Err(implausible(format!("/nodes/{}", node.index), number).into());
        }
    }
    Ok(placed)
}

/// The weights of all morph targets in an animation, including targets of the file that is passed through.
fn weights_of<'a>(scene: &'a mut Scene, morphs: &'a mut [MorphCurves], animation: usize) -> Vec<&'a mut Keys<f32>> {
    let passed_through = morphs.iter_mut().flat_map(|curves| &mut curves.targets);
    let targets = scene.weight_keys().chain(passed_through);
    targets.filter_map(|animations| animations.get_mut(animation)).collect()
}

/// Collects the tracks of each node in one channel. A missing track becomes a constant track with the node's own value.
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
