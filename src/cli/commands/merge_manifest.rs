//! `mocap merge-manifest`: merges the manifests of a run's shards.

use std::io;

use crate::args::MergeManifestArgs;
use crate::batch::manifest;
use crate::printed::FilesReport;
use crate::{Failure, report};

pub(crate) fn run(args: &MergeManifestArgs) -> Result<(), Failure> {
    let in_folder = |error: io::Error| Failure::Folder(args.folder.clone(), error);
    let records = manifest::merge(&args.folder).map_err(in_folder)?;
    let failed = records.iter().filter(|record| record.error.is_some()).count();
    match args.json {
        true => super::print_json(&FilesReport {
            files: records.len(),
            failed,
        })?,
        false => report::say(&format!("{} files, {failed} failed", records.len())),
    }
    if failed > 0 {
        return Err(Failure::Some);
    }
    Ok(())
}
