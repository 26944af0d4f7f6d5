//! Steps that change a motion, each with a report of what it changed and by how much.
//!
//! A step is a function on `&mut Scene` that changes one of its animations, given by its index. No step calls another.
//! Those that need to know the body take the bones that [`humanoid`](crate::figure::humanoid()) finds, and fail with
//! [`Code::NotHumanoid`](crate::Code::NotHumanoid) if it finds none. Bones keep their lengths.
//!
//! Lengths in options and reports are in metres, whatever the unit of the scene, and times in seconds.

mod blend;
mod body;
mod concat;
mod contacts;
mod despike;
mod fill;
mod foot_lock;
mod frames;
mod ground;
mod in_between;
mod inertia;
mod layer;
mod loop_clip;
mod mirror;
mod pose_distance;
mod smooth;
mod step;
mod warp_path;
mod warp_time;

pub use self::blend::{BlendReport, BlendWeight, blend};
pub use self::concat::{ConcatOptions, ConcatReport, concat};
pub use self::contacts::{ContactOptions, ContactPoint, DetectedContacts, contacts};
pub(crate) use self::contacts::{Thresholds, contacts_of, level, low_and_slow};
pub use self::despike::{DespikeOptions, DespikeReport, despike};
pub use self::fill::{FillOptions, FillReport, fill};
pub(crate) use self::foot_lock::{Followed, SolePoint, follow_feet};
pub use self::foot_lock::{FootLockOptions, FootLockReport, foot_lock};
pub use self::in_between::{InBetweenOptions, InBetweenReport, KeyInterpolation, in_between};
pub use self::layer::{LayerPart, LayerReport, layer};
pub use self::loop_clip::{LoopOptions, LoopReport, loop_clip};
pub use self::mirror::{MirrorReport, mirror};
pub use self::smooth::{SmoothFilter, SmoothOptions, SmoothReport, smooth};
pub use self::step::{EDIT_STEPS, EditReport, EditStep};
pub use self::warp_path::{PathFacing, PathPoint, WarpPathOptions, WarpPathReport, warp_path};
pub use self::warp_time::{WarpTimeReport, warp_time};
