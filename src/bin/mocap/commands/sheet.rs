//! `mocap sheet`: draws poses over time, one row per file.

use std::path::Path;

use mocap::Scene;
use mocap::render::{Clip, SheetOptions, sheet};
use mocap::skeleton::TPose;

use super::{import_motion, mapped_skeleton, short_name, write_drawing};
use crate::args::{Given, MapArgs, SheetArgs};
use crate::{Failure, streams};

pub(crate) fn run(args: &SheetArgs, given: &Given) -> Result<(), Failure> {
    if !args.t_pose {
        given.refuse(&["map"], "only the T-pose comes from the bones; add --t-pose")?;
    }
    streams::check_output(&args.files, &args.output)?;
    let mut named_scenes: Vec<(String, Scene)> = Vec::new();
    for file in &args.files {
        let mut scene = import_motion(&args.read, file)?;
        args.up.state(&mut scene);
        let scene = match args.t_pose {
            true => in_t_pose(scene, file, &args.map)?,
            false => scene,
        };
        named_scenes.push((short_name(file), scene));
    }
    let clips: Vec<Clip<'_>> = named_scenes.iter().map(|(name, scene)| Clip { name, scene }).collect();
    let options = SheetOptions {
        poses: if args.t_pose { 1 } else { args.poses },
        width: args.width,
    };
    write_drawing(&sheet(&clips, &options), &args.output)
}

/// The scene without motion, its skeleton in T-pose.
fn in_t_pose(mut scene: Scene, file: &Path, map: &MapArgs) -> Result<Scene, Failure> {
    let skeleton = mapped_skeleton(&scene, map)?;
    let Some(found) = TPose::new(&scene, &skeleton) else {
        let message = format!("{}: there is no T-pose: {}", file.display(), skeleton.humanoid.reason);
        return Err(Failure::Usage(message));
    };
    scene.animations.clear();
    for (node, node_to_parent) in scene.nodes.iter_mut().zip(found.pose.node_to_parent) {
        node.transform = node_to_parent;
    }
    Ok(scene)
}
