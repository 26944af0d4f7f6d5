//! Compiles a function twice: for every processor, and for processors with AVX2, whose vectors are twice as wide. The
//! second version also uses BMI, whose shifts take any register. Every processor with AVX2 has BMI.
//!
//! Products and sums are not fused (no FMA instructions), so that both versions give the same bits.

/// Declares a function whose body is compiled twice. A call runs the version for the processor.
///
/// The body must consist of `#[inline(always)]` functions, and of closures with that attribute or called directly. Any
/// other function or closure is compiled once, for every processor. `else` gives a separate body for processors without
/// AVX2.
///
/// ```ignore
/// wide::dispatch! {
///     fn sum(values: &[f32]) -> f32 {
///         sum_lanes(values)
///     }
/// }
/// ```
#[macro_export]
macro_rules! dispatch {
    (
        $(#[$attribute:meta])*
        $visibility:vis fn $name:ident($($argument:ident: $type:ty),* $(,)?) $(-> $output:ty)? $body:block
    ) => {
        $crate::math::wide::dispatch! {
            $(#[$attribute])*
            $visibility fn $name($($argument: $type),*) $(-> $output)? $body else $body
        }
    };
    (
        $(#[$attribute:meta])*
        $visibility:vis fn $name:ident($($argument:ident: $type:ty),* $(,)?) $(-> $output:ty)? $wide:block else $body:block
    ) => {
        $(#[$attribute])*
        $visibility fn $name($($argument: $type),*) $(-> $output)? {
            #[cfg(target_arch = "x86_64")]
            {
                #[target_feature(enable = "avx2,bmi1,bmi2")]
                fn with_avx2($($argument: $type),*) $(-> $output)? $wide

                if std::arch::is_x86_feature_detected!("avx2")
                    && std::arch::is_x86_feature_detected!("bmi1")
                    && std::arch::is_x86_feature_detected!("bmi2")
                {
                    // SAFETY: a call requires a processor with AVX2, BMI1 and BMI2, which the condition checks.
                    #[allow(unsafe_code, reason = "up to twice as fast: tools/bench/README.md")]
                    return unsafe { with_avx2($($argument),*) };
                }
            }
            $body
        }
    };
}

#[doc(inline)]
pub use dispatch;
