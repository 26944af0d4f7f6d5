//! `mocap formats`: lists the formats that can be read and written.

use std::io::{self, Write};

use mocap::{FORMATS, Format};

use crate::Failure;

/// The formats that are written.
const WRITTEN: [Format; 5] = [Format::Bvh, Format::Gltf, Format::Vrma, Format::Fbx, Format::Mclip];

pub(crate) fn run() -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    for row in FORMATS {
        let extensions: Vec<String> = row.extensions.iter().map(|extension| format!(".{extension}")).collect();
        let does = match (WRITTEN.contains(&row.format), row.format) {
            (true, Format::Fbx) if cfg!(not(feature = "fbx")) => "write",
            (true, _) => "read, write",
            (false, Format::Bip) => "-",
            (false, _) => "read",
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
