//! Writes a document as one `.glb`, a `.gltf` with an embedded buffer, or a `.gltf` with a `.bin`.

use std::borrow::Cow;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use gltf::binary::{Glb, Header};
use gltf::json::Root;

use super::{Document, text};
use crate::error::{Code, Diagnostic, Error, Result};
use crate::files::write_file_with;
use crate::format::WrittenFile;

/// Bytes before the first chunk of a `.glb` file, and before what is in a chunk.
const GLB_HEADER: usize = 12;
const CHUNK_HEADER: usize = 8;

/// Bytes before the JSON text and between it and the buffer, with padding.
const GLB_OVERHEAD: usize = GLB_HEADER + 2 * CHUNK_HEADER + 6;

impl Document {
    /// The bytes of a `.glb` file.
    ///
    /// # Errors
    /// [`Code::LimitExceeded`] beyond the 4 GiB that the container can hold.
    pub fn to_glb(&self) -> Result<Vec<u8>> {
        self.glb()?.to_vec().map_err(|error| unwritable(&error))
    }

    /// The number of bytes of [`Self::to_glb`], without making them.
    ///
    /// # Errors
    /// As [`Self::to_glb`].
    pub fn glb_len(&self) -> Result<usize> {
        let glb = self.glb()?;
        let chunk = |bytes: &[u8]| CHUNK_HEADER + bytes.len().next_multiple_of(4);
        Ok(GLB_HEADER + chunk(&glb.json) + glb.bin.as_deref().map_or(0, chunk))
    }

    /// Writes a `.glb` file, and returns its length.
    pub(in crate::format::gltf) fn write_glb(&self, path: &Path) -> Result<u64> {
        let glb = self.glb()?;
        write_file_with(path, |file| {
            // The header goes out number by number; all of a small file becomes one write.
            let mut file = BufWriter::with_capacity(1 << 16, file);
            glb.to_writer(&mut file).map_err(|error| match error {
                gltf::Error::Io(error) => error,
                error => io::Error::other(error),
            })?;
            file.flush()
        })
    }

    /// A `.glb` file; its buffer is not copied.
    pub(in crate::format::gltf) fn into_glb_file(self, name: &str) -> Result<WrittenFile> {
        let json = self.glb()?.json.into_owned();
        let padding = |length: usize| length.next_multiple_of(4) - length;
        let chunk = |bytes: usize| match bytes {
            0 => 0,
            bytes => CHUNK_HEADER + bytes.next_multiple_of(4),
        };
        let length = GLB_HEADER + chunk(json.len()) + chunk(self.bin.len());
        // A file of more than 4 GiB was refused above.
        let number = |number: usize| (number as u32).to_le_bytes();
        let mut head = Vec::with_capacity(length - self.bin.len());
        head.extend(b"glTF");
        head.extend(number(2));
        head.extend(number(length));
        head.extend(number(json.len().next_multiple_of(4)));
        head.extend(b"JSON");
        let spaces = padding(json.len());
        head.extend(json);
        head.resize(head.len() + spaces, b' ');
        if self.bin.is_empty() {
            return Ok(WrittenFile::new(name, head));
        }
        head.extend(number(self.bin.len().next_multiple_of(4)));
        head.extend(b"BIN\0");
        let zeros = vec![0; padding(self.bin.len())];
        let parts = [head, self.bin, zeros].into_iter().filter(|part| !part.is_empty());
        Ok(WrittenFile::of_parts(name, parts.collect()))
    }

    /// A `.gltf` file after the `.bin` of its buffer, which has the same name, and is absent where it is empty.
    pub(in crate::format::gltf) fn into_text_and_bin_files(self, name: &str) -> Result<Vec<WrittenFile>> {
        let bin_name = Path::new(name).with_extension("bin").to_string_lossy().into_owned();
        let text = WrittenFile::new(name, self.to_text_and_bin(&bin_name)?.0);
        let bin = (!self.bin.is_empty()).then(|| WrittenFile::new(bin_name, self.bin));
        Ok(bin.into_iter().chain([text]).collect())
    }

    /// The parts of a `.glb` file.
    fn glb(&self) -> Result<Glb<'_>> {
        let json = self.text(&self.root)?;
        if u32::try_from(json.len() + self.bin.len() + GLB_OVERHEAD).is_err() {
            let message = "the file would be larger than the 4 GiB that a .glb can hold";
            return Err(Diagnostic::new(Code::LimitExceeded, message)
                .help("write .gltf, or write fewer frames")
                .into());
        }
        Ok(Glb {
            // The writer computes the length itself.
            header: Header {
                magic: *b"glTF",
                version: 2,
                length: 0,
            },
            json: Cow::Owned(json),
            bin: Some(Cow::Borrowed(self.bin.as_slice())).filter(|bin| !bin.is_empty()),
        })
    }

    /// The bytes of a `.gltf` file with its buffer as a data URI.
    ///
    /// # Errors
    /// None is known for a document of this crate.
    pub fn to_embedded(&self) -> Result<Vec<u8>> {
        self.with_uri(|| format!("data:application/octet-stream;base64,{}", STANDARD.encode(&self.bin)))
    }

    /// The bytes of a `.gltf` file, and those of the file `bin_name` beside it, which are empty if the scene has
    /// neither meshes nor motion.
    ///
    /// # Errors
    /// None is known for a document of this crate.
    pub fn to_text_and_bin(&self, bin_name: &str) -> Result<(Vec<u8>, &[u8])> {
        Ok((self.with_uri(|| percent_encoded(bin_name))?, &self.bin))
    }

    fn with_uri(&self, uri: impl FnOnce() -> String) -> Result<Vec<u8>> {
        let mut root = self.root.clone();
        if let Some(buffer) = root.buffers.first_mut() {
            buffer.uri = Some(uri());
        }
        self.text(&root)
    }

    /// The JSON text, with `root` in place of the document's own.
    fn text(&self, root: &Root) -> Result<Vec<u8>> {
        text::write(root, &self.animations).map_err(|error| unwritable(&error))
    }
}

fn unwritable(error: &dyn std::error::Error) -> Error {
    Diagnostic::new(Code::Unrepresentable, error.to_string()).into()
}

/// A file name as a relative URI: all but RFC 3986's unreserved characters as `%` and two digits.
fn percent_encoded(name: &str) -> String {
    let mut uri = String::with_capacity(name.len());
    for byte in name.bytes() {
        if byte.is_ascii_alphanumeric() || b"-._~".contains(&byte) {
            uri.push(char::from(byte));
        } else {
            uri.push_str(&format!("%{byte:02X}"));
        }
    }
    uri
}
