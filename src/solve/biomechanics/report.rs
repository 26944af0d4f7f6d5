//! What a gait consists of.

pub use super::gait::{MeanAndDeviation, SideOfGait, Stride};
