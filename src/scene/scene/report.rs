//! Where a scene comes from, what was done to it and guessed, and how well markers determine its skeleton.

pub use super::attribution::Attribution;
pub use super::guess::Guess;
pub use super::ledger::{DataKind, DataLoss};
pub use super::metadata::{AppliedStep, JointRename, Origin, RootOffsetUsed, SecondMotion, StepRecord};
pub use super::solved::{MarkerSolution, SolvedJoint, SolvedMarker, SwappedMarkers};
pub use super::source_lines::SourceLines;
