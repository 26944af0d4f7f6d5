//! The skeleton of a layer.

use std::collections::HashMap;

use glam::{DMat4, Mat4};
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::limits::{is_plausible, limit_exceeded};
use mocap_scene::scene::{GROUP_OF_ROOTS, Node, NodeId, NodeKind};

use super::above::{Placement, transform};
use crate::depth_first::{depth_first, sorted};
use crate::usd::KINDS;
use crate::usd::parse::{Layer, Prim};
use crate::warnings::Warnings;
use crate::{Failure, ReadOptions};

/// The nodes of a skeleton.
pub(super) struct Skeleton {
    /// The index of the skeleton's prim.
    pub(super) prim: usize,
    pub(super) nodes: Vec<Node>,
    /// The node of each joint, by path.
    pub(super) joints: HashMap<String, usize>,
    /// The path of the bound animation.
    pub(super) source: Option<String>,
    /// The transforms of the first node at time codes, if ancestor prims of the skeleton are animated.
    pub(super) path: Vec<(f64, Mat4)>,
}

pub(super) fn read(layer: &Layer<'_>, options: &ReadOptions, warnings: &mut Warnings) -> Result<Skeleton, Failure> {
    let is_skeleton = |prim: &Prim| prim.kind == "Skeleton" && !prim.texts("joints").is_empty();
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
            Diagnostic::new(Code::MissingFile, message).help("flatten them to one layer, for example with usdcat")
        });
    }
    let unselected = layer.unselected.first().map(|(prim, set)| {
        let path = layer.path(*prim);
        format!("{path} has variants of {set:?}, but the layer selects none")
    });
    let Some(index) = skeletons.next() else {
        if let Some(unselected) = unselected {
            let message = format!("there is no Skeleton with joints outside variants; {unselected}");
            let help =
                "select a variant, such as variants = { string NAME = \"VARIANT\" }, or flatten the layer with usdcat";
            return Err(Diagnostic::new(Code::InvalidUsd, message).help(help).into());
        }
        let message = "there is no Skeleton with joints in the file";
        let help = "export UsdSkel, not vertex caches; if the skeleton is in another layer, flatten both with usdcat";
        return Err(Diagnostic::new(Code::InvalidUsd, message).help(help).into());
    };
    if let Some(unselected) = unselected {
        warnings.push(Code::MissingFile, || {
            Diagnostic::new(Code::MissingFile, unselected).help("the contents of variants were not read")
        });
    }
    let others = skeletons.count();
    if others > 0 {
        warnings.push(Code::SeveralRoots, || {
            let message = format!("the first skeleton of {} was read", others + 1);
            Diagnostic::new(Code::SeveralRoots, message).help("export each in a separate file")
        });
    }
    let prim = &layer.prims[index];
    let nodes = nodes(prim, options)?;
    let order = depth_first(&nodes);
    let mut skeleton = Skeleton {
        prim: index,
        joints: joints(prim)
            .into_iter()
            .map(|(path, joint)| (path, order[joint]))
            .collect(),
        nodes: sorted(nodes, &order),
        source: bound_source(layer, index),
        path: Vec::new(),
    };
    let placement = Placement::of(layer, index, warnings);
    let placed = placement.at(None)?;
    let times = placement.times(options, layer.text.len())?;
    let is_placed = placed != Mat4::IDENTITY || !times.is_empty();
    let roots = skeleton.nodes.iter().filter(|node| node.parent.is_none()).count();
    if is_placed || roots > 1 {
        skeleton.put_below(
            match is_placed {
                true => layer.prims[prim.parent.unwrap_or(index)].name.clone(),
                false => GROUP_OF_ROOTS.to_owned(),
            },
            placed,
        );
    }
    if !times.is_empty() {
        skeleton.nodes[0].kind = NodeKind::Joint;
    }
    let path = times
        .into_iter()
        .map(|time| Ok::<_, Failure>((time, placement.at(Some(time))?)));
    skeleton.path = path.collect::<Result<_, _>>()?;
    Ok(skeleton)
}

/// The animation that is bound to a skeleton, or to an ancestor prim.
fn bound_source(layer: &Layer<'_>, skeleton: usize) -> Option<String> {
    let mut prim = Some(skeleton);
    while let Some(index) = prim {
        let own = layer.prims[index].texts("skel:animationSource");
        if let Some(source) = own.first() {
            return Some(source.clone());
        }
        prim = layer.prims[index].parent;
    }
    None
}

fn joints(prim: &Prim) -> HashMap<String, usize> {
    let joints = prim.texts("joints").iter().enumerate();
    joints.map(|(index, joint)| (joint.clone(), index)).collect()
}

fn nodes(prim: &Prim, options: &ReadOptions) -> Result<Vec<Node>, Failure> {
    let (paths, names, kinds) = (prim.texts("joints"), prim.texts("jointNames"), prim.texts(KINDS));
    let broken =
        |joint: &str, message: String| -> Failure { Diagnostic::new(Code::InvalidUsd, message).in_joint(joint).into() };
    let known = joints(prim);
    if known.len() != paths.len() {
        return Err(Diagnostic::new(Code::InvalidUsd, "a joint of the skeleton occurs twice").into());
    }
    let mut depths: Vec<usize> = Vec::with_capacity(paths.len());
    let mut nodes: Vec<Node> = Vec::with_capacity(paths.len());
    for (index, path) in paths.iter().enumerate() {
        // The nearest ancestor joint. A path may contain names that are not joints.
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
            return Err(broken(path, "a joint precedes its parent".to_owned()));
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
            let message = "a matrix of the rest pose is not a transform: its last column must be 0 0 0 1";
            Diagnostic::new(Code::InvalidUsd, message).in_joint(&nodes[index].name)
        })?;
    }
    Ok(())
}

impl Skeleton {
    /// Adds a group as the parent of the roots.
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
