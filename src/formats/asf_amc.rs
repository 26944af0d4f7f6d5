//! Acclaim's pair of files: `.asf`, the skeleton of a person, and `.amc`, a motion of that person.
//!
//! ```text
//! asf       := section*
//! section   := ":units" (("mass" | "length") x | "angle" ("deg" | "rad"))*
//!            | ":root" ("order" channel* | "axis" order | "position" x y z | "orientation" x y z)*
//!            | ":bonedata" bone*
//!            | ":hierarchy" "begin" (parent child*)* "end"
//!            | ":version" ... | ":name" ... | ":documentation" ... | any other, which is passed over
//! bone      := "begin" property* "end"
//! property  := "name" name | "direction" x y z | "length" x | "axis" x y z order | "dof" channel* | ...
//! amc       := (":FULLY-SPECIFIED" | ":DEGREES" | ":RADIANS")* frame*
//! frame     := number (name value*)*
//! ```
//!
//! Each construction has its own line, and `#` begins a comment. A bone has a name, a direction and a length. Without
//! `axis` it rotates about the world axes. Without `dof` it does not rotate.
//!
//! A bone is a vector from its near end to its far end, in the axes of the world. It rotates about its own axes, whose
//! world rotation `C` comes from `axis`. With the rotation `M` of the motion, the rotation of the bone's node is `C M
//! C^-1`, as matrices on column vectors. In the rest pose the rotation of the node is the identity. `C` and `M` rotate
//! about the first named axis first: `XYZ` is `Rz Ry Rx`. A bone's node is at its near end, which is the far end of its
//! parent. A bone without children has an end site at its far end.
//!
//! Lengths are in the file's unit.

#[cfg(feature = "acclaim")]
mod read;

use mocap_scene::scene::Format;

use crate::FormatInfo;
use crate::text::{Cursor, Word, decode, is_line_end, is_space};

pub(super) const FORMAT: FormatInfo = FormatInfo {
    format: Format::AsfAmc,
    name: "Acclaim ASF/AMC",
    description: "Acclaim skeleton and motion",
    extensions: Format::AsfAmc.extensions(),
    reading: "good",
    writing: "no",
    sniff,
    feature: Some("acclaim"),
    reads: cfg!(feature = "acclaim"),
    read: reader!("acclaim", read::read),
    names_clips: false,
    // Acclaim files state no unit.
    carried: &[],
    ..FormatInfo::BASE
};

/// The keywords before the frames of a motion.
const HEADER: [&str; 3] = [":FULLY-SPECIFIED", ":DEGREES", ":RADIANS"];

fn sniff(bytes: &[u8]) -> bool {
    /// The number of bytes at the start of a file that must contain the first word after the comments.
    const ENOUGH: usize = 64 << 10;
    decode(&bytes[..bytes.len().min(ENOUGH)]).is_ok_and(|text| begins_skeleton(&text) || begins_motion(&text))
}

fn begins_skeleton(text: &[u8]) -> bool {
    let sections = [":version", ":name", ":units", ":documentation", ":root", ":bonedata"];
    first_word(text).is_some_and(|word| sections.iter().any(|section| word.is(section)))
}

fn begins_motion(text: &[u8]) -> bool {
    first_word(text).is_some_and(|word| HEADER.iter().any(|keyword| word.is(keyword)))
}

/// The first word after comments.
fn first_word(text: &[u8]) -> Option<Word<'_>> {
    let mut cursor = Cursor::new(text);
    loop {
        cursor.skip_spaces();
        match cursor.peek()? {
            b'#' => cursor.take_while(|byte| !is_line_end(byte)),
            _ => return Some(cursor.take_while(|byte| !is_space(byte) && byte != b'#')),
        };
    }
}
