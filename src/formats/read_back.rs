//! Refuses to write a file that its own reader would refuse.
//!
//! [`Limits`] and [`numbers`] define what a reader accepts. A writer can exceed the limits: sparse keys can make a long
//! take, a name gets a suffix, lengths get another unit. It is cheap to detect whether a scene is near a limit. The
//! reader reads the written file again only if the scene is near a limit.

use std::path::Path;

use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::limits::{FARTHEST, FRAME_RATES, Limits, SMALLEST_SCALE};
use mocap_scene::scene::{Animation, Node, Scene};

use super::{ExportFile, ReadOptions, Source, numbers};

/// The largest factor by which a writer may change a number: units, rotations of axes, products of two transforms.
const ROOM: f64 = 1e4;

/// The largest number of nodes, levels and name bytes that a file may have beyond its scene: groups, end sites,
/// suffixes.
const MORE: usize = 64;

/// The largest number of values per key: a position, a rotation and a scale.
const VALUES_OF_CHANNEL: u64 = 10;

/// Refuses files that `read` refuses, made from these nodes and animations. Files with references to missing companion
/// files are not checked.
///
/// # Errors
/// The errors of `read`, and of [`numbers::check`].
pub fn check<'a>(
    read: &dyn Fn(&Source<'_>, &ReadOptions) -> Result<Scene>,
    files: &[ExportFile],
    nodes: &[Node],
    animations: impl Iterator<Item = &'a Animation> + Clone,
) -> Result<()> {
    let bytes: usize = files.iter().map(ExportFile::len).sum();
    if !(is_near_in_nodes(nodes) || is_near_in_animations(animations, nodes.len(), bytes)) {
        return Ok(());
    }
    let options = ReadOptions {
        without_meshes: true,
        ..ReadOptions::default()
    };
    match read_again(read, files, &options).and_then(|scene| numbers::check(&scene)) {
        Err(error) if error.code() != Code::MissingFile => {
            let mut refusal = error.diagnostic().clone();
            refusal.message = format!("the reader would refuse the file: {}", refusal.message);
            refusal.help = Some("trim the motion, lower its frame rate, or remove the parts that are too large".into());
            refusal.location = None;
            Err(refusal.into())
        }
        _ => Ok(()),
    }
}

/// Whether files have no motion when `read` reads them.
pub fn is_still(read: &dyn Fn(&Source<'_>, &ReadOptions) -> Result<Scene>, files: &[ExportFile]) -> bool {
    let options = ReadOptions {
        gltf_meshes: true,
        morph_targets: true,
        ..ReadOptions::default()
    };
    read_again(read, files, &options).is_ok_and(|again| !again.moves())
}

fn read_again(
    read: &dyn Fn(&Source<'_>, &ReadOptions) -> Result<Scene>,
    files: &[ExportFile],
    options: &ReadOptions,
) -> Result<Scene> {
    let Some(main) = files.last() else {
        return Err(Diagnostic::new(Code::MissingFile, "there are no files").into());
    };
    let open = |path: &Path| {
        let beside = files.iter().find(|file| path.ends_with(file.name()));
        let missing = || Diagnostic::new(Code::MissingFile, "the file is not in the output");
        Ok(beside.ok_or_else(missing)?.bytes().into_owned())
    };
    read(
        &Source {
            bytes: &main.bytes(),
            blocks: None,
            name: Path::new(main.name()),
            release: &|_| {},
            open: &open,
            list: &|_| Vec::new(),
        },
        options,
    )
}

fn is_near_in_nodes(nodes: &[Node]) -> bool {
    let limits = Limits::default();
    let mut depths: Vec<usize> = Vec::with_capacity(nodes.len());
    for node in nodes {
        let above = node.parent.and_then(|parent| depths.get(parent.index()));
        depths.push(above.map_or(1, |above| above + 1));
    }
    let deepest = depths.into_iter().max().unwrap_or_default();
    let longest = nodes.iter().map(|node| node.name.len()).max().unwrap_or_default();
    nodes.len() + MORE > limits.max_nodes
        || deepest + MORE > limits.max_depth
        || longest + MORE > limits.max_name_bytes
        || nodes.iter().any(|node| is_far(&node.transform.to_cols_array()))
}

fn is_near_in_animations<'a>(
    animations: impl Iterator<Item = &'a Animation> + Clone,
    nodes: usize,
    bytes: usize,
) -> bool {
    let mut values = 0_u64;
    for animation in animations {
        let rate = animation.ticks_per_second;
        let frames = animation.frame_count() as u64;
        let values_a_frame = (VALUES_OF_CHANNEL * animation.channels.len() as u64).max(nodes as u64);
        values = values.saturating_add(frames.saturating_mul(values_a_frame));
        let is_near = !(FRAME_RATES.start() * ROOM..=FRAME_RATES.end() / ROOM.sqrt()).contains(&rate)
            || animation.channels.iter().any(|channel| {
                let positions = channel.position_keys.values.iter();
                let mut scales = channel.scaling_keys.values.iter().flat_map(glam::Vec3::to_array);
                let is_small = |scale: f32| scale != 0.0 && f64::from(scale.abs()) < SMALLEST_SCALE * ROOM;
                positions.into_iter().any(|position| is_far(&position.to_array())) || scales.any(is_small)
            });
        if is_near {
            return true;
        }
    }
    values > Limits::default().expanded_values(bytes as u64)
}

/// Whether a number is large, or NaN.
fn is_far(numbers: &[f32]) -> bool {
    let are_near = numbers.iter().all(|number| f64::from(number.abs()) < FARTHEST / ROOM);
    !are_near
}
