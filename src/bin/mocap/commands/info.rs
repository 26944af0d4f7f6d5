//! `mocap info`: summarises a file.

use std::io::{self, IsTerminal, Write};

use mocap::render::{Clip, ScreenOptions};
use mocap::scene::{Animation, Assumption, NodeKind, Recorded, RootOffsetUsed, Solved};
use mocap::{Diagnostic, Format, Scene, SkeletonMesh};
use serde::Serialize;
use terminal_size::{Height, Width};

use super::print_json;
use crate::args::InfoArgs;
use crate::{Failure, report, streams};

#[derive(Serialize)]
struct InfoView<'a> {
    file: String,
    format: Option<Format>,
    nodes: usize,
    joints: usize,
    end_sites: usize,
    meshes: usize,
    vertices: usize,
    channels: usize,
    frames: usize,
    ticks_per_second: Option<f64>,
    duration_ticks: f64,
    duration_seconds: f64,
    clips: Vec<ClipView<'a>>,
    /// Events, analog channels and force plates.
    #[serde(skip_serializing_if = "Option::is_none")]
    recorded: Option<&'a Recorded>,
    /// What is known of a skeleton that was solved from markers.
    #[serde(skip_serializing_if = "Option::is_none")]
    solved: Option<&'a Solved>,
    root_offset: Option<&'a RootOffsetUsed>,
    assumptions: Vec<Assumption>,
    warnings: &'a [Diagnostic],
}

/// One animation.
#[derive(Serialize)]
struct ClipView<'a> {
    name: &'a str,
    channels: usize,
    frames: usize,
    seconds: f64,
}

impl<'a> ClipView<'a> {
    fn new(animation: &'a Animation) -> Self {
        Self {
            name: &animation.name,
            channels: animation.channels.len(),
            frames: animation.frame_count(),
            seconds: animation.duration / animation.ticks_per_second,
        }
    }
}

impl<'a> InfoView<'a> {
    fn new(file: String, scene: &'a Scene) -> Self {
        let animation = scene.animations.first();
        let count = |kind| scene.nodes.iter().filter(|node| node.kind == kind).count();
        Self {
            file,
            format: scene.metadata.format,
            nodes: scene.nodes.len(),
            joints: count(NodeKind::Joint),
            end_sites: count(NodeKind::EndSite),
            meshes: scene.meshes.len(),
            vertices: scene.meshes.iter().map(|mesh| mesh.vertices.len()).sum(),
            channels: animation.map_or(0, |animation| animation.channels.len()),
            frames: animation.map_or(0, Animation::frame_count),
            ticks_per_second: animation.map(|animation| animation.ticks_per_second),
            duration_ticks: animation.map_or(0.0, |animation| animation.duration),
            duration_seconds: animation.map_or(0.0, |animation| animation.duration / animation.ticks_per_second),
            clips: scene.animations.iter().map(ClipView::new).collect(),
            recorded: scene.metadata.recorded.as_deref(),
            solved: scene.metadata.solved.as_deref(),
            root_offset: scene.metadata.root_offset.as_ref(),
            assumptions: scene.assumptions(),
            warnings: &scene.warnings,
        }
    }
}

pub(crate) fn run(args: &InfoArgs) -> Result<(), Failure> {
    let mut scene = import(args)?;
    let name = args.file.display().to_string();
    if args.json {
        return Ok(print_json(&InfoView::new(name, &scene))?);
    }
    make_names_visible(&mut scene);
    Ok(print_screen(&report::visible(&name), &scene)?)
}

/// What `--json` prints.
pub(crate) fn summary(args: &InfoArgs) -> Result<serde_json::Value, Failure> {
    let scene = import(args)?;
    Ok(super::value(&InfoView::new(args.file.display().to_string(), &scene)))
}

fn import(args: &InfoArgs) -> mocap::Result<Scene> {
    let importer = args.read.importer().skeleton_mesh(SkeletonMesh::Segmented);
    streams::import(&importer, &args.file)
}

/// The screen has colours, so that escapes cannot be replaced afterwards.
fn make_names_visible(scene: &mut Scene) {
    let clips = scene.animations.iter_mut();
    let in_clips = clips.flat_map(|clip| {
        let channels = clip.channels.iter_mut().map(|channel| &mut channel.node_name);
        std::iter::once(&mut clip.name).chain(channels)
    });
    let nodes = scene.nodes.iter_mut().map(|node| &mut node.name);
    let warnings = scene.warnings.iter_mut().flat_map(|warning| {
        let texts = [
            &mut warning.joint,
            &mut warning.expected,
            &mut warning.found,
            &mut warning.help,
        ];
        texts.into_iter().flatten().chain([&mut warning.message])
    });
    for text in nodes.chain(in_clips).chain(warnings) {
        *text = report::visible(text).into_owned();
    }
}

/// The size of the terminal; if the output is not a terminal, the usual width and no limit on the length.
fn print_screen(name: &str, scene: &Scene) -> io::Result<()> {
    let mut out = io::stdout().lock();
    let is_terminal = out.is_terminal();
    let size = terminal_size::terminal_size().filter(|_| is_terminal);
    let options = match size {
        Some((Width(width), Height(height))) => ScreenOptions::new()
            .width(width.into())
            .height(height.into())
            .colour(std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())),
        None => ScreenOptions::new().height(usize::MAX),
    };
    out.write_all(Clip { name, scene }.screen(&options).as_bytes())
}
