//! Assembles `.glb` files: <https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html#glb-file-format-specification>

use mocap_scene::error::{Code, Diagnostic, Result};

use super::super::json::{CHUNK_HEADER, HEADER, MAGIC};

/// The version of the container.
const VERSION: u32 = 2;

/// A `.glb` file without its buffer, which may be large and is not copied.
pub(super) struct Glb {
    /// The header, the JSON text and the header of the buffer.
    pub(super) head: Vec<u8>,
    /// The bytes after the buffer: padding, and chunks that only extensions use.
    pub(super) tail: Vec<u8>,
}

impl Glb {
    /// Makes the file from a JSON text, the length of a buffer, and further chunks with their headers.
    ///
    /// # Errors
    /// [`Code::LimitExceeded`] beyond the container's 4 GiB.
    pub(super) fn new(mut json: Vec<u8>, bin: Option<usize>, further: &[u8]) -> Result<Self> {
        // The text and the buffer are padded to a multiple of four bytes: the text with spaces, the buffer with zeros.
        json.resize(json.len().next_multiple_of(4), b' ');
        let padded = bin.map(|bin| bin.next_multiple_of(4));
        let bin_chunk = padded.map_or(0, |padded| CHUNK_HEADER + padded);
        let length = HEADER + CHUNK_HEADER + json.len() + bin_chunk + further.len();
        let length = u32::try_from(length).map_err(|_| {
            let message = "the file would be larger than the 4 GiB that a .glb can hold";
            Diagnostic::new(Code::LimitExceeded, message).help("write .gltf, or write fewer frames")
        })?;
        // The length of the file fits into 32 bits, and so does the length of a chunk.
        let number = |length: usize| (length as u32).to_le_bytes();
        let mut head = Vec::with_capacity(HEADER + 2 * CHUNK_HEADER + json.len());
        head.extend(MAGIC);
        head.extend(VERSION.to_le_bytes());
        head.extend(length.to_le_bytes());
        head.extend(number(json.len()));
        head.extend(b"JSON");
        head.extend(json);
        let mut tail = Vec::new();
        if let (Some(bin), Some(padded)) = (bin, padded) {
            head.extend(number(padded));
            head.extend(b"BIN\0");
            tail.resize(padded - bin, 0);
        }
        tail.extend(further);
        Ok(Self { head, tail })
    }

    /// The bytes of the file with its buffer.
    pub(super) fn around(&self, bin: &[u8]) -> Vec<u8> {
        [&self.head, bin, &self.tail].concat()
    }
}
