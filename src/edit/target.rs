//! The target of a limb or of the gaze: a point of the world, or a node.

use std::fmt;

use glam::{Mat4, Vec3};
use serde::{Deserialize, Serialize};

use mocap_figure::HumanoidBone;
use mocap_figure::names::node_named;
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::pose::Pose;
use mocap_scene::scene::{NodeId, Scene};

/// The target of a hand, a foot or the gaze.
///
/// [`Reach`](crate::Reach) has an example.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged)]
#[non_exhaustive]
pub enum ReachTarget {
    /// A point of the world in metres, along the axes of the scene.
    Point([f64; 3]),
    /// The name of a node of the scene, or of a bone, such as `rightHand` or `right-hand`. The node may move or not.
    Node(String),
}

impl fmt::Display for ReachTarget {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Point([x, y, z]) => write!(f, "{x}/{y}/{z}"),
            Self::Node(name) => f.write_str(name),
        }
    }
}

/// A target, resolved in the scene.
#[derive(Clone, Copy, Debug)]
pub(super) enum TargetJoint {
    /// A point of the world, in units of the scene.
    Point(Vec3),
    Node(NodeId),
}

impl TargetJoint {
    /// Converts an offset from the target, in metres along its axes, to units of the scene.
    pub(super) fn offset(self, metres: [f64; 3], metres_per_unit: f64) -> Result<Vec3> {
        point(metres, metres_per_unit)
    }

    /// The transform from the coordinate frame of the target to the world.
    pub(super) fn to_world(self, pose: &Pose) -> Mat4 {
        match self {
            Self::Point(point) => Mat4::from_translation(point),
            Self::Node(node) => pose.node_to_world[node.index()],
        }
    }
}

impl ReachTarget {
    /// Finds the target in a scene. Refuses a node that is one of `moved` or below one of them, because this node would
    /// move with the limb.
    pub(super) fn find(
        &self,
        scene: &Scene,
        joint: impl Fn(HumanoidBone) -> Option<NodeId>,
        metres_per_unit: f64,
        moved: &[NodeId],
    ) -> Result<TargetJoint> {
        let name = match self {
            Self::Point(at) => return point(*at, metres_per_unit).map(TargetJoint::Point),
            Self::Node(name) => name,
        };
        let node = node_named(scene, name, joint)?;
        match moved
            .iter()
            .find(|moved| node == **moved || is_below(scene, node, **moved))
        {
            Some(moved) => {
                let moved = &scene.nodes[moved.index()].name;
                let message = format!(
                    "{name:?} cannot be the target: it moves together with {moved:?}, the joint that the step brings \
                     to the target"
                );
                Err(Diagnostic::new(Code::InvalidValue, message).into())
            }
            None => Ok(TargetJoint::Node(node)),
        }
    }
}

/// Converts a point in metres to units of the scene.
fn point(at: [f64; 3], metres_per_unit: f64) -> Result<Vec3> {
    let point = Vec3::from(at.map(|metres| (metres / metres_per_unit) as f32));
    match point.is_finite() {
        true => Ok(point),
        false => {
            let message = format!("a point must have three finite lengths in metres, got {at:?}");
            Err(Diagnostic::new(Code::InvalidValue, message).into())
        }
    }
}

/// Whether a node is below another in the hierarchy.
pub(super) fn is_below(scene: &Scene, node: NodeId, ancestor: NodeId) -> bool {
    let parent = |node: &NodeId| scene.nodes[node.index()].parent;
    std::iter::successors(parent(&node), parent).any(|above| above == ancestor)
}
