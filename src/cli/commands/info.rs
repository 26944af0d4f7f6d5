//! `mocap info`: summarises a file.

use std::fmt;
use std::io::{self, IsTerminal};

use mocap::dump::report::Summary;
use mocap::render::{Clip, ScreenOptions};
use mocap::{Scene, SkeletonMesh};
use serde::Serialize;
use terminal_size::{Height, Width};

use super::{Place, print_report};
use crate::args::InfoArgs;
use crate::{Failure, report, streams};

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct InfoView<'a> {
    file: String,
    #[serde(flatten)]
    summary: Summary<'a>,
    /// The text for people.
    #[serde(skip)]
    screen: String,
}

impl fmt::Display for InfoView<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.screen)
    }
}

pub(crate) fn run(args: &InfoArgs) -> Result<(), Failure> {
    let mut scene = import(args)?;
    let mut screen = String::new();
    if !args.json {
        make_names_visible(&mut scene);
        screen = screen_of(&report::visible(&args.file.display().to_string()), &scene);
    }
    print_report(&view(args, &scene, screen), args.json, Place::Screen)
}

/// What `--json` prints.
pub(crate) fn summary(args: &InfoArgs) -> Result<serde_json::Value, Failure> {
    Ok(super::value(&view(args, &import(args)?, String::new())))
}

fn view<'a>(args: &InfoArgs, scene: &'a Scene, screen: String) -> InfoView<'a> {
    InfoView {
        file: args.file.display().to_string(),
        summary: Summary::of(scene),
        screen,
    }
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

/// The text of a scene, of the size of the terminal. If the output is not a terminal, the text has the usual width and
/// no limit on its length.
fn screen_of(name: &str, scene: &Scene) -> String {
    let is_terminal = io::stdout().is_terminal();
    let size = terminal_size::terminal_size().filter(|_| is_terminal);
    let options = match size {
        Some((Width(width), Height(height))) => ScreenOptions::new()
            .width(width.into())
            .height(height.into())
            .colour(std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())),
        None => ScreenOptions::new().height(usize::MAX),
    };
    Clip { name, scene }.screen(&options)
}
