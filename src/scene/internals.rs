//! Items for the tests of this package.

pub use crate::error::nearest::edit_distance;
pub use crate::files::confined::check_within;
pub use crate::files::record::user::{RecordState, UserRecord};
pub use crate::files::set::Replaced;
#[cfg(feature = "ik")]
pub use crate::ik::hinge::MOST_OF_HINGE;
