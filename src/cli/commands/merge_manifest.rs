//! `mocap merge-manifest`: merges the manifests of a run's shards.

use std::io;

use super::{Place, print_report};
use crate::Failure;
use crate::args::MergeManifestArgs;
use crate::batch::manifest;
use crate::printed::FilesReport;

pub(crate) fn run(args: &MergeManifestArgs) -> Result<(), Failure> {
    let in_folder = |error: io::Error| Failure::Folder(args.folder.clone(), error);
    let records = manifest::merge(&args.folder).map_err(in_folder)?;
    let failed = records.iter().filter(|record| record.error.is_some()).count();
    let files = records.len();
    print_report(&FilesReport { files, failed }, args.json, Place::Message)?;
    if failed > 0 {
        return Err(Failure::Some);
    }
    Ok(())
}
