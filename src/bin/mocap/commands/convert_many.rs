//! `mocap convert -o`: many motion files into a folder.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use mocap::scene::{Confidence, Topic, UpAxis};

use super::convert::{Round, Wanted};
use super::{convert, verify};
use crate::Failure;
use crate::args::{ConvertArgs, Given};
use crate::batch::folder::{Made, Many, Work};
use crate::batch::manifest::Record;
use crate::batch::outputs::Output;

/// Converts what the arguments name into `folder`.
pub(crate) fn run(args: &ConvertArgs, folder: &Path, given: &Given) -> Result<(), Failure> {
    convert::check(args)?;
    let wanted = Wanted::new(args, given, args.batch.to)?;
    let many = Many {
        paths: &args.paths,
        folder,
        others: &[],
        inputs: &args.batch.inputs,
        spread: &args.batch.spread,
        resume: args.batch.resume,
        force: args.force,
        options: given.options.clone(),
    };
    many.run(&mut Convert {
        args,
        wanted,
        axes: None,
    })
}

struct Convert<'a> {
    args: &'a ConvertArgs,
    wanted: Wanted<'a>,
    /// The up axes of skeletons, once the clips that stand have told them.
    axes: Option<BTreeMap<String, UpAxis>>,
}

impl Work for Convert<'_> {
    fn extension(&self) -> &str {
        self.args.batch.to.extension
    }

    fn make(&self, file: &Path, output: &Output<'_>, record: &mut Record) -> Result<Made, String> {
        let round = self.axes.as_ref().map_or(Round::First, Round::Last);
        let is_known = || output.is_known();
        let converted = convert::convert(&self.wanted, file, &output.path, output.policy, &is_known, round);
        let converted = converted.map_err(|error| error.to_string())?;
        if converted.waits {
            return Ok(Made::Waits);
        }
        record.skeleton = Some(converted.skeleton);
        record.guesses = converted.guesses;
        record.warnings = converted.warnings.iter().map(ToString::to_string).collect();
        record.output_sha256 = converted.hash;
        record.max_error = converted.max_error;
        let allowed = self.args.write.smaller.tolerance();
        if let Some(verification) = converted.verification.filter(|found| !found.is_within(allowed)) {
            // It is written, and it is not what it should be.
            record.output = Some(output.name.to_owned());
            return Err(verify::difference(&verification, allowed));
        }
        Ok(Made::Done)
    }

    fn learn(&mut self, others: &[&Record]) {
        self.axes = Some(Clips::of(others).axes());
    }

    fn summary(&self, records: &[&Record]) -> Vec<String> {
        Vec::from_iter(Clips::of(records).units())
    }
}

/// What clips say of their skeletons.
#[derive(Default)]
struct Clips {
    /// For each skeleton the up axes of the clips in which it is sure.
    up: BTreeMap<String, BTreeSet<String>>,
    /// The number of files in each unit.
    units: BTreeMap<String, usize>,
}

impl Clips {
    fn of(records: &[&Record]) -> Self {
        let mut clips = Self::default();
        records.iter().for_each(|record| clips.add(record));
        clips
    }

    fn add(&mut self, record: &Record) {
        for guess in &record.guesses {
            if guess.topic == Topic::Unit {
                *self.units.entry(guess.choice.clone()).or_default() += 1;
            }
            if let (Topic::Up, Some(Confidence::Sure), Some(skeleton)) =
                (guess.topic, guess.confidence, &record.skeleton)
            {
                self.up
                    .entry(skeleton.clone())
                    .or_default()
                    .insert(guess.choice.clone());
            }
        }
    }

    /// The skeletons all of whose clips stand along one axis.
    fn axes(&self) -> BTreeMap<String, UpAxis> {
        let one = |(skeleton, axes): (&String, &BTreeSet<String>)| {
            let named = |up: &UpAxis| axes.len() == 1 && axes.contains(up.as_str());
            let up = UpAxis::ALL.into_iter().find(named)?;
            Some((skeleton.clone(), up))
        };
        self.up.iter().filter_map(one).collect()
    }

    /// `unit: cm in 12 files, inch in 1 file`.
    fn units(&self) -> Option<String> {
        let unit = |(unit, files): (&String, &usize)| {
            let noun = if *files == 1 { "file" } else { "files" };
            format!("{unit} in {files} {noun}")
        };
        let units: Vec<String> = self.units.iter().map(unit).collect();
        (!units.is_empty()).then(|| format!("unit: {}", units.join(", ")))
    }
}
