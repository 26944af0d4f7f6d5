//! A glTF file as its JSON and its bytes, for a comparison of everything except motion.

use std::path::Path;

use mocap_scene::error::Result;
use serde_json::Value;

use super::file::contents_of;
use super::invalid::{invalid, json_words};
use super::json;

/// The JSON of a file, and its buffers.
#[doc(hidden)]
pub struct RawFile {
    #[doc(hidden)]
    pub json: Value,
    /// The bytes of each buffer. `None` if a buffer has no bytes, or if its file is missing.
    buffers: Vec<Option<Vec<u8>>>,
}

impl RawFile {
    /// Splits a file into its JSON and its buffers. `open` reads a companion file.
    ///
    /// # Errors
    /// The container or the JSON is broken.
    #[doc(hidden)]
    pub fn read(bytes: &[u8], open: &dyn Fn(&Path) -> Result<Vec<u8>>) -> Result<Self> {
        let (text, bin) = json::split(bytes)?;
        let json: Value = serde_json::from_str(&String::from_utf8_lossy(text))
            .map_err(|error| invalid("", format!("the JSON cannot be read: {}", json_words(&error))))?;
        let buffers = items(&json, "buffers").iter().enumerate();
        let buffers = buffers.map(|(index, buffer)| match buffer["uri"].as_str() {
            Some(uri) => contents_of(uri, "", open).ok().map(Into::into),
            None => bin.filter(|_| index == 0).map(<[u8]>::to_vec),
        });
        let buffers = buffers.collect();
        Ok(Self { json, buffers })
    }

    /// The items of a root list; empty if it is absent.
    #[doc(hidden)]
    pub fn list(&self, name: &str) -> &[Value] {
        items(&self.json, name)
    }

    /// The bytes of a buffer view. If the view is compressed, the bytes of its stream.
    #[doc(hidden)]
    pub fn view(&self, view: &Value) -> Option<&[u8]> {
        let number = |name: &str| usize::try_from(view[name].as_u64()?).ok();
        let start = number("byteOffset").unwrap_or_default();
        let bytes = self.buffers.get(number("buffer")?)?.as_deref()?;
        bytes.get(start..)?.get(..number("byteLength")?)
    }

    /// The bytes of an image. `open` reads a companion file.
    #[doc(hidden)]
    pub fn image(&self, image: &Value, open: &dyn Fn(&Path) -> Result<Vec<u8>>) -> Option<Vec<u8>> {
        if let Some(uri) = image["uri"].as_str() {
            return contents_of(uri, "", open).ok().map(Into::into);
        }
        let view = self
            .list("bufferViews")
            .get(usize::try_from(image["bufferView"].as_u64()?).ok()?)?;
        self.view(view).map(<[u8]>::to_vec)
    }
}

fn items<'a>(json: &'a Value, name: &str) -> &'a [Value] {
    json[name].as_array().map_or(&[][..], Vec::as_slice)
}
