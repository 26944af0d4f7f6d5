//! Writes the skeleton: all nodes of a scene as joints.

use glam::DMat4;
use mocap_scene::error::Result;
use mocap_scene::limits::is_plausible;
use mocap_scene::scene::{NodeId, NodeKind, Scene};

use super::names::Names;
use super::text::{self, Text};
use super::{ROOT, SKELETON, unrepresentable};
use crate::usd::KINDS;

pub(super) struct Skeleton {
    /// The path of each joint: identifiers, starting with the root joint.
    pub(super) joints: Vec<String>,
    /// The rest matrix from each joint to the skeleton.
    pub(super) rest: Vec<DMat4>,
    /// The bind matrices, if a mesh or an ancestor joint states them.
    pub(super) bind: Vec<Option<DMat4>>,
}

impl Skeleton {
    pub(super) fn new(scene: &Scene) -> Result<Self> {
        let mut names = Names::default();
        let mut joints: Vec<String> = Vec::with_capacity(scene.nodes.len());
        let mut rest: Vec<DMat4> = Vec::with_capacity(scene.nodes.len());
        for node in &scene.nodes {
            let own = node.transform.to_cols_array();
            if !own.into_iter().all(|number| is_plausible(number.into())) {
                return Err(unrepresentable(
                    &node.name,
                    "the rest pose is not finite, or too large to compute with",
                ));
            }
            let instead = match node.kind {
                NodeKind::EndSite => "EndSite",
                NodeKind::Group => "Group",
                _ => "Joint",
            };
            let name = names.unique(&node.name, instead);
            let own = node.transform.as_dmat4();
            match node.parent.map(NodeId::index) {
                Some(parent) => {
                    joints.push(format!("{}/{name}", joints[parent]));
                    rest.push(rest[parent] * own);
                }
                None => {
                    joints.push(name);
                    rest.push(own);
                }
            }
        }
        let bind = vec![None; joints.len()];
        Ok(Self { joints, rest, bind })
    }

    /// The bind matrix, or the rest matrix if no mesh is bound.
    pub(super) fn bound(&self, joint: usize) -> DMat4 {
        self.bind[joint].unwrap_or(self.rest[joint])
    }

    pub(super) fn write(&self, scene: &Scene, clip: Option<&String>, out: &mut Text) {
        out.open("def Skeleton", SKELETON, &["prepend apiSchemas = [\"SkelBindingAPI\"]"]);
        let token = |out: &mut String, token: &str| out.push_str(&text::quoted(token));
        out.list("uniform token[] joints", self.joints.iter().map(String::as_str), token);
        let names = scene.nodes.iter().map(|node| node.name.as_str());
        out.list("uniform token[] jointNames", names, token);
        let kinds = scene.nodes.iter().map(|node| match node.kind {
            NodeKind::EndSite => "end_site",
            NodeKind::Group => "group",
            _ => "joint",
        });
        out.list(&format!("custom uniform token[] {KINDS}"), kinds, token);
        let bind = (0..self.joints.len()).map(|joint| self.bound(joint));
        out.list("uniform matrix4d[] bindTransforms", bind, text::matrix);
        let rest = scene.nodes.iter().map(|node| node.transform.as_dmat4());
        out.list("uniform matrix4d[] restTransforms", rest, text::matrix);
        if let Some(clip) = clip {
            out.line(&format!("rel skel:animationSource = </{ROOT}/{clip}>"));
        }
        out.close();
    }
}
