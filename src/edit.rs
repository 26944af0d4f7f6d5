//! Steps that change a motion, each with a report of what it changed and by how much.
//!
//! A step is a value that has its options, and a type that is a [`Step`]; [`EditStep`] is any of them. It changes one
//! animation of a scene. No step calls another. Those that need to know the body take the bones that
//! [`humanoid`](crate::figure::humanoid()) finds, unless the [`StepInput`] has them, and fail with
//! [`Code::NotHumanoid`](crate::Code::NotHumanoid) if there are none. Bones keep their lengths.
//!
//! Lengths in options and reports are in metres, whatever the unit of the scene, and times in seconds.
//!
//! To add a step, write its file and add its type to the list in `list.rs`: names, help, text, JSON, reports and the
//! command line follow.

mod blend;
mod body;
mod concat;
mod contacts;
mod despike;
mod drop_first_frame;
mod extract_root;
mod fill;
mod foot_lock;
mod frames;
mod frames_report;
mod ground;
mod in_between;
mod in_place;
mod inertia;
mod layer;
mod list;
mod loop_clip;
mod mirror;
mod pose_distance;
mod quantity;
mod resample;
mod reverse;
mod sequence;
mod smooth;
mod step;
mod text;
mod trim;
mod warp;
mod warp_path;
mod warp_time;

pub use self::blend::{Blend, BlendReport, BlendWeight};
pub use self::concat::{Concat, ConcatReport};
pub(crate) use self::contacts::contacts_of;
pub use self::contacts::{ContactOptions, ContactPoint, DetectedContacts, contacts};
pub use self::despike::{Despike, DespikeReport};
pub use self::drop_first_frame::DropFirstFrame;
pub use self::extract_root::ExtractRoot;
pub use self::fill::{Fill, FillReport};
pub(crate) use self::foot_lock::{Followed, SolePoint, follow_feet};
pub use self::foot_lock::{FootLock, FootLockOptions, FootLockReport, foot_lock};
pub use self::frames_report::FramesReport;
pub use self::in_between::{InBetween, InBetweenReport, KeyInterpolation};
pub use self::in_place::InPlace;
pub use self::layer::{Layer, LayerPart, LayerReport};
pub use self::list::{EditReport, EditStep, StepReport};
pub use self::loop_clip::{Loop, LoopReport};
pub use self::mirror::{Mirror, MirrorReport};
pub use self::resample::Resample;
pub use self::reverse::Reverse;
pub use self::sequence::{apply_all, second_motions};
pub use self::smooth::{Smooth, SmoothFilter, SmoothReport};
pub use self::step::{Step, StepInfo, StepInput, StepKey, Takes};
pub use self::trim::Trim;
pub use self::warp::{Warp, WarpReport};
pub use self::warp_path::{PathFacing, PathPoint, WarpPathReport};
pub use self::warp_time::WarpTimeReport;
