//! `mocap index`: a database of the frames of many motions.

use std::collections::HashMap;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use mocap::files::{ReplacePolicy, check_confined};
use mocap::matching::{Database, IndexedClip};
use mocap::{Code, Diagnostic, Error, SkeletonMesh};

use super::{Place, print_report};
use crate::args::IndexArgs;
use crate::batch::gather::gather;
use crate::batch::hash::sha256;
use crate::batch::inputs::{self, Input};
use crate::printed::IndexReport;
use crate::{Failure, report, streams};

type FormerIndex = HashMap<String, Vec<IndexedClip>>;

pub(crate) fn run(args: &IndexArgs) -> Result<(), Failure> {
    if super::output_format(&args.output, args.to.as_deref(), "mdb")? != "mdb" {
        return Err(super::unknown_extension(&args.output, ".mdb"));
    }
    super::check_json(args.json, &args.output)?;
    let mut inputs = inputs::find(&args.paths, &args.inputs)?;
    inputs::refuse_missing(&inputs)?;
    inputs.retain(|input| args.spread.shard.is_none_or(|shard| shard.has(input)));
    let output = args.spread.of_shard(&args.output);
    let policy = ReplacePolicy::new(inputs.iter().map(|input| &input.path)).force(args.force.force);
    let check = || match streams::is_standard(&output) {
        true => Ok(()),
        false => policy.check(&output),
    };
    check()?;
    let former = match args.resume && output.is_file() {
        true => former(&output)?,
        false => FormerIndex::new(),
    };
    let work = |input: &Input| match unchanged(args, &former, input) {
        Some(clips) => Ok(clips),
        None => of_file(args, input),
    };
    let (files, counts) = gather(&args.spread, &inputs, work, |_| Ok(()))?;
    let clips: Vec<IndexedClip> = files.into_iter().flatten().flatten().collect();
    if clips.is_empty() && !(inputs.is_empty() && args.inputs.allow_empty) {
        report::complain("no motion of a humanoid or of an animal on four legs was found: no database is written");
        return Err(Failure::Told);
    }
    let database = Database::new(clips);
    let bytes = database.to_bytes();
    // Another program may have written the file in the meantime.
    check()?;
    streams::write(&output, &bytes)?;
    let found = IndexReport {
        output: output.display().to_string(),
        bytes: bytes.len(),
        clips: database.clips().len(),
        frames: database.frames(),
    };
    print_report(&found, args.json, Place::Message)?;
    counts.verdict()
}

/// Reads the database at `path`.
pub(super) fn read(path: &Path) -> mocap::Result<Database> {
    check_confined(path)?;
    let file = File::open(path).map_err(|error| Error::io(path, error))?;
    Database::read(BufReader::with_capacity(1 << 16, file)).map_err(|error| error.with_path(path))
}

/// The clips of an earlier run, by file.
fn former(output: &Path) -> Result<FormerIndex, Failure> {
    let mut files = FormerIndex::new();
    for clip in read(output)?.into_clips() {
        files.entry(clip.row.file.clone()).or_default().push(clip);
    }
    Ok(files)
}

/// The clips of a file from an earlier run, if its bytes are unchanged and the same clips are wanted.
fn unchanged(args: &IndexArgs, former: &FormerIndex, input: &Input) -> Option<Vec<IndexedClip>> {
    let clips = former.get(&*input.path.to_string_lossy())?;
    let sha256 = sha256(&input.path).ok()?;
    let is_same = clips.iter().all(|clip| clip.row.sha256 == sha256);
    let is_wanted =
        clips.iter().any(|clip| clip.mirrored) == args.mirror && clips.iter().any(IndexedClip::is_packed) == args.pack;
    (is_same && is_wanted).then(|| clips.clone())
}

/// The clips of a motion file or of a database.
fn of_file(args: &IndexArgs, input: &Input) -> mocap::Result<Vec<IndexedClip>> {
    let path = input.path()?;
    if super::extension(path) == "mdb" {
        return Ok(read(path)?.into_clips());
    }
    let importer = args.read.importer().threads(1).skeleton_mesh(SkeletonMesh::None);
    let scene = streams::import(&importer, path)?;
    let (name, is_still) = (path.to_string_lossy(), scene.animations.is_empty());
    let clips = match args.pack {
        true => IndexedClip::packed_read(scene, &name, args.mirror).map_err(|error| error.with_path(path))?,
        false => IndexedClip::of_read(scene, &name, args.mirror),
    };
    if clips.is_empty() {
        let code = match is_still {
            true => Code::NoMotion,
            false => Code::NotHumanoid,
        };
        let error = Error::from(Diagnostic::new(
            code,
            "it has no motion of a humanoid with two feet or of an animal on four legs",
        ));
        return Err(error.with_path(path));
    }
    Ok(clips)
}
