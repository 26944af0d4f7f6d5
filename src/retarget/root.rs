//! The path of the hips.

use glam::{Mat4, Quat, Vec3};

use super::body::Body;
use super::{Scale, ground};
use crate::error::{Code, Result};
use crate::limits::positive;
use crate::pose::Pose;
use crate::scene::{NodeId, Scene};
use crate::skeleton::HumanoidBone as Bone;

/// Puts the middle of the hip joints where that of the source is, scaled.
///
/// Not the joint of the hips itself: in one skeleton it is between the hip joints, in another a hand's breadth above
/// them.
#[derive(Clone, Debug)]
pub(super) struct Root {
    /// How many times as long the steps are, and how many times as high.
    pub(super) scale: f32,
    pub(super) height_scale: f32,
    source_legs: [NodeId; 2],
    /// From the world of the source to the frame of the T-pose, and from there to the world of the target.
    world_to_frame: Quat,
    frame_to_world: Quat,
    /// The height of the ankles of a body that stands.
    pub(super) source_ankle: f32,
    pub(super) target_ankle: f32,
    /// From the target's hips to the middle of its hip joints, in the axes of the hips.
    hips_to_middle: Vec3,
    world_to_parent: Mat4,
}

impl Root {
    pub(super) fn new(from: &Body, to: &Body, source: &Scene, target: &Scene, scale: Scale) -> Result<Self> {
        let legs =
            |body: &Body| [Bone::LeftUpperLeg, Bone::RightUpperLeg].map(|bone| body.joint(bone).unwrap_or(body.hips));
        let metres = from.metres_per_unit / to.metres_per_unit;
        let height_scale = f64::from(to.leg) / f64::from(from.leg);
        let scale = match scale {
            Scale::Auto => height_scale,
            Scale::None => metres,
            Scale::Factor(factor) => metres * positive(Code::UnknownOption, "scale", factor)?,
        };
        let [left, right] = legs(to);
        let middle = 0.5 * (to.position(left) + to.position(right));
        let hips_to_world = to.rotation(to.hips);
        let parent = to.parents[to.hips.index()];
        let parent_to_world = parent.map_or(Mat4::IDENTITY, |parent| Pose::rest(target).node_to_world[parent]);
        Ok(Self {
            scale: scale as f32,
            height_scale: height_scale as f32,
            source_legs: legs(from),
            world_to_frame: from.axes.inverse(),
            frame_to_world: to.axes,
            source_ankle: ground::of_motion(from, source),
            target_ankle: ground::of_character(to, target),
            hips_to_middle: hips_to_world.inverse() * (middle - to.position(to.hips)),
            world_to_parent: parent_to_world.inverse(),
        })
    }

    /// The translation of the target's hips to their parent, where they have this rotation to the world.
    pub(super) fn hips(&self, source: &Pose, hips_to_world: Quat) -> Vec3 {
        let [left, right] = self.source_legs.map(|leg| source.position(leg));
        let mut place = self.world_to_frame * (0.5 * (left + right));
        place.x *= self.scale;
        place.y = self.height_scale * (place.y - self.source_ankle) + self.target_ankle;
        place.z *= self.scale;
        let hips = self.frame_to_world * place - hips_to_world * self.hips_to_middle;
        self.world_to_parent.transform_point3(hips)
    }
}
