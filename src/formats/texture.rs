//! What formats with meshes share about images.

/// The type of an image by its first bytes, which are right where the file's word is not.
pub(crate) fn media_type(bytes: &[u8]) -> Option<&'static str> {
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => Some("image/png"),
        [0xFF, 0xD8, 0xFF, ..] => Some("image/jpeg"),
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => Some("image/webp"),
        _ => None,
    }
}

/// The name of a file that every system takes, without its extension; empty where nothing is left of it.
pub(crate) fn file_stem(name: &str) -> String {
    /// Windows takes these for devices.
    const DEVICES: [&str; 4] = ["con", "prn", "aux", "nul"];
    /// Characters, of at most four bytes, where most systems have 255 bytes.
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

/// As [`file_stem`], or `instead` where nothing is left of it.
pub(crate) fn file_stem_or(name: &str, instead: &str) -> String {
    match file_stem(name) {
        stem if stem.is_empty() => instead.to_owned(),
        stem => stem,
    }
}
