//! The formats of motions on robots.

use crate::error::{Code, Diagnostic, Result};
use crate::format::Written;
use crate::retargeting::{Retargeting, Target};
use crate::robot::RobotMotion;

/// A format of the positions of a robot's joints. The links of a robot, as an animated skeleton, are written in every
/// format that [`FORMATS`](crate::FORMATS) writes.
///
/// ```
/// use mocap::job::RobotFormat;
///
/// assert_eq!(RobotFormat::Qpos.extension(), "npz");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum RobotFormat {
    /// NumPy arrays: fps, root_pos, root_rot (x y z w), dof_pos, dof_names
    Npz,
    /// The same as a pickle, as GMR writes it
    Pkl,
    /// Rows: position and rotation (x y z w) of the base, joints
    Csv,
    /// NumPy arrays for MuJoCo: qpos, with rotations as w x y z
    Qpos,
}

impl RobotFormat {
    /// Every one.
    pub const ALL: [Self; 4] = [Self::Npz, Self::Pkl, Self::Csv, Self::Qpos];

    /// The extension of its files.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Npz | Self::Qpos => "npz",
            Self::Pkl => "pkl",
            Self::Csv => "csv",
        }
    }

    /// The name that users type.
    pub fn name(self) -> &'static str {
        match self {
            Self::Qpos => "qpos",
            _ => self.extension(),
        }
    }

    /// The format that users name so.
    ///
    /// ```
    /// use mocap::job::RobotFormat;
    ///
    /// assert_eq!(RobotFormat::named("qpos"), Some(RobotFormat::Qpos));
    /// ```
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|format| format.name() == name)
    }

    /// The file of the motion.
    ///
    /// # Errors
    /// [`Code::NoMotion`] where there is none; [`Code::Unrepresentable`] where there are several;
    /// [`Code::MissingFeature`] where this build has no archives of NumPy.
    pub fn write(self, retargeting: &Retargeting) -> Result<Written> {
        let mut motions = retargeting.clips().iter().filter_map(|clip| clip.robot_motion.as_ref());
        let (Some(motion), Target::Robot(robot)) = (motions.next(), retargeting.target()) else {
            return Err(Diagnostic::new(Code::NoMotion, "there is no motion on a robot").into());
        };
        if motions.next().is_some() {
            let message = format!("a {} of a robot has one motion; name one", self.name());
            return Err(Diagnostic::new(Code::Unrepresentable, message).into());
        }
        Ok(match self {
            Self::Npz | Self::Qpos => Written::from(self.archive(motion)?),
            Self::Pkl => Written::from(motion.to_pickle()),
            Self::Csv => Written::from(motion.to_csv(robot).into_bytes()),
        })
    }

    #[cfg(feature = "npz")]
    #[expect(clippy::unnecessary_wraps, reason = "a build without archives fails")]
    fn archive(self, motion: &RobotMotion) -> Result<Vec<u8>> {
        Ok(match self {
            Self::Qpos => motion.to_qpos_npz(),
            _ => motion.to_npz(),
        })
    }

    #[cfg(not(feature = "npz"))]
    fn archive(self, _: &RobotMotion) -> Result<Vec<u8>> {
        let message = "this build cannot write NumPy's .npz";
        let help = "build it with the feature npz, or write .csv";
        Err(Diagnostic::new(Code::MissingFeature, message).help(help).into())
    }
}
