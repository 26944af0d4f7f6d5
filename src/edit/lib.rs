//! Steps that change a motion, each with a report of its changes.
//!
//! Each step is a type with its options, which implements [`Step`]. The enum [`EditStep`] has a variant for each step.
//! A step changes one animation of a scene, and calls no other step. A step that needs the bones of the body takes them
//! from the [`StepInput`], or otherwise from [`Humanoid::of`](mocap_figure::Humanoid::of). If the skeleton is no
//! humanoid, such a step fails with [`Code::NotHumanoid`](mocap_scene::Code::NotHumanoid).
//!
//! Lengths in options and reports are in metres, whatever the unit of the scene, and times are in seconds.
//!
//! To add a step, write its file, and add a line to the list at the end of this file. The name, the help, the text, the
//! JSON, the report and the command line of the step follow from this line.

// Tests may unwrap and print; the library may not.
#![warn(clippy::unwrap_used, clippy::print_stdout, clippy::print_stderr)]

mod alike;
mod body;
mod bridge;
mod carrier;
mod chain;
mod clean_weights;
mod contacts;
mod fit;
mod flips;
mod floor;
mod frames;
mod frames_report;
pub mod graph;
mod held;
mod inertia;
#[doc(hidden)]
pub mod internals;
mod layer_part;
mod limb;
mod list;
mod lock;
mod pair;
mod pose_distance;
mod quantity;
mod sequence;
mod step;
mod target;
mod text;
mod twist;
mod value;
mod walk;
mod warp_path;
mod warp_time;
mod window;
mod work;

#[doc(hidden)]
pub use self::body::knee_at_rest;
#[doc(hidden)]
pub use self::clean::{LiveClean, MotionErrors};
pub use self::clean_weights::CleanWeights;
pub use self::contacts::ContactOptions;
#[doc(hidden)]
pub use self::contacts::{LiveContacts, contacts_of};
pub use self::layer_part::LayerPart;
pub use self::limb::Limb;
pub use self::lock::FootLockWeights;
#[doc(hidden)]
pub use self::lock::{FootGuide, SolePoint, follow_feet};
#[doc(hidden)]
pub use self::lock::{FootLockOptions, foot_lock};
#[doc(hidden)]
pub use self::sequence::Fitted;
#[doc(hidden)]
pub use self::step::StepDocs;
pub use self::step::{Step, StepInput};
#[doc(hidden)]
pub use self::step::{StepInfo, StepKey, ValueKind};
pub use self::target::ReachTarget;
#[doc(hidden)]
pub use self::value::metres;
pub use self::warp_path::{PathFacing, PathPoint};

// One line for each step, in the order of the help: its file, its type, the other public items of the file, and its
// report.
self::list::steps! {
    report {
        contacts: ContactPoint;
        contacts: DetectedContacts;
        frames_report: FramesReport;
        held: LimbReport;
        list: EditReport;
        lock: FootLockReport;
        walk: WalkReport;
        warp_path: WarpPathReport;
        warp_time: WarpTimeReport;
    }
    foot_lock: FootLock;
    mirror: Mirror => MirrorReport;
    smooth: Smooth, SmoothFilter => SmoothReport;
    despike: Despike => DespikeReport;
    fill: Fill => FillReport, PointGaps;
    clean: Clean, CleanPart => CleanMeasures, CleanOutcome, CleanReport, CleanedPart;
    loop_clip: Loop => LoopReport;
    concat: Concat => ConcatReport;
    blend: Blend, BlendWeight => BlendReport;
    layer: Layer => LayerReport;
    warp: Warp => WarpReport;
    in_between: InBetween, KeyInterpolation => InBetweenReport;
    trim: Trim;
    resample: Resample;
    drop_first_frame: DropFirstFrame;
    in_place: InPlace;
    extract_root: ExtractRoot;
    reverse: Reverse;
    rest: Rest, StandingPose => RestReport;
    t_pose_first: TPoseFirst;
    bone_axis: BoneAxis => BoneAxisReport;
    reach: Reach => ReachReport;
    pin: Pin => PinReport;
    look_at: LookAt => LookAtReport;
    ground: Ground => GroundReport;
    turn: Turn => TurnReport;
}
