//! Reads the `.parquet` files of `fk` with the Parquet reader, without code of the writer.

use mocap_formats::parquet_rows;
use mocap_scene::error::Result;
use mocap_scene::limits::Limits;

use super::arrays::{ArrayFile, Header};

/// Whether the file is a Parquet file.
pub(super) fn sniff(bytes: &[u8]) -> bool {
    bytes.starts_with(b"PAR1")
}

/// The arrays of a file; `None` for a table of clips, which is read as a scene.
///
/// # Errors
/// If the file is broken.
pub(super) fn read(bytes: &[u8]) -> Result<Option<ArrayFile>> {
    let Some(rows) = parquet_rows(bytes, &Limits::default())? else {
        return Ok(None);
    };
    Ok(Some(ArrayFile {
        header: Header::from_json(&rows.header)?,
        frames: rows.frames,
        positions: rows.positions,
        rotations: rows.rotations,
        velocities: rows.velocities,
    }))
}
