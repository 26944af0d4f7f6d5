//! The formats of motions on robots.

use std::path::Path;

use super::writing::Writing;
use crate::error::{Code, Diagnostic, Result};
use crate::export::Exporter;
use crate::format::Written;
use crate::retargeting::{Retargeting, Target};
use crate::robot::RobotMotion;
use crate::scene::Format;

/// A format of the motion of a robot.
///
/// ```
/// use mocap::job::RobotFormat;
///
/// assert_eq!(RobotFormat::Qpos.extension(), "npz");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
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
    /// The links of the robot as an animated skeleton, in glTF
    Glb,
}

impl RobotFormat {
    /// Every one.
    pub const ALL: [Self; 5] = [Self::Npz, Self::Pkl, Self::Csv, Self::Qpos, Self::Glb];

    /// The extension of its files.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Npz | Self::Qpos => "npz",
            Self::Pkl => "pkl",
            Self::Csv => "csv",
            Self::Glb => "glb",
        }
    }

    /// The name that users type.
    pub fn name(self) -> &'static str {
        match self {
            Self::Qpos => "qpos",
            _ => self.extension(),
        }
    }

    /// The format that the extension of a file names.
    pub fn of_output(path: &Path) -> Option<Self> {
        let extension = path.extension()?;
        let mut formats = Self::ALL.into_iter().filter(|format| *format != Self::Qpos);
        formats.find(|format| extension.eq_ignore_ascii_case(format.extension()))
    }

    /// The format of a job.
    pub(super) fn of(writing: &Writing) -> Result<Self> {
        let name = writing.extension();
        Self::ALL
            .into_iter()
            .find(|format| format.name() == name)
            .ok_or_else(|| {
                let message = format!("a motion on a robot is not written as {name:?}");
                let names = Self::ALL.map(Self::name).join(", ");
                Diagnostic::new(Code::UnknownFormat, message)
                    .expected_found(names, format!("{name:?}"))
                    .into()
            })
    }

    /// The file of the first motion.
    ///
    /// # Errors
    /// [`Code::NoMotion`] where there is none; [`Code::MissingFeature`] where this build has no archives of NumPy.
    pub fn write(self, retargeting: &Retargeting) -> Result<Written> {
        let motion = retargeting.clips().iter().find_map(|clip| clip.robot_motion.as_ref());
        let (Some(motion), Target::Robot(robot)) = (motion, retargeting.target()) else {
            return Err(Diagnostic::new(Code::NoMotion, "there is no motion on a robot").into());
        };
        Ok(match self {
            Self::Npz | Self::Qpos => Written::from(self.archive(motion)?),
            Self::Pkl => Written::from(motion.to_pickle()),
            Self::Csv => Written::from(motion.to_csv(robot).into_bytes()),
            Self::Glb => Exporter::new().write(&retargeting.scene_in_metres()?, Format::Gltf)?,
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
