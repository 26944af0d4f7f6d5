//! Reads compressed buffer views.

use std::collections::HashMap;

use gltf::json::Root;
use gltf::{Document, buffer};
use serde::Deserialize;
use serde_json::{Map, Value};

use super::compression::{EXT, KHR};
use super::file::invalid;
use super::meshopt::{self, Filter};
use crate::error::Result;

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

/// The object of one of the two extensions, of a buffer or of a view.
fn settings(extensions: &Map<String, Value>) -> Option<&Value> {
    [EXT, KHR].into_iter().find_map(|name| extensions.get(name))
}

/// The document, validated except for extensions that this crate reads and the `gltf` crate does not know.
pub(super) fn known(mut root: Root) -> Result<Document> {
    let is_meshopt = |name: &String| name == EXT || name == KHR;
    if cfg!(not(feature = "meshopt")) && root.extensions_required.iter().any(is_meshopt) {
        return Err(meshopt::missing());
    }
    root.extensions_required.retain(|name| !is_meshopt(name));
    Document::from_json(root).map_err(|error| invalid(error.to_string()))
}

/// Whether a buffer is a fallback without bytes.
pub(super) fn is_placeholder(document: &Document, buffer: &buffer::Buffer) -> bool {
    let json = &document.as_json().buffers[buffer.index()];
    let settings = json.extensions.as_ref().and_then(|json| settings(&json.others));
    let is_marked = settings.is_some_and(|settings| settings.get("fallback") == Some(&true.into()));
    json.uri.is_none() && (is_marked || buffer.index() > 0)
}

/// The bytes of all compressed views that animations need, by their index.
pub(super) fn decode(document: &Document, buffers: &[Vec<u8>]) -> Result<HashMap<usize, Vec<u8>>> {
    let mut views = HashMap::new();
    let samplers = document.animations().flat_map(|animation| {
        let accessors = animation
            .samplers()
            .flat_map(|sampler| [sampler.input(), sampler.output()]);
        accessors.collect::<Vec<_>>()
    });
    for view in samplers.filter_map(|accessor| accessor.view()) {
        let json = &document.as_json().buffer_views[view.index()];
        let settings = json.extensions.as_ref().and_then(|json| settings(&json.others));
        let (Some(settings), false) = (settings, views.contains_key(&view.index())) else {
            continue;
        };
        // Without a decoder, use the fallback of the file, if it has one.
        if cfg!(not(feature = "meshopt")) && !buffers[view.buffer().index()].is_empty() {
            continue;
        }
        let broken = |what: &dyn std::fmt::Display| invalid(format!("view {}: {what}", view.index()));
        let settings: Settings = serde_json::from_value(settings.clone()).map_err(|error| broken(&error))?;
        let filter = match settings.filter.as_deref() {
            None | Some("NONE") => Filter::None,
            Some("QUATERNION") => Filter::Quaternion,
            Some("EXPONENTIAL") => Filter::Exponential,
            Some(_) => return Err(broken(&"its filter is not one for animations")),
        };
        if settings.mode != "ATTRIBUTES" {
            return Err(broken(&"its mode is not ATTRIBUTES, the mode for animations"));
        }
        let end = settings.byte_offset.checked_add(settings.byte_length);
        let stream = buffers
            .get(settings.buffer)
            .and_then(|bytes| bytes.get(settings.byte_offset..end?))
            .ok_or_else(|| broken(&"its stream reaches beyond its buffer"))?;
        let decoded = meshopt::decode(stream, settings.count, settings.byte_stride, filter)?;
        if decoded.len() != view.length() {
            return Err(broken(&"its length differs from the length of its elements"));
        }
        views.insert(view.index(), decoded);
    }
    Ok(views)
}
