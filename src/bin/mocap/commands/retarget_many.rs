//! `mocap retarget` into a folder: an output of each of many motions, and a manifest.

use std::path::Path;

use mocap::Importer;
use mocap::fbx::{FbxOptions, FbxTextures};
use mocap::retarget::{LimbError, Verdict};
use mocap::retargeting::{Retargeting, Target};
use serde::Deserialize;

use super::extension;
use super::retarget::{add, check_output, import_target, inputs, onto, write};
use crate::args::{Given, RetargetArgs};
use crate::batch::folder::{Made, Many, Work, verdicts};
use crate::batch::hash::{sha256, sha256_of};
use crate::batch::manifest::Record;
use crate::batch::outputs::Output;
use crate::batch::progress::Counts;
use crate::report::Voice;
use crate::{Failure, report};

pub(crate) fn run(args: &RetargetArgs, given: &Given) -> Result<(), Failure> {
    let (motions, file) = inputs(args)?;
    if args.json {
        let message = "--json prints the report of one output; the manifest in the folder has those of many";
        return Err(Failure::Usage(message.to_owned()));
    }
    let target = import_target(args, &file)?;
    let format = match &args.to {
        Some(format) => format.clone(),
        None => default_format(&target, &file),
    };
    refuse_files_beside(&file, &target, &format)?;
    // As for standard output, whose format is that of `--to` too.
    check_output(args, &file, &target, &format, Path::new("-"))?;
    let fbx = args.fbx.options(given, &format, &args.output)?;
    if fbx.textures == FbxTextures::Beside {
        let message = "textures of many files would have one name; retarget one motion at a time, or leave it out";
        return Err(Failure::Usage(format!("--textures beside: {message}")));
    }
    let hash = sha256(&file).map_err(|error| Failure::Folder(file.clone(), error))?;
    let many = Many {
        paths: &motions,
        folder: &args.output,
        others: std::slice::from_ref(&file),
        inputs: &args.inputs,
        spread: &args.spread,
        resume: args.resume,
        force: args.force,
        options: format!("{} character-sha256={hash}", given.options),
    };
    many.run(&mut OnTarget {
        args,
        retargeting: onto(args, target, &file)?,
        // Many files keep all threads busy, a thread a file.
        importer: args.read.importer().threads(1),
        format,
        fbx,
    })
}

/// The format of the character, or GLB for a skeleton.
fn default_format(target: &Target, file: &Path) -> String {
    match (target, extension(file).as_str()) {
        (Target::Character(_), own @ ("gltf" | "vrm")) => own.to_owned(),
        _ => "glb".to_owned(),
    }
}

/// Refuses a character with files beside it, which outputs in another folder would not find.
fn refuse_files_beside(file: &Path, target: &Target, format: &str) -> Result<(), Failure> {
    let Target::Character(character) = target else {
        return Ok(());
    };
    // These are written from the scene.
    if ["vrma", "fbx"].contains(&format) {
        return Ok(());
    }
    match character.external_files()?.first() {
        None => Ok(()),
        Some(beside) => Err(Failure::Usage(format!(
            "{}: outputs in a folder would not find {beside}, which is beside it: name a character that holds all its \
             files, such as a .glb",
            file.display()
        ))),
    }
}

struct OnTarget<'a> {
    args: &'a RetargetArgs,
    /// The target, without a motion yet.
    retargeting: Retargeting,
    importer: Importer,
    format: String,
    fbx: FbxOptions,
}

impl Work for OnTarget<'_> {
    fn extension(&self) -> &str {
        &self.format
    }

    fn make(&self, file: &Path, output: &Output<'_>, record: &mut Record) -> Result<Made, String> {
        let mut retargeting = self.retargeting.clone();
        let mut voice = Voice::Kept(&mut record.warnings);
        let added = add(self.args, &mut retargeting, &self.importer, file, &mut voice);
        added.map_err(Failure::into_words)?;
        let written = write(&retargeting, &output.path, &self.format, &self.fbx, &mut voice);
        let (bytes, _) = written.map_err(Failure::into_words)?;
        output.write(&bytes).map_err(|error| error.to_string())?;
        // The contents of other formats say who wrote them.
        record.output_sha256 = (self.format == "bvh").then(|| sha256_of(&bytes));
        let reports: Vec<_> = retargeting.clips().iter().map(|clip| &clip.report).collect();
        record.retarget = serde_json::value::to_raw_value(&reports).ok();
        Ok(Made::Done)
    }

    fn is_complete(&self, former: &Record) -> bool {
        former.retarget.is_some()
    }

    fn summary(&self, records: &[&Record]) -> Vec<String> {
        let found = clips(records);
        let found = found.iter().map(|clip| clip.verdict);
        Vec::from_iter(verdicts("clips on the character", found))
    }

    fn finish(&self, records: &[&Record], counts: &Counts) -> Result<(), Failure> {
        counts.verdict()?;
        let Some(most) = &self.args.max_angle else {
            return Ok(());
        };
        let found = clips(records);
        let is_worse = |clip: &&Clip| clip.limbs.iter().any(|limb| limb.max_degrees > most.0);
        match found.iter().filter(is_worse).count() {
            0 => Ok(()),
            worse => {
                let count = found.len();
                report::complain(&format!(
                    "{worse} of {count} clips are farther off than --max-angle allows"
                ));
                Err(Failure::Told)
            }
        }
    }
}

/// What is read again of a report in the manifest.
#[derive(Deserialize)]
struct Clip {
    limbs: Vec<LimbError>,
    verdict: Verdict,
}

/// The clips of all motions, those that were retargeted before too.
fn clips(records: &[&Record]) -> Vec<Clip> {
    let reports = records.iter().filter_map(|record| record.retarget.as_ref());
    let clips = reports.filter_map(|reports| serde_json::from_str::<Vec<Clip>>(reports.get()).ok());
    clips.flatten().collect()
}
