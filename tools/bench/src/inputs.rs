//! Inputs of any size: the rows of a real capture, repeated.

use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// A walk of 38 nodes, 96 channels and 2,752 frames, from the CMU Graphics Lab Motion Capture Database.
const CAPTURE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/real/cmu_01_01.bvh");
/// A skeleton of two joints, for a file that measures start-up.
const SMALL: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../../fixtures/real/blender_two_joints.bvh"
);

/// Copies a small file of 2 KB into `folder`.
pub(crate) fn small(folder: &Path) -> io::Result<PathBuf> {
    let path = folder.join("small.bvh");
    fs::copy(SMALL, &path)?;
    Ok(path)
}

/// Writes a file of about `bytes` bytes, with whole rows, into `folder`.
pub(crate) fn tile(folder: &Path, name: &str, bytes: usize) -> io::Result<PathBuf> {
    let text = fs::read_to_string(CAPTURE)?;
    let (hierarchy, motion) = text.split_once("MOTION").ok_or(io::ErrorKind::InvalidData)?;
    let rows: Vec<&str> = motion.lines().skip(3).filter(|row| !row.trim().is_empty()).collect();
    let frame_time = motion.lines().nth(2).ok_or(io::ErrorKind::InvalidData)?;
    let mut frames = 0;
    let mut left = bytes.saturating_sub(hierarchy.len());
    for row in rows.iter().cycle() {
        if left < row.len() + 1 {
            break;
        }
        left -= row.len() + 1;
        frames += 1;
    }
    let path = folder.join(name);
    let mut out = BufWriter::new(fs::File::create(&path)?);
    write!(out, "{hierarchy}MOTION\nFrames: {frames}\n{frame_time}\n")?;
    for row in rows.iter().cycle().take(frames) {
        writeln!(out, "{row}")?;
    }
    out.flush()?;
    Ok(path)
}
