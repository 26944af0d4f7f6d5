//! Items that only the tests of this package need.

pub use crate::arrays::robot::rounded_within;
