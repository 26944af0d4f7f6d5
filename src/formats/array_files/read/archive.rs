//! Zip archives: NumPy's `.npz` and PyTorch's `.pt`. Each entry is stored or deflated.

use std::collections::HashMap;
use std::io::Cursor;

use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::limits::{Limits, limit_exceeded};
use zip::{CompressionMethod, ZipArchive};
use zlib_rs::{Inflate, InflateFlush, Status, crc32::crc32};

use super::ndarray::Bytes;
use crate::Failure;

/// The largest number of entries. A motion file has fewer.
const MOST_ENTRIES: usize = 4096;

/// Bytes that may be inflated from any archive: enough for the values that [`Limits`] allow for any file.
const ANY_INFLATED: u64 = 32 << 20;

/// Bytes that may be inflated per byte of an archive. Motions have about 2; deflate itself allows up to 1032.
const MOST_INFLATED: u64 = 8;

/// The window size of deflate, as a power of two.
const WINDOW_BITS: u8 = 15;

pub(super) struct Archive<'a> {
    bytes: &'a [u8],
    zip: ZipArchive<Cursor<&'a [u8]>>,
    /// The number of bytes that may still be inflated.
    left: u64,
    /// The number of stored bytes that further entries may use. Without this limit, the overlapping entries of a small
    /// archive could have a large total size.
    stored: u64,
    /// Inflated entries by their index in the archive, because many tensors may be views of one storage.
    inflated: HashMap<usize, Bytes<'a>>,
}

fn broken(message: String) -> Failure {
    Box::new(
        Diagnostic::new(Code::UnexpectedEnd, message)
            .help("the file is cut off or damaged: export or download it again"),
    )
}

impl<'a> Archive<'a> {
    pub(super) fn open(bytes: &'a [u8], limits: &Limits) -> Result<Self, Failure> {
        let zip = ZipArchive::new(Cursor::new(bytes))
            .map_err(|error| broken(format!("the zip archive cannot be read: {error}")))?;
        if zip.len() > MOST_ENTRIES {
            return Err(Box::new(limit_exceeded(
                format!("at most {MOST_ENTRIES} entries"),
                format!("{}", zip.len()),
            )));
        }
        let most = (bytes.len() as u64).saturating_mul(MOST_INFLATED);
        Ok(Self {
            bytes,
            zip,
            left: limits.max_bytes.min(ANY_INFLATED.saturating_add(most)),
            stored: bytes.len() as u64,
            inflated: HashMap::new(),
        })
    }

    pub(super) fn names(&self) -> Vec<String> {
        self.zip
            .file_names()
            .filter_map(|name| Some(name.ok()?.into_owned()))
            .collect()
    }

    /// The bytes of an entry; `None` if there is no entry with this name.
    pub(super) fn entry(&mut self, name: &str) -> Result<Option<Bytes<'a>>, Failure> {
        let Some(index) = self.zip.index_for_name(name) else {
            return Ok(None);
        };
        if let Some(bytes) = self.inflated.get(&index) {
            return Ok(Some(bytes.clone()));
        }
        let refused = |error: String| broken(format!("the entry {name} of the archive cannot be read: {error}"));
        let entry = self
            .zip
            .by_index_raw(index)
            .map_err(|error| refused(error.to_string()))?;
        let (method, size, sum) = (entry.compression(), entry.size(), entry.crc32());
        if entry.encrypted() {
            return Err(refused("it is encrypted".to_owned()));
        }
        let begin = usize::try_from(entry.data_start().unwrap_or(u64::MAX)).unwrap_or(usize::MAX);
        let length = usize::try_from(entry.compressed_size()).unwrap_or(usize::MAX);
        drop(entry);
        let stored = self.bytes.get(begin..begin.saturating_add(length));
        let stored = stored.ok_or_else(|| refused("it ends beyond the file".to_owned()))?;
        self.stored = self
            .stored
            .checked_sub(length as u64)
            .ok_or_else(|| refused("it overlaps another entry".to_owned()))?;
        let bytes = match method {
            CompressionMethod::Stored => Bytes::File(stored),
            CompressionMethod::DEFLATE => self.inflate(name, stored, size)?,
            other => {
                return Err(refused(format!(
                    "it is compressed by {other}, expected stored or deflated"
                )));
            }
        };
        if bytes.len() as u64 != size || crc32(0, &bytes) != sum {
            return Err(refused(
                "its length or its check sum differs from the stated value".to_owned(),
            ));
        }
        self.inflated.insert(index, bytes.clone());
        Ok(Some(bytes))
    }

    /// Checks the stated size against the limits before allocating memory.
    fn inflate(&mut self, name: &str, stored: &[u8], size: u64) -> Result<Bytes<'a>, Failure> {
        let Some(left) = self.left.checked_sub(size) else {
            let expected = format!(
                "at most {} bytes inflated from an archive of {}",
                self.left,
                self.bytes.len()
            );
            return Err(Box::new(
                limit_exceeded(expected, format!("{size} bytes in {name}"))
                    .help("save the arrays without compression, with numpy.savez, or save a part of the motion"),
            ));
        };
        self.left = left;
        let mut bytes = vec![0; size as usize];
        let mut inflate = Inflate::new(false, WINDOW_BITS);
        match inflate.decompress(stored, &mut bytes, InflateFlush::Finish) {
            Ok(Status::StreamEnd) if inflate.total_out() == size => Ok(Bytes::made(bytes)),
            _ => {
                let message =
                    format!("the entry {name} of the archive cannot be read: its compressed bytes are damaged");
                Err(broken(message))
            }
        }
    }
}
