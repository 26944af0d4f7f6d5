//! The quality of a motion on its target.

pub use mocap_figure::LimbAngles;

pub use crate::files::{ClipReport, RetargetedClip};
pub use crate::hand_report::{HandContact, HandsReport, TouchedPart};
pub use crate::plan::UnmappedBone;
pub use crate::quality::{ByNames, ClampedLeg, FeetReport, FootMotion, LimbError, LockedFeet, RetargetReport, Verdict};
pub use crate::sight::{Aspect, AspectError};
pub use crate::skin_report::SkinReport;
