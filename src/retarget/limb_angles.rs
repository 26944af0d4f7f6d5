//! The angle of each limb between two skeletons, tick by tick.

use glam::Vec3;

use super::body::{Body, limb_end};
use super::{Retargeter, ticks};
use crate::pose::{Binding, Pose};
use crate::scene::{Animation, HumanoidBone, NodeId, Scene};

/// How far the directions of a limb are apart at each tick.
#[derive(Clone, Debug, PartialEq)]
pub struct LimbAngles {
    /// The bone.
    pub bone: HumanoidBone,
    /// The joint of the target that the limb starts from.
    pub node: NodeId,
    /// The angle at each tick, in degrees.
    pub degrees: Vec<f32>,
}

impl Retargeter {
    /// The angles of which [`Retargeter::measure`] tells the mean and the largest: between the limbs of `animation`, of the
    /// scene `source`, and those of `moved`, of the scene `target`, at each tick of the source.
    pub fn limb_angles(
        &self,
        source: &Scene,
        animation: &Animation,
        target: &Scene,
        moved: &Animation,
    ) -> Vec<LimbAngles> {
        let limbs = HumanoidBone::ALL.iter().filter_map(|&bone| {
            let end = limb_end(bone)?;
            let ends = |body: &Body| Some((body.joint(bone)?, body.joint(end)?));
            Some((bone, ends(&self.source)?, ends(&self.target)?))
        });
        let limbs: Vec<_> = limbs.collect();
        let mut angles: Vec<LimbAngles> = (limbs.iter())
            .map(|(bone, _, (node, _))| LimbAngles {
                bone: *bone,
                node: *node,
                degrees: Vec::new(),
            })
            .collect();
        let (from, to) = (Binding::new(source, animation), Binding::new(target, moved));
        let (mut was, mut is) = (Pose::rest(source), Pose::rest(target));
        for tick in ticks(animation) {
            was.sample(&from, animation, tick);
            is.sample(&to, moved, tick);
            for (angles, (_, before, after)) in angles.iter_mut().zip(&limbs) {
                let (a, b) = (way(&self.source, &was, *before), way(&self.target, &is, *after));
                angles.degrees.push(a.cross(b).length().atan2(a.dot(b)).to_degrees());
            }
        }
        angles
    }
}

/// The direction of a limb in the axes of the figure.
fn way(body: &Body, pose: &Pose, (from, to): (NodeId, NodeId)) -> Vec3 {
    (body.axes.inverse() * (pose.position(to) - pose.position(from))).normalize_or_zero()
}
