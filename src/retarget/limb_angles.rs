//! The angle of each limb between two skeletons, tick by tick.

use mocap_figure::LimbAngles;
use mocap_figure::ticks::ticks;
use mocap_scene::scene::{Animation, Scene};

use super::{PoseRetargeter, measure};

impl PoseRetargeter {
    /// For each tick of the source: the angle between each limb in `animation` and the same limb in `moved`.
    /// `animation` belongs to the scene `source`, and `moved` to the scene `target`. [`PoseRetargeter::measure`]
    /// reports the mean and the largest angle.
    pub fn limb_angles(
        &self,
        source: &Scene,
        animation: &Animation,
        target: &Scene,
        moved: &Animation,
    ) -> Vec<LimbAngles> {
        let ticks = ticks(animation);
        let moved = self.in_rig(target, moved);
        let (from, to) = self.moving(source, animation, self.skeleton(target), &moved);
        let angles = measure::angles(&from.track(&ticks, None), &to.track(&ticks, None));
        let limbs = angles.into_iter().filter_map(|(bone, degrees)| {
            let node = self.target.joint(bone)?;
            let node = self.rig.as_deref().map_or(node, |(rig, _)| rig.node_of_file(node));
            Some(LimbAngles { bone, node, degrees })
        });
        limbs.collect()
    }
}
