//! Removes invalid indices from a file that is passed through.
//!
//! mocap reads only a part of such a file. Other programs reject a file with an invalid index, or fail when they use
//! the index. mocap removes the smallest optional member that contains the index. In lists that are indexed, a
//! placeholder replaces the removed item.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};

use mocap_scene::error::{Code, Diagnostic, Result};
use serde_json::{Value, json};

use super::super::invalid::invalid;
use super::super::json::{self, MAGIC};
use super::glb::Glb;
use super::indices::Done::{self, Broken, Hidden, Out, StandIn, White};
use super::indices::{INDICES, MAY_BE_NEGATIVE, NO_IMAGE};
use crate::warnings::Warnings;

/// The file without invalid indices, with a warning for each. A file without invalid indices stays unchanged. Bytes
/// that are not JSON stay unchanged too, and the reader reports them.
pub(in super::super) fn without(bytes: &[u8]) -> Result<(Cow<'_, [u8]>, Vec<Diagnostic>)> {
    let (text, bin) = json::split(bytes)?;
    let Ok(json @ Value::Object(_)) = serde_json::from_slice::<Value>(text) else {
        return Ok((bytes.into(), Vec::new()));
    };
    let mut file = File {
        json,
        broken: BTreeMap::new(),
        warnings: Warnings::default(),
    };
    file.mend();
    let warnings = file.warnings.into_kept();
    if warnings.is_empty() {
        return Ok((bytes.into(), warnings));
    }
    let text = file.json.to_string().into_bytes();
    if !bytes.starts_with(MAGIC) {
        return Ok((text.into(), warnings));
    }
    let glb = Glb::new(text, bin.map(<[u8]>::len), json::further_chunks(bytes)?)?;
    Ok((glb.around(bin.unwrap_or_default()).into(), warnings))
}

/// The path of a value: keys and indices.
type JsonPath = Vec<String>;

struct File {
    json: Value,
    /// For each list, the indices of the items that a repair has replaced or emptied. References to these items count
    /// as invalid.
    broken: BTreeMap<&'static str, BTreeSet<usize>>,
    warnings: Warnings,
}

impl File {
    fn mend(&mut self) {
        for &(pattern, list, done) in INDICES {
            if pattern.starts_with("nodes/*/mesh") {
                self.empty_meshes();
            }
            let pattern: Vec<&str> = pattern.split('/').collect();
            let mut found = Vec::new();
            matching(&self.json, &pattern, &mut Vec::new(), &mut found);
            found.retain(|path| self.is_dangling(path, list));
            for path in &found {
                self.warn(path, list, done);
            }
            // From the last to the first, so that earlier indices stay valid. An item with several faults is removed
            // once.
            if let Out(levels) = done {
                found.iter_mut().for_each(|path| path.truncate(path.len() - levels));
                found.dedup();
            }
            for path in found.iter().rev() {
                self.take_out(path, done);
            }
        }
        self.samplers_of_animations();
        self.pointers_of_animations();
    }

    /// The length of a list in the file.
    fn length(&self, list: &str) -> usize {
        let list = self.json.pointer(&format!("/{list}"));
        list.and_then(Value::as_array).map_or(0, Vec::len)
    }

    fn is_dangling(&self, path: &JsonPath, list: &str) -> bool {
        let value = self.json.pointer(&pointer(path));
        let may_be_negative = path.join("/").starts_with(MAY_BE_NEGATIVE);
        match value {
            None | Some(Value::Null) => false,
            Some(value) if may_be_negative && value.as_i64().is_some_and(|number| number < 0) => false,
            Some(value) => index_of(value).is_none_or(|index| {
                let is_broken = self.broken.get(list).is_some_and(|broken| broken.contains(&index));
                index >= self.length(list) || is_broken
            }),
        }
    }

    /// Warns about a fault and its repair.
    fn warn(&mut self, path: &JsonPath, list: &'static str, done: Done) {
        let owner = match self.json.pointer(&pointer(&path[..2.min(path.len())])) {
            Some(Value::Object(item)) => item.get("name").and_then(Value::as_str),
            _ => None,
        };
        let what = singular(list);
        let owner = owner.map_or_else(String::new, |name| format!("{} \"{name}\": ", singular(&path[0])));
        let gone = match done {
            Out(levels) => format!("{} is left out", path[..path.len() - levels].join("/")),
            Broken | White => format!("the elements that refer to {} are left out", path[..2].join("/")),
            StandIn(_) => format!("{} is empty", path[..2].join("/")),
            Hidden => format!("{} shows nothing", path[..2].join("/")),
        };
        let value = self.json.pointer(&pointer(path)).unwrap_or(&Value::Null);
        let count = self.length(list);
        let is_there = index_of(value).is_some_and(|index| index < count);
        let condition = "if mocap writes the file as glTF";
        let message = match is_there {
            // A consequence of another fault is reported once.
            true => format!("{what} {value} is not valid, so the elements that refer to it are left out {condition}"),
            false => format!("{owner}there is no {what} {value}, so {gone} {condition}"),
        };
        let mut warning = invalid(pointer(path), message);
        if !is_there {
            warning = warning.expected_found(format!("an index below {count}"), value.to_string());
        }
        self.warnings.distinct(warning);
    }

    /// Repairs the invalid index at `path`.
    fn take_out(&mut self, path: &JsonPath, done: Done) {
        match done {
            Out(_) => remove(&mut self.json, path),
            Broken => {
                self.mark(path);
                remove(&mut self.json, path);
            }
            White => {
                self.mark(path);
                let image = self.append("images", serde_json::from_str(NO_IMAGE).unwrap_or_default());
                if let Some(source) = self.json.pointer_mut(&pointer(path)) {
                    *source = image.into();
                }
            }
            StandIn(item) => {
                self.mark(path);
                if let Some(value) = self.json.pointer_mut(&pointer(&path[..2])) {
                    *value = serde_json::from_str(item).unwrap_or_default();
                }
            }
            Hidden => {
                // Without a mesh the node would be a joint.
                let primitives = self.nothing();
                let mesh = self.append("meshes", json!({ "primitives": primitives }));
                if let Some(Value::Object(node)) = self.json.pointer_mut(&pointer(&path[..2])) {
                    node.insert("mesh".to_owned(), mesh.into());
                    node.remove("skin");
                    node.remove("weights");
                }
            }
        }
    }

    /// Marks the item that contains `path` as invalid.
    fn mark(&mut self, path: &JsonPath) {
        let list = INDICES.iter().map(|(_, list, _)| *list).find(|list| *list == path[0]);
        if let (Some(list), Ok(index)) = (list, path[1].parse()) {
            self.broken.entry(list).or_default().insert(index);
        }
    }

    /// Adds a triangle without area to meshes that have lost all primitives, because a mesh must have one.
    fn empty_meshes(&mut self) {
        let meshes = self.json["meshes"].as_array().map_or(&[][..], Vec::as_slice);
        let is_empty = |mesh: &Value| mesh.is_object() && mesh.get("primitives").is_none();
        let empty: BTreeSet<usize> = (0..meshes.len()).filter(|mesh| is_empty(&meshes[*mesh])).collect();
        if empty.is_empty() || !self.warnings.has(Code::InvalidGltf) {
            return;
        }
        let primitives = self.nothing();
        for &mesh in &empty {
            self.json["meshes"][mesh]["primitives"] = primitives.clone();
        }
        self.broken.insert("meshes", empty);
    }

    /// Primitives of an invisible mesh.
    fn nothing(&mut self) -> Value {
        let corners = json!({"componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [0, 0, 0]});
        let corners = self.append("accessors", corners);
        json!([{"attributes": {"POSITION": corners}}])
    }

    /// Appends an item to a list of the file, and returns its index.
    fn append(&mut self, list: &str, item: Value) -> usize {
        match self.json[list].as_array_mut() {
            Some(items) => items.push(item),
            None => self.json[list] = json!([item]),
        }
        self.length(list) - 1
    }

    /// Checks the samplers of animations. The reader has already checked the samplers of joint channels.
    fn samplers_of_animations(&mut self) {
        for animation in 0..self.length("animations") {
            let at: JsonPath = ["animations", &animation.to_string(), "samplers"]
                .map(str::to_owned)
                .to_vec();
            let mut found = Vec::new();
            let pattern = ["animations", at[1].as_str(), "samplers", "*", "*put"];
            matching(&self.json, &pattern, &mut Vec::new(), &mut found);
            found.retain(|path| self.is_dangling(path, "accessors"));
            let dead: BTreeSet<String> = found.iter().map(|path| path[3].clone()).collect();
            for path in &found {
                self.warn(path, "accessors", Out(1));
            }
            let samplers = self.json.pointer(&pointer(&at)).and_then(Value::as_array);
            let mut sound = samplers.into_iter().flatten().enumerate();
            let sound = sound.find(|(index, _)| !dead.contains(&index.to_string()));
            let sound = sound.map_or(Value::Null, |(_, sampler)| sampler.clone());
            let channels = self.json.pointer_mut(&format!("/animations/{animation}/channels"));
            if let Some(channels) = channels.and_then(Value::as_array_mut) {
                channels.retain(|channel| !dead.contains(&channel["sampler"].to_string()));
            }
            for index in &dead {
                // Sampler indices do not change.
                let path = [&at[..], std::slice::from_ref(index)].concat();
                if let Some(sampler) = self.json.pointer_mut(&pointer(&path)) {
                    *sampler = sound.clone();
                }
            }
        }
    }

    /// Checks KHR_animation_pointer channels whose pointer leads to a missing list item.
    fn pointers_of_animations(&mut self) {
        let pattern = "animations/*/channels/*/target/extensions/KHR_animation_pointer/pointer";
        let pattern: Vec<&str> = pattern.split('/').collect();
        let mut found = Vec::new();
        matching(&self.json, &pattern, &mut Vec::new(), &mut found);
        // From the last to the first, so that earlier indices stay valid.
        for path in found.iter().rev() {
            let target = self.json.pointer(&pointer(path)).and_then(Value::as_str);
            let Some(target) = target.filter(|target| !self.leads_to_an_item(target)) else {
                continue;
            };
            let message = format!(
                "there is no {target}, so {} is left out if mocap writes the file as glTF",
                path[..4].join("/")
            );
            self.warnings.distinct(invalid(pointer(path), message));
            let channels = self.json.pointer_mut(&pointer(&path[..3]));
            if let (Some(channels), Ok(channel)) = (channels.and_then(Value::as_array_mut), path[3].parse()) {
                let _: Value = channels.remove(channel);
            }
        }
    }

    /// Whether the first list in a pointer has the item. Members of the item are not checked, because members have
    /// defaults.
    fn leads_to_an_item(&self, target: &str) -> bool {
        let is_number = |part: &str| part.parse::<usize>().is_ok();
        let parts: Vec<&str> = target.split('/').collect();
        parts
            .iter()
            .position(|part| is_number(part))
            .is_none_or(|item| self.json.pointer(&parts[..=item].join("/")).is_some())
    }
}

/// All values that match a pattern.
fn matching(value: &Value, pattern: &[&str], at: &mut JsonPath, found: &mut Vec<JsonPath>) {
    let Some((first, rest)) = pattern.split_first() else {
        found.push(at.clone());
        return;
    };
    if *first == "**" {
        matching(value, rest, at, found);
    }
    let deeper = if *first == "**" { pattern } else { rest };
    let mut follow = |name: String, member: &Value| {
        if is_match(first, &name) {
            at.push(name);
            matching(member, deeper, at, found);
            at.pop();
        }
    };
    match value {
        Value::Object(members) if first.contains('*') => {
            members.iter().for_each(|(name, member)| follow(name.clone(), member));
        }
        Value::Object(members) => {
            if let Some(member) = members.get(*first) {
                follow((*first).to_owned(), member);
            }
        }
        Value::Array(items) if first.contains('*') => {
            let items = items.iter().enumerate();
            items.for_each(|(index, item)| follow(index.to_string(), item));
        }
        Value::Array(items) => {
            if let Some(item) = first.parse().ok().and_then(|index: usize| items.get(index)) {
                follow((*first).to_owned(), item);
            }
        }
        _ => {}
    }
}

/// Whether a name matches a segment of a pattern.
fn is_match(pattern: &str, name: &str) -> bool {
    match pattern.split_once('*') {
        Some((_, "*")) => true,
        Some((start, end)) => name.starts_with(start) && name.ends_with(end),
        None => pattern == name,
    }
}

/// Removes a value from its object or array. Also removes a list that becomes empty.
fn remove(json: &mut Value, path: &[String]) {
    let Some((last, above)) = path.split_last() else {
        return;
    };
    let parent = json.pointer_mut(&pointer(above));
    let is_empty = match parent {
        Some(Value::Object(members)) => {
            members.remove(last);
            false
        }
        Some(Value::Array(items)) => {
            if let Some(index) = last.parse().ok().filter(|index: &usize| *index < items.len()) {
                items.remove(index);
            }
            items.is_empty()
        }
        _ => false,
    };
    if is_empty {
        remove(json, above);
    }
}

fn pointer(path: &[String]) -> String {
    let escaped = path
        .iter()
        .map(|part| format!("/{}", part.replace('~', "~0").replace('/', "~1")));
    escaped.collect()
}

fn index_of(value: &Value) -> Option<usize> {
    value.as_u64().and_then(|number| usize::try_from(number).ok())
}

/// The singular noun for an item of a list.
fn singular(list: &str) -> &str {
    match list {
        "bufferViews" => "buffer view",
        "meshes" => "mesh",
        _ => {
            let name = list.rsplit('/').next().unwrap_or(list);
            name.strip_suffix('s').unwrap_or(name)
        }
    }
}
