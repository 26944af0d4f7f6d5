//! The angle of each limb between two skeletons, tick by tick.

use super::{Retargeter, measure};
use crate::figure::ticks::ticks;
use crate::scene::{Animation, HumanoidBone, NodeId, Scene};

/// How far the directions of a limb are apart at each tick.
///
/// [`Retargeter`](crate::retarget::Retargeter) has an example.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct LimbAngles {
    /// The bone.
    pub bone: HumanoidBone,
    /// The joint of the target that the limb starts from.
    pub node: NodeId,
    /// The angle at each tick, in degrees.
    pub degrees: Vec<f32>,
}

impl Retargeter {
    /// The angles of which [`Retargeter::measure`] tells the mean and the largest: between the limbs of `animation`, of
    /// the scene `source`, and those of `moved`, of the scene `target`, at each tick of the source.
    pub fn limb_angles(
        &self,
        source: &Scene,
        animation: &Animation,
        target: &Scene,
        moved: &Animation,
    ) -> Vec<LimbAngles> {
        let ticks = ticks(animation);
        let (from, to) = self.moving(source, animation, target, moved);
        let angles = measure::angles(&from.track(&ticks, None), &to.track(&ticks, None));
        let limbs = angles.into_iter().filter_map(|(bone, degrees)| {
            let node = self.target.joint(bone)?;
            Some(LimbAngles { bone, node, degrees })
        });
        limbs.collect()
    }
}
