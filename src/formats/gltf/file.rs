//! A glTF file in memory: its nodes, and the bytes that its animations need.

use std::borrow::Cow;
use std::collections::{BTreeSet, HashMap, HashSet};
use std::path::{Path, PathBuf};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::{Mat4, Quat, Vec3, Vec4};
use mocap_scene::error::{Diagnostic, Result};
use mocap_scene::files::percent_decoded;
use mocap_scene::limits::{self, FARTHEST, Limits, SMALLEST_SCALE, is_degenerate_scale, limit_exceeded};
use mocap_scene::math::quaternion::unit;
use mocap_scene::scene::{Face, Format, NodeId};

use super::accessors::{self, Budget, Bytes};
use super::invalid::{invalid, missing};
use super::json::{self, Root};
use super::{humanoid, required, streams};
use crate::named_file::below;
use crate::provenance::Provenance;
use crate::{Failure, FormatInfo};

/// A glTF file with the buffers that animations need.
#[doc(hidden)]
pub struct File<'a> {
    pub(super) root: Root,
    pub(super) bytes: Bytes<'a>,
    /// Warnings about data that the reader does not need.
    pub(super) warnings: Vec<Diagnostic>,
    limits: Limits,
}

/// A node of the default scene.
#[derive(Clone, Copy)]
#[doc(hidden)]
pub struct SceneNode {
    /// The index in the file.
    #[doc(hidden)]
    pub index: usize,
    /// The index of the parent in the list of scene nodes.
    #[doc(hidden)]
    pub parent: Option<usize>,
}

/// The transform of a node relative to its parent.
#[derive(Clone, Copy)]
#[doc(hidden)]
pub struct Transform {
    #[doc(hidden)]
    pub translation: Vec3,
    #[doc(hidden)]
    pub rotation: Quat,
    #[doc(hidden)]
    pub scale: Vec3,
    /// The product of translation, rotation and scale, or the matrix of the file, which may have shear.
    #[doc(hidden)]
    pub matrix: Mat4,
}

/// A node of the scene, and its transform in the file.
pub(super) struct NodePlace {
    pub(super) id: NodeId,
    pub(super) transform: Transform,
}

impl<'a> File<'a> {
    /// A `.glb` begins with its magic number. A `.gltf` is a JSON object with a member `asset`.
    #[doc(hidden)]
    pub fn sniff(bytes: &[u8]) -> bool {
        super::sniff(bytes)
    }

    /// The table row of the format.
    #[doc(hidden)]
    pub fn row(&self) -> &'static FormatInfo {
        FormatInfo::of(Format::Gltf)
    }

    /// Reads `.glb` or `.gltf`. `open` reads a buffer in a separate file.
    #[doc(hidden)]
    pub fn read(bytes: &'a [u8], open: &dyn Fn(&Path) -> Result<Vec<u8>>, limits: &Limits) -> Result<Self> {
        let (root, bin) = json::parse(bytes)?;
        let warnings = required::check(&root.extensions_required)?;
        let views = views_of_animations(&root);
        let mut wanted = BTreeSet::new();
        for view in views.iter().filter_map(|&view| root.buffer_views.get(view)) {
            // If the stream of a view is read, the fallback of the view is not read.
            wanted.insert(streams::buffer_of(view));
        }
        let mut buffers: Vec<Option<Cow<'a, [u8]>>> = Vec::new();
        buffers.resize_with(root.buffers.len(), || None);
        let mut size = bytes.len() as u64;
        for index in wanted.into_iter().filter(|&index| index < root.buffers.len()) {
            buffers[index] = buffer(&root, bin, index, open)?;
            if let Some(Cow::Owned(contents)) = &buffers[index] {
                size += contents.len() as u64;
            }
        }
        let budget = Budget::new(limits, size, streams::length(&root, &views).min(size));
        let mut views = streams::decode(&root, &views, &buffers, &budget)?;
        // Bind poses are read if possible.
        let of_skins = views_of_skins(&root);
        for view in of_skins.iter().filter_map(|&view| root.buffer_views.get(view)) {
            let index = streams::buffer_of(view);
            if buffers.get(index).is_some_and(Option::is_none) {
                buffers[index] = buffer(&root, bin, index, open).ok().flatten();
            }
        }
        views.extend(streams::decode(&root, &of_skins, &buffers, &budget).unwrap_or_default());
        Ok(Self {
            root,
            bytes: Bytes { buffers, views, budget },
            warnings,
            limits: *limits,
        })
    }

    /// The provenance that this crate wrote; absent in files of other programs.
    #[doc(hidden)]
    pub fn provenance(&self) -> Option<Provenance> {
        provenance_in(self.root.asset.extras.as_ref())
    }

    /// Removes the provenances of the file and of its animations.
    #[doc(hidden)]
    pub fn forget_provenance(&mut self) {
        self.root.asset.extras = None;
        for animation in &mut self.root.animations {
            animation.extras = None;
        }
    }

    /// The provenances of the animations that this crate added to a character file.
    #[doc(hidden)]
    pub fn provenances_of_animations(&self) -> impl Iterator<Item = Provenance> {
        let animations = self.root.animations.iter();
        animations.filter_map(|animation| provenance_in(animation.extras.as_ref()))
    }

    /// The provenance of the first animation that this crate changed in a file with kept meshes. Animations that this
    /// crate added to another program's character do not count.
    #[doc(hidden)]
    pub fn provenance_of_kept(&self) -> Option<Provenance> {
        self.provenances_of_animations()
            .find(|provenance| provenance.onto().is_none())
    }

    /// The provenance of an animation that this crate added to the file; absent for animations of other programs.
    pub(crate) fn provenance_of(&self, animation: usize) -> Option<Provenance> {
        provenance_in(self.root.animations.get(animation)?.extras.as_ref())
    }

    /// The name of a node in the scene from which this crate wrote the file. In files of other programs: the name of
    /// the node in the file.
    #[doc(hidden)]
    pub fn source_name(&self, node: usize) -> String {
        let node = &self.root.nodes[node];
        let source_name = node.extra("source_name").and_then(serde_json::Value::as_str);
        source_name.or(node.name.as_deref()).unwrap_or_default().to_owned()
    }

    /// The bones that VRM requires, but that the file does not state.
    #[doc(hidden)]
    pub fn missing_bones(&self) -> Vec<&'static str> {
        humanoid::missing(&self.root.extensions)
    }

    /// The face roles of nodes in a VRM animation, by node index.
    #[doc(hidden)]
    pub fn faces(&self) -> HashMap<usize, Face> {
        let stated = humanoid::stated_faces(&self.root.extensions).into_iter().rev();
        stated.filter_map(|(face, node, _)| Some((node?, face))).collect()
    }

    /// Whether a node is marked as an end site.
    #[doc(hidden)]
    pub fn is_end_site(&self, node: usize) -> bool {
        self.root.nodes[node].extra("end_site") == Some(&serde_json::Value::Bool(true))
    }

    /// Whether a node holds something visible.
    #[doc(hidden)]
    pub fn shows(&self, node: usize) -> bool {
        let node = &self.root.nodes[node];
        node.mesh.is_some() || node.camera.is_some()
    }

    /// The nodes that only show something, in a file with skins: they have no children and no motion, and are not
    /// joints. A scene omits these nodes, so their transforms are not computed.
    ///
    /// # Errors
    /// A skin or an animation names a node that does not exist.
    #[doc(hidden)]
    pub fn only_show(&self) -> Result<HashSet<usize>, Failure> {
        let mut used: HashSet<usize> = self.joints()?.into_iter().collect();
        if used.is_empty() {
            return Ok(used);
        }
        used.extend(self.moved()?);
        let only_shows = |node: &usize| !used.contains(node) && self.shows(*node) && !self.has_children(*node);
        Ok((0..self.root.nodes.len()).filter(only_shows).collect())
    }

    /// Whether the file has a skin, which binds a mesh to its joints.
    #[doc(hidden)]
    pub fn has_skin(&self) -> bool {
        !self.root.skins.is_empty()
    }

    /// Whether a node has children.
    pub(super) fn has_children(&self, node: usize) -> bool {
        !self.root.nodes[node].children.is_empty()
    }

    /// The joints of all skins.
    ///
    /// # Errors
    /// A joint is not a node.
    pub(super) fn joints(&self) -> Result<Vec<usize>, Failure> {
        let count = self.root.nodes.len();
        let mut joints = Vec::new();
        for (skin, json) in self.root.skins.iter().enumerate() {
            for (slot, &joint) in json.joints.iter().enumerate() {
                if joint >= count {
                    return Err(missing(format!("/skins/{skin}/joints/{slot}"), "node", joint, count).into());
                }
                joints.push(joint);
            }
        }
        Ok(joints)
    }

    /// The numbers of a matrix accessor, 16 each; `None` if they cannot be read.
    pub(super) fn matrices(&self, accessor: usize) -> Option<Vec<f32>> {
        accessors::numbers(&self.root, &self.bytes, accessor, 16, "").ok()
    }

    /// The nodes of the default scene, or all nodes of a file without scenes. Parents come before children.
    ///
    /// # Errors
    /// A node has two parents or is its own ancestor, or the file has more nodes or levels than the limits allow.
    #[doc(hidden)]
    pub fn nodes(&self) -> Result<Vec<SceneNode>, Failure> {
        let Root { nodes, scenes, .. } = &self.root;
        let limits = &self.limits;
        if nodes.len() > limits.max_nodes {
            let expected = format!("at most {} nodes", limits.max_nodes);
            return Err(limit_exceeded(expected, format!("{}", nodes.len()))
                .at_pointer("/nodes")
                .into());
        }
        let (roots, at): (Cow<'_, [usize]>, String) = match self.root.scene.or((!scenes.is_empty()).then_some(0)) {
            Some(scene) => match scenes.get(scene) {
                Some(found) => (found.nodes.as_slice().into(), format!("/scenes/{scene}/nodes")),
                None => return Err(missing("/scene", "scene", scene, scenes.len()).into()),
            },
            None => {
                let mut is_child = vec![false; nodes.len()];
                for &child in nodes.iter().flat_map(|node| &node.children) {
                    if let Some(is_child) = is_child.get_mut(child) {
                        *is_child = true;
                    }
                }
                let roots: Vec<_> = (0..nodes.len()).filter(|&node| !is_child[node]).collect();
                (roots.into(), "/nodes".to_owned())
            }
        };
        let mut is_listed = vec![false; nodes.len()];
        let mut listed: Vec<SceneNode> = Vec::with_capacity(nodes.len());
        // An explicit list instead of recursion, so that no file can overflow the call stack. The last item is popped
        // first, so children are pushed in reverse.
        let mut open: Vec<(usize, Option<usize>, usize)> = roots.iter().rev().map(|&root| (root, None, 1)).collect();
        while let Some((index, parent, depth)) = open.pop() {
            let Some(node) = nodes.get(index) else {
                let at = parent.map_or(at, |parent| format!("/nodes/{}/children", listed[parent].index));
                return Err(missing(at, "node", index, nodes.len()).into());
            };
            let pointer = || format!("/nodes/{index}");
            if std::mem::replace(&mut is_listed[index], true) {
                return Err(invalid(pointer(), "the node has more than one parent, or is its own parent").into());
            }
            if depth > limits.max_depth {
                let expected = format!("at most {} nodes below one another", limits.max_depth);
                return Err(limit_exceeded(expected, "more".to_owned()).at_pointer(pointer()).into());
            }
            if let Some(name) = node.name.as_ref().filter(|name| name.len() > limits.max_name_bytes) {
                let expected = format!("at most {} bytes in a name", limits.max_name_bytes);
                return Err(limit_exceeded(expected, format!("{} bytes", name.len()))
                    .at_pointer(format!("/nodes/{index}/name"))
                    .into());
            }
            let position = listed.len();
            listed.push(SceneNode { index, parent });
            open.extend(
                node.children
                    .iter()
                    .rev()
                    .map(|&child| (child, Some(position), depth + 1)),
            );
        }
        Ok(listed)
    }

    /// The transform of a node without animation.
    ///
    /// # Errors
    /// A number is not finite, or larger than any position.
    #[doc(hidden)]
    pub fn transform(&self, index: usize) -> Result<Transform, Failure> {
        let node = &self.root.nodes[index];
        let check = |field: &str, numbers: &[f32]| -> Result<(), Failure> {
            match numbers.iter().find(|number| !is_plausible(**number)) {
                None => Ok(()),
                Some(number) => Err(implausible(format!("/nodes/{index}/{field}"), *number).into()),
            }
        };
        if let Some(columns) = &node.matrix {
            check("matrix", columns)?;
            let matrix = Mat4::from_cols_array(columns);
            if matrix.row(3) != Vec4::W {
                return Err(invalid(format!("/nodes/{index}/matrix"), "the matrix is not affine")
                    .expected_found("a last row of 0 0 0 1", format!("{}", matrix.row(3)))
                    .into());
            }
            // In double precision: with shear in the axes, rounding would choose between two rotations.
            let (scale, rotation, translation) = matrix.as_dmat4().to_scale_rotation_translation();
            let (scale, translation) = (scale.as_vec3(), translation.as_vec3());
            return Ok(Transform {
                translation,
                rotation: unit(rotation.as_quat()).unwrap_or_default(),
                scale: if scale.is_finite() { scale } else { Vec3::ONE },
                matrix,
            });
        }
        let translation = node.translation.unwrap_or_default();
        let rotation = node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
        let scale = node.scale.unwrap_or([1.0; 3]);
        check("translation", &translation)?;
        check("rotation", &rotation)?;
        check("scale", &scale)?;
        if let Some(number) = scale.iter().find(|number| is_degenerate(**number)) {
            return Err(degenerate(format!("/nodes/{index}/scale"), *number).into());
        }
        let (translation, scale) = (Vec3::from(translation), Vec3::from(scale));
        let rotation = unit(Quat::from_array(rotation)).unwrap_or_default();
        Ok(Transform {
            translation,
            rotation,
            scale,
            matrix: Mat4::from_scale_rotation_translation(scale, rotation, translation),
        })
    }
}

/// The extras of an animation without the data that this crate wrote; null if nothing remains.
pub(super) fn own_extras(extras: Option<&serde_json::Value>) -> serde_json::Value {
    match extras {
        Some(serde_json::Value::Object(members)) => {
            let mut own = members.clone();
            own.remove("mocap");
            if own.is_empty() {
                serde_json::Value::Null
            } else {
                own.into()
            }
        }
        Some(other) => other.clone(),
        None => serde_json::Value::Null,
    }
}

/// The provenance that this crate wrote into the extras of an object.
fn provenance_in(extras: Option<&serde_json::Value>) -> Option<Provenance> {
    // Parsed from text, because all other provenance is also read from text.
    serde_json::from_str(&extras?.get("mocap")?.to_string()).ok()
}

/// Whether kinematics can square and add a number.
pub(super) fn is_plausible(number: f32) -> bool {
    limits::is_plausible(number.into())
}

/// Whether a scale is not 0, but too small to have an inverse.
pub(super) fn is_degenerate(scale: f32) -> bool {
    is_degenerate_scale(scale.into())
}

pub(super) fn implausible(pointer: String, number: f32) -> Diagnostic {
    invalid(pointer, "a number is not finite, or too large to compute with")
        .expected_found(format!("at most {FARTHEST:e}"), format!("{number}"))
        .help("repair the number, or export the file again")
}

pub(super) fn degenerate(pointer: String, scale: f32) -> Diagnostic {
    invalid(pointer, "a scale is too small to compute with")
        .expected_found(format!("0, or at least {SMALLEST_SCALE:e}"), format!("{scale:e}"))
        .help("to hide an object, set its scale to 0")
}

/// The views that animations read, in ascending order. Invalid indices are reported where they are used.
fn views_of_animations(root: &Root) -> Vec<usize> {
    let mut views = BTreeSet::new();
    let samplers = root.animations.iter().flat_map(|animation| &animation.samplers);
    for accessor in samplers.flat_map(|sampler| [sampler.input, sampler.output]) {
        let Some(accessor) = root.accessors.get(accessor) else {
            continue;
        };
        views.extend(accessor.buffer_view);
        if let Some(sparse) = &accessor.sparse {
            views.extend([sparse.indices.buffer_view, sparse.values.buffer_view]);
        }
    }
    views.into_iter().collect()
}

/// The views of the inverse bind matrices in a file with motion.
fn views_of_skins(root: &Root) -> Vec<usize> {
    let skins = root.skins.iter().filter(|_| !root.animations.is_empty());
    let accessors = skins.filter_map(|skin| root.accessors.get(skin.inverse_bind_matrices?));
    let views: BTreeSet<usize> = accessors.filter_map(|accessor| accessor.buffer_view).collect();
    views.into_iter().collect()
}

/// The contents of a buffer; `None` for a fallback without bytes.
pub(super) fn buffer<'a>(
    root: &Root,
    bin: Option<&'a [u8]>,
    index: usize,
    open: &dyn Fn(&Path) -> Result<Vec<u8>>,
) -> Result<Option<Cow<'a, [u8]>>> {
    let buffer = &root.buffers[index];
    let pointer = format!("/buffers/{index}");
    let contents = match &buffer.uri {
        Some(uri) => contents_of(uri, &pointer, open)?,
        None if index == 0 && bin.is_some() => Cow::Borrowed(bin.unwrap_or_default()),
        None if streams::is_placeholder(index, buffer) => return Ok(None),
        None => return Err(invalid(pointer, "the buffer has neither a uri nor a binary chunk").into()),
    };
    if contents.len() < buffer.byte_length {
        let (claimed, found) = (
            format!("{} bytes", buffer.byte_length),
            format!("{} bytes", contents.len()),
        );
        return Err(
            invalid(format!("{pointer}/byteLength"), "the buffer is shorter than stated")
                .expected_found(claimed, found)
                .into(),
        );
    }
    Ok(Some(contents))
}

/// The contents of a URI: embedded data, or a companion file.
pub(super) fn contents_of<'a>(
    uri: &str,
    pointer: &str,
    open: &dyn Fn(&Path) -> Result<Vec<u8>>,
) -> Result<Cow<'a, [u8]>> {
    let pointer = || format!("{pointer}/uri");
    let Some(data) = uri.strip_prefix("data:") else {
        return Ok(open(&beside(uri, &pointer())?)?.into());
    };
    let (kind, data) = data
        .split_once(',')
        .ok_or_else(|| invalid(pointer(), "the data URI has no comma before its data"))?;
    if !kind.ends_with(";base64") {
        return Err(invalid(pointer(), "a data URI must be base64")
            .expected_found("a type that ends in ;base64", format!("\"{kind}\""))
            .into());
    }
    let decoded = STANDARD.decode(data.trim_ascii());
    Ok(decoded
        .map_err(|error| invalid(pointer(), format!("the data URI is not base64: {error}")))?
        .into())
}

/// The path of a relative URI, in the same folder or a subfolder. Other paths are refused, so that an input cannot read
/// other files.
fn beside(uri: &str, pointer: &str) -> Result<PathBuf, Failure> {
    below(percent_decoded(uri)).ok_or_else(|| {
        let message = "a buffer must be in the folder of the file, or in a subfolder";
        invalid(pointer, message)
            .expected_found("a relative path without \"..\"", format!("\"{uri}\""))
            .help("put the buffer into the folder of the file, or write a .glb")
            .into()
    })
}
