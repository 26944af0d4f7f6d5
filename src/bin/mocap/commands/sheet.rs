//! `mocap sheet`: draws poses over time, one row per file.

use mocap::render::{Clip, SheetOptions, sheet};
use mocap::{Scene, SkeletonMesh};

use super::{check_output, short_name, write_drawing};
use crate::args::SheetArgs;
use crate::{Failure, report};

pub(crate) fn run(args: &SheetArgs) -> Result<(), Failure> {
    check_output(&args.files, &args.output)?;
    let importer = args.read.importer().skeleton_mesh(SkeletonMesh::None);
    let mut named_scenes: Vec<(String, Scene)> = Vec::new();
    for file in &args.files {
        let scene = importer.import(file)?;
        report::warnings(Some(file), &scene.warnings);
        report::clip_taken(&scene);
        named_scenes.push((short_name(file), scene));
    }
    let clips: Vec<Clip<'_>> = named_scenes.iter().map(|(name, scene)| Clip { name, scene }).collect();
    let options = SheetOptions {
        poses: args.poses,
        width: args.width,
    };
    write_drawing(&sheet(&clips, &options), &args.output)
}
