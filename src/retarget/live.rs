//! Motion as it comes over a network: the VMC protocol, which programs of VTubers and trackers speak.
//!
//! A packet of VMC is Open Sound Control over UDP: the rotation of each bone of a humanoid against its parent, without
//! rotation in the T-pose, as Unity has it. No socket is opened here:
//!
//! | type | from | to |
//! |---|---|---|
//! | [`VmcRecorder`] | the bytes of packets | a scene |
//! | [`VmcPoses`] | packets | poses as they come |
//! | [`VmcMotion`] | a scene at a time | packets |
//! | [`VmcCleaner`] | packets as they come | packets without noise |
//! | [`VmcBridge`] | packets | packets on another body |
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
