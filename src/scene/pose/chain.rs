//! The separate matrices of a chain of joints.

use std::iter::successors;

use glam::{Mat4, Vec4};
use serde::{Serialize, Serializer};

use super::{Pose, Trs};
use crate::error::{Code, Diagnostic, Result, nearest};
use crate::math::rotation::to_euler;
use crate::scene::{NodeId, NodeKind, RotationOrder, Scene};

/// A matrix of the chain from the root to a joint, T = J0 L1 J1 L2 J2 ..., in the notation of animation courses.
///
/// A link L is the translation of a joint relative to its parent. A joint J is the rotation of a joint; J0 also has the
/// translation of the first joint. [`Pose::chain`] has an example.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ChainMatrix {
    /// `J0`, `L1`, `J1`, ...
    pub symbol: String,
    /// The name of the joint or end site.
    pub joint: String,
    /// The node of the joint or end site.
    #[cfg_attr(feature = "schema", schemars(with = "u32"))]
    pub node: NodeId,
    /// The matrix, for column vectors. `serde` writes its rows.
    #[serde(serialize_with = "rows")]
    #[cfg_attr(feature = "schema", schemars(with = "[[f64; 4]; 4]"))]
    pub matrix: Mat4,
    /// The product of the chain up to this matrix. The last product is the joint-to-world matrix.
    #[serde(serialize_with = "rows")]
    #[cfg_attr(feature = "schema", schemars(with = "[[f64; 4]; 4]"))]
    pub product: Mat4,
    /// The order of the angles of a J: `Zyx` is Rz Ry Rx. It is Z X Y if the file has no Euler angles.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub order: Option<RotationOrder>,
    /// The angles of a J in degrees, in this order. A positive angle rotates counter-clockwise for a viewer at whom the
    /// axis points (right-hand rule).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub degrees: Option<[f64; 3]>,
}

impl Pose {
    /// The matrices from the root to the node named `joint`. The pose must have been made from `scene`. A group counts
    /// as a joint if its transform is not the identity, or if it is the named node.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::Pose;
    /// use mocap::glam::Vec3;
    ///
    /// let scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
    /// let chain = Pose::at_tick(&scene, 0, 9.0).unwrap().chain(&scene, "Wrist")?;
    /// let symbols: Vec<&str> = chain.iter().map(|matrix| &*matrix.symbol).collect();
    /// assert_eq!(symbols, ["J0", "L1", "J1", "L2", "J2"]);
    /// assert!((chain[2].degrees.unwrap()[0] - 100.0).abs() < 1e-4);
    /// // A point at the tip of the hand.
    /// let tip = chain[4].product.transform_point3(Vec3::new(0.5, 0.0, 0.0));
    /// assert!(tip.abs_diff_eq(Vec3::new(0.66514, 2.07907, 0.0), 1e-5));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Code::InvalidValue`] if no node has this name.
    pub fn chain(&self, scene: &Scene, joint: &str) -> Result<Vec<ChainMatrix>> {
        let Some(end) = scene.find_node(joint) else {
            return Err(no_joint(scene, joint));
        };
        let parent = |node: &NodeId| scene.nodes[node.index()].parent;
        let is_part = |node: &NodeId| {
            let is_still = self.node_to_parent[node.index()] == Mat4::IDENTITY;
            *node == end || scene.nodes[node.index()].kind != NodeKind::Group || !is_still
        };
        let mut nodes: Vec<NodeId> = successors(Some(end), parent).filter(is_part).collect();
        nodes.reverse();
        let mut chain: Vec<ChainMatrix> = Vec::new();
        for (index, node) in nodes.into_iter().enumerate() {
            let (own, to_parent) = (&scene.nodes[node.index()], self.node_to_parent[node.index()]);
            let mut push = |letter: char, matrix: Mat4| {
                let product = chain.last().map_or(matrix, |before| before.product * matrix);
                chain.push(ChainMatrix {
                    symbol: format!("{letter}{index}"),
                    joint: own.name.clone(),
                    node,
                    matrix,
                    product,
                    order: None,
                    degrees: None,
                });
            };
            let mut rotation = to_parent;
            if index > 0 {
                push('L', Mat4::from_translation(to_parent.w_axis.truncate()));
                rotation.w_axis = Vec4::W;
            }
            if own.kind == NodeKind::EndSite && index > 0 {
                continue;
            }
            push('J', rotation);
            if let Some(last) = chain.last_mut() {
                let order = own.rotation_order.unwrap_or(RotationOrder::Zxy);
                let turn = Trs::from_matrix(rotation).rotation.as_dquat().normalize();
                last.order = Some(order);
                last.degrees = Some(to_euler(turn, order, [0.0; 3]));
            }
        }
        Ok(chain)
    }
}

fn no_joint(scene: &Scene, name: &str) -> crate::Error {
    let unknown = Diagnostic::new(Code::InvalidValue, format!("no joint is called {name:?}"));
    let names = scene.nodes.iter().map(|node| node.name.as_str());
    match nearest(name, names) {
        Some(near) => unknown.help(format!("did you mean {near:?}?")),
        None => unknown.help("`mocap dump FILE` prints the name of every joint"),
    }
    .into()
}

fn rows<S: Serializer>(matrix: &Mat4, serializer: S) -> std::result::Result<S::Ok, S::Error> {
    matrix.transpose().to_cols_array_2d().serialize(serializer)
}
