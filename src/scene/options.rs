//! Setters for option structs: a method with the name of each field. Also reads and writes option values as text in
//! JSON.
//!
//! Option structs are `#[non_exhaustive]`, so that a new option breaks no program. Start with `new()` and call setters,
//! as with an `Importer`. A struct literal does not compile.

use crate::error::{Code, Diagnostic, Result};

/// Gives an option struct `new()`, which returns the defaults. For each field, it also gives a method that sets the
/// field and returns the options. A field of type `Option` accepts a value or an `Option`.
#[macro_export]
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
#[doc(inline)]
pub use setters;

/// Declares a struct of weights from one table: field, default, unit, and the reason for the default with its source.
/// It generates the documentation, the default, the setters, and JSON with only the values that differ from the
/// defaults. It also generates `ROWS`, the source of `docs/weights.md` and of the job schema.
#[macro_export]
macro_rules! weights {
    (
        $(#[$about:meta])*
        $name:ident in $kind:literal {
            $($field:ident = $default:literal, $unit:literal, $reason:literal;)+
        }
    ) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize)]
        #[serde(default, rename_all = "kebab-case", deny_unknown_fields)]
        #[non_exhaustive]
        pub struct $name {
            $(
                #[doc = concat!($reason, "\n\nUnit: ", $unit, ". Default: ", stringify!($default), ".")]
                pub $field: f64,
            )+
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $default,)+ }
            }
        }

        $crate::options::setters! { $name { $($field: f64,)+ } }

        impl $name {
            #[doc(hidden)]
            pub const ROWS: &'static [$crate::options::WeightRow] = &[$(
                $crate::options::WeightRow {
                    kind: $kind,
                    field: stringify!($field),
                    unit: $unit,
                    default: $default,
                    reason: $reason,
                },
            )+];

            /// Refuses values outside of a thousandth to a thousand times their defaults.
            #[doc(hidden)]
            pub fn check(&self) -> $crate::Result<()> {
                let values = [$(self.$field),+];
                Self::ROWS.iter().zip(values).try_for_each(|(row, value)| row.check(value))
            }
        }

        impl serde::Serialize for $name {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                let values = [$(self.$field),+];
                let changed = Self::ROWS.iter().zip(values).filter(|(row, value)| row.default != *value);
                serializer.collect_map(changed.map(|(row, value)| (row.key(), value)))
            }
        }
    };
}
#[doc(inline)]
pub use weights;

/// The description of a weight.
#[derive(Clone, Copy, Debug)]
pub struct WeightRow {
    /// The kind of the weight, as a job names it.
    pub kind: &'static str,
    pub field: &'static str,
    pub unit: &'static str,
    pub default: f64,
    /// The effect of the weight, and the reason for its default.
    pub reason: &'static str,
}

/// The largest factor between a weight and its default, in both directions. A weight of a thousandth of its default has
/// practically no effect, and the solvers still have a solution.
const LARGEST_FACTOR: f64 = 1000.0;

impl WeightRow {
    /// The name in JSON: the field in kebab case.
    pub fn key(&self) -> String {
        self.field.replace('_', "-")
    }

    /// The smallest and the largest value.
    pub fn range(&self) -> [f64; 2] {
        [self.default / LARGEST_FACTOR, self.default * LARGEST_FACTOR]
    }

    /// Refuses a value outside of the range.
    pub fn check(&self, value: f64) -> Result<()> {
        let [least, largest] = self.range();
        if (least..=largest).contains(&value) {
            return Ok(());
        }
        let (key, kind) = (self.key(), self.kind);
        let message = format!("the weight {key} of {kind} must be from {least} to {largest}, got {value}");
        Err(Diagnostic::new(Code::InvalidValue, message).into())
    }
}

/// A type that serializes as its text. It also reads a number as text.
#[macro_export]
macro_rules! as_text {
    ($($name:ident)*) => {$(
        impl serde::Serialize for $name {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.collect_str(self)
            }
        }

        impl<'de> serde::Deserialize<'de> for $name {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                let text = match <$crate::options::TextOrNumber as serde::Deserialize>::deserialize(deserializer)? {
                    $crate::options::TextOrNumber::Text(text) => text,
                    $crate::options::TextOrNumber::Number(number) => number.to_string(),
                };
                text.parse().map_err(|expected: String| serde::de::Error::custom(format!("{text:?}: {expected}")))
            }
        }

        #[cfg(feature = "schema")]
        impl schemars::JsonSchema for $name {
            fn schema_name() -> std::borrow::Cow<'static, str> {
                stringify!($name).into()
            }

            fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
                schemars::json_schema!({ "type": ["string", "number"], "description": Self::TAKES })
            }
        }
    )*};
}
#[doc(inline)]
pub use as_text;

/// A JSON string or number, which is read as text.
#[derive(serde::Deserialize)]
#[serde(untagged, expecting = "a string or a number")]
pub enum TextOrNumber {
    Text(String),
    Number(serde_json::Number),
}
