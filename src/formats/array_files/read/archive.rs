//! Zip archives: `.npz` of NumPy and `.pt` of PyTorch. Each entry is stored or deflated.

use std::io::Cursor;

use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::limits::{Limits, limit_exceeded};
use zip::{CompressionMethod, ZipArchive};
use zlib_rs::{Inflate, InflateFlush, Status, crc32::crc32};

use super::ndarray::Bytes;
use crate::Failure;

/// More entries than a file has whose motion is read.
const MOST_ENTRIES: usize = 4096;

/// How many times its bytes a deflated entry may have: the format's own maximum.
const MOST_INFLATED: u64 = 1032;

/// The windows of deflate, as a power of two.
const WINDOW_BITS: u8 = 15;

pub(super) struct Archive<'a> {
    bytes: &'a [u8],
    zip: ZipArchive<Cursor<&'a [u8]>>,
    /// Bytes that may still be inflated.
    left: u64,
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
            .map_err(|error| broken(format!("the file is no zip archive that can be read: {error}")))?;
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
            left: limits.max_bytes.min(most),
        })
    }

    pub(super) fn names(&self) -> Vec<String> {
        self.zip
            .file_names()
            .filter_map(|name| Some(name.ok()?.into_owned()))
            .collect()
    }

    /// The bytes of an entry; `None` where there is none of this name.
    pub(super) fn entry(&mut self, name: &str) -> Result<Option<Bytes<'a>>, Failure> {
        let Some(index) = self.zip.index_for_name(name) else {
            return Ok(None);
        };
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
        let bytes = match method {
            CompressionMethod::Stored => Bytes::File(stored),
            CompressionMethod::DEFLATE => Bytes::made(self.inflate(stored, size).map_err(refused)?),
            other => {
                return Err(refused(format!(
                    "it is compressed by {other}, expected stored or deflated"
                )));
            }
        };
        if bytes.len() as u64 != size || crc32(0, &bytes) != sum {
            return Err(refused("its length or its check sum is not the stated one".to_owned()));
        }
        Ok(Some(bytes))
    }

    /// What is stated is held against what deflate can make of the bytes, and against the limits, before memory is
    /// taken for it.
    fn inflate(&mut self, stored: &[u8], size: u64) -> Result<Vec<u8>, String> {
        if size > (stored.len() as u64).saturating_mul(MOST_INFLATED) || size > self.left {
            return Err(format!(
                "{size} bytes cannot be made of {}, or are more than the limits allow",
                stored.len()
            ));
        }
        self.left -= size;
        let mut bytes = vec![0; size as usize];
        let mut inflate = Inflate::new(false, WINDOW_BITS);
        match inflate.decompress(stored, &mut bytes, InflateFlush::Finish) {
            Ok(Status::StreamEnd) if inflate.total_out() == size => Ok(bytes),
            _ => Err("its compressed bytes are damaged".to_owned()),
        }
    }
}
