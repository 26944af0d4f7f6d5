//! glTF: parses the JSON, changes it, and writes it with correct lengths of the container.

use fastrand::Rng;
use serde_json::{Map, Value, json};

use super::{float, number};

/// The size in bytes of the header of a `.glb` file together with the header of its first chunk.
const HEAD: usize = 20;

/// The number of nodes in the longest chain that is put into a file.
const LONGEST_CHAIN: usize = 3000;

/// The largest number of copies of a part of the file.
const MOST_COPIES: usize = 300;

pub(super) fn mutate(bytes: &[u8], random: &mut Rng) -> Option<Vec<u8>> {
    let is_glb = bytes.starts_with(b"glTF");
    let (mut json, mut bin) = match is_glb {
        true => take_apart(bytes)?,
        false => (serde_json::from_slice(bytes).ok()?, Vec::new()),
    };
    for _ in 0..random.usize(1..=4) {
        change(&mut json, &mut bin, random);
    }
    let text = serde_json::to_vec(&json).ok()?;
    Some(if is_glb { put_together(text, &bin) } else { text })
}

fn take_apart(bytes: &[u8]) -> Option<(Value, Vec<u8>)> {
    let length = u32::from_le_bytes(*bytes.get(12..16)?.first_chunk()?) as usize;
    let end = HEAD.checked_add(length)?;
    let json = serde_json::from_slice(bytes.get(HEAD..end)?).ok()?;
    Some((json, bytes.get(end + 8..).unwrap_or_default().to_vec()))
}

fn put_together(mut json: Vec<u8>, bin: &[u8]) -> Vec<u8> {
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend((HEAD + json.len() + 8 + bin.len()).to_le_bytes()[..4].iter());
    bytes.extend((json.len() as u32).to_le_bytes());
    bytes.extend(b"JSON");
    bytes.extend(&json);
    bytes.extend((bin.len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(bin);
    bytes
}

fn change(json: &mut Value, bin: &mut [u8], random: &mut Rng) {
    match random.u8(..16) {
        // Counts, strides, offsets, indices: any number of the file.
        0..=4 => change_number(json, random),
        5 => share_accessors(json, random),
        6 => copy_a_part(json, random),
        7 => join_nodes(json, random),
        8 => deepen(json, random),
        9 => make_sparse(json, random),
        10 => compress(json, random),
        11 => {
            let word = ["STEP", "LINEAR", "CUBICSPLINE", "SMOOTH"][random.usize(..4)];
            set_somewhere(json, "samplers", "interpolation", json!(word), random);
        }
        12 => {
            let (key, value) = [
                (
                    "componentType",
                    json!([5120, 5121, 5122, 5123, 5125, 5126, 1][random.usize(..7)]),
                ),
                (
                    "type",
                    json!(["SCALAR", "VEC2", "VEC3", "VEC4", "MAT4"][random.usize(..5)]),
                ),
                ("normalized", json!(random.bool())),
            ][random.usize(..3)]
            .clone();
            set_somewhere(json, "accessors", key, value, random);
        }
        13 => {
            let mut numbers = |count: usize| json!((0..count).map(|_| edge(random)).collect::<Vec<_>>());
            let places = [("translation", 3), ("rotation", 4), ("scale", 3), ("matrix", 16)];
            let made = places.map(|(key, count)| (key, numbers(count)));
            let (key, value) = made[random.usize(..4)].clone();
            set_somewhere(json, "nodes", key, value, random);
        }
        14 => {
            let stride = [0, 1, 2, 3, 4, 8, 12, 16, 252, 65_536][random.usize(..10)];
            set_somewhere(json, "bufferViews", "byteStride", json!(stride), random);
        }
        _ if bin.len() >= 4 => {
            let place = random.usize(..=bin.len() - 4) / 4 * 4;
            bin[place..place + 4].copy_from_slice(&float(random).to_le_bytes());
        }
        _ => remove_something(json, random),
    }
}

/// A number that JSON can represent.
fn edge(random: &mut Rng) -> f64 {
    let number = f64::from(float(random));
    if number.is_finite() { number } else { 1e39 }
}

/// The values below, in the order of the file.
fn leaves<'a>(value: &'a mut Value, is_wanted: &impl Fn(&Value) -> bool, found: &mut Vec<&'a mut Value>) {
    if is_wanted(value) {
        found.push(value);
        return;
    }
    match value {
        Value::Array(values) => values.iter_mut().for_each(|value| leaves(value, is_wanted, found)),
        Value::Object(values) => values.values_mut().for_each(|value| leaves(value, is_wanted, found)),
        _ => {}
    }
}

fn change_number(json: &mut Value, random: &mut Rng) {
    let mut numbers = Vec::new();
    leaves(json, &Value::is_number, &mut numbers);
    if numbers.is_empty() {
        return;
    }
    let chosen = random.usize(..numbers.len());
    let changed = match numbers[chosen].as_u64() {
        Some(now) if random.u8(..4) > 0 => json!(number(now, random)),
        _ => json!(edge(random)),
    };
    *numbers[chosen] = changed;
}

fn list<'a>(json: &'a mut Value, name: &str) -> Option<&'a mut Vec<Value>> {
    json.get_mut(name)?.as_array_mut().filter(|list| !list.is_empty())
}

/// One of the objects of a list, at any depth.
fn set_somewhere(json: &mut Value, name: &str, key: &str, value: Value, random: &mut Rng) {
    let mut lists = Vec::new();
    lists_of(json, name, &mut lists);
    let mut objects: Vec<&mut Map<String, Value>> = lists
        .into_iter()
        .flat_map(|list| list.iter_mut().filter_map(Value::as_object_mut))
        .collect();
    if !objects.is_empty() {
        let chosen = random.usize(..objects.len());
        objects[chosen].insert(key.to_owned(), value);
    }
}

fn lists_of<'a>(value: &'a mut Value, name: &str, found: &mut Vec<&'a mut Vec<Value>>) {
    match value {
        Value::Array(values) => values.iter_mut().for_each(|value| lists_of(value, name, found)),
        Value::Object(values) => {
            for (key, value) in values {
                if key != name || !value.is_array() {
                    lists_of(value, name, found);
                } else if let Value::Array(list) = value {
                    found.push(list);
                }
            }
        }
        _ => {}
    }
}

/// All samplers of the file read what one of them reads.
fn share_accessors(json: &mut Value, random: &mut Rng) {
    let mut lists = Vec::new();
    lists_of(json, "samplers", &mut lists);
    let mut samplers: Vec<&mut Value> = lists.into_iter().flatten().collect();
    if samplers.is_empty() {
        return;
    }
    let shared = samplers[random.usize(..samplers.len())].clone();
    for sampler in &mut samplers {
        for key in ["input", "output"] {
            if random.bool() {
                sampler[key] = shared[key].clone();
            }
        }
    }
}

/// Many copies of an animation, a channel, a view, an accessor or a node.
fn copy_a_part(json: &mut Value, random: &mut Rng) {
    let name = [
        "animations",
        "channels",
        "samplers",
        "nodes",
        "accessors",
        "bufferViews",
        "skins",
    ][random.usize(..7)];
    let copies = random.usize(1..=MOST_COPIES);
    let mut lists = Vec::new();
    lists_of(json, name, &mut lists);
    if !lists.is_empty() {
        let chosen = random.usize(..lists.len());
        let list = &mut lists[chosen];
        if let Some(part) = list.get(random.usize(..list.len().max(1))).cloned() {
            list.extend(std::iter::repeat_n(part, copies));
        }
    }
}

/// Adds a child to some node: the child of another node, an ancestor of the node, or the node itself.
fn join_nodes(json: &mut Value, random: &mut Rng) {
    let Some(nodes) = list(json, "nodes") else { return };
    let count = nodes.len();
    let (parent, child) = (random.usize(..count), random.usize(..=count));
    match nodes[parent].get_mut("children").and_then(Value::as_array_mut) {
        Some(children) => children.push(json!(child)),
        None => nodes[parent]["children"] = json!([child]),
    }
}

/// A long chain of nodes below one.
fn deepen(json: &mut Value, random: &mut Rng) {
    let length = random.usize(1..=LONGEST_CHAIN);
    let Some(nodes) = list(json, "nodes") else { return };
    let first = nodes.len();
    let parent = random.usize(..first);
    nodes[parent]["children"] = json!([first]);
    nodes.extend((0..length).map(|link| json!({ "translation": [0, 1, 0], "children": [first + link + 1] })));
    nodes.push(json!({}));
}

fn make_sparse(json: &mut Value, random: &mut Rng) {
    let Some(views) = list(json, "bufferViews").map(|views| views.len()) else {
        return;
    };
    let view = |random: &mut Rng| random.usize(..=views);
    let kind = [5121, 5123, 5125, 5126][random.usize(..4)];
    let sparse = json!({
        "count": number(2, random),
        "indices": { "bufferView": view(random), "byteOffset": random.u8(..8), "componentType": kind },
        "values": { "bufferView": view(random), "byteOffset": random.u8(..8) },
    });
    set_somewhere(json, "accessors", "sparse", sparse, random);
    if random.bool() {
        let mut lists = Vec::new();
        lists_of(json, "accessors", &mut lists);
        for accessor in lists.into_iter().flatten().filter_map(Value::as_object_mut) {
            if accessor.contains_key("sparse") {
                accessor.remove("bufferView");
            }
        }
    }
}

/// A view that claims to be compressed.
fn compress(json: &mut Value, random: &mut Rng) {
    let name = ["EXT_meshopt_compression", "KHR_meshopt_compression"][random.usize(..2)];
    let stride = [4, 8, 12, 16, 64][random.usize(..5)];
    let length = number(64, random);
    let mode = ["ATTRIBUTES", "TRIANGLES"][random.usize(..2)];
    let filter = ["NONE", "QUATERNION", "EXPONENTIAL", "OCTAHEDRAL"][random.usize(..4)];
    let settings = json!({
        "buffer": 0,
        "byteOffset": random.u16(..64),
        "byteLength": length,
        "byteStride": stride,
        "count": number(16, random),
        "mode": mode,
        "filter": filter,
    });
    let mut extensions = Map::new();
    extensions.insert(name.to_owned(), settings);
    set_somewhere(json, "bufferViews", "extensions", extensions.into(), random);
}

fn remove_something(json: &mut Value, random: &mut Rng) {
    let mut objects = Vec::new();
    objects_of(json, &mut objects);
    if !objects.is_empty() {
        let chosen = random.usize(..objects.len());
        let object = &mut objects[chosen];
        let keys: Vec<String> = object.keys().cloned().collect();
        if let Some(key) = keys.get(random.usize(..keys.len().max(1))) {
            match random.bool() {
                true => drop(object.remove(key)),
                false => drop(object.insert(
                    key.clone(),
                    [json!(null), json!([]), json!("a"), json!({})][random.usize(..4)].clone(),
                )),
            }
        }
    }
}

/// The objects at the ends of the tree: objects that contain no object.
fn objects_of<'a>(value: &'a mut Value, found: &mut Vec<&'a mut Map<String, Value>>) {
    match value {
        Value::Array(values) => values.iter_mut().for_each(|value| objects_of(value, found)),
        Value::Object(values) => {
            let is_inner = values.values().any(|value| value.is_object() || value.is_array());
            match is_inner {
                true => values.values_mut().for_each(|value| objects_of(value, found)),
                false => found.push(values),
            }
        }
        _ => {}
    }
}
