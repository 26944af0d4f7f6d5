//! Decomposes a matrix without an inverse.

use glam::{DMat3, DMat4, DQuat, DVec3, DVec4};

/// The scale and the rotation of a matrix with axes of zero length. The other axes complete the rotation. Shear is
/// lost.
#[doc(hidden)]
pub fn of_flat(matrix: &DMat4) -> (DVec3, DQuat) {
    let axes = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(DVec4::truncate);
    let scale = DVec3::from_array(axes.map(DVec3::length));
    let known = axes.map(DVec3::try_normalize);
    // Start with an axis of known direction. If two are known, the next one is known too.
    let first = (0..3)
        .find(|axis| known[*axis].is_some() && (known[(axis + 1) % 3].is_some() || known[(axis + 2) % 3].is_none()));
    let Some((first, start)) = first.and_then(|axis| Some((axis, known[axis]?))) else {
        return (scale, DQuat::IDENTITY);
    };
    let next = known[(first + 1) % 3].and_then(|next| next.reject_from_normalized(start).try_normalize());
    let next = next.unwrap_or_else(|| start.any_orthonormal_vector());
    let mut whole = [start; 3];
    whole[(first + 1) % 3] = next;
    whole[(first + 2) % 3] = start.cross(next);
    let rotation = DQuat::from_mat3(&DMat3::from_cols(whole[0], whole[1], whole[2]));
    (scale, rotation.normalize())
}
