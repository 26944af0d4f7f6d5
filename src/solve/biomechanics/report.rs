//! What a gait consists of, and how far angles are from those of the file.

pub use super::beside::OutputDifference;
pub use super::gait::{MeanAndDeviation, SideOfGait, Stride};
