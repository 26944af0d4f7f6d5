//! BIP, the motion of a Biped in 3ds Max. The format has no public specification, so it is recognised and refused.

use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::scene::{Format, Scene};

use crate::{FormatInfo, ReadOptions, Source};

pub(super) const FORMAT: FormatInfo = FormatInfo {
    format: Format::Bip,
    name: "BIP",
    description: "3ds Max Biped: refused; the error states what to export",
    extensions: Format::Bip.extensions(),
    reading: "no: the format is not documented; the error states what to export from 3ds Max instead",
    writing: "no",
    // Without a specification, only the extension identifies the format.
    sniff: |_| false,
    reads: false,
    read,
    names_clips: false,
    // BIP files state no unit.
    carried: &[],
    ..FormatInfo::BASE
};

fn read(_source: &Source<'_>, _options: &ReadOptions) -> Result<Scene> {
    Err(Diagnostic::new(
        Code::UnreadableFormat,
        "BIP, a format of 3ds Max without a public specification, cannot be read",
    )
    .help("open it in 3ds Max, and export the motion as BVH or FBX")
    .into())
}
