//! Pictures of the results of `mocap find`: a sheet, and a page with the player.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use mocap::convert::Moment;
use mocap::files::ReplacePolicy;
use mocap::matching::Database;
use mocap::matching::report::Match;
use mocap::render::{Clip, Drawing, Page, PageClip, SheetOptions};
use mocap::{Conversion, Scene, SkeletonMesh};

use super::{Place, drawn, print_report, refuse_one_file, short_name};
use crate::args::FindArgs;
use crate::printed::PictureReport;
use crate::{Failure, report, streams};

/// The number of poses in a row of the sheet.
const POSES: usize = 8;

/// Refuses outputs that cannot be written, before the search.
pub(super) fn check(args: &FindArgs, database: &Database) -> Result<(), Failure> {
    let is = |path: &Path, extensions: &[&str]| extensions.contains(&super::extension(path).as_str());
    if let Some(sheet) = args.sheet.as_deref().filter(|sheet| !is(sheet, &["png", "svg"])) {
        return Err(super::unknown_extension(sheet, ".png or .svg"));
    }
    if let Some(page) = args.page.as_deref().filter(|page| !is(page, &["html"])) {
        return Err(super::unknown_extension(page, ".html"));
    }
    let policy = policy(args, database);
    refuse_one_file(args.sheet.iter().chain(&args.page).map(PathBuf::as_path))?;
    for output in args.sheet.iter().chain(&args.page) {
        policy.check(output)?;
    }
    Ok(())
}

fn policy(args: &FindArgs, database: &Database) -> ReplacePolicy {
    let clips = database.clips().iter().map(|clip| Path::new(&clip.row.file));
    let queries = [
        args.like.as_ref().map(|like| &like.file),
        args.pose.as_ref().map(|pose| &pose.file),
    ];
    let queries = queries.into_iter().flatten().map(PathBuf::as_path);
    let inputs = [args.database.as_path()].into_iter().chain(queries).chain(clips);
    ReplacePolicy::new(inputs).force(args.force.force)
}

/// Writes the requested pictures: the query, then the results, the best first.
pub(super) fn write(args: &FindArgs, database: &Database, found: &[Match], query: &Scene) -> Result<(), Failure> {
    let mut shown = vec![of_query(args, query)?];
    let mut files: HashMap<&str, Scene> = HashMap::new();
    for (number, found) in (1..).zip(found) {
        let scene = of_clip(args, database, found, &mut files)?;
        let ends = [found.first, found.last].map(Moment::Seconds);
        let mirrored = if found.mirrored { " mirrored" } else { "" };
        let name = short_name(Path::new(&found.file));
        let name = match found.last > found.first {
            true => format!("{number}: {name}{mirrored}, {:.2}..{:.2} s", found.first, found.last),
            false => format!("{number}: {name}{mirrored}, {:.2} s", found.first),
        };
        shown.push((name, part(scene, Some(ends[0]), Some(ends[1]), Path::new(&found.file))?));
    }
    let clips: Vec<Clip<'_>> = shown.iter().map(|(name, scene)| Clip { name, scene }).collect();
    let (mut made, mut drawing) = (Vec::new(), None);
    if let Some(sheet) = &args.sheet {
        let poses = if args.pose.is_some() { 1 } else { POSES };
        let drawing = drawing.insert(Drawing::sheet(&clips, &SheetOptions::new().poses(poses)));
        made.push((sheet, drawn(drawing, &super::extension(sheet))?));
    }
    if let Some(path) = &args.page {
        let pages: Vec<PageClip<'_>> = clips.iter().copied().map(PageClip::new).collect();
        made.push((path, Page::new(&pages).html.into_bytes()));
    }
    streams::write_all(&made, &policy(args, database))?;
    if let (Some(sheet), Some(drawing)) = (&args.sheet, &drawing) {
        print_report(&PictureReport::of(drawing, sheet, 0), false, Place::Message)?;
    }
    if let Some(path) = &args.page {
        report::say(&format!("{}: {} motions", path.display(), clips.len()));
    }
    Ok(())
}

/// The clip or the pose of the query.
fn of_query(args: &FindArgs, query: &Scene) -> Result<(String, Scene), Failure> {
    let (file, first, last) = match (&args.like, &args.pose) {
        (Some(like), _) => (&like.file, like.part.first, like.part.last),
        (None, Some(pose)) => (&pose.file, Some(pose.at), Some(pose.at)),
        (None, None) => return Err(Failure::Usage("name a query with --like or --pose".to_owned())),
    };
    let name = format!("looked for: {}", short_name(file));
    Ok((name, part(query.clone(), first, last, file)?))
}

/// The motion of a clip, from the database or from its file.
fn of_clip<'a>(
    args: &FindArgs,
    database: &'a Database,
    found: &'a Match,
    files: &mut HashMap<&'a str, Scene>,
) -> Result<Scene, Failure> {
    let is_it = |clip: &&mocap::matching::IndexedClip| clip.row.file == found.file && clip.row.clip == found.clip;
    if let Some(clip) = database.clips().iter().filter(is_it).find(|clip| clip.is_packed()) {
        return Ok(clip.motion()?);
    }
    let path = Path::new(&found.file);
    if !files.contains_key(found.file.as_str()) {
        let importer = args.read.importer().skeleton_mesh(SkeletonMesh::None);
        files.insert(&found.file, streams::import(&importer, path)?);
    }
    let mut scene = files[found.file.as_str()].clone();
    let mut clips = scene.animations.iter().enumerate();
    let clip = clips.position(|(index, clip)| clip.name == found.clip || index.to_string() == found.clip);
    match clip {
        Some(index) => scene.keep_animation(index),
        None => scene.animations.clear(),
    }
    Ok(scene)
}

/// A part of a motion, in metres with +Y up, without meshes.
fn part(mut scene: Scene, first: Option<Moment>, last: Option<Moment>, file: &Path) -> Result<Scene, Failure> {
    scene.meshes.clear();
    scene.animations.truncate(1);
    let conversion = Conversion::new().trim(first, last);
    conversion.apply(&mut scene).map_err(|error| error.with_path(file))?;
    Ok(scene)
}
