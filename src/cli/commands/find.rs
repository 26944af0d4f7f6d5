//! `mocap find`: searches a database for frames similar to a clip or a pose.

use std::fmt;

use mocap::Scene;
use mocap::matching::report::Match;
use mocap::matching::{FindOptions, Query};
use serde::Serialize;

use super::{Place, found, import_motion, index, print_report};
use crate::Failure;
use crate::args::FindArgs;

pub(crate) fn run(args: &FindArgs) -> Result<(), Failure> {
    let database = index::read(&args.database)?;
    found::check(args, &database)?;
    let (query, scene) = query(args)?;
    let parts = database.find(&query, &options(args));
    if args.sheet.is_some() || args.page.is_some() {
        found::write(args, &database, &parts, &scene)?;
    }
    let list = MatchList {
        matches: &parts,
        are_parts: query.seconds() > 0.0,
    };
    print_report(&list, args.json, Place::Result)
}

/// The output of `--json`.
pub(crate) fn summary(args: &FindArgs) -> Result<serde_json::Value, Failure> {
    let database = index::read(&args.database)?;
    let (query, _) = query(args)?;
    Ok(super::value(&database.find(&query, &options(args))))
}

fn options(args: &FindArgs) -> FindOptions {
    FindOptions::new()
        .count(args.count)
        .per_clip(Some(args.per_clip.get()))
        .mirror(!args.no_mirror)
        .condition(args.condition.clone())
}

/// The query, and its motion.
fn query(args: &FindArgs) -> Result<(Query, Scene), Failure> {
    let (file, scene) = match (&args.like, &args.pose) {
        (Some(like), _) => (&like.file, import_motion(&args.read, &like.file)?),
        (None, Some(pose)) => (&pose.file, import_motion(&args.read, &pose.file)?),
        (None, None) => {
            return Err(Failure::Usage("name a query with --like or --pose".to_owned()));
        }
    };
    let query = match (&args.like, &args.pose) {
        (None, Some(pose)) => Query::pose(&scene, 0, pose.at),
        (like, _) => Query::part(&scene, 0, like.as_ref().map_or_else(Default::default, |like| like.part)),
    };
    Ok((query.map_err(|error| error.with_path(file))?, scene))
}

/// The results of a search, the best first.
#[derive(Serialize)]
#[serde(transparent)]
struct MatchList<'a> {
    matches: &'a [Match],
    #[serde(skip)]
    are_parts: bool,
}

impl fmt::Display for MatchList<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let found = self.matches;
        let width = found
            .iter()
            .map(|found| found.file.chars().count())
            .max()
            .unwrap_or(4)
            .max(4);
        let (when, pace) = match self.are_parts {
            true => ("seconds", "  pace"),
            false => ("second", ""),
        };
        writeln!(f, "distance  {when:<16}{pace}  mirrored  {:width$}  clip", "file")?;
        for Match {
            file,
            clip,
            first,
            last,
            distance,
            mirrored,
            pace,
            ..
        } in found
        {
            let when = match self.are_parts {
                true => format!("{first:.2}..{last:.2}"),
                false => format!("{first:.2}"),
            };
            let pace = match self.are_parts {
                true => format!("  {pace:.2}"),
                false => String::new(),
            };
            let mirrored = if *mirrored { "yes" } else { "no" };
            writeln!(
                f,
                "{distance:<8.3}  {when:<16}{pace}  {mirrored:<8}  {file:width$}  {clip}"
            )?;
        }
        Ok(())
    }
}
