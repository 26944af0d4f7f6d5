//! The constant rotations, offsets and pivots of a model.

use glam::{DQuat, DVec3, EulerRot};

/// The first three numbers of a property.
fn xyz(v: ufbx::Vec4) -> DVec3 {
    DVec3::new(v.x, v.y, v.z)
}

/// The parts of a model's transform that curves do not change.
pub(super) struct Pivots {
    pub(super) post_rotation: DQuat,
    rotation_offset: DVec3,
    rotation_pivot: DVec3,
    scaling_offset: DVec3,
    scaling_pivot: DVec3,
}

impl Pivots {
    pub(super) fn of(node: &ufbx::Node) -> Self {
        let offset = |name: &str| {
            node.element
                .props
                .find_prop(name)
                .map_or(DVec3::ZERO, |found| xyz(found.value_vec4))
        };
        Self {
            post_rotation: rotation(node, "PostRotation"),
            rotation_offset: offset("RotationOffset"),
            rotation_pivot: offset("RotationPivot"),
            scaling_offset: offset("ScalingOffset"),
            scaling_pivot: offset("ScalingPivot"),
        }
    }

    pub(super) fn are_none(&self) -> bool {
        let offsets = [
            self.rotation_offset,
            self.rotation_pivot,
            self.scaling_offset,
            self.scaling_pivot,
        ];
        offsets == [DVec3::ZERO; 4] && self.post_rotation == DQuat::IDENTITY
    }

    /// The `Lcl Translation` that places the model at `translation` in its parent, with this rotation and scale.
    pub(super) fn translation(&self, translation: DVec3, rotation: DQuat, scale: DVec3) -> DVec3 {
        let turned = self.scaling_offset + self.scaling_pivot - self.rotation_pivot - scale * self.scaling_pivot;
        translation - self.rotation_offset - self.rotation_pivot - rotation * turned
    }
}

/// A constant rotation of a model, in the order XYZ.
pub(super) fn rotation(node: &ufbx::Node, name: &str) -> DQuat {
    let property = node.element.props.find_prop(name).filter(|_| node.use_rotation_space);
    let angles = property.map_or(DVec3::ZERO, |found| xyz(found.value_vec4));
    let [x, y, z] = angles.to_array().map(f64::to_radians);
    DQuat::from_euler(EulerRot::ZYX, z, y, x)
}
