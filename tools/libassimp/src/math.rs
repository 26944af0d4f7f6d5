//! The functions of vectors, quaternions and matrices of Assimp's C interface. They work in the caller's memory.
//!
//! Sums have Assimp's order, so that they round alike; `tests/math.cpp` compares every function with Debian's library.
//! Matrices are lists of rows, quaternions [w, x, y, z].

mod matrices;
mod quaternions;
mod vectors;

/// An argument from C: a number, or a pointer to a value, which is copied before the function writes anything.
trait Argument {
    type Value;

    /// # Safety
    /// A pointer points to a value.
    unsafe fn value(self) -> Self::Value;
}

impl Argument for f32 {
    type Value = Self;

    unsafe fn value(self) -> f32 {
        self
    }
}

impl<T: Copy> Argument for *const T {
    type Value = T;

    unsafe fn value(self) -> T {
        // SAFETY: the caller promises it.
        unsafe { self.read() }
    }
}

/// Defines functions of C, each under its name.
///
/// `change` replaces the value of its first argument by the result, `make` writes the result to a given address, and
/// `tell` returns the result.
macro_rules! functions {
    () => {};
    (
        $(#[$attribute:meta])*
        change $name:ident($place:ident: $type:ty $(, $argument:ident: $argument_type:ty)*) { $($body:tt)* }
        $($rest:tt)*
    ) => {
        $(#[$attribute])*
        ///
        /// # Safety
        /// All pointers point to values; they may be the same.
        #[unsafe(no_mangle)]
        pub(crate) unsafe extern "C" fn $name($place: *mut $type $(, $argument: $argument_type)*) {
            let target = $place;
            // SAFETY: the caller passes places of values.
            let ($place, $($argument,)*) = unsafe {
                (target.read(), $($crate::math::Argument::value($argument),)*)
            };
            // SAFETY: the caller passes the place of a value.
            unsafe { target.write({ $($body)* }) };
        }
        functions! { $($rest)* }
    };
    (
        $(#[$attribute:meta])*
        make $name:ident($type:ty $(, $argument:ident: $argument_type:ty)*) { $($body:tt)* }
        $($rest:tt)*
    ) => {
        $(#[$attribute])*
        ///
        /// # Safety
        /// All pointers point to values, the first to the place of one; they may be the same.
        #[unsafe(no_mangle)]
        pub(crate) unsafe extern "C" fn $name(place: *mut $type $(, $argument: $argument_type)*) {
            // SAFETY: the caller passes places of values.
            let ($($argument,)*) = unsafe { ($($crate::math::Argument::value($argument),)*) };
            // SAFETY: the caller passes the place of a value.
            unsafe { place.write({ $($body)* }) };
        }
        functions! { $($rest)* }
    };
    (
        $(#[$attribute:meta])*
        tell $name:ident($($argument:ident: $argument_type:ty),*) -> $result:ty { $($body:tt)* }
        $($rest:tt)*
    ) => {
        $(#[$attribute])*
        ///
        /// # Safety
        /// All pointers point to values.
        #[unsafe(no_mangle)]
        pub(crate) unsafe extern "C" fn $name($($argument: $argument_type),*) -> $result {
            // SAFETY: the caller passes places of values.
            let ($($argument,)*) = unsafe { ($($crate::math::Argument::value($argument),)*) };
            $($body)*
        }
        functions! { $($rest)* }
    };
}
use functions;

/// Whether no component differs by more than `epsilon`.
fn near(left: &[f32], right: &[f32], epsilon: f32) -> bool {
    std::iter::zip(left, right).all(|(left, right)| (left - right).abs() <= epsilon)
}

/// The sum of the products of components.
fn dot<const N: usize>(left: [f32; N], right: [f32; N]) -> f32 {
    (1..N).fold(left[0] * right[0], |sum, axis| sum + left[axis] * right[axis])
}

/// A vector whose components are the results of `operation` on the components of two vectors.
fn each<const N: usize>(left: [f32; N], right: [f32; N], operation: impl Fn(f32, f32) -> f32) -> [f32; N] {
    std::array::from_fn(|axis| operation(left[axis], right[axis]))
}

fn cross(left: [f32; 3], right: [f32; 3]) -> [f32; 3] {
    let ([a, b, c], [x, y, z]) = (left, right);
    [b * z - c * y, c * x - a * z, a * y - b * x]
}

/// Divides with the reciprocal, as Assimp does for vectors in space; a divisor of 0 changes nothing.
fn divided<const N: usize>(vector: [f32; N], divisor: f32) -> [f32; N] {
    if divisor == 0.0 {
        return vector;
    }
    let reciprocal = 1.0 / divisor;
    vector.map(|component| component * reciprocal)
}

fn length<const N: usize>(vector: [f32; N]) -> f32 {
    dot(vector, vector).sqrt()
}

fn normalized<const N: usize>(vector: [f32; N]) -> [f32; N] {
    divided(vector, length(vector))
}
