//! Packed clips of this crate. Packed clips play without unpacking. This module unpacks them into a normal scene.
//!
//! `docs/packed-clip.md` describes the bytes; [`PackedClip`] checks the bytes.

use mocap_compress::PackedClip;
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::limits::{FrameBudget, limit_exceeded};
use mocap_scene::pose::Pose;
use mocap_scene::scene::{Format, Scene, UpAxis};

use super::report::Deviation;
use super::written::{millimetres, unit_warning};
use super::{Export, ExportFile, Failure, FormatInfo, ReadOptions, Source, WriteOption, WriteOptions};

pub(super) const FORMAT: FormatInfo = FormatInfo {
    format: Format::Mclip,
    name: "a packed clip",
    description: "packed clip of mocap",
    extensions: Format::Mclip.extensions(),
    reading: "excellent: the whole clip, or the pose at one tick",
    writing: "excellent",
    sniff: PackedClip::sniff,
    read,
    write: Some(write),
    options: &[
        WriteOption::MaxError,
        WriteOption::ShellDistance,
        WriteOption::Names,
        WriteOption::Rest,
        WriteOption::RootMotion,
    ],
    has_one_clip: true,
    names_clips: false,
    has_key_times: true,
    is_packed: true,
    ..FormatInfo::BASE
};

/// The files of this format, with the first animation.
fn write(scene: &Scene, options: &WriteOptions) -> Result<Export> {
    let (clip, unpacked) = PackedClip::pack(scene, 0, options.bound_or_usual())?;
    let mut written = Export {
        notes: vec![format!("error: {} mm at most", millimetres(clip.max_error()))],
        warnings: Vec::from_iter(unit_warning(scene, "a packed clip")),
        nodes: scene.nodes.len(),
        ..Export::of(vec![ExportFile::new(&options.name, clip.into_bytes())])
    };
    Deviation::add(&mut written.error, scene, &unpacked, 1.0);
    Ok(written)
}

fn read(source: &Source<'_>, options: &ReadOptions) -> Result<Scene> {
    let clip = PackedClip::new(source.bytes)?;
    check_limits(&clip, options)?;
    let ticks_per_second = options.frame_rate_or(clip.ticks_per_second())?;
    let mut scene = clip.unpack();
    // Each number may be in bounds, but their product may not.
    let rest = Pose::rest(&scene);
    if let Some(index) = rest.node_to_world.iter().position(|matrix| !matrix.is_finite()) {
        let message = "the joint is too far from the origin at rest to compute with";
        return Err(Diagnostic::new(Code::NumberRange, message)
            .in_joint(&scene.nodes[index].name)
            .into());
    }
    for animation in &mut scene.animations {
        animation.ticks_per_second = ticks_per_second;
    }
    scene.metadata.format = Some(Format::Mclip);
    scene.metadata.metres_per_unit = Some(1.0);
    scene.metadata.up = Some(UpAxis::Y);
    Ok(scene)
}

fn within(found: usize, most: usize, what: &str) -> Result<(), Failure> {
    if found <= most {
        return Ok(());
    }
    Err(Box::new(limit_exceeded(
        format!("at most {most} {what}"),
        found.to_string(),
    )))
}

/// Checks that the unpacked size is within the limits, and in proportion to the bytes of the file.
fn check_limits(clip: &PackedClip<'_>, options: &ReadOptions) -> Result<(), Failure> {
    let limits = &options.limits;
    within(clip.node_count(), limits.max_nodes, "nodes")?;
    let mut depths: Vec<usize> = Vec::with_capacity(clip.node_count());
    for node in 0..clip.node_count() {
        let depth = clip.parent(node).map_or(1, |parent| depths[parent] + 1);
        within(
            depth,
            limits.max_depth,
            &format!("nodes on the path from the root to node {node}"),
        )?;
        let name = clip.name(node).len();
        within(
            name,
            limits.max_name_bytes,
            &format!("bytes in the name of node {node}"),
        )?;
        depths.push(depth);
    }
    // A static node takes no memory here, but has a value in every row of an output.
    let values_a_frame = clip.values_a_frame().max(clip.node_count());
    let last = (clip.frame_count() as f64 - 1.0).max(clip.duration());
    FrameBudget::stated_by(limits, clip.bytes().len() as u64).frames(last, values_a_frame)?;
    Ok(())
}
