//! The skeleton of a layer.

use std::collections::HashMap;

use glam::{DMat4, DQuat, DVec3, DVec4, Mat4};
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::limits::{is_plausible, limit_exceeded};
use mocap_scene::scene::{GROUP_OF_ROOTS, Node, NodeId, NodeKind};

use crate::depth_first::{depth_first, sorted};
use crate::usd::KINDS;
use crate::usd::parse::{Attribute, Layer, Prim, Value};
use crate::warnings::Warnings;
use crate::{Failure, ReadOptions};

/// The nodes of a skeleton.
pub(super) struct Skeleton {
    pub(super) nodes: Vec<Node>,
    /// The node of each joint, by its path.
    pub(super) joints: HashMap<String, usize>,
    /// The path of the animation that it is bound to.
    pub(super) source: Option<String>,
}

pub(super) fn read(layer: &Layer<'_>, options: &ReadOptions, warnings: &mut Warnings) -> Result<Skeleton, Failure> {
    let is_skeleton = |prim: &Prim| prim.kind == "Skeleton" && !texts(prim, "joints").is_empty();
    let mut skeletons = (0..layer.prims.len()).filter(|prim| is_skeleton(&layer.prims[*prim]));
    let refers = |prim: &&Prim| {
        ["references", "payload", "inherits"]
            .iter()
            .any(|key| prim.metadata.contains_key(*key))
    };
    let referring = layer.prims.iter().filter(refers).count();
    if referring > 0 || layer.metadata.contains_key("subLayers") {
        warnings.push(Code::MissingFile, || {
            let message = "the file refers to other layers, which are not read";
            Diagnostic::new(Code::MissingFile, message).help("make one layer of them, for example with usdcat")
        });
    }
    let Some(index) = skeletons.next() else {
        let message = "there is no Skeleton with joints in the file";
        let help = "export UsdSkel, not caches of vertices; where the skeleton is in another layer, make one of both with usdcat";
        return Err(Diagnostic::new(Code::InvalidUsd, message).help(help).into());
    };
    let others = skeletons.count();
    if others > 0 {
        warnings.push(Code::SeveralRoots, || {
            let message = format!("the first skeleton of {} was read", others + 1);
            Diagnostic::new(Code::SeveralRoots, message).help("export each in a file of its own")
        });
    }
    let prim = &layer.prims[index];
    let nodes = nodes(prim, options)?;
    let order = depth_first(&nodes);
    let mut skeleton = Skeleton {
        joints: joints(prim)
            .into_iter()
            .map(|(path, joint)| (path, order[joint]))
            .collect(),
        nodes: sorted(nodes, &order),
        source: bound_source(layer, index),
    };
    let placed = above(layer, index, warnings)?;
    let roots = skeleton.nodes.iter().filter(|node| node.parent.is_none()).count();
    if placed != DMat4::IDENTITY || roots > 1 {
        skeleton.put_below(
            match placed == DMat4::IDENTITY {
                true => GROUP_OF_ROOTS.to_owned(),
                false => layer.prims[prim.parent.unwrap_or(index)].name.clone(),
            },
            transform(placed).ok_or_else(|| {
                let message =
                    "the matrix of the prims above the skeleton is no transform: its last column must be 0 0 0 1";
                Diagnostic::new(Code::InvalidUsd, message)
            })?,
        );
    }
    Ok(skeleton)
}

/// The animation that is bound to a skeleton, or to a prim above it.
fn bound_source(layer: &Layer<'_>, skeleton: usize) -> Option<String> {
    let mut prim = Some(skeleton);
    while let Some(index) = prim {
        let own = texts(&layer.prims[index], "skel:animationSource");
        if let Some(source) = own.first() {
            return Some(source.clone());
        }
        prim = layer.prims[index].parent;
    }
    None
}

pub(super) fn texts<'a>(prim: &'a Prim, name: &str) -> &'a [String] {
    let value = prim.attributes.get(name).and_then(|attribute| attribute.value.as_ref());
    value.map_or(&[], |value| &value.texts)
}

fn joints(prim: &Prim) -> HashMap<String, usize> {
    let joints = texts(prim, "joints").iter().enumerate();
    joints.map(|(index, joint)| (joint.clone(), index)).collect()
}

fn nodes(prim: &Prim, options: &ReadOptions) -> Result<Vec<Node>, Failure> {
    let (paths, names, kinds) = (texts(prim, "joints"), texts(prim, "jointNames"), texts(prim, KINDS));
    let broken =
        |joint: &str, message: String| -> Failure { Diagnostic::new(Code::InvalidUsd, message).in_joint(joint).into() };
    let known = joints(prim);
    if known.len() != paths.len() {
        return Err(Diagnostic::new(Code::InvalidUsd, "a joint of the skeleton is named twice").into());
    }
    let mut depths: Vec<usize> = Vec::with_capacity(paths.len());
    let mut nodes: Vec<Node> = Vec::with_capacity(paths.len());
    for (index, path) in paths.iter().enumerate() {
        // The nearest joint above; a path may have names between that are no joints.
        let mut rest = path.as_str();
        let mut parent = None;
        while let Some((above, _)) = rest.rsplit_once('/') {
            rest = above;
            if let Some(found) = known.get(above) {
                parent = Some(*found);
                break;
            }
        }
        if parent.is_some_and(|parent| parent >= index) {
            return Err(broken(path, "a joint stands before the one above it".to_owned()));
        }
        let depth = parent.map_or(1, |parent| depths[parent] + 1);
        if depth > options.limits.max_depth {
            let most = format!("at most {} joints above each other", options.limits.max_depth);
            return Err(limit_exceeded(most, "more".to_owned()).into());
        }
        depths.push(depth);
        let last = path.rsplit('/').next().unwrap_or(path);
        let name = names
            .get(index)
            .filter(|_| names.len() == paths.len())
            .map_or(last, String::as_str);
        if name.len() > options.limits.max_name_bytes {
            let most = format!("at most {} bytes in a name", options.limits.max_name_bytes);
            return Err(limit_exceeded(most, name.len().to_string()).into());
        }
        nodes.push(Node {
            name: name.to_owned(),
            kind: match kinds.get(index).map(String::as_str) {
                Some("end_site") => NodeKind::EndSite,
                Some("group") => NodeKind::Group,
                _ => NodeKind::Joint,
            },
            parent: parent.map(NodeId::new),
            ..Node::default()
        });
    }
    set_transforms(prim, &mut nodes)?;
    Ok(nodes)
}

/// Sets the rest pose.
fn set_transforms(prim: &Prim, nodes: &mut [Node]) -> Result<(), Failure> {
    let value = |name: &str| prim.attributes.get(name).and_then(|attribute| attribute.value.as_ref());
    let (matrices, is_local) = match (value("restTransforms"), value("bindTransforms")) {
        (Some(rest), _) if !rest.numbers.is_empty() => (rest, true),
        (_, Some(bind)) if !bind.numbers.is_empty() => (bind, false),
        _ => {
            let message = "the skeleton has neither restTransforms nor bindTransforms";
            return Err(Diagnostic::new(Code::InvalidUsd, message).into());
        }
    };
    if matrices.numbers.len() != 16 * nodes.len() {
        let message = "a skeleton has a matrix of 16 numbers for each joint";
        let diagnostic = Diagnostic::new(Code::InvalidUsd, message);
        let expected = format!("{} numbers", 16 * nodes.len());
        return Err(diagnostic
            .expected_found(expected, matrices.numbers.len().to_string())
            .into());
    }
    let (rows, _) = matrices.numbers.as_chunks::<16>();
    let worlds: Vec<DMat4> = rows.iter().map(DMat4::from_cols_array).collect();
    for (index, world) in worlds.iter().enumerate() {
        let parent = nodes[index].parent.filter(|_| !is_local);
        let own = parent.map_or(*world, |parent| worlds[parent.index()].inverse() * *world);
        let is_sound = own.to_cols_array().into_iter().all(is_plausible);
        if !is_sound {
            let message = "the rest pose has a number that is too large to compute with, or no inverse";
            return Err(Diagnostic::new(Code::NumberRange, message)
                .in_joint(&nodes[index].name)
                .into());
        }
        nodes[index].transform = transform(own).ok_or_else(|| {
            let message = "a matrix of the rest pose is no transform: its last column must be 0 0 0 1";
            Diagnostic::new(Code::InvalidUsd, message).in_joint(&nodes[index].name)
        })?;
    }
    Ok(())
}

/// A matrix of 32 bits, where its last row is 0 0 0 1 up to rounding.
fn transform(matrix: DMat4) -> Option<Mat4> {
    /// The fraction of a number that products and inverses in 64 bits leave of it.
    const ROUNDING: f64 = 1e-9;
    let is_affine = matrix.row(3).abs_diff_eq(DVec4::W, ROUNDING);
    is_affine.then(|| {
        let mut matrix = matrix.as_mat4();
        for (column, last) in [0.0, 0.0, 0.0, 1.0].into_iter().enumerate() {
            matrix.col_mut(column).w = last;
        }
        matrix
    })
}

impl Skeleton {
    /// Puts a group above the roots.
    fn put_below(&mut self, name: String, transform: Mat4) {
        for node in &mut self.nodes {
            node.parent = Some(node.parent.map_or(NodeId(0), |parent| NodeId(parent.0 + 1)));
        }
        let group = Node {
            name,
            kind: NodeKind::Group,
            transform,
            ..Node::default()
        };
        self.nodes.insert(0, group);
        self.joints.values_mut().for_each(|joint| *joint += 1);
    }
}

/// The transform of the prims above a skeleton, and its own.
fn above(layer: &Layer<'_>, skeleton: usize, warnings: &mut Warnings) -> Result<DMat4, Failure> {
    let mut whole = DMat4::IDENTITY;
    let mut next = Some(skeleton);
    while let Some(index) = next {
        let prim = &layer.prims[index];
        let mut own = DMat4::IDENTITY;
        next = prim.parent;
        for name in texts(prim, "xformOpOrder") {
            if name == "!resetXformStack!" {
                // The prims above do not set_transforms this one.
                next = None;
                continue;
            }
            let found = prim.attributes.get(name);
            if found.is_some_and(|attribute| attribute.samples.len() > 1) {
                warnings.push(Code::IgnoredChannel, || {
                    let message = format!(
                        "{}: {name} is animated; only its first value was read",
                        layer.path(index)
                    );
                    Diagnostic::new(Code::IgnoredChannel, message).help("put the motion on the root joint")
                });
            }
            match found.and_then(first).and_then(|value| operation(name, value)) {
                Some(operation) => own *= operation,
                None => warnings.push(Code::IgnoredChannel, || {
                    let message = format!("{}: {name} was not read", layer.path(index));
                    Diagnostic::new(Code::IgnoredChannel, message)
                }),
            }
        }
        whole = own * whole;
    }
    match whole.to_cols_array().into_iter().all(is_plausible) {
        true => Ok(whole),
        false => {
            let message = "the transform above the skeleton has a number that is too large to compute with";
            Err(Diagnostic::new(Code::NumberRange, message).into())
        }
    }
}

fn first(attribute: &Attribute) -> Option<&Value> {
    attribute
        .value
        .as_ref()
        .or(attribute.samples.first().map(|(_, value)| value))
}

/// The matrix of a transform operation; `None` for one that is not known.
fn operation(name: &str, value: &Value) -> Option<DMat4> {
    let numbers = value.numbers.as_slice();
    let (name, is_inverse) = match name.strip_prefix("!invert!") {
        Some(name) => (name, true),
        None => (name, false),
    };
    let kind = name.strip_prefix("xformOp:")?.split(':').next()?;
    let vector = || numbers.first_chunk::<3>().map(|numbers| DVec3::from_array(*numbers));
    let about = |axis: u8, degrees: f64| match axis {
        b'X' => Some(DMat4::from_rotation_x(degrees.to_radians())),
        b'Y' => Some(DMat4::from_rotation_y(degrees.to_radians())),
        b'Z' => Some(DMat4::from_rotation_z(degrees.to_radians())),
        _ => None,
    };
    // The axes stay; the first that is named turns first.
    let turned = |axes: &str| {
        let mut matrix = DMat4::IDENTITY;
        for axis in axes.bytes() {
            // One angle of one axis; else the angles of X, Y and Z.
            let index = if axes.len() == 1 {
                0
            } else {
                usize::from(axis.checked_sub(b'X')?)
            };
            matrix = about(axis, *numbers.get(index)?)? * matrix;
        }
        Some(matrix)
    };
    let matrix = match kind {
        "transform" => DMat4::from_cols_array(numbers.first_chunk::<16>()?),
        "translate" => DMat4::from_translation(vector()?),
        "scale" => DMat4::from_scale(vector()?),
        "orient" => {
            let [w, x, y, z] = *numbers.first_chunk::<4>()?;
            let rotation = DQuat::from_xyzw(x, y, z, w);
            (rotation.length_squared() > f64::EPSILON).then(|| DMat4::from_quat(rotation.normalize()))?
        }
        _ => turned(kind.strip_prefix("rotate")?)?,
    };
    Some(if is_inverse { matrix.inverse() } else { matrix })
}
