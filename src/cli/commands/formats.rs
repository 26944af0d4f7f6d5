//! `mocap formats`: lists the formats that can be read and written.

use std::io::{self, Write};

use mocap::FormatInfo;
use serde::Serialize;

use super::print_json;
use crate::Failure;
use crate::args::FormatsArgs;

/// What `--json` prints of a format.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Row {
    format: &'static str,
    extensions: &'static [&'static str],
    read: bool,
    written: bool,
    description: &'static str,
}

pub(crate) fn run(args: &FormatsArgs) -> Result<(), Failure> {
    if args.json {
        let rows = FormatInfo::ALL.iter().map(|row| Row {
            format: row.format.as_str(),
            extensions: row.extensions,
            read: row.reads,
            written: row.writes(),
            description: row.description,
        });
        return Ok(print_json(&rows.collect::<Vec<_>>())?);
    }
    let mut out = io::stdout().lock();
    for row in FormatInfo::ALL {
        let extensions: Vec<String> = row.extensions.iter().map(|extension| format!(".{extension}")).collect();
        let does = match (row.reads, row.writes()) {
            (true, true) => "read, write",
            (true, false) => "read",
            (false, true) => "write",
            (false, false) => "-",
        };
        writeln!(
            out,
            "{:<8}  {:<11}  {:<12}  {}",
            row.format.as_str(),
            does,
            extensions.join(" "),
            row.description
        )?;
    }
    Ok(())
}
