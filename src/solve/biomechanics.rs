//! Joint angles and gait, as laboratories of biomechanics state them, of any humanoid: whatever its file, its names and
//! the frames of its joints.
//!
//! [`JointAngles`] are the angles of the International Society of Biomechanics (Wu and others, 2002 and 2005), knees as
//! Grood and Suntay (1983) have them. [`Gait`] has the events of a walk and the table that is made of them.
//! [`TimeSeries`] has analog channels and ground reaction forces.

mod angles;
mod beside;
pub(crate) mod events;
mod forces;
pub(crate) mod gait;
pub mod report;
mod segments;
pub(crate) mod series;
mod table;

pub use self::angles::JointAngles;
pub use self::gait::Gait;
pub use self::series::TimeSeries;
