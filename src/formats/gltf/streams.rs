//! Reads compressed buffer views.

use std::borrow::Cow;
use std::collections::HashMap;

use serde::Deserialize;
use serde_json::{Map, Value};

use super::accessors::Budget;
use super::compression::{EXT, KHR};
use super::invalid::{invalid, missing};
use super::json::{Buffer, BufferView, Root};
use super::meshopt::{self, Filter};
use crate::Failure;

/// The description of a view's stream, equal in both extensions.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Settings {
    buffer: usize,
    #[serde(default)]
    byte_offset: usize,
    byte_length: usize,
    byte_stride: usize,
    count: usize,
    mode: String,
    #[serde(default)]
    filter: Option<String>,
}

/// The remedy for a stream that is not read.
const UNCOMPRESSED: &str = "write the file without compression: gltf-transform copy IN OUT";

/// The object of one of the two extensions in a buffer or a view.
fn settings(extensions: &Map<String, Value>) -> Option<(&'static str, &Value)> {
    [EXT, KHR]
        .into_iter()
        .find_map(|name| Some((name, extensions.get(name)?)))
}

/// The buffer with the stream of a view, if the view is compressed.
fn source(view: &BufferView) -> Option<usize> {
    let (_, settings) = settings(&view.extensions)?;
    settings.get("buffer")?.as_u64()?.try_into().ok()
}

/// The buffer from which a view is read: the buffer of its stream, if this build has the codec.
pub(super) fn buffer_of(view: &BufferView) -> usize {
    match source(view) {
        Some(stream) if cfg!(feature = "meshopt") => stream,
        _ => view.buffer,
    }
}

/// Whether a view is a stream.
pub(super) fn is_stream(view: &BufferView) -> bool {
    settings(&view.extensions).is_some()
}

/// Whether a buffer is a fallback without bytes.
pub(super) fn is_placeholder(index: usize, buffer: &Buffer) -> bool {
    let is_marked =
        settings(&buffer.extensions).is_some_and(|(_, settings)| settings.get("fallback") == Some(&true.into()));
    buffer.uri.is_none() && (is_marked || index > 0)
}

/// The stated bytes of the streams of `views`.
pub(super) fn length(root: &Root, views: &[usize]) -> u64 {
    let length = |view: &usize| {
        let (_, settings) = settings(&root.buffer_views.get(*view)?.extensions)?;
        settings.get("byteLength")?.as_u64()
    };
    views.iter().filter_map(length).fold(0, u64::saturating_add)
}

/// The bytes of the compressed views among `views`, by index.
pub(super) fn decode(
    root: &Root,
    views: &[usize],
    buffers: &[Option<Cow<'_, [u8]>>],
    budget: &Budget,
) -> Result<HashMap<usize, Vec<u8>>, Failure> {
    let mut decoded = HashMap::new();
    for &index in views {
        let Some(view) = root.buffer_views.get(index) else {
            continue;
        };
        let Some((extension, settings)) = settings(&view.extensions) else {
            continue;
        };
        // A build without the decoder uses the fallback of the file, if the file has a fallback.
        if cfg!(not(feature = "meshopt")) {
            let fallback = buffers.get(view.buffer).and_then(|buffer| buffer.as_deref());
            if fallback.is_some_and(|bytes| !bytes.is_empty()) {
                continue;
            }
            return Err(meshopt::missing().into());
        }
        let pointer = format!("/bufferViews/{index}/extensions/{extension}");
        let at = |field: &str| format!("{pointer}/{field}");
        let settings: Settings =
            serde_json::from_value(settings.clone()).map_err(|error| invalid(&*pointer, error.to_string()))?;
        let filter = match settings.filter.as_deref() {
            None | Some("NONE") => Filter::None,
            Some("QUATERNION") => Filter::Quaternion,
            Some("EXPONENTIAL") => Filter::Exponential,
            Some(other) => {
                return Err(invalid(at("filter"), "streams with this filter are not read")
                    .expected_found("NONE, QUATERNION or EXPONENTIAL", format!("\"{other}\""))
                    .help(UNCOMPRESSED)
                    .into());
            }
        };
        if settings.mode != "ATTRIBUTES" {
            return Err(invalid(at("mode"), "streams of this mode are not read")
                .expected_found("ATTRIBUTES", format!("\"{}\"", settings.mode))
                .help(UNCOMPRESSED)
                .into());
        }
        let buffer = buffers.get(settings.buffer).and_then(|buffer| buffer.as_deref());
        let buffer = buffer.ok_or_else(|| missing(at("buffer"), "buffer", settings.buffer, buffers.len()))?;
        let stream = settings
            .byte_offset
            .checked_add(settings.byte_length)
            .and_then(|end| buffer.get(settings.byte_offset..end))
            .ok_or_else(|| {
                invalid(at("byteLength"), "the stream reaches beyond its buffer").expected_found(
                    format!("at most {} bytes", buffer.len()),
                    format!("{} bytes from byte {}", settings.byte_length, settings.byte_offset),
                )
            })?;
        let claimed = (settings.count as u64).saturating_mul(settings.byte_stride as u64);
        if claimed != view.byte_length as u64 {
            return Err(
                invalid(at("count"), "the length of the elements differs from the view's")
                    .expected_found(
                        format!("{} bytes", view.byte_length),
                        format!("{} elements of {} bytes", settings.count, settings.byte_stride),
                    )
                    .into(),
            );
        }
        budget.take(claimed / 4, &at("count"))?;
        let bytes = meshopt::decode(stream, settings.count, settings.byte_stride, filter)
            .map_err(|error| error.at_pointer(&*pointer))?;
        decoded.insert(index, bytes);
    }
    Ok(decoded)
}
