//! `mocap formats`: lists the formats that can be read and written.

use std::io::{self, Write};

use mocap::FormatInfo;

use crate::Failure;

pub(crate) fn run() -> Result<(), Failure> {
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
