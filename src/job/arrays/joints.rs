//! Selects the nodes of the arrays, and finds the parent and the offset of each.

use glam::{Mat4, Vec3};
use mocap_scene::error::Result;
use mocap_scene::pose::Pose;
use mocap_scene::scene::{NodeId, NodeKind, RotationOrder, Scene};
use regex_lite::Regex;
use serde::Serialize;

use crate::arrays::{ArrayOptions, unknown_option};

/// A joint or an end site of the output.
///
/// [`Arrays::of`](crate::arrays::Arrays::of) has an example.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Joint {
    /// The name as in the file. Names may repeat.
    pub name: String,
    /// The nearest ancestor in the output, as an index into its joints.
    pub parent: Option<usize>,
    /// The offset from the parent in the rest pose, in the parent's axes and the unit of the output. For a joint
    /// without a parent, the offset from the origin, in the file's axes.
    pub offset: Vec3,
    /// Whether the node is an end site, which the file does not animate.
    pub end_site: bool,
    /// The order of the joint's Euler angles in the file, if it has one.
    pub rotation_order: Option<RotationOrder>,
}

/// The nodes of the output.
pub(super) struct Selection {
    pub(super) nodes: Vec<NodeId>,
    pub(super) joints: Vec<Joint>,
    /// For each node, the root of its chain. The root need not be in the output.
    pub(super) roots: Vec<NodeId>,
}

/// Compiles a regular expression of the caller.
pub(super) fn pattern(pattern: &str) -> Result<Regex> {
    Regex::new(pattern).map_err(|error| {
        let message = "the pattern for joint names is not a regular expression";
        unknown_option(message, "a regular expression", format!("{pattern:?}: {error}"))
    })
}

impl Selection {
    pub(super) fn new(scene: &Scene, options: &ArrayOptions, scale: f32) -> Result<Self> {
        let wanted = options.joints.as_deref().map(pattern).transpose()?;
        let is_wanted = |name: &str| wanted.as_ref().is_none_or(|wanted| wanted.is_match(name));
        let rest = Pose::rest(scene);
        let mut selection = Self {
            nodes: Vec::new(),
            joints: Vec::new(),
            roots: Vec::new(),
        };
        // Parents come before their children, so inherited values are known.
        let mut listed_above: Vec<Option<usize>> = Vec::with_capacity(scene.nodes.len());
        let mut roots: Vec<Option<NodeId>> = Vec::with_capacity(scene.nodes.len());
        for (index, node) in scene.nodes.iter().enumerate() {
            let id = NodeId::new(index);
            let above = node.parent.map(NodeId::index);
            let parent = above.and_then(|above| listed_above.get(above).copied().flatten());
            let root = above.and_then(|above| roots.get(above).copied().flatten());
            if node.kind == NodeKind::Group || !is_wanted(&node.name) {
                listed_above.push(parent);
            } else {
                listed_above.push(Some(selection.nodes.len()));
                selection.nodes.push(id);
                selection.roots.push(root.unwrap_or(id));
                let ancestor = parent.map(|parent| selection.nodes[parent]);
                let offset = to_ancestor(scene, &rest, id, ancestor).w_axis.truncate() * scale;
                selection.joints.push(Joint {
                    name: node.name.clone(),
                    parent,
                    offset,
                    end_site: node.kind == NodeKind::EndSite,
                    rotation_order: node.rotation_order,
                });
            }
            roots.push(root.or((node.kind != NodeKind::Group).then_some(id)));
        }
        match (&options.joints, selection.nodes.is_empty()) {
            (Some(pattern), true) => Err(unknown_option(
                "no joint's name matches the pattern",
                "a pattern that matches a joint's name",
                format!("{pattern:?}"),
            )),
            _ => Ok(selection),
        }
    }
}

/// The matrix from `node` to `ancestor`. If `ancestor` is `None`, to the world.
fn to_ancestor(scene: &Scene, pose: &Pose, node: NodeId, ancestor: Option<NodeId>) -> Mat4 {
    if ancestor.is_none() {
        return pose.node_to_world[node.index()];
    }
    let mut matrix = pose.node_to_parent[node.index()];
    let mut above = scene.nodes[node.index()].parent;
    while let Some(between) = above.filter(|_| above != ancestor) {
        matrix = pose.node_to_parent[between.index()] * matrix;
        above = scene.nodes[between.index()].parent;
    }
    matrix
}
