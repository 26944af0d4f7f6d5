//! How options are set: a method for each field, named like it.
//!
//! Structs of options are `#[non_exhaustive]`, so that a new option breaks no program. Such a struct is not written as
//! a literal: it begins with `new()` and is changed field by field, as an [`Importer`](crate::Importer) is.

/// Gives a struct of options `new()`, which has the defaults, and for each field a method that sets it and returns the
/// options. A field that is an `Option` is set from a value or from an `Option`.
macro_rules! setters {
    ($options:ident { $($fields:tt)+ }) => {
        impl $options {
            #[doc = concat!("The defaults of [`", stringify!($options), "`].")]
            #[must_use]
            pub fn new() -> Self {
                Self::default()
            }

            $crate::options::setters! { @ $($fields)+ }
        }
    };
    (@ $field:ident: Option<$type:ty>, $($rest:tt)*) => {
        #[doc = concat!("Sets [`", stringify!($field), "`](Self#structfield.", stringify!($field), "), or unsets it.")]
        #[must_use]
        pub fn $field(mut self, $field: impl Into<Option<$type>>) -> Self {
            self.$field = $field.into();
            self
        }

        $crate::options::setters! { @ $($rest)* }
    };
    (@ $field:ident: $type:ty, $($rest:tt)*) => {
        #[doc = concat!("Sets [`", stringify!($field), "`](Self#structfield.", stringify!($field), ").")]
        #[must_use]
        pub fn $field(mut self, $field: $type) -> Self {
            self.$field = $field;
            self
        }

        $crate::options::setters! { @ $($rest)* }
    };
    (@) => {};
}
pub(crate) use setters;
