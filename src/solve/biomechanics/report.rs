//! The data of a gait report, and of the comparison with the angles in the file.

pub use super::animal_gait::{AnimalGait, Footfalls, GaitName, GaitStretch};
pub use super::beside::OutputDifference;
pub use super::cycles::AngleCycle;
pub use super::gait::{SideOfGait, Stride};
pub use super::mean::MeanAndDeviation;
