//! The path of the hips.

use glam::{Mat4, Vec3, Vec4};
use mocap_figure::HumanoidBone as Bone;
use mocap_figure::body::Body;
use mocap_figure::ground;
use mocap_figure::rotations::{Points, Rotations};
use mocap_figure::watched::{WatchedJoints, WatchedPose};
use mocap_scene::error::{Code, Result};
use mocap_scene::limits::positive;
use mocap_scene::math::soa::Lanes;
use mocap_scene::pose::Pose;
use mocap_scene::scene::Scene;

use super::Scale;

/// Moves the middle of the hip joints along the scaled path of the source's hip joints.
///
/// The joint of the hips itself is not used. In some skeletons it is between the hip joints, in others a hand's width
/// above them.
#[derive(Clone, Debug)]
pub(super) struct Root {
    /// The factors of the horizontal and of the vertical path.
    pub(super) scale: f32,
    pub(super) height_scale: f32,
    /// The hip joints of the source, as indices into [`WatchedJoints`].
    source_legs: [usize; 2],
    /// The height of the ankles of the standing source; `target_ankle` is the height on the target.
    pub(super) source_ankle: f32,
    pub(super) target_ankle: f32,
    /// The vector from the target's hips to the middle of its hip joints, in the axes of the hips.
    hips_to_middle: Vec3,
    /// The transform from the axes of the target's figure to the parent of its hips.
    figure_to_parent: Mat4,
}

impl Root {
    /// Adds the hip joints of the source to `watched`.
    pub(super) fn new(
        (from, source): (&Body, &Scene),
        (to, target): (&Body, &Scene),
        scale: Scale,
        watched: &mut WatchedJoints,
    ) -> Result<Self> {
        let legs =
            |body: &Body| [Bone::LeftUpperLeg, Bone::RightUpperLeg].map(|bone| body.joint(bone).unwrap_or(body.hips));
        let metres = from.metres_per_unit / to.metres_per_unit;
        let height_scale = f64::from(to.leg) / f64::from(from.leg);
        let scale = match scale {
            Scale::Auto => height_scale,
            Scale::None => metres,
            Scale::Factor(factor) => metres * positive(Code::InvalidValue, "scale", factor)?,
        };
        let [left, right] = legs(to);
        let middle = 0.5 * (to.position(left) + to.position(right));
        let hips_to_world = to.rotation(to.hips);
        let parent = to.hierarchy.parents[to.hips.index()];
        let parent_to_world = parent.map_or(Mat4::IDENTITY, |parent| Pose::rest(target).node_to_world[parent]);
        Ok(Self {
            scale: scale as f32,
            height_scale: height_scale as f32,
            source_legs: legs(from).map(|leg| watched.index_of(leg)),
            source_ankle: ground::of_motion(from, source),
            target_ankle: ground::of_character((to, target), (from, source), height_scale as f32),
            hips_to_middle: hips_to_world.inverse() * (middle - to.position(to.hips)),
            figure_to_parent: parent_to_world.inverse() * Mat4::from_quat(to.axes),
        })
    }

    /// The translation of the target's hips relative to their parent, for this rotation in the axes of the figure.
    #[inline(always)]
    pub(super) fn hips<const N: usize>(&self, seen: &WatchedPose<N>, hips: Rotations<N>) -> Points<N> {
        let [left, right] = self.source_legs.map(|leg| seen.positions[leg]);
        let middle = left + right;
        let standing = self.target_ankle - self.height_scale * self.source_ankle;
        let position = Points {
            x: middle.x * Lanes::all(0.5 * self.scale),
            y: middle.y * Lanes::all(0.5 * self.height_scale) + Lanes::all(standing),
            z: middle.z * Lanes::all(0.5 * self.scale),
        };
        let position = position - hips * Points::all(self.hips_to_middle.to_array());
        let [x, y, z, origin] = [Vec4::X, Vec4::Y, Vec4::Z, Vec4::W]
            .map(|axis| Points::all((self.figure_to_parent * axis).truncate().to_array()));
        x * position.x + y * position.y + z * position.z + origin
    }

    /// The vector that raises the hips by `height`, in the axes of their parent.
    pub(super) fn up(&self, height: f32) -> Vec3 {
        self.figure_to_parent.transform_vector3(Vec3::Y * height)
    }
}
