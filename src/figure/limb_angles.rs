//! Stores the angles between the limbs of two skeletons.

use mocap_scene::scene::{HumanoidBone, NodeId};

/// The angle between the directions of a limb in two skeletons, at each tick.
///
/// `PoseRetargeter` has an example.
#[derive(Clone, Debug, PartialEq)]
pub struct LimbAngles {
    /// The bone of the limb.
    pub bone: HumanoidBone,
    /// The joint of the target at which the limb begins.
    pub node: NodeId,
    /// The angle at each tick, in degrees.
    pub degrees: Vec<f32>,
}
