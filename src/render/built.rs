//! The files that `build.rs` made, compressed except for browsers.

use std::io::Read;

use flate2::read::ZlibDecoder;

/// The script of the player.
pub fn script() -> String {
    text(include_bytes!(concat!(env!("OUT_DIR"), "/player.js")))
}

/// The style sheet of the player's page.
pub(crate) fn style() -> String {
    text(include_bytes!(concat!(env!("OUT_DIR"), "/page.css")))
}

/// The TrueType font for pictures.
pub(crate) fn font() -> Vec<u8> {
    unpacked(include_bytes!(concat!(env!("OUT_DIR"), "/font")))
}

fn text(packed: &[u8]) -> String {
    String::from_utf8(unpacked(packed)).expect("the source is UTF-8")
}

fn unpacked(packed: &[u8]) -> Vec<u8> {
    if cfg!(target_arch = "wasm32") {
        return packed.to_vec();
    }
    let mut bytes = Vec::new();
    let read = ZlibDecoder::new(packed).read_to_end(&mut bytes);
    read.expect("the build compressed it");
    bytes
}
