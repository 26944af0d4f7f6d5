//! The matrix functions of Assimp's C interface. They work in the caller's memory.
//!
//! Sums are in the order of Assimp's, so that they round alike.

use mocap::glam::{Mat3, Mat4, Vec3};

use crate::abi::{aiMatrix3x3, aiMatrix4x4, aiQuaternion, aiVector3D};

/// `matrix` becomes the identity.
///
/// # Safety
/// `matrix` is a matrix.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiIdentityMatrix4(matrix: *mut aiMatrix4x4) {
    // SAFETY: the caller hands over the place of a matrix.
    unsafe { matrix.write(Mat4::IDENTITY.to_cols_array_2d()) };
}

/// `matrix` becomes the identity.
///
/// # Safety
/// `matrix` is a matrix.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiIdentityMatrix3(matrix: *mut aiMatrix3x3) {
    // SAFETY: the caller hands over the place of a matrix.
    unsafe { matrix.write(Mat3::IDENTITY.to_cols_array_2d()) };
}

/// `matrix` becomes `matrix` x `factor`.
///
/// # Safety
/// Both are matrices; they may be the same.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiMultiplyMatrix4(matrix: *mut aiMatrix4x4, factor: *const aiMatrix4x4) {
    // SAFETY: the caller hands over two matrices, which are copied before one is written.
    unsafe { matrix.write(product(*matrix, *factor)) };
}

/// `matrix` becomes `matrix` x `factor`.
///
/// # Safety
/// Both are matrices; they may be the same.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiMultiplyMatrix3(matrix: *mut aiMatrix3x3, factor: *const aiMatrix3x3) {
    // SAFETY: the caller hands over two matrices, which are copied before one is written.
    unsafe { matrix.write(product(*matrix, *factor)) };
}

/// `matrix` becomes its transpose.
///
/// # Safety
/// `matrix` is a matrix.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiTransposeMatrix4(matrix: *mut aiMatrix4x4) {
    // SAFETY: the caller hands over a matrix.
    unsafe { matrix.write(transpose(*matrix)) };
}

/// `matrix` becomes its transpose.
///
/// # Safety
/// `matrix` is a matrix.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiTransposeMatrix3(matrix: *mut aiMatrix3x3) {
    // SAFETY: the caller hands over a matrix.
    unsafe { matrix.write(transpose(*matrix)) };
}

/// `vector` becomes the point `matrix` x `vector`; the last row has no part in it.
///
/// # Safety
/// They are a vector and a matrix.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiTransformVecByMatrix4(vector: *mut aiVector3D, matrix: *const aiMatrix4x4) {
    // SAFETY: the caller hands over a vector and a matrix.
    let ([x, y, z], rows) = unsafe { (*vector, *matrix) };
    let row = |[a, b, c, d]: [f32; 4]| a * x + b * y + c * z + d;
    // SAFETY: the caller hands over a vector.
    unsafe { vector.write([row(rows[0]), row(rows[1]), row(rows[2])]) };
}

/// `vector` becomes `matrix` x `vector`.
///
/// # Safety
/// They are a vector and a matrix.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiTransformVecByMatrix3(vector: *mut aiVector3D, matrix: *const aiMatrix3x3) {
    // SAFETY: the caller hands over a vector and a matrix.
    let ([x, y, z], rows) = unsafe { (*vector, *matrix) };
    // SAFETY: the caller hands over a vector.
    unsafe { vector.write(rows.map(|[a, b, c]| a * x + b * y + c * z)) };
}

/// `quaternion` becomes the rotation that `matrix` is.
///
/// # Safety
/// They are a quaternion and a matrix.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiCreateQuaternionFromMatrix(
    quaternion: *mut aiQuaternion,
    matrix: *const aiMatrix3x3,
) {
    // SAFETY: the caller hands over a matrix.
    let rotation = Mat3::from_cols_array_2d(unsafe { &*matrix }).transpose();
    // SAFETY: the caller hands over the place of a quaternion.
    unsafe { quaternion.write(quaternion_of(rotation)) };
}

/// Takes `matrix` apart: translation x rotation x scaling. One that mirrors has three negative scales.
///
/// # Safety
/// They are a matrix and the places of two vectors and a quaternion.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiDecomposeMatrix(
    matrix: *const aiMatrix4x4,
    scaling: *mut aiVector3D,
    rotation: *mut aiQuaternion,
    position: *mut aiVector3D,
) {
    // SAFETY: the caller hands over a matrix.
    let matrix = Mat4::from_cols_array_2d(unsafe { &*matrix }).transpose();
    let axes = Mat3::from_mat4(matrix);
    let lengths = Vec3::new(axes.x_axis.length(), axes.y_axis.length(), axes.z_axis.length());
    let scale = if axes.determinant() < 0.0 { -lengths } else { lengths };
    // An axis without a length has no direction to divide out.
    let divisors = Vec3::select(scale.cmpeq(Vec3::ZERO), Vec3::ONE, scale);
    let turned = Mat3::from_cols(
        axes.x_axis / divisors.x,
        axes.y_axis / divisors.y,
        axes.z_axis / divisors.z,
    );
    // SAFETY: the caller hands over the places of two vectors and a quaternion.
    unsafe {
        scaling.write(scale.to_array());
        rotation.write(quaternion_of(turned));
        position.write(matrix.w_axis.truncate().to_array());
    }
}

/// The rotation as a quaternion, by Shepperd's method: the part that is divided by comes from the trace where that is
/// positive, else from the greatest element of the diagonal, and is positive itself. That fixes which of the two
/// quaternions it is, and also the answer for a matrix that shears.
fn quaternion_of(rotation: Mat3) -> aiQuaternion {
    let [[a1, b1, c1], [a2, b2, c2], [a3, b3, c3]] = rotation.to_cols_array_2d();
    let twice_root = |sum: f32| 2.0 * (1.0 + sum).sqrt();
    if a1 + b2 + c3 > 0.0 {
        let s = twice_root(a1 + b2 + c3);
        [s / 4.0, (c2 - b3) / s, (a3 - c1) / s, (b1 - a2) / s]
    } else if a1 > b2 && a1 > c3 {
        let s = twice_root(a1 - b2 - c3);
        [(c2 - b3) / s, s / 4.0, (a2 + b1) / s, (a3 + c1) / s]
    } else if b2 > c3 {
        let s = twice_root(b2 - a1 - c3);
        [(a3 - c1) / s, (a2 + b1) / s, s / 4.0, (b3 + c2) / s]
    } else {
        let s = twice_root(c3 - a1 - b2);
        [(b1 - a2) / s, (a3 + c1) / s, (b3 + c2) / s, s / 4.0]
    }
}

fn product<const N: usize>(left: [[f32; N]; N], right: [[f32; N]; N]) -> [[f32; N]; N] {
    std::array::from_fn(|row| {
        std::array::from_fn(|column| {
            let terms = (1..N).map(|index| left[row][index] * right[index][column]);
            terms.fold(left[row][0] * right[0][column], |sum, term| sum + term)
        })
    })
}

fn transpose<const N: usize>(matrix: [[f32; N]; N]) -> [[f32; N]; N] {
    std::array::from_fn(|row| std::array::from_fn(|column| matrix[column][row]))
}
