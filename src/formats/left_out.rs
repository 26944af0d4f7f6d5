//! Formats that a build omits. Their rows stay in the table, so that their files are recognised and the error names the
//! feature.

use mocap_scene::error::{Code, Diagnostic, Error, Result};
use mocap_scene::scene::Scene;

use crate::{Export, FormatInfo, ReadOptions, Source, WriteOptions};

/// The reader of a row, if the build has the feature.
macro_rules! reader {
    ($feature:literal, $read:path) => {{
        #[cfg(feature = $feature)]
        {
            $read
        }
        #[cfg(not(feature = $feature))]
        {
            $crate::left_out::read
        }
    }};
}

/// The writer of a row, if the build has the feature.
macro_rules! writer {
    ($feature:literal, $write:path) => {{
        #[cfg(feature = $feature)]
        {
            $write
        }
        #[cfg(not(feature = $feature))]
        {
            $crate::left_out::write
        }
    }};
}

/// The reader of an omitted format. [`FormatInfo::read`] makes the error with the name of the format.
#[allow(dead_code, reason = "a build with all features omits nothing")]
pub(crate) fn read(_: &Source<'_>, _: &ReadOptions) -> Result<Scene> {
    Err(Diagnostic::new(Code::MissingFeature, "this build does not read the format").into())
}

/// The writer of an omitted format. [`FormatInfo::write`] makes the error with the name of the format.
#[allow(dead_code, reason = "a build with all features omits nothing")]
pub(crate) fn write(_: &Scene, _: &WriteOptions) -> Result<Export> {
    Err(Diagnostic::new(Code::MissingFeature, "this build does not write the format").into())
}

impl FormatInfo {
    /// The error of a build without the format. `verb` is the action that the caller wanted, such as `read`.
    pub(crate) fn left_out(&self, verb: &str) -> Error {
        let (name, feature) = (self.name, self.feature.unwrap_or_default());
        let message = format!("this build does not {verb} {name}: it was built without the feature `{feature}`");
        Diagnostic::new(Code::MissingFeature, message)
            .help(format!("build it with the feature `{feature}`"))
            .into()
    }
}
