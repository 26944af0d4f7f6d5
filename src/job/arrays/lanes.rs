//! Transforms in a block of frames, as structures of arrays: see [`soa`](mocap_scene::math::soa).
//!
//! The compiler turns the same operation on neighbouring lanes into one SIMD instruction. With an array of matrices,
//! one instruction would only work on the four numbers of a column. The operations have the same order as in glam.

use glam::{Mat4, Quat, Vec3};

use mocap_scene::math::soa::{Matrices, single};

/// The number of frames in a block. The transforms of about 40 nodes then fit into the processor's level-2 cache.
pub(super) const LANES: usize = PARTS * single::LANES;

/// The number of structures of arrays in a block. With four, the work on a node outweighs the loop over the node's
/// tracks.
const PARTS: usize = 4;

/// A rotation in every frame.
#[derive(Clone)]
pub(super) struct Rotations([single::Quaternions; PARTS]);

impl Rotations {
    /// One rotation for every frame.
    pub(super) fn splat(rotation: Quat) -> Self {
        Self([single::Quaternions::all(rotation.to_array()); PARTS])
    }

    #[inline]
    pub(super) fn get(&self, frame: usize) -> Quat {
        Quat::from_array(self.0[frame / single::LANES].lane(frame % single::LANES))
    }

    #[inline]
    pub(super) fn set(&mut self, frame: usize, rotation: Quat) {
        self.0[frame / single::LANES].set_lane(frame % single::LANES, rotation.to_array());
    }
}

/// An affine transform in every frame.
#[derive(Clone)]
pub(super) struct Transforms([single::Transforms; PARTS]);

impl Transforms {
    /// One transform for every frame.
    pub(super) fn splat(matrix: Mat4) -> Self {
        let [x, y, z, origin] = [matrix.x_axis, matrix.y_axis, matrix.z_axis, matrix.w_axis]
            .map(|column| single::Vectors::all(column.truncate().to_array()));
        let axes = Matrices([x, y, z]);
        Self([single::Transforms { axes, origin }; PARTS])
    }

    #[inline]
    pub(super) fn origin(&self, frame: usize) -> Vec3 {
        Vec3::from_array(self.0[frame / single::LANES].origin.lane(frame % single::LANES))
    }

    pub(super) fn matrix(&self, frame: usize) -> Mat4 {
        let axes = &self.0[frame / single::LANES].axes.0;
        let [x, y, z] = [0, 1, 2].map(|axis| Vec3::from_array(axes[axis].lane(frame % single::LANES)).extend(0.0));
        Mat4::from_cols(x, y, z, self.origin(frame).extend(1.0))
    }

    #[inline]
    pub(super) fn set_origin(&mut self, frame: usize, origin: Vec3) {
        let part = &mut self.0[frame / single::LANES];
        part.origin.set_lane(frame % single::LANES, origin.to_array());
    }

    /// Sets the axes from unit quaternions.
    pub(super) fn set_rotations(&mut self, rotations: &Rotations) {
        for (part, rotations) in std::iter::zip(&mut self.0, &rotations.0) {
            part.axes = Matrices::from(*rotations);
        }
    }

    /// Scales the axes of the transform in one frame.
    pub(super) fn scale(&mut self, frame: usize, scale: Vec3) {
        let axes = &mut self.0[frame / single::LANES].axes.0;
        for (axis, scale) in std::iter::zip(axes, scale.to_array()) {
            for row in [&mut axis.x, &mut axis.y, &mut axis.z] {
                row.0[frame % single::LANES] *= scale;
            }
        }
    }

    /// Sets the origins to the origins of `parent * local`.
    pub(super) fn set_product_of_origins(&mut self, parent: &Self, local: &Self) {
        for ((part, parent), local) in std::iter::zip(&mut self.0, &parent.0).zip(&local.0) {
            part.set_product_of_origins(parent, local);
        }
    }

    /// Sets the axes to the axes of `parent * local`.
    pub(super) fn set_product_of_axes(&mut self, parent: &Self, local: &Self) {
        for ((part, parent), local) in std::iter::zip(&mut self.0, &parent.0).zip(&local.0) {
            part.set_product_of_axes(parent, local);
        }
    }
}
