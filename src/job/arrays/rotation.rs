//! Representations of rotations.

use glam::{Mat3, Quat};
use serde::{Deserialize, Serialize};

use mocap_scene::math::rotation::euler_rot;
use mocap_scene::scene::RotationOrder;

/// The representation of rotations. Files and options use these names.
///
/// [`ArrayOptions`](crate::arrays::ArrayOptions) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Rotation {
    /// x, y, z, w of a unit quaternion. Its sign is arbitrary: a quaternion and its negative are the same rotation.
    #[default]
    #[serde(rename = "quat")]
    Quaternion,
    /// The first column of the rotation matrix, then the second: x, y, z, x, y, z. This is the continuous 6D
    /// representation for neural networks of Zhou et al., On the Continuity of Rotation Representations in Neural
    /// Networks, CVPR 2019.
    #[serde(rename = "6d")]
    SixD,
    /// The rotation matrix, row by row. It is multiplied by column vectors.
    #[serde(rename = "matrix")]
    Matrix,
    /// Degrees about x, y and z, each from -180 to 180, in the joint's
    /// [`rotation_order`](crate::arrays::Joint::rotation_order), or X Y Z if the joint has no order. If rotations are
    /// relative to the parent, these are the file's own angles, except for whole revolutions and the second Euler
    /// solution.
    #[serde(rename = "euler")]
    Euler,
}

/// The coordinate frame of rotations.
///
/// [`ArrayOptions`](crate::arrays::ArrayOptions) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum RotationSpace {
    /// The joint's parent in the output. The rotation of a joint without a parent is relative to the world.
    #[default]
    Local,
    /// The world.
    World,
}

impl Rotation {
    /// The number of values of a rotation.
    pub const fn width(self) -> usize {
        self.columns().len()
    }

    /// The names of the values, as in tables.
    pub const fn columns(self) -> &'static [&'static str] {
        match self {
            Self::Quaternion => &["qx", "qy", "qz", "qw"],
            Self::SixD => &["r00", "r10", "r20", "r01", "r11", "r21"],
            Self::Matrix => &["r00", "r01", "r02", "r10", "r11", "r12", "r20", "r21", "r22"],
            Self::Euler => &["ex", "ey", "ez"],
        }
    }

    /// Writes a rotation to `values`, which has [`Self::width`] elements.
    pub(super) fn write(self, rotation: Quat, order: Option<RotationOrder>, values: &mut [f32]) {
        match self {
            Self::Quaternion => values.copy_from_slice(&rotation.to_array()),
            Self::SixD => values.copy_from_slice(&Mat3::from_quat(rotation).to_cols_array()[..6]),
            Self::Matrix => values.copy_from_slice(&Mat3::from_quat(rotation).transpose().to_cols_array()),
            Self::Euler => {
                let order = order.unwrap_or(RotationOrder::Xyz);
                let (first, second, third) = rotation.as_dquat().normalize().to_euler(euler_rot(order));
                for (axis, angle) in order.axes().into_iter().zip([first, second, third]) {
                    values[axis] = angle.to_degrees() as f32;
                }
            }
        }
    }
}
