//! Identifies the files of a former run by their contents.

use std::fs::File;
use std::io;
use std::path::Path;

use mocap::files::FilePart;
use sha2::{Digest, Sha256};

/// The SHA-256 of a file, as `sha256sum` prints it.
pub(crate) fn sha256(path: &Path) -> io::Result<String> {
    mocap::files::check_confined(path).map_err(io::Error::other)?;
    let mut hasher = Sha256::new();
    io::copy(&mut File::open(path)?, &mut hasher)?;
    Ok(format!("{:x}", hasher.finalize()))
}

/// The SHA-256 of bytes.
pub(crate) fn sha256_of(bytes: &[u8]) -> String {
    sha256_of_parts(&[bytes.into()])
}

/// The SHA-256 of bytes in several parts.
pub(crate) fn sha256_of_parts(parts: &[FilePart<'_>]) -> String {
    let mut hasher = Sha256::new();
    parts.iter().for_each(|part| hasher.update(part.bytes()));
    format!("{:x}", hasher.finalize())
}
