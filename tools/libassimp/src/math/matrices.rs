//! Functions of matrices.

use super::quaternions::{matrix_of, quaternion_of, unit};
use super::{cross, divided, dot, functions, length, near};
use crate::abi::{aiMatrix3x3, aiMatrix4x4, aiQuaternion, aiVector2D, aiVector3D};

/// The largest distance of an element of a matrix from the element of the identity.
const NEARLY_IDENTITY: f32 = 10e-3;

/// The smallest cosine at which two directions count as parallel.
const PARALLEL: f32 = 1.0 - 0.00001;

/// The largest cosine of the angle about y at which the axes of x and z coincide. Then only the sum or the difference
/// of their angles is known, and x gets 0.
const GIMBAL_LOCK: f32 = f32::EPSILON;

functions! {
    /// The product with `factor` on the right.
    change aiMultiplyMatrix4(matrix: aiMatrix4x4, factor: *const aiMatrix4x4) { product(matrix, factor) }

    /// The product with `factor` on the right.
    change aiMultiplyMatrix3(matrix: aiMatrix3x3, factor: *const aiMatrix3x3) { product(matrix, factor) }

    /// The transpose.
    change aiTransposeMatrix4(matrix: aiMatrix4x4) { transpose(matrix) }

    /// The transpose.
    change aiTransposeMatrix3(matrix: aiMatrix3x3) { transpose(matrix) }

    /// The point `matrix` x `vector`, without the last row.
    change aiTransformVecByMatrix4(vector: aiVector3D, matrix: *const aiMatrix4x4) {
        let [x, y, z] = vector;
        let [first, second, third, _] = matrix.map(|[a, b, c, d]| a * x + b * y + c * z + d);
        [first, second, third]
    }

    /// `matrix` x `vector`.
    change aiTransformVecByMatrix3(vector: aiVector3D, matrix: *const aiMatrix3x3) { matrix.map(|row| dot(row, vector)) }

    /// The part without translation and last row.
    make aiMatrix3FromMatrix4(aiMatrix3x3, matrix: *const aiMatrix4x4) { upper_left(matrix) }

    /// The rotation of a unit quaternion.
    make aiMatrix3FromQuaternion(aiMatrix3x3, quaternion: *const aiQuaternion) { matrix_of(quaternion) }

    /// 1 if both are the same, else 0.
    tell aiMatrix3AreEqual(a: *const aiMatrix3x3, b: *const aiMatrix3x3) -> i32 { i32::from(a == b) }

    /// 1 if no element differs by more than `epsilon`, else 0.
    tell aiMatrix3AreEqualEpsilon(a: *const aiMatrix3x3, b: *const aiMatrix3x3, epsilon: f32) -> i32 {
        i32::from(near(a.as_flattened(), b.as_flattened(), epsilon))
    }

    /// The inverse; NaN for a singular matrix.
    change aiMatrix3Inverse(matrix: aiMatrix3x3) {
        inverse(determinant3(matrix), |rows, columns| {
            let [a, b] = rows.map(|row| columns.map(|column: usize| matrix[row][column]));
            a[0] * b[1] - a[1] * b[0]
        })
    }

    /// The determinant.
    tell aiMatrix3Determinant(matrix: *const aiMatrix3x3) -> f32 { determinant3(matrix) }

    /// A rotation in the plane, by radians.
    make aiMatrix3RotationZ(aiMatrix3x3, angle: f32) { rotation_in_plane(angle, 0, 1) }

    /// A rotation about a unit vector, by radians.
    make aiMatrix3FromRotationAroundAxis(aiMatrix3x3, axis: *const aiVector3D, angle: f32) { rotation(axis, angle) }

    /// A translation in the plane.
    make aiMatrix3Translation(aiMatrix3x3, translation: *const aiVector2D) {
        let [x, y] = translation;
        [[1.0, 0.0, x], [0.0, 1.0, y], [0.0, 0.0, 1.0]]
    }

    /// A rotation that takes the first of two unit vectors to the second.
    make aiMatrix3FromTo(aiMatrix3x3, from: *const aiVector3D, to: *const aiVector3D) { from_to(from, to) }

    /// A 3 x 3 rotation matrix that takes the first of two unit vectors to the second.
    make aiMatrix4FromMatrix3(aiMatrix4x4, matrix: *const aiMatrix3x3) { extended(matrix, [0.0; 3]) }

    /// A rotation whose rows are scaled, and a translation.
    make aiMatrix4FromScalingQuaternionPosition(
        aiMatrix4x4, scaling: *const aiVector3D, rotation: *const aiQuaternion, position: *const aiVector3D
    ) {
        let rotation = matrix_of(rotation);
        let rows = std::array::from_fn(|row| rotation[row].map(|element| element * scaling[row]));
        extended(rows, position)
    }

    /// The sum.
    change aiMatrix4Add(a: aiMatrix4x4, b: *const aiMatrix4x4) {
        std::array::from_fn(|row| super::each(a[row], b[row], |a, b| a + b))
    }

    /// 1 if both are the same, else 0.
    tell aiMatrix4AreEqual(a: *const aiMatrix4x4, b: *const aiMatrix4x4) -> i32 { i32::from(a == b) }

    /// 1 if no element differs by more than `epsilon`, else 0.
    tell aiMatrix4AreEqualEpsilon(a: *const aiMatrix4x4, b: *const aiMatrix4x4, epsilon: f32) -> i32 {
        i32::from(near(a.as_flattened(), b.as_flattened(), epsilon))
    }

    /// The inverse; NaN for a singular matrix.
    change aiMatrix4Inverse(matrix: aiMatrix4x4) {
        inverse(determinant4(matrix), |rows, columns| {
            let [a, b, c] = rows.map(|row| columns.map(|column: usize| matrix[row][column]));
            dot(a, cross(b, c))
        })
    }

    /// The determinant.
    tell aiMatrix4Determinant(matrix: *const aiMatrix4x4) -> f32 { determinant4(matrix) }

    /// 1 if no element is farther than 0.01 from the element of the identity, else 0.
    tell aiMatrix4IsIdentity(matrix: *const aiMatrix4x4) -> i32 {
        let is_near = |element: f32, expected: f32| {
            element <= expected + NEARLY_IDENTITY && element >= expected - NEARLY_IDENTITY
        };
        let identity: aiMatrix4x4 = identity();
        let mut elements = std::iter::zip(matrix.as_flattened(), identity.as_flattened());
        i32::from(elements.all(|(element, expected)| is_near(*element, *expected)))
    }

    /// The rotation about x, then y, then z, by radians; the other elements do not change.
    change aiMatrix4FromEulerAngles(matrix: aiMatrix4x4, x: f32, y: f32, z: f32) {
        let rotation = from_euler_angles(x, y, z);
        let mut changed = matrix;
        for (row, rotation) in std::iter::zip(&mut changed, rotation) {
            row[..3].copy_from_slice(&rotation);
        }
        changed
    }

    /// A rotation about x, by radians.
    make aiMatrix4RotationX(aiMatrix4x4, angle: f32) { extended(rotation_in_plane(angle, 1, 2), [0.0; 3]) }

    /// A rotation about y, by radians.
    make aiMatrix4RotationY(aiMatrix4x4, angle: f32) { extended(rotation_in_plane(angle, 2, 0), [0.0; 3]) }

    /// A rotation about z, by radians.
    make aiMatrix4RotationZ(aiMatrix4x4, angle: f32) { extended(rotation_in_plane(angle, 0, 1), [0.0; 3]) }

    /// A rotation about a unit vector, by radians.
    make aiMatrix4FromRotationAroundAxis(aiMatrix4x4, axis: *const aiVector3D, angle: f32) {
        extended(rotation(axis, angle), [0.0; 3])
    }

    /// A translation.
    make aiMatrix4Translation(aiMatrix4x4, translation: *const aiVector3D) { extended(identity(), translation) }

    /// A scaling along the axes.
    make aiMatrix4Scaling(aiMatrix4x4, scaling: *const aiVector3D) {
        let [x, y, z] = scaling;
        extended([[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]], [0.0; 3])
    }

    /// A rotation that takes the first of two unit vectors to the second.
    make aiMatrix4FromTo(aiMatrix4x4, from: *const aiVector3D, to: *const aiVector3D) {
        extended(from_to(from, to), [0.0; 3])
    }
}

/// The identity.
///
/// # Safety
/// `matrix` points to a matrix.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiIdentityMatrix4(matrix: *mut aiMatrix4x4) {
    // SAFETY: the caller passes a valid pointer to a matrix.
    unsafe { matrix.write(identity()) };
}

/// The identity.
///
/// # Safety
/// `matrix` points to a matrix.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiIdentityMatrix3(matrix: *mut aiMatrix3x3) {
    // SAFETY: the caller passes a valid pointer to a matrix.
    unsafe { matrix.write(identity()) };
}

/// Splits `matrix` into translation x rotation x scaling. A matrix that mirrors has three negative scales.
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
    // SAFETY: the caller passes a matrix.
    let parts = Parts::of(unsafe { *matrix });
    // SAFETY: the caller passes the places of two vectors and a quaternion.
    unsafe {
        scaling.write(parts.scaling);
        rotation.write(quaternion_of(transpose(parts.axes)));
        position.write(parts.position);
    }
}

/// As [`aiDecomposeMatrix`], with the rotation as angles about x, then y, then z, in radians.
///
/// # Safety
/// They are a matrix and the places of three vectors.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiMatrix4DecomposeIntoScalingEulerAnglesPosition(
    matrix: *const aiMatrix4x4,
    scaling: *mut aiVector3D,
    rotation: *mut aiVector3D,
    position: *mut aiVector3D,
) {
    // SAFETY: the caller passes a matrix.
    let parts = Parts::of(unsafe { *matrix });
    // SAFETY: the caller passes the places of three vectors.
    unsafe {
        scaling.write(parts.scaling);
        rotation.write(euler_angles_of(parts.axes));
        position.write(parts.position);
    }
}

/// As [`aiDecomposeMatrix`], with the rotation as a unit vector and an angle about it, in radians.
///
/// # Safety
/// They are a matrix and the places of three vectors and a number.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiMatrix4DecomposeIntoScalingAxisAnglePosition(
    matrix: *const aiMatrix4x4,
    scaling: *mut aiVector3D,
    axis: *mut aiVector3D,
    angle: *mut f32,
    position: *mut aiVector3D,
) {
    // SAFETY: the caller passes a matrix.
    let parts = Parts::of(unsafe { *matrix });
    let [cosine, x, y, z] = unit(quaternion_of(transpose(parts.axes)));
    let sine = (1.0 - cosine * cosine).sqrt();
    // For a rotation by almost 0, the axis has length 0.
    let divisor = if sine.abs() < NEARLY_IDENTITY { 1.0 } else { sine };
    // SAFETY: the caller passes the places of three vectors and a number.
    unsafe {
        scaling.write(parts.scaling);
        axis.write([x, y, z].map(|component| component / divisor));
        angle.write(cosine.acos() * 2.0);
        position.write(parts.position);
    }
}

/// Splits a matrix into its rotation and its translation.
///
/// # Safety
/// They are a matrix and the places of a quaternion and a vector.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiMatrix4DecomposeNoScaling(
    matrix: *const aiMatrix4x4,
    rotation: *mut aiQuaternion,
    position: *mut aiVector3D,
) {
    // SAFETY: the caller passes a matrix.
    let matrix = unsafe { *matrix };
    // SAFETY: the caller passes the places of a quaternion and a vector.
    unsafe {
        rotation.write(quaternion_of(upper_left(matrix)));
        position.write(position_of(matrix));
    }
}

/// The factors of a matrix.
struct Parts {
    scaling: aiVector3D,
    /// The axes of the rotation: its columns.
    axes: [aiVector3D; 3],
    position: aiVector3D,
}

impl Parts {
    fn of(matrix: aiMatrix4x4) -> Self {
        let columns = transpose(upper_left(matrix));
        let lengths = columns.map(length);
        let scaling = match determinant4(matrix) < 0.0 {
            true => lengths.map(|length| -length),
            false => lengths,
        };
        Self {
            scaling,
            // An axis of length 0 has no direction.
            axes: std::array::from_fn(|axis| divided(columns[axis], scaling[axis])),
            position: position_of(matrix),
        }
    }
}

/// The angles about x, y and z of a rotation with these columns.
fn euler_angles_of(axes: [aiVector3D; 3]) -> aiVector3D {
    let y = (-axes[0][2]).asin();
    let cosine = y.cos();
    if cosine.abs() > GIMBAL_LOCK {
        let x = (axes[1][2] / cosine).atan2(axes[2][2] / cosine);
        let z = (axes[0][1] / cosine).atan2(axes[0][0] / cosine);
        [x, y, z]
    } else {
        [0.0, y, (-axes[1][0]).atan2(axes[1][1])]
    }
}

fn from_euler_angles(x: f32, y: f32, z: f32) -> aiMatrix3x3 {
    let ((sx, cx), (sy, cy), (sz, cz)) = ((x.sin(), x.cos()), (y.sin(), y.cos()), (z.sin(), z.cos()));
    [
        [cz * cy, cz * sy * sx - sz * cx, sz * sx + cz * sy * cx],
        [sz * cy, cz * cx + sz * sy * sx, sz * sy * cx - cz * sx],
        [-sy, cy * sx, cy * cx],
    ]
}

fn identity<const N: usize>() -> [[f32; N]; N] {
    std::array::from_fn(|row| std::array::from_fn(|column| if row == column { 1.0 } else { 0.0 }))
}

fn upper_left(matrix: aiMatrix4x4) -> aiMatrix3x3 {
    std::array::from_fn(|row| std::array::from_fn(|column| matrix[row][column]))
}

fn position_of(matrix: aiMatrix4x4) -> aiVector3D {
    std::array::from_fn(|row| matrix[row][3])
}

fn extended([a, b, c]: aiMatrix3x3, [x, y, z]: aiVector3D) -> aiMatrix4x4 {
    let row = |[first, second, third]: [f32; 3], last| [first, second, third, last];
    [row(a, x), row(b, y), row(c, z), [0.0, 0.0, 0.0, 1.0]]
}

/// The rotation from one axis towards another.
fn rotation_in_plane(angle: f32, from: usize, to: usize) -> aiMatrix3x3 {
    let mut matrix: aiMatrix3x3 = identity();
    let (sine, cosine) = (angle.sin(), angle.cos());
    matrix[from][from] = cosine;
    matrix[to][to] = cosine;
    matrix[to][from] = sine;
    matrix[from][to] = -sine;
    matrix
}

/// Rodrigues' formula.
fn rotation([x, y, z]: aiVector3D, angle: f32) -> aiMatrix3x3 {
    let (c, s) = (angle.cos(), angle.sin());
    let t = 1.0 - c;
    [
        [t * x * x + c, t * x * y - s * z, t * x * z + s * y],
        [t * x * y + s * z, t * y * y + c, t * y * z - s * x],
        [t * x * z - s * y, t * y * z + s * x, t * z * z + c],
    ]
}

/// Moller and Hughes, "Efficiently Building a Matrix to Rotate One Vector to Another", 1999.
fn from_to(from: aiVector3D, to: aiVector3D) -> aiMatrix3x3 {
    let cosine = dot(from, to);
    if cosine.abs() > PARALLEL {
        return two_reflections(from, to);
    }
    let [x, y, z] = cross(from, to);
    let h = 1.0 / (1.0 + cosine);
    let (hx, hz) = (h * x, h * z);
    let (xy, xz, yz) = (hx * y, hx * z, hz * y);
    [
        [cosine + hx * x, xy - z, xz + y],
        [xy + z, cosine + h * y * y, yz - x],
        [xz - y, yz + x, cosine + hz * z],
    ]
}

/// For nearly parallel vectors, rotates over the axis that is farthest from the first vector.
fn two_reflections(from: aiVector3D, to: aiVector3D) -> aiMatrix3x3 {
    let [x, y, z] = from.map(f32::abs);
    let axis = match (x < y, x < z, y < z) {
        (true, true, _) => 0,
        (false, _, true) => 1,
        _ => 2,
    };
    let away: aiVector3D = std::array::from_fn(|at| if at == axis { 1.0 } else { 0.0 });
    let (u, v) = (
        super::each(away, from, |a, b| a - b),
        super::each(away, to, |a, b| a - b),
    );
    let (of_u, of_v) = (2.0 / dot(u, u), 2.0 / dot(v, v));
    let of_both = of_u * of_v * dot(u, v);
    std::array::from_fn(|row| {
        std::array::from_fn(|column| {
            let element = -of_u * u[row] * u[column] - of_v * v[row] * v[column] + of_both * v[row] * u[column];
            element + if row == column { 1.0 } else { 0.0 }
        })
    })
}

fn product<const N: usize>(left: [[f32; N]; N], right: [[f32; N]; N]) -> [[f32; N]; N] {
    let columns = transpose(right);
    left.map(|row| columns.map(|column| dot(row, column)))
}

fn transpose<const N: usize>(matrix: [[f32; N]; N]) -> [[f32; N]; N] {
    std::array::from_fn(|row| std::array::from_fn(|column| matrix[column][row]))
}

fn determinant3([a, b, c]: aiMatrix3x3) -> f32 {
    let terms = (0..3).flat_map(|first| {
        let [second, third] = [(first + 1) % 3, (first + 2) % 3];
        [a[first] * b[second] * c[third], -(a[first] * b[third] * c[second])]
    });
    terms.reduce(|sum, term| sum + term).unwrap_or_default()
}

fn determinant4([a, b, c, d]: aiMatrix4x4) -> f32 {
    let terms = (0..4).flat_map(|first: usize| {
        let others = [1, 2, 3].map(|step| (first + step) % 4);
        (0..3).flat_map(move |place| {
            let [second, third, fourth] = [0, 1, 2].map(|step| others[(place + step) % 3]);
            let plus = a[first] * b[second] * c[third] * d[fourth];
            let minus = a[first] * b[second] * c[fourth] * d[third];
            // The cycle of four columns is an odd permutation.
            let sign = if first.is_multiple_of(2) { 1.0 } else { -1.0 };
            [sign * plus, -sign * minus]
        })
    });
    terms.reduce(|sum, term| sum + term).unwrap_or_default()
}

/// The adjugate over the determinant. `minor` is the determinant of some rows and columns, all but one.
fn inverse<const N: usize, const M: usize>(
    determinant: f32,
    minor: impl Fn([usize; M], [usize; M]) -> f32,
) -> [[f32; N]; N] {
    if determinant == 0.0 {
        return [[f32::NAN; N]; N];
    }
    let reciprocal = 1.0 / determinant;
    let without = |left_out: usize| std::array::from_fn(|place| place + usize::from(place >= left_out));
    std::array::from_fn(|row| {
        std::array::from_fn(|column| {
            let sign = if (row + column).is_multiple_of(2) {
                reciprocal
            } else {
                -reciprocal
            };
            sign * minor(without(column), without(row))
        })
    })
}
