//! What the tests of this package need, and nothing else.

pub use crate::arrays::robot::rounded_within;
