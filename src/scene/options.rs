//! How options are set: a method for each field, named like it. How a value is text in JSON.
//!
//! Structs of options are `#[non_exhaustive]`, so that a new option breaks no program. Such a struct is not written as
//! a literal: it begins with `new()` and is changed field by field, as an `Importer` is.

/// Gives a struct of options `new()`, which has the defaults, and for each field a method that sets it and returns the
/// options. A field that is an `Option` is set from a value or from an `Option`.
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

/// A type that serializes as its text; a number is read as its text too.
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

/// A value in JSON that is read as its text.
#[derive(serde::Deserialize)]
#[serde(untagged, expecting = "a text or a number")]
pub enum TextOrNumber {
    Text(String),
    Number(serde_json::Number),
}
