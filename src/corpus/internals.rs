//! Items that are public only for the tests of this package.

pub use crate::matching::controller::nearest_to;
pub use crate::matching::features::{AHEAD, Root};
pub use crate::matching::like::{cost, limbs_of_both};
pub use crate::matching::steering::{RATE, Steering};
pub use crate::survey::fingerprint::{LIMBS, WIDTH};
