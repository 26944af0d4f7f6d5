//! `mocap formats`: what can be read, and what written.

use std::io::{self, Write};

use mocap::FORMATS;

use crate::Failure;

/// The formats that are written, by name.
const WRITTEN: [&str; 2] = ["bvh", "gltf"];

pub(crate) fn run() -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    for format in FORMATS {
        let extensions: Vec<String> = format
            .extensions
            .iter()
            .map(|extension| format!(".{extension}"))
            .collect();
        let does = match (WRITTEN.contains(&format.name), format.name) {
            (true, _) => "read, write",
            (false, "bip") => "-",
            (false, _) => "read",
        };
        writeln!(
            out,
            "{:<8}  {:<11}  {:<12}  {}",
            format.name,
            does,
            extensions.join(" "),
            format.description
        )?;
    }
    Ok(())
}
