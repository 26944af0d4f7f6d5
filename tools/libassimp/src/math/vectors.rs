//! Functions of vectors in the plane and in space.

use super::quaternions::{conjugate, multiply};
use super::{cross, divided, dot, each, functions, length, near, normalized};
use crate::abi::{aiQuaternion, aiVector2D, aiVector3D};

functions! {
    /// 1 if both are the same, else 0.
    tell aiVector2AreEqual(a: *const aiVector2D, b: *const aiVector2D) -> i32 { i32::from(a == b) }

    /// 1 if no component differs by more than `epsilon`, else 0.
    tell aiVector2AreEqualEpsilon(a: *const aiVector2D, b: *const aiVector2D, epsilon: f32) -> i32 {
        i32::from(near(&a, &b, epsilon))
    }

    /// The sum.
    change aiVector2Add(a: aiVector2D, b: *const aiVector2D) { each(a, b, |a, b| a + b) }

    /// The difference.
    change aiVector2Subtract(a: aiVector2D, b: *const aiVector2D) { each(a, b, |a, b| a - b) }

    /// Each component times `factor`.
    change aiVector2Scale(v: aiVector2D, factor: f32) { v.map(|component| component * factor) }

    /// The products of the components.
    change aiVector2SymMul(a: aiVector2D, b: *const aiVector2D) { each(a, b, |a, b| a * b) }

    /// Each component divided by `divisor`, which may be 0.
    change aiVector2DivideByScalar(v: aiVector2D, divisor: f32) { v.map(|component| component / divisor) }

    /// The quotients of the components.
    change aiVector2DivideByVector(a: aiVector2D, b: *const aiVector2D) { each(a, b, |a, b| a / b) }

    /// The length.
    tell aiVector2Length(v: *const aiVector2D) -> f32 { length(v) }

    /// The square of the length.
    tell aiVector2SquareLength(v: *const aiVector2D) -> f32 { dot(v, v) }

    /// The opposite.
    change aiVector2Negate(v: aiVector2D) { v.map(|component| -component) }

    /// The scalar product.
    tell aiVector2DotProduct(a: *const aiVector2D, b: *const aiVector2D) -> f32 { dot(a, b) }

    /// Of length 1; not a number if the length is 0.
    change aiVector2Normalize(v: aiVector2D) { v.map(|component| component / length(v)) }

    /// 1 if both are the same, else 0.
    tell aiVector3AreEqual(a: *const aiVector3D, b: *const aiVector3D) -> i32 { i32::from(a == b) }

    /// 1 if no component differs by more than `epsilon`, else 0.
    tell aiVector3AreEqualEpsilon(a: *const aiVector3D, b: *const aiVector3D, epsilon: f32) -> i32 {
        i32::from(near(&a, &b, epsilon))
    }

    /// 1 if the first component that differs is smaller, else 0.
    tell aiVector3LessThan(a: *const aiVector3D, b: *const aiVector3D) -> i32 {
        let differing = std::iter::zip(a, b).find(|(a, b)| a != b);
        i32::from(differing.is_some_and(|(a, b)| a < b))
    }

    /// The sum.
    change aiVector3Add(a: aiVector3D, b: *const aiVector3D) { each(a, b, |a, b| a + b) }

    /// The difference.
    change aiVector3Subtract(a: aiVector3D, b: *const aiVector3D) { each(a, b, |a, b| a - b) }

    /// Each component times `factor`.
    change aiVector3Scale(v: aiVector3D, factor: f32) { v.map(|component| component * factor) }

    /// The products of the components.
    change aiVector3SymMul(a: aiVector3D, b: *const aiVector3D) { each(a, b, |a, b| a * b) }

    /// Each component divided by `divisor`; unchanged if `divisor` is 0.
    change aiVector3DivideByScalar(v: aiVector3D, divisor: f32) { divided(v, divisor) }

    /// The quotients of the components.
    change aiVector3DivideByVector(a: aiVector3D, b: *const aiVector3D) { each(a, b, |a, b| a / b) }

    /// The length.
    tell aiVector3Length(v: *const aiVector3D) -> f32 { length(v) }

    /// The square of the length.
    tell aiVector3SquareLength(v: *const aiVector3D) -> f32 { dot(v, v) }

    /// The opposite.
    change aiVector3Negate(v: aiVector3D) { v.map(|component| -component) }

    /// The scalar product.
    tell aiVector3DotProduct(a: *const aiVector3D, b: *const aiVector3D) -> f32 { dot(a, b) }

    /// The cross product of two.
    make aiVector3CrossProduct(aiVector3D, a: *const aiVector3D, b: *const aiVector3D) { cross(a, b) }

    /// Of length 1; unchanged if the length is 0.
    change aiVector3Normalize(v: aiVector3D) { normalized(v) }

    /// As `aiVector3Normalize`.
    change aiVector3NormalizeSafe(v: aiVector3D) { normalized(v) }

    /// Turned by a unit quaternion.
    change aiVector3RotateByQuaternion(v: aiVector3D, rotation: *const aiQuaternion) {
        let [x, y, z] = v;
        let [_, x, y, z] = multiply(multiply(rotation, [0.0, x, y, z]), conjugate(rotation));
        [x, y, z]
    }
}
