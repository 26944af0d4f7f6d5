//! The space of the numbers in a file.

use super::UpAxis;

/// The unit and the up axis of the numbers in a file, each where its reader has converted from it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[doc(hidden)]
pub struct FileSpace {
    #[doc(hidden)]
    pub metres_per_unit: Option<f64>,
    #[doc(hidden)]
    pub up: Option<UpAxis>,
    /// Whether the file leaves its up axis open.
    #[doc(hidden)]
    pub up_is_guess: bool,
}
