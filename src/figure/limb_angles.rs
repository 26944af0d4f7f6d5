//! The angle of each limb between two skeletons, tick by tick.

use mocap_scene::scene::{HumanoidBone, NodeId};

/// How far the directions of a limb are apart at each tick.
///
/// `PoseRetargeter` has an example.
#[derive(Clone, Debug, PartialEq)]
pub struct LimbAngles {
    /// The bone.
    pub bone: HumanoidBone,
    /// The joint of the target that the limb starts from.
    pub node: NodeId,
    /// The angle at each tick, in degrees.
    pub degrees: Vec<f32>,
}
