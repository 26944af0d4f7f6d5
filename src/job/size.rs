//! Options for compression.

use mocap_compress::ErrorBound;
use mocap_formats::gltf::{Compression, GltfOptions};
use serde::{Deserialize, Serialize};

use super::is_default;
use super::text::Length;

/// Compression options: fewer keys and bits, within a largest error.
///
/// ```
/// use mocap::job::SizeOptions;
///
/// let smaller: SizeOptions = serde_json::from_str(r#"{"max-error": "1mm", "compress": "int16"}"#).unwrap();
/// assert_eq!(smaller.tolerance(), 0.001);
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, rename_all = "kebab-case", deny_unknown_fields)]
#[cfg_attr(feature = "clap", derive(clap::Args), command(next_help_heading = "Smaller files"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct SizeOptions {
    /// Remove keys and bits, but keep every joint and end site within this distance of its position in every frame,
    /// such as 1mm. Fails if the format cannot keep this distance [default with a compression: 1mm]
    #[cfg_attr(feature = "clap", arg(long, value_name = "LENGTH"))]
    #[serde(skip_serializing_if = "is_default")]
    pub max_error: Option<Length>,
    /// Also keep points at this distance around each joint, such as the skin, within the largest error. ACL uses 3cm
    /// [default: 0, only joints and end sites]
    #[cfg_attr(feature = "clap", arg(long, value_name = "LENGTH"))]
    #[serde(skip_serializing_if = "is_default")]
    pub shell_distance: Option<Length>,
    /// How to store the keys [default with a largest error: int16, otherwise none]
    #[cfg_attr(feature = "clap", arg(long, value_name = "KIND"))]
    #[serde(skip_serializing_if = "is_default")]
    pub compress: Option<Compression>,
}

impl SizeOptions {
    /// The largest error in metres, including the default.
    pub fn tolerance(&self) -> f64 {
        self.max_error
            .map_or(ErrorBound::default().max_error, Length::to_metres)
    }

    pub(super) fn gltf(&self) -> GltfOptions {
        let compression = match (self.compress, self.max_error) {
            (Some(kind), _) => kind,
            (None, Some(_)) => Compression::Int16,
            (None, None) => Compression::None,
        };
        let bound = ErrorBound::new(self.tolerance());
        let bound = match self.shell_distance {
            Some(length) => bound.shell_distance(length.to_metres()),
            None => bound,
        };
        GltfOptions::new()
            .compression(compression)
            .error_bound(self.has_bound().then_some(bound))
    }

    /// Whether keys or bits may be removed.
    pub fn has_bound(&self) -> bool {
        self.max_error.is_some() || self.compress.is_some_and(|kind| kind != Compression::None)
    }
}
