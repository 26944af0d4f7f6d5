//! Makes nodes and channels from bones and values.

use glam::{DVec3, Mat4, Quat, Vec3};
use mocap_scene::scene::{
    Animation, Assumption, Channel, Confidence, Format, Keys, Node, NodeId, NodeKind, Scene, Topic,
};

use super::motion::{Motion, Track};
use super::skeleton::{Bone, ChannelKind, Skeleton, turn};
use crate::ReadOptions;

/// The frame rate in frames per second of CMU's captures, from which nearly all Acclaim files come. The files state no
/// frame rate.
const CMU_FRAME_RATE: f64 = 120.0;

/// The factor `:units length` of CMU's skeletons. Lengths divided by this factor are in inches, by the notes of CMU's
/// database.
const CMU_LENGTH_UNIT: f64 = 0.45;

/// Metres per inch, by definition.
const METRES_PER_INCH: f64 = 0.0254;

/// The scene of a skeleton and its motion, if there is one, without meshes.
pub(super) fn build(skeleton: &Skeleton, motion: Option<Motion>, options: &ReadOptions) -> Scene {
    let mut scene = Scene {
        nodes: build_nodes(skeleton),
        ..Scene::default()
    };
    scene.metadata.format = Some(Format::AsfAmc);
    if skeleton.length_unit == Some(CMU_LENGTH_UNIT) {
        let metres_per_unit = METRES_PER_INCH / CMU_LENGTH_UNIT;
        scene.metadata.metres_per_unit = Some(metres_per_unit);
        scene.metadata.assumptions.push(Assumption {
            topic: Topic::Unit,
            choice: format!("a unit of length is {metres_per_unit:.5} m"),
            reason: format!(
                "the skeleton states `length {CMU_LENGTH_UNIT}`, which in CMU's files means units per \
                inch"
            ),
            confidence: Some(Confidence::Likely),
        });
    }
    if let Some(motion) = motion.filter(|motion| motion.frames > 0) {
        if options.retime.is_none() {
            scene.metadata.assumptions.push(Assumption {
                topic: Topic::FrameRate,
                choice: format!("{CMU_FRAME_RATE} frames a second"),
                reason: "the file states no frame rate; CMU's captures have 120 frames per second".to_owned(),
                confidence: Some(Confidence::Likely),
            });
        }
        scene.animations.push(build_animation(skeleton, &motion, options));
    }
    scene
}

/// One node for each bone, at its near end, and an end site at the far end of each bone without children.
fn build_nodes(skeleton: &Skeleton) -> Vec<Node> {
    let mut nodes: Vec<Node> = Vec::with_capacity(skeleton.bones.len());
    let mut node_of_bone = Vec::with_capacity(skeleton.bones.len());
    for bone in &skeleton.bones {
        let id = NodeId::new(nodes.len());
        node_of_bone.push(id);
        nodes.push(Node {
            name: bone.name.clone(),
            parent: bone.parent.map(|parent| node_of_bone[parent]),
            transform: Mat4::from_translation(rest_position(skeleton, bone).as_vec3()),
            ..Node::default()
        });
        if bone.is_leaf && bone.link != DVec3::ZERO {
            nodes.push(Node {
                name: format!("EndSite_{}", bone.name),
                kind: NodeKind::EndSite,
                parent: Some(id),
                transform: Mat4::from_translation(bone.link.as_vec3()),
                ..Node::default()
            });
        }
    }
    nodes
}

/// The near end of a bone, relative to its parent's near end.
fn rest_position(skeleton: &Skeleton, bone: &Bone) -> DVec3 {
    bone.parent
        .map_or(skeleton.position, |parent| skeleton.bones[parent].link)
}

fn build_animation(skeleton: &Skeleton, motion: &Motion, options: &ReadOptions) -> Animation {
    let channels = std::iter::zip(&skeleton.bones, &motion.tracks).map(|(bone, track)| Channel {
        node_name: bone.name.clone(),
        node: None,
        position_keys: position_keys(skeleton, bone, track),
        rotation_keys: rotation_keys(bone, track, motion.degrees),
        scaling_keys: Keys::constant(Vec3::ONE),
    });
    Animation {
        name: "Motion".to_owned(),
        ticks_per_second: options.retime.unwrap_or(CMU_FRAME_RATE),
        duration: (motion.frames - 1) as f64,
        channels: channels.collect(),
    }
}

/// The values of one frame, each with its channel.
fn rows<'a>(
    bone: &'a Bone,
    track: &'a Track,
) -> impl Iterator<Item = impl Iterator<Item = (ChannelKind, f64)> + Clone> {
    let rows = track.values.chunks_exact(bone.channels.len().max(1));
    rows.map(|row| std::iter::zip(bone.channels.iter().copied(), row.iter().copied()))
}

/// The position of the root is relative to its rest position. Other bones do not move.
fn position_keys(skeleton: &Skeleton, bone: &Bone, track: &Track) -> Keys<Vec3> {
    let rest = rest_position(skeleton, bone);
    let moves = |kind: &ChannelKind| matches!(kind, ChannelKind::Translation(_));
    if bone.parent.is_some() || track.ticks.is_empty() || !bone.channels.iter().any(moves) {
        return Keys::constant(rest.as_vec3());
    }
    let positions = rows(bone, track).map(|row| {
        let mut position = rest;
        for (kind, value) in row {
            if let ChannelKind::Translation(axis) = kind {
                position[axis] += value;
            }
        }
        position.as_vec3()
    });
    Keys::at_ticks(positions.collect(), track.ticks.clone())
}

/// `C M C^-1`: the motion rotates the bone about its own axes.
fn rotation_keys(bone: &Bone, track: &Track, degrees: bool) -> Keys<Quat> {
    if bone.channels.is_empty() || track.ticks.is_empty() {
        return Keys::constant(Quat::IDENTITY);
    }
    let rotations = rows(bone, track).map(|row| {
        let motion = turn(row.filter_map(|(kind, value)| match kind {
            ChannelKind::Rotation(axis) => Some((axis, if degrees { value.to_radians() } else { value })),
            ChannelKind::Translation(_) | ChannelKind::Length => None,
        }));
        (bone.axes * motion * bone.axes.inverse()).normalize().as_quat()
    });
    Keys::at_ticks(rotations.collect(), track.ticks.clone())
}
