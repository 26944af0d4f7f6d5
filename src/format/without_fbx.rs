//! FBX in a build without the feature `fbx`: the file is known, and the error names the feature.

use crate::error::{Code, Diagnostic, Result};
use crate::format::{FormatInfo, ReadOptions, Source};
use crate::scene::{Format, Scene};

pub(super) const FORMAT: FormatInfo = FormatInfo {
    format: Format::Fbx,
    description: "Autodesk FBX: this build cannot read it",
    extensions: &["fbx"],
    sniff: |bytes| bytes.starts_with(b"Kaydara FBX Binary") || bytes.trim_ascii_start().starts_with(b"; FBX"),
    reads_blocks: false,
    read,
};

fn read(_: &Source<'_>, _: &ReadOptions) -> Result<Scene> {
    Err(Diagnostic::new(Code::MissingFeature, "this build cannot read FBX")
        .help("build it with `--features fbx`, which needs a C compiler")
        .into())
}
