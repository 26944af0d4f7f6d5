//! Writes a document as one `.glb`, a `.gltf` with an embedded buffer, or a `.gltf` with a `.bin`.

use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use gltf_json::Root;
use mocap_scene::error::{Code, Diagnostic, Error, Result};

use super::glb::Glb;
use super::{Document, text};
use crate::ExportFile;

impl Document {
    /// The bytes of a `.glb` file.
    ///
    /// # Errors
    /// [`Code::LimitExceeded`] beyond the container's 4 GiB.
    pub fn to_glb(&self) -> Result<Vec<u8>> {
        Ok(self.glb()?.around(&self.bin))
    }

    /// The length of [`Self::to_glb`] in bytes, without making the file.
    ///
    /// # Errors
    /// The errors of [`Self::to_glb`].
    pub fn glb_len(&self) -> Result<usize> {
        let glb = self.glb()?;
        Ok(glb.head.len() + self.bin.len() + glb.tail.len())
    }

    /// A `.glb` file. Its buffer is not copied.
    pub(in crate::gltf) fn into_glb_file(self, name: &str) -> Result<ExportFile> {
        let glb = self.glb()?;
        Ok(ExportFile::of_parts(name, vec![glb.head, self.bin, glb.tail]))
    }

    /// A `.gltf` file, preceded by the `.bin` of its buffer. The `.bin` has the name of the `.gltf`, and is absent if
    /// the buffer is empty.
    pub(in crate::gltf) fn into_text_and_bin_files(self, name: &str) -> Result<Vec<ExportFile>> {
        let bin_name = bin_name(name);
        let text = ExportFile::new(name, self.to_text_and_bin(&bin_name)?.0);
        let bin = (!self.bin.is_empty()).then(|| ExportFile::new(bin_name, self.bin));
        Ok(bin.into_iter().chain([text]).collect())
    }

    fn glb(&self) -> Result<Glb> {
        let bin = Some(self.bin.len()).filter(|bytes| *bytes > 0);
        Glb::new(self.text(&self.root)?, bin, &[])
    }

    /// The bytes of a `.gltf` file with its buffer as a data URI.
    ///
    /// # Errors
    /// No error is known for a document of this crate.
    pub fn to_embedded(&self) -> Result<Vec<u8>> {
        self.with_uri(|| uri_of_buffer(None, &self.bin))
    }

    /// The bytes of a `.gltf` file, and of its companion file `bin_name`. The companion file is empty if the scene has
    /// neither meshes nor motion.
    ///
    /// # Errors
    /// No error is known for a document of this crate.
    pub fn to_text_and_bin(&self, bin_name: &str) -> Result<(Vec<u8>, &[u8])> {
        Ok((self.with_uri(|| uri_of_buffer(Some(bin_name), &self.bin))?, &self.bin))
    }

    fn with_uri(&self, uri: impl FnOnce() -> String) -> Result<Vec<u8>> {
        let mut root = self.root.clone();
        if let Some(buffer) = root.buffers.first_mut() {
            buffer.uri = Some(uri());
        }
        self.text(&root)
    }

    /// The JSON text, with `root` instead of the document's own root.
    fn text(&self, root: &Root) -> Result<Vec<u8>> {
        text::write(root, &self.animations).map_err(|error| unwritable(&error))
    }
}

pub(super) fn unwritable(error: &dyn std::error::Error) -> Error {
    Diagnostic::new(Code::Unrepresentable, error.to_string()).into()
}

/// The name of the buffer file of a `.gltf`.
pub(super) fn bin_name(name: &str) -> String {
    Path::new(name).with_extension("bin").to_string_lossy().into_owned()
}

/// The URI of a buffer: the name of its file, or the bytes themselves.
pub(super) fn uri_of_buffer(beside: Option<&str>, bytes: &[u8]) -> String {
    beside.map_or_else(|| data_uri("application/octet-stream", bytes), percent_encoded)
}

/// The contents of a file as a URI.
pub(super) fn data_uri(media_type: &str, bytes: &[u8]) -> String {
    format!("data:{media_type};base64,{}", STANDARD.encode(bytes))
}

/// A file name as a relative URI. All but RFC 3986's unreserved characters become `%` and two hexadecimal digits.
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
