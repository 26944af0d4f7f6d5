//! Live motion over a network: the VMC protocol of VTuber programs and trackers.
//!
//! A packet of VMC is Open Sound Control over UDP. It has the rotation of each humanoid bone relative to its parent,
//! with no rotation in the T-pose, in Unity's axes. This module opens no socket:
//!
//! | type | from | to |
//! |---|---|---|
//! | [`VmcRecorder`] | the bytes of packets | a scene |
//! | [`VmcPoses`] | packets | poses as they arrive |
//! | [`VmcMotion`] | a scene and a time | packets |
//! | [`VmcCleaner`] | packets | packets without noise, after a delay |
//! | [`VmcBridge`] | packets | packets for another body |
//!
//! `docs/live.md` has the axes.
//!
//! ```
//! # std::env::set_current_dir("../..").unwrap();
//! use mocap::live::{VmcMotion, VmcRecorder};
//!
//! let mut scene = mocap::import("fixtures/real/cmu_short.bvh")?;
//! mocap::Conversion::new().apply(&mut scene)?;
//! let motion = VmcMotion::new(&scene)?;
//! let mut recorder = VmcRecorder::new();
//! for frame in 0..30 {
//!     let seconds = f64::from(frame) / 60.0;
//!     for packet in motion.packets(seconds) {
//!         recorder.hear(&packet, seconds);
//!     }
//! }
//! let recorded = recorder.scene()?;
//! assert_eq!(recorded.animations[0].ticks_per_second, 60.0);
//! assert_eq!(recorded.animations[0].duration, 29.0);
//! # Ok::<(), mocap::Error>(())
//! ```

mod bridge;
mod clean;
mod clock;
mod play;
mod poses;
mod record;
pub mod report;
#[doc(hidden)]
pub(crate) mod vmc;

pub use self::bridge::VmcBridge;
#[doc(hidden)]
pub use self::clean::VmcCleaner;
pub use self::play::VmcMotion;
#[doc(hidden)]
pub use self::poses::VmcPoses;
pub use self::record::VmcRecorder;
