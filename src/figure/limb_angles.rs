//! The angle of each limb between two skeletons, tick by tick.

use mocap_scene::scene::{HumanoidBone, NodeId};

/// The angle between the directions of a limb in two skeletons, at each tick.
///
/// `PoseRetargeter` has an example.
#[derive(Clone, Debug, PartialEq)]
pub struct LimbAngles {
    /// The bone.
    pub bone: HumanoidBone,
    /// The joint of the target at which the limb begins.
    pub node: NodeId,
    /// The angle at each tick, in degrees.
    pub degrees: Vec<f32>,
}
