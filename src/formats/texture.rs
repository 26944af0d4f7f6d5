//! Shared image helpers for formats with meshes.

/// The type of an image by its first bytes. These bytes are reliable even if the file states another type.
pub(crate) fn media_type(bytes: &[u8]) -> Option<&'static str> {
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => Some("image/png"),
        [0xFF, 0xD8, 0xFF, ..] => Some("image/jpeg"),
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => Some("image/webp"),
        _ => None,
    }
}

/// A file name that is valid on every system, without its extension. Empty if no character remains.
pub(crate) fn file_stem(name: &str) -> String {
    /// Windows reserves these names for devices.
    const DEVICES: [&str; 4] = ["con", "prn", "aux", "nul"];
    /// The largest number of characters, each of at most four bytes. Most systems allow 255 bytes.
    const MOST: usize = 50;
    let is_forbidden = |c: char| c.is_control() || ":*?\"<>|/\\".contains(c);
    let name: String = name
        .chars()
        .map(|c| if is_forbidden(c) { '_' } else { c })
        .take(MOST)
        .collect();
    let name = name.trim().trim_matches('.').trim();
    let lower = name.to_ascii_lowercase();
    let port = lower.strip_prefix("com").or_else(|| lower.strip_prefix("lpt"));
    let is_port = port.is_some_and(|port| port.len() == 1 && port.bytes().all(|byte| byte.is_ascii_digit()));
    let is_device = is_port || DEVICES.contains(&lower.split('.').next().unwrap_or_default());
    match is_device {
        true => format!("_{name}"),
        false => name.to_owned(),
    }
}

/// Like [`file_stem`], or `instead` if no character remains.
pub(crate) fn file_stem_or(name: &str, instead: &str) -> String {
    match file_stem(name) {
        stem if stem.is_empty() => instead.to_owned(),
        stem => stem,
    }
}
