//! `mocap match`: a character follows a path by motion matching.

use std::collections::HashMap;
use std::path::Path;

use mocap::files::ReplacePolicy;
use mocap::glam::Vec3;
use mocap::matching::{Controller, Database, Followed, Moves};
use mocap::retargeting::{Retargeting, RetargetingOptions};
use mocap::scene::Animation;
use mocap::{Code, Conversion, Diagnostic, Error, Exporter, FormatInfo, Importer, Scene, SkeletonMesh};

use super::{check_json, index, output_format, print_json};
use crate::args::{Given, MatchArgs};
use crate::{Failure, report, streams};

pub(crate) fn run(args: &MatchArgs, given: &Given) -> Result<(), Failure> {
    check_json(args.json, &args.output)?;
    let format = output_format(&args.output, args.to.as_deref(), "glb")?;
    let named = Path::new("match").with_extension(&format);
    let output = if streams::is_standard(&args.output) {
        &named
    } else {
        &args.output
    };
    let Some(format) = FormatInfo::of_output(output) else {
        return Err(super::unknown_extension(
            &args.output,
            ".glb, .gltf, .bvh, .fbx or another that is written",
        ));
    };
    let format = format.format;
    let database = index::read(&args.database)?;
    let clips = database.clips().iter().map(|clip| Path::new(&clip.row.file));
    let inputs = [args.database.as_path(), &args.on].into_iter().chain(clips);
    let policy = ReplacePolicy::new(inputs).force(args.force.force);
    if !streams::is_standard(&args.output) {
        policy.check(&args.output)?;
    }
    let mut hero = streams::import(&Importer::new().gltf_meshes(true), &args.on)?;
    hero.animations.clear();
    Conversion::new()
        .apply(&mut hero)
        .map_err(|error| error.with_path(&args.on))?;
    let moves = moves(args, &database, &hero)?;
    let path = &args.path.0;
    let [start, next] = [path[0], path[1]].map(|point| Vec3::new(point.x, 0.0, point.y));
    let forward = (next - start).normalize_or(Vec3::Z);
    let mut controller = Controller::new(&database, moves, start, forward)?;
    let (animation, followed) = controller.follow(&hero, path, args.speed)?;
    hero.animations = vec![animation];
    let mut written = Exporter::new().format(format).write_as(&hero, output)?;
    streams::save(&mut written, &args.output, &policy, given)?;
    match args.json {
        true => print_json(&followed)?,
        false => tell(args, &followed),
    }
    Ok(())
}

fn tell(args: &MatchArgs, followed: &Followed) {
    report::say(&format!(
        "{}: {} frames, {} jumps; a path of {:.1} m: {:.2} m off it in the mean, {:.2} m at most{}",
        args.output.display(),
        followed.frames,
        followed.jumps,
        followed.length,
        followed.mean_distance,
        followed.largest_distance,
        if followed.has_arrived {
            ""
        } else {
            "; its end was not reached"
        }
    ));
}

/// The frames of the database on the character.
fn moves(args: &MatchArgs, database: &Database, hero: &Scene) -> Result<Moves, Failure> {
    let mut moves = Moves::new(hero).map_err(|error| error.with_path(&args.on))?;
    let mut files: HashMap<&str, HashMap<String, Animation>> = HashMap::new();
    for clip in database.clips() {
        let row = &clip.row;
        if !files.contains_key(row.file.as_str()) {
            files.insert(&row.file, on_hero(args, &row.file, &row.sha256, hero)?);
        }
        let path = Path::new(&row.file);
        let Some(animation) = files[row.file.as_str()].get(&row.clip) else {
            return Err(changed(path).into());
        };
        moves.add(clip, animation).map_err(|error| error.with_path(path))?;
    }
    Ok(moves)
}

/// The motions of a file on the character, by their names in the database.
fn on_hero(args: &MatchArgs, file: &str, sha256: &str, hero: &Scene) -> Result<HashMap<String, Animation>, Failure> {
    let path = Path::new(file);
    let importer = args.read.importer().skeleton_mesh(SkeletonMesh::None);
    let scene = streams::import(&importer, path)?;
    if scene
        .metadata
        .origin
        .as_ref()
        .is_none_or(|origin| origin.sha256 != sha256)
    {
        return Err(changed(path).into());
    }
    let name = |(index, clip): (usize, &Animation)| match clip.name.is_empty() {
        true => index.to_string(),
        false => clip.name.clone(),
    };
    let names: Vec<String> = scene.animations.iter().enumerate().map(name).collect();
    let clips = Retargeting::new(scene, hero.clone(), RetargetingOptions::new());
    let clips = clips.map_err(|error| error.with_path(path))?.into_clips();
    Ok(names
        .into_iter()
        .zip(clips.into_iter().map(|clip| clip.animation))
        .collect())
}

fn changed(path: &Path) -> Error {
    let diagnostic = Diagnostic::new(Code::InvalidDatabase, "the file has changed since it was indexed")
        .help("make the database again with `mocap index --resume`");
    Error::from(diagnostic).with_path(path)
}
