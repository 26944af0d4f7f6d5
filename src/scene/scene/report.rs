//! Reports about a scene: its origin, its steps and guesses, and the fit of its skeleton to markers.

pub use super::attribution::Attribution;
pub use super::guess::Guess;
pub use super::ledger::{DataKind, DataLoss};
pub use super::metadata::{AppliedStep, JointRename, Origin, RootOffsetUsed, SecondMotion, StepRecord};
pub use super::solved::{FilledJoint, MarkerSolution, SolvedJoint, SolvedMarker, SwappedMarkers};
pub use super::source_lines::SourceLines;
