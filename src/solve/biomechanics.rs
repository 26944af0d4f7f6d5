//! Joint angles and gait as biomechanics laboratories define them, for every humanoid. Neither the file format nor
//! joint names and axes matter.
//!
//! [`JointAngles`] has the joint angles of the International Society of Biomechanics (Wu and others, 2002 and 2005);
//! knees follow Grood and Suntay (1983). [`Gait`] has the events of a walk and the gait table. [`BodyGait`] also
//! names the gaits of animals on four legs. [`TimeSeries`] has analog channels and ground reaction forces.

mod angles;
mod animal_gait;
mod beside;
mod body_gait;
mod cycles;
pub(crate) mod events;
mod forces;
pub(crate) mod gait;
mod mean;
pub(crate) mod plates;
pub mod report;
mod segments;
pub(crate) mod series;
mod table;

pub use self::angles::JointAngles;
pub use self::body_gait::BodyGait;
pub use self::gait::Gait;
pub use self::series::TimeSeries;
