//! The coordinate space of the numbers in a file.

use super::UpAxis;

/// The unit and the up axis of the numbers in a file. A field is set if the reader converted the numbers to another
/// unit or axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[doc(hidden)]
pub struct FileSpace {
    #[doc(hidden)]
    pub metres_per_unit: Option<f64>,
    #[doc(hidden)]
    pub up: Option<UpAxis>,
    /// Whether the file does not state its up axis.
    #[doc(hidden)]
    pub up_is_guess: bool,
}
