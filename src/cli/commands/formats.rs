//! `mocap formats`: lists the formats that can be read and written.

use std::fmt;

use mocap::FormatInfo;
use serde::Serialize;

use super::{Place, print_report};
use crate::Failure;
use crate::args::FormatsArgs;
use crate::printed::ReportList;

/// The output of `--json` for a format.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Row {
    format: &'static str,
    extensions: &'static [&'static str],
    read: bool,
    written: bool,
    description: &'static str,
}

impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let extensions: Vec<String> = self
            .extensions
            .iter()
            .map(|extension| format!(".{extension}"))
            .collect();
        let does = match (self.read, self.written) {
            (true, true) => "read, write",
            (true, false) => "read",
            (false, true) => "write",
            (false, false) => "-",
        };
        let (format, description) = (self.format, self.description);
        write!(
            f,
            "{format:<8}  {does:<11}  {:<12}  {description}",
            extensions.join(" ")
        )
    }
}

pub(crate) fn run(args: &FormatsArgs) -> Result<(), Failure> {
    let rows = FormatInfo::ALL.iter().map(|row| Row {
        format: row.format.as_str(),
        extensions: row.extensions,
        read: row.reads,
        written: row.writes(),
        description: row.description,
    });
    print_report(&ReportList(rows.collect()), args.json, Place::Result)
}
