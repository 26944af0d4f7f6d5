//! `mocap sheet`: draws poses over time, or the T-pose, one row per file.

use std::path::Path;

use mocap::figure::Figure;
use mocap::job::SourceMap;
use mocap::render::{Clip, Drawing, SheetOptions, TPoseClip};
use mocap::{Code, Diagnostic, Error, Scene};

use super::{check_picture, import_drawn, mapped_figure, on_robot, short_name, write_drawing};
use crate::Failure;
use crate::args::{ArgumentSources, SheetArgs};

pub(crate) fn run(args: &SheetArgs, given: &ArgumentSources) -> Result<(), Failure> {
    if !args.t_pose {
        given.refuse(&["map"], "only the T-pose needs the bones; add --t-pose")?;
    }
    check_picture(&args.files, &args.picture)?;
    write(&drawing(args)?, args)
}

/// Writes the picture.
pub(crate) fn write(drawing: &Drawing, args: &SheetArgs) -> Result<(), Failure> {
    let format = check_picture(&args.files, &args.picture)?;
    write_drawing(drawing, &args.picture, &format)
}

/// Draws the poses of the files.
pub(crate) fn drawing(args: &SheetArgs) -> Result<Drawing, Failure> {
    let mut named_scenes: Vec<(String, Scene)> = Vec::new();
    for file in &args.files {
        let mut scene = import_drawn(&args.read, args.up, file)?;
        if let Some(robot) = &args.robot {
            scene = on_robot(scene, file, robot)?;
        }
        named_scenes.push((short_name(file), scene));
    }
    match args.t_pose {
        true => t_poses(args, &named_scenes),
        false => Ok(poses(args, &named_scenes)),
    }
}

fn poses(args: &SheetArgs, named_scenes: &[(String, Scene)]) -> Drawing {
    let clips: Vec<Clip<'_>> = named_scenes.iter().map(|(name, scene)| Clip { name, scene }).collect();
    let options = SheetOptions::new().poses(args.poses).width(args.width);
    Drawing::sheet(&clips, &options)
}

fn t_poses(args: &SheetArgs, named_scenes: &[(String, Scene)]) -> Result<Drawing, Failure> {
    let mut found = Vec::new();
    for (file, (_, scene)) in args.files.iter().zip(named_scenes) {
        found.push(figure_with_t_pose(scene, file, &args.map)?);
    }
    let clips = named_scenes.iter().zip(&found).filter_map(|((name, scene), figure)| {
        Some(TPoseClip {
            name,
            scene,
            figure,
            t_pose: figure.t_pose(scene)?,
        })
    });
    Ok(Drawing::t_pose_sheet(&clips.collect::<Vec<_>>(), args.width))
}

/// The figure of a scene that has a T-pose.
fn figure_with_t_pose(scene: &Scene, file: &Path, map: &SourceMap) -> Result<Figure, Failure> {
    let figure = mapped_figure(scene, map)?;
    if figure.t_pose(scene).is_none() {
        let message = format!("there is no T-pose: {}", figure.humanoid.reason);
        let error = Error::from(Diagnostic::new(Code::NotHumanoid, message));
        return Err(error.with_path(file).into());
    }
    Ok(figure)
}
