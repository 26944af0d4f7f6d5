//! The reports of many motions on a robot, as one table.

use std::path::{Path, PathBuf};

use mocap::files::ReplacePolicy;

use crate::Failure;
use crate::args::RobotArgs;
use crate::batch::manifest::Record;

/// The table of `--report`.
#[cfg_attr(
    not(feature = "parquet"),
    expect(dead_code, reason = "a build without Parquet refuses it")
)]
pub(super) struct Table<'a> {
    path: &'a Path,
    args: &'a RobotArgs,
}

impl<'a> Table<'a> {
    pub(super) fn new(path: &'a Path, args: &'a RobotArgs) -> Self {
        Self { path, args }
    }
}

impl Table<'_> {
    /// The file of the table for this shard, if it may be written.
    #[cfg(feature = "parquet")]
    pub(super) fn check(&self, policy: &ReplacePolicy) -> Result<PathBuf, Failure> {
        let Self { path, args } = *self;
        if super::extension(path) != "parquet" {
            return Err(super::unknown_extension(path, ".parquet"));
        }
        let path = args.onto.spread.of_shard(path);
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        // The output folder need not exist, because it is created later.
        if let Some(folder) = folder.filter(|folder| !folder.is_dir() && !args.output.starts_with(folder)) {
            let message = format!(
                "{}: folder not found: {}; create it first",
                path.display(),
                folder.display()
            );
            return Err(Failure::Usage(message));
        }
        policy.check_inputs(&path)?;
        let is_ours = || std::fs::File::open(&path).is_ok_and(|file| mocap::arrays::table::is_own_parquet(&file));
        if path.is_file() && !args.onto.force.force && !is_ours() {
            let message = "mocap did not write this file: use another name, or replace it with --force";
            return Err(Failure::Usage(format!("{}: {message}", path.display())));
        }
        Ok(path)
    }

    /// Writes a row for each record.
    #[cfg(feature = "parquet")]
    pub(super) fn write<'a>(&self, path: &Path, records: impl Iterator<Item = &'a Record>) -> Result<(), Failure> {
        use mocap::arrays::table;

        let unknown = "the manifest has no report of this motion";
        let reports: Vec<_> = records.map(|record| (record, record.robot_report())).collect();
        let clips = reports.iter().map(|(record, report)| table::RobotClip {
            clip: &record.input,
            output: record.output.as_deref(),
            report: report.as_ref().ok_or(record.error.as_deref().unwrap_or(unknown)),
        });
        let rows = table::robot_reports(&clips.collect::<Vec<_>>());
        let bytes = table::to_parquet([rows])?;
        crate::streams::write(path, &bytes)
    }

    #[cfg(not(feature = "parquet"))]
    pub(super) fn check(&self, _: &ReplacePolicy) -> Result<PathBuf, Failure> {
        Err(super::without_parquet())
    }

    #[cfg(not(feature = "parquet"))]
    pub(super) fn write<'a>(&self, _: &Path, _: impl Iterator<Item = &'a Record>) -> Result<(), Failure> {
        Err(super::without_parquet())
    }
}
