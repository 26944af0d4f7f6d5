//! Checks that an output keeps the contents of the glTF file to which animations were added: meshes, skins, materials,
//! textures, morph targets and extensions, as JSON and byte by byte.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Component, Path, PathBuf};

use glam::{DMat4, DQuat, DVec3};
use mocap_formats::gltf::RawFile;
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::files::percent_decoded;
use mocap_scene::scene::OriginalFile;
use serde_json::Value;

use super::{Finding, FindingKind};

/// Sections that are compared item by item, or not at all. The writer rewrites animations, which changes the indices in
/// these sections.
const BY_ITEM: [&str; 9] = [
    "accessors",
    "animations",
    "bufferViews",
    "buffers",
    "extensionsRequired",
    "extensionsUsed",
    "images",
    "nodes",
    "scenes",
];

/// Extensions of a buffer view whose bytes are in a compressed stream.
const STREAMS: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

/// The largest relative error of a value in a node's matrix. An animated node stores its matrix as translation,
/// rotation and scale.
const ROUNDED: f64 = 1e-5;

/// A file, and the bytes of its images.
pub(super) struct Parts {
    raw: RawFile,
    images: Vec<Option<Vec<u8>>>,
}

impl Parts {
    pub(super) fn read(bytes: &[u8], open: &dyn Fn(&Path) -> Result<Vec<u8>>) -> Result<Self> {
        let raw = RawFile::read(bytes, open)?;
        let images = raw.list("images").iter().map(|image| raw.image(image, open));
        let images = images.collect();
        Ok(Self { raw, images })
    }

    fn of_original(file: &OriginalFile) -> Result<Self> {
        let open = |path: &Path| {
            let is_it = |uri: &str| {
                let named = PathBuf::from(percent_decoded(uri));
                let parts = named.components().filter(|part| *part != Component::CurDir);
                parts.eq(path.components())
            };
            let beside = file.beside.iter().find(|(uri, _)| is_it(uri));
            let missing = || Diagnostic::new(Code::MissingFile, "the file beside the character is missing").into();
            beside.map(|(_, bytes)| bytes.clone()).ok_or_else(missing)
        };
        Self::read(&file.bytes, &open)
    }

    fn item(&self, section: &str, index: usize) -> Option<&Value> {
        self.raw.list(section).get(index)
    }
}

/// The animations of the character's file that may differ.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum AnimationChoice {
    /// All animations.
    All,
    /// The animation with this index.
    One(usize),
    /// None or all: animations were added, or replaced all animations.
    Added,
}

/// Finds contents of a character's file that are missing or different in an output.
///
/// # Errors
/// If the file of the character is broken.
pub(super) fn find(original: &OriginalFile, output: &Parts, changed: AnimationChoice) -> Result<Vec<Finding>> {
    let before = Parts::of_original(original)?;
    let mut found = Found::default();
    let both = Both {
        before: &before,
        after: output,
    };
    both.sections(&mut found);
    both.nodes(&mut found);
    both.images(&mut found);
    both.animations(changed, &mut found);
    both.numbers(&mut found);
    Ok(found.findings())
}

/// The differences, by kind.
#[derive(Default)]
struct Found(Vec<(FindingKind, Vec<String>)>);

impl Found {
    fn add(&mut self, kind: FindingKind, what: impl Into<String>) {
        let what = what.into();
        match self.0.iter_mut().find(|(known, _)| *known == kind) {
            Some((_, all)) if all.contains(&what) => {}
            Some((_, all)) => all.push(what),
            None => self.0.push((kind, vec![what])),
        }
    }

    fn findings(self) -> Vec<Finding> {
        let finding = |(kind, all): (FindingKind, Vec<String>)| {
            let more = match all.len() {
                1 => String::new(),
                count => format!(", and {} more", count - 1),
            };
            let message = format!("differs from the file of the character: {}{more}", all[0]);
            Finding::new(kind, message)
        };
        self.0.into_iter().map(finding).collect()
    }
}

struct Both<'a> {
    before: &'a Parts,
    after: &'a Parts,
}

impl Both<'_> {
    /// Compares the sections that are passed through unchanged.
    fn sections(&self, found: &mut Found) {
        let (before, after) = (&self.before.raw.json, &self.after.raw.json);
        let keys = |json: &Value| -> BTreeSet<String> {
            json.as_object()
                .into_iter()
                .flatten()
                .map(|(key, _)| key.clone())
                .collect()
        };
        let all = &keys(before) | &keys(after);
        for key in all.iter().filter(|key| !BY_ITEM.contains(&key.as_str())) {
            let (before, after) = (&before[key], &after[key]);
            if before != after {
                found.add(kind_of(key), differing(key, before, after));
            }
        }
        for key in ["extensionsUsed", "extensionsRequired"] {
            let has = self.after.raw.list(key);
            let lost = self.before.raw.list(key).iter().find(|name| !has.contains(name));
            if let Some(lost) = lost {
                found.add(FindingKind::Character, format!("{key} lacks {lost}"));
            }
        }
    }

    /// Compares the nodes of the character. A node for root motion may follow them.
    fn nodes(&self, found: &mut Found) {
        let (before, after) = (self.before.raw.list("nodes"), self.after.raw.list("nodes"));
        for (index, node) in before.iter().enumerate() {
            let is_same = after.get(index).is_some_and(|other| {
                node == other || (without_transform(node) == without_transform(other) && is_near(node, other))
            });
            if !is_same {
                found.add(FindingKind::Character, labelled("node", index, node));
            }
        }
        let shows = |node: &&Value| ["mesh", "skin", "camera"].iter().any(|part| !node[part].is_null());
        if after.iter().skip(before.len()).any(|node| shows(&node)) {
            found.add(
                FindingKind::Character,
                "a node with a mesh, a skin or a camera was added",
            );
        }
        let below_added = |root: &Value| -> Vec<Value> {
            let added = root.as_u64().and_then(|root| after.get(usize::try_from(root).ok()?));
            let children = added.filter(|_| root.as_u64() >= Some(before.len() as u64));
            children
                .and_then(|node| node["children"].as_array())
                .cloned()
                .unwrap_or_else(|| vec![root.clone()])
        };
        let roots = |scenes: &[Value]| -> Vec<Value> {
            let scene = |scene: &Value| {
                let mut scene = scene.clone();
                if let Some(nodes) = scene.get_mut("nodes").and_then(Value::as_array_mut) {
                    *nodes = nodes.iter().flat_map(below_added).collect();
                }
                scene
            };
            scenes.iter().map(scene).collect()
        };
        let [before, after] = [self.before, self.after].map(|file| roots(file.raw.list("scenes")));
        if before != after {
            found.add(FindingKind::Character, "the list of scenes");
        }
    }

    fn images(&self, found: &mut Found) {
        let (before, after) = (self.before.raw.list("images"), self.after.raw.list("images"));
        for (index, image) in before.iter().enumerate() {
            // An image may be embedded or in a separate file.
            let rest = |image: &Value| without(image, &["uri", "bufferView", "mimeType"]);
            let is_same = after.get(index).is_some_and(|other| rest(image) == rest(other))
                && self.before.images[index] == self.after.images[index];
            if !is_same {
                found.add(FindingKind::Material, labelled("image", index, image));
            }
        }
    }

    /// Compares the animations of the character that no command has written.
    fn animations(&self, changed: AnimationChoice, found: &mut Found) {
        let (before, after) = (self.before.raw.list("animations"), self.after.raw.list("animations"));
        let is_same = |index: usize| after.get(index) == before.get(index);
        let stays = |index: usize| match changed {
            AnimationChoice::All => false,
            AnimationChoice::One(changed) => index != changed,
            AnimationChoice::Added => (0..before.len()).any(is_same),
        };
        for (index, animation) in before.iter().enumerate() {
            let is_ours = |other: &Value| !other["extras"]["mocap"].is_null();
            let may_differ = !stays(index) && after.get(index).is_none_or(is_ours);
            if !may_differ && !is_same(index) {
                found.add(FindingKind::MissingClip, labelled("animation", index, animation));
            }
        }
    }

    /// Compares accessors and buffer views, except those that only rewritten animations use.
    fn numbers(&self, found: &mut Found) {
        let users = users(&self.before.raw);
        let after = self.after.raw.list("animations");
        let (mut gone, mut stay) = (BTreeSet::new(), BTreeSet::new());
        for (index, animation) in self.before.raw.list("animations").iter().enumerate() {
            let samplers = animation["samplers"].as_array().into_iter().flatten();
            let numbers = samplers.flat_map(|sampler| [number(&sampler["input"]), number(&sampler["output"])]);
            match after.get(index) == Some(animation) {
                true => stay.extend(numbers.flatten()),
                false => gone.extend(numbers.flatten()),
            }
        }
        let is_gone = |index: &usize| gone.contains(index) && !stay.contains(index) && !users.contains_key(index);
        let other = |what: &str, index: usize| (FindingKind::Character, format!("{what} {index}"));
        // The user of every view, and the views that only rewritten animations use.
        let (mut of_view, mut of_gone) = (BTreeMap::new(), BTreeSet::new());
        for (index, accessor) in self.before.raw.list("accessors").iter().enumerate() {
            let places = ["/bufferView", "/sparse/indices/bufferView", "/sparse/values/bufferView"];
            let views = places.iter().filter_map(|place| number(accessor.pointer(place)?));
            if is_gone(&index) {
                of_gone.extend(views);
                continue;
            }
            let user = users.get(&index).cloned().unwrap_or_else(|| other("accessor", index));
            if self.after.item("accessors", index) != Some(accessor) {
                found.add(user.0, user.1.clone());
            }
            views.for_each(|view| {
                of_view.entry(view).or_insert_with(|| user.clone());
            });
        }
        for (index, image) in self.before.raw.list("images").iter().enumerate() {
            if let Some(view) = number(&image["bufferView"]) {
                of_view.insert(view, (FindingKind::Material, labelled("image", index, image)));
            }
        }
        for (index, view) in self.before.raw.list("bufferViews").iter().enumerate() {
            if of_gone.contains(&index) && !of_view.contains_key(&index) {
                continue;
            }
            let is_same = self.after.item("bufferViews", index).is_some_and(|other| {
                without_place(view) == without_place(other)
                    && self.before.raw.view(view) == self.after.raw.view(other)
                    && STREAMS.iter().all(|name| {
                        let [before, after] = [(self.before, view), (self.after, other)]
                            .map(|(file, view)| file.raw.view(&view["extensions"][name]));
                        before == after
                    })
            });
            if !is_same {
                let (kind, what) = of_view.remove(&index).unwrap_or_else(|| other("buffer view", index));
                found.add(kind, what);
            }
        }
    }
}

fn number(value: &Value) -> Option<usize> {
    value.as_u64().and_then(|number| usize::try_from(number).ok())
}

fn kind_of(section: &str) -> FindingKind {
    match section {
        "skins" => FindingKind::Skin,
        "meshes" => FindingKind::Mesh,
        "materials" | "textures" | "samplers" => FindingKind::Material,
        _ => FindingKind::Character,
    }
}

/// The first item of a section that differs.
fn differing(section: &str, before: &Value, after: &Value) -> String {
    let (Some(before), Some(after)) = (before.as_array(), after.as_array()) else {
        return section.to_owned();
    };
    let same = std::iter::zip(before, after)
        .take_while(|(before, after)| before == after)
        .count();
    let item = before.get(same).or(after.get(same)).unwrap_or(&Value::Null);
    labelled(section, same, item)
}

fn labelled(what: &str, index: usize, item: &Value) -> String {
    match item["name"].as_str() {
        Some(name) => format!("{what} {index}, \"{name}\""),
        None => format!("{what} {index}"),
    }
}

/// The purpose of each accessor of meshes and skins.
fn users(file: &RawFile) -> BTreeMap<usize, (FindingKind, String)> {
    let mut users = BTreeMap::new();
    for (index, mesh) in file.list("meshes").iter().enumerate() {
        let mesh_name = labelled("mesh", index, mesh);
        let primitives = mesh["primitives"].as_array().into_iter().flatten();
        for primitive in primitives {
            let targets = primitive["targets"].as_array().into_iter().flatten();
            let targets = targets.map(|target| (target, " of a morph target"));
            for (attributes, of) in std::iter::once((&primitive["attributes"], "")).chain(targets) {
                for (name, accessor) in attributes.as_object().into_iter().flatten() {
                    let what = format!("{name}{of} of {mesh_name}");
                    users.extend(number(accessor).map(|accessor| (accessor, (FindingKind::Mesh, what))));
                }
            }
            let what = format!("the faces of {mesh_name}");
            users.extend(number(&primitive["indices"]).map(|accessor| (accessor, (FindingKind::Mesh, what))));
        }
    }
    for (index, skin) in file.list("skins").iter().enumerate() {
        let what = format!("the inverse bind matrices of {}", labelled("skin", index, skin));
        users.extend(number(&skin["inverseBindMatrices"]).map(|accessor| (accessor, (FindingKind::Skin, what))));
    }
    users
}

fn without(value: &Value, keys: &[&str]) -> Value {
    let mut value = value.clone();
    if let Some(object) = value.as_object_mut() {
        object.retain(|key, _| !keys.contains(&key.as_str()));
    }
    value
}

fn without_transform(node: &Value) -> Value {
    without(node, &["matrix", "translation", "rotation", "scale"])
}

/// A buffer view, or the view of its compressed stream, without the location of its bytes.
fn without_place(view: &Value) -> Value {
    let place = ["buffer", "byteOffset"];
    let mut view = without(view, &place);
    for name in STREAMS {
        if let Some(stream) = view
            .get_mut("extensions")
            .and_then(|extensions| extensions.get_mut(name))
        {
            *stream = without(stream, &place);
        }
    }
    view
}

/// Whether two nodes have the same local matrix.
fn is_near(before: &Value, after: &Value) -> bool {
    let (before, after) = (local(before).to_cols_array(), local(after).to_cols_array());
    std::iter::zip(before, after).all(|(before, after)| (before - after).abs() <= ROUNDED * before.abs().max(1.0))
}

/// The matrix from a node to its parent.
fn local(node: &Value) -> DMat4 {
    let numbers = |key: &str| -> Vec<f64> {
        let numbers = node[key].as_array().into_iter().flatten();
        numbers.filter_map(Value::as_f64).collect()
    };
    if let Ok(columns) = numbers("matrix").try_into() {
        return DMat4::from_cols_array(&columns);
    }
    let rotation = numbers("rotation")
        .try_into()
        .map_or(DQuat::IDENTITY, DQuat::from_array);
    DMat4::from_scale_rotation_translation(
        numbers("scale").try_into().map_or(DVec3::ONE, DVec3::from_array),
        rotation.normalize(),
        numbers("translation").try_into().map_or(DVec3::ZERO, DVec3::from_array),
    )
}
