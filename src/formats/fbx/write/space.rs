//! Converts from the unit and axes of a scene to the unit and axes of the file.

use glam::{DMat3, DMat4, DQuat, DVec3, Mat3, Quat, Vec3};

use mocap_scene::math::up_axis;
use mocap_scene::scene::{RotationOrder, UpAxis};

/// A rotation of the axes, and a factor of lengths.
pub(super) struct Space {
    factor: f64,
    rotation: DMat3,
}

impl Space {
    pub(super) fn new(factor: f64, from: UpAxis, to: UpAxis) -> Self {
        Self {
            factor,
            rotation: Mat3::from_mat4(up_axis::from_to(from, to)).as_dmat3(),
        }
    }

    pub(super) fn point(&self, point: Vec3) -> DVec3 {
        self.rotation * (point.as_dvec3() * self.factor)
    }

    pub(super) fn direction(&self, direction: Vec3) -> DVec3 {
        self.rotation * direction.as_dvec3()
    }

    /// Converts a rotation to the axes of the file and normalizes it. Returns `None` if the quaternion is not a
    /// rotation.
    pub(super) fn rotation(&self, rotation: Quat) -> Option<DQuat> {
        if !(rotation.is_finite() && rotation.length_squared() > f32::EPSILON) {
            return None;
        }
        let rotation = rotation.as_dquat().normalize();
        let axis = self.rotation * rotation.xyz();
        Some(DQuat::from_xyzw(axis.x, axis.y, axis.z, rotation.w))
    }

    /// The length of one scene unit, in units of the file.
    pub(super) fn factor(&self) -> f64 {
        self.factor
    }

    /// The axis of the scene that is parallel to an axis of the file, and its sign: -1 if the axes point in opposite
    /// directions.
    pub(super) fn axis_in_scene(&self, axis: usize) -> (usize, f64) {
        let turned = self.direction_in_scene(DVec3::AXES[axis]);
        let target_axis = (0..3)
            .find(|&target_axis| turned[target_axis].abs() > 0.5)
            .unwrap_or(axis);
        (target_axis, turned[target_axis].signum())
    }

    /// Converts a direction, or angles about axes, from the file to the scene.
    pub(super) fn direction_in_scene(&self, direction: DVec3) -> DVec3 {
        self.rotation.transpose() * direction
    }

    /// Converts a rotation from the file to the scene.
    pub(super) fn rotation_in_scene(&self, rotation: DQuat) -> DQuat {
        let axis = self.direction_in_scene(rotation.xyz());
        DQuat::from_xyzw(axis.x, axis.y, axis.z, rotation.w)
    }

    /// Converts a rotation order from the axes of the file to the axes of the scene.
    pub(super) fn order_in_scene(&self, order: RotationOrder) -> RotationOrder {
        let axes = order.axes().map(|axis| self.axis_in_scene(axis).0);
        RotationOrder::from_axes(axes).unwrap_or(order)
    }

    /// Converts scales along axes. The rotation only permutes them.
    pub(super) fn scale(&self, scale: Vec3) -> DVec3 {
        let permutation = DMat3::from_cols(
            self.rotation.x_axis.abs(),
            self.rotation.y_axis.abs(),
            self.rotation.z_axis.abs(),
        );
        permutation * scale.as_dvec3()
    }

    /// Converts a transform between two spaces of the scene.
    pub(super) fn map(&self, map: DMat4) -> DMat4 {
        let to_file = DMat4::from_mat3(self.rotation * self.factor);
        to_file * map * to_file.inverse()
    }

    /// Converts a rotation order from the axes of the scene to the axes of the file.
    pub(super) fn order(&self, order: RotationOrder) -> RotationOrder {
        let target_axis = |axis: usize| {
            let turned = (self.rotation * DVec3::AXES[axis]).abs();
            (0..3).find(|&target_axis| turned[target_axis] > 0.5).unwrap_or(axis)
        };
        RotationOrder::from_axes(order.axes().map(target_axis)).unwrap_or(order)
    }
}
