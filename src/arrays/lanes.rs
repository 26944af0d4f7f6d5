//! Transforms of several frames at once: each of their numbers is a row of lanes, one a frame.
//!
//! A compiler makes one instruction of the same operation on neighbouring lanes, where a matrix of its own for every
//! frame leaves it no more than the four numbers of a column. The order of the operations is that of glam's matrices.

use glam::{Mat4, Quat, Vec3};

/// Frames of a block. Some 40 nodes stay in the processor's second cache.
pub(super) const LANES: usize = 32;

/// A number in every frame of a block.
pub(super) type Lanes = [f32; LANES];

/// A rotation in every frame: the lanes of x, y, z and w.
pub(super) type Rotations = [Lanes; 4];

/// An affine transform in every frame.
#[derive(Clone)]
pub(super) struct Transforms {
    /// By axis, then by coordinate.
    axes: [[Lanes; 3]; 3],
    origin: [Lanes; 3],
}

impl Transforms {
    /// The same transform in every frame.
    pub(super) fn splat(matrix: Mat4) -> Self {
        let axes = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
        Self {
            axes: axes.map(|axis| axis.truncate().to_array().map(|value| [value; LANES])),
            origin: matrix.w_axis.truncate().to_array().map(|value| [value; LANES]),
        }
    }

    #[inline]
    pub(super) fn origin(&self, frame: usize) -> Vec3 {
        Vec3::from_array([0, 1, 2].map(|row| self.origin[row][frame]))
    }

    pub(super) fn matrix(&self, frame: usize) -> Mat4 {
        let axis = |axis: usize| Vec3::from_array([0, 1, 2].map(|row| self.axes[axis][row][frame])).extend(0.0);
        Mat4::from_cols(axis(0), axis(1), axis(2), self.origin(frame).extend(1.0))
    }

    #[inline]
    pub(super) fn set_origin(&mut self, frame: usize, origin: Vec3) {
        for (lanes, value) in self.origin.iter_mut().zip(origin.to_array()) {
            lanes[frame] = value;
        }
    }

    /// Makes the axes those of unit quaternions.
    pub(super) fn set_rotations(&mut self, [x, y, z, w]: &Rotations) {
        let [x_axis, y_axis, z_axis] = &mut self.axes;
        for frame in 0..LANES {
            let (x, y, z, w) = (x[frame], y[frame], z[frame], w[frame]);
            let (x2, y2, z2) = (x + x, y + y, z + z);
            let (xx, xy, xz) = (x * x2, x * y2, x * z2);
            let (yy, yz, zz) = (y * y2, y * z2, z * z2);
            let (wx, wy, wz) = (w * x2, w * y2, w * z2);
            x_axis[0][frame] = 1.0 - (yy + zz);
            x_axis[1][frame] = xy + wz;
            x_axis[2][frame] = xz - wy;
            y_axis[0][frame] = xy - wz;
            y_axis[1][frame] = 1.0 - (xx + zz);
            y_axis[2][frame] = yz + wx;
            z_axis[0][frame] = xz + wy;
            z_axis[1][frame] = yz - wx;
            z_axis[2][frame] = 1.0 - (xx + yy);
        }
    }

    /// Scales along the axes of one frame.
    pub(super) fn scale(&mut self, frame: usize, scale: Vec3) {
        for (axis, scale) in self.axes.iter_mut().zip(scale.to_array()) {
            for lanes in axis {
                lanes[frame] *= scale;
            }
        }
    }

    /// The product of `outer` and the origin of `inner`.
    pub(super) fn set_product_of_origin(&mut self, outer: &Self, inner: &Self) {
        for (row, origin) in self.origin.iter_mut().enumerate() {
            multiply(&outer.axes, row, &inner.origin, origin);
            for (value, from) in origin.iter_mut().zip(&outer.origin[row]) {
                *value += from;
            }
        }
    }

    /// The product of the axes of `outer` and those of `inner`.
    pub(super) fn set_product_of_axes(&mut self, outer: &Self, inner: &Self) {
        for (axis, inner) in self.axes.iter_mut().zip(&inner.axes) {
            for (row, product) in axis.iter_mut().enumerate() {
                multiply(&outer.axes, row, inner, product);
            }
        }
    }
}

/// One coordinate of the product of axes and a vector.
#[inline]
fn multiply(axes: &[[Lanes; 3]; 3], row: usize, [x, y, z]: &[Lanes; 3], product: &mut Lanes) {
    let [x_axis, y_axis, z_axis] = [&axes[0][row], &axes[1][row], &axes[2][row]];
    for frame in 0..LANES {
        product[frame] = x_axis[frame] * x[frame] + y_axis[frame] * y[frame] + z_axis[frame] * z[frame];
    }
}

/// The same rotation in every frame.
pub(super) fn splat_rotation(rotation: Quat) -> Rotations {
    rotation.to_array().map(|value| [value; LANES])
}
