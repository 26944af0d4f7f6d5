//! Motion formats that are recognised but not read. The error states what to export instead.

use std::path::Path;

use mocap_scene::error::{Code, Diagnostic};

use crate::text::begins_with_element;

struct Unread {
    name: &'static str,
    extension: &'static str,
    sniff: fn(&[u8]) -> bool,
    help: &'static str,
}

const UNREAD: [Unread; 5] = [
    Unread {
        name: "COLLADA",
        extension: "dae",
        sniff: |bytes| begins_with_element(bytes, "COLLADA"),
        help: "export glTF (.glb), FBX or BVH from the program that wrote it; Blender up to 4.5 opens COLLADA too",
    },
    Unread {
        name: "SMD, of Valve's Source engine,",
        extension: "smd",
        sniff: |bytes| bytes.starts_with(b"version 1") && bytes[9..].trim_ascii_start().starts_with(b"nodes"),
        help: "open it in Blender with Blender Source Tools, and export glTF (.glb), FBX or BVH",
    },
    Unread {
        name: "VPD, a pose of MikuMikuDance,",
        extension: "vpd",
        sniff: |bytes| bytes.starts_with(b"Vocaloid Pose Data file"),
        help: "load the pose on its model in MikuMikuDance, register it as a key, and save the motion as VMD",
    },
    Unread {
        name: "MVNX, of Xsens MVN,",
        extension: "mvnx",
        sniff: |bytes| begins_with_element(bytes, "mvnx"),
        help: "export FBX, BVH or C3D from MVN Analyze",
    },
    Unread {
        name: "HTR, of Motion Analysis,",
        extension: "htr",
        sniff: |bytes| {
            let head = bytes[..bytes.len().min(4096)].to_ascii_lowercase();
            memchr::memmem::find(&head, b"[header]").is_some() && memchr::memmem::find(&head, b"filetype htr").is_some()
        },
        help: "export BVH, TRC or C3D from Cortex, or FBX from the program that wrote it",
    },
];

/// The error for a file of a motion format that is not read. The contents or else the extension show the format.
#[doc(hidden)]
pub fn unread(bytes: &[u8], name: &Path) -> Option<Diagnostic> {
    let extension = name.extension().unwrap_or_default();
    let by_contents = UNREAD.iter().find(|format| (format.sniff)(bytes));
    let found = by_contents.or_else(|| {
        let mut formats = UNREAD.iter();
        formats.find(|format| extension.eq_ignore_ascii_case(format.extension))
    })?;
    let message = format!("{} is not read", found.name);
    Some(Diagnostic::new(Code::UnreadableFormat, message).help(found.help))
}
