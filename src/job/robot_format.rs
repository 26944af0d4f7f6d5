//! The formats of motions on robots.

use mocap_formats::Export;
use mocap_formats::gltf::report::Provenance;
use mocap_retarget::robot::{Robot, RobotMotion};
use mocap_retarget::{Retargeter, Target};
use mocap_scene::error::{Code, Diagnostic, Result};

use crate::arrays::{self, trainers};

/// A format for the joint positions of a robot. Every format that [`FormatInfo::ALL`](mocap_formats::FormatInfo::ALL)
/// writes can also store the links of a robot, as an animated skeleton.
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
    /// The same arrays as a pickle, as GMR writes
    Pkl,
    /// Rows: position and rotation (x y z w) of the base, joints
    Csv,
    /// NumPy arrays for MuJoCo: qpos, with rotations as w x y z
    Qpos,
    /// The pickle that GMR's tools load
    Gmr,
    /// Rows as in LAFAN1 for Unitree's robots, at 30 frames per second
    UnitreeCsv,
    /// NumPy arrays for mjlab, at 50 frames per second, joints and bodies depth-first
    Mjlab,
    /// NumPy arrays for BeyondMimic, at 50 frames per second, joints and bodies breadth-first
    BeyondMimic,
    /// NumPy arrays for the AMP tasks of Isaac Lab, bodies and joints breadth-first
    IsaacLab,
    /// NumPy arrays for ProtoMotions
    ProtoMotions,
    /// The pickle that MimicKit loads
    MimicKit,
    /// The pickle that TWIST loads: GMR's pickle with the positions of links
    Twist,
    /// The pickle that ASAP and PBHC load: motions by name
    Asap,
    /// JSON of the four-legged robot MAX: base and joints, leg by leg
    Max,
    /// NumPy arrays of the inverse dynamics, with MuJoCo's names: qpos, qvel, qacc and qfrc_inverse
    Dynamics,
}

impl RobotFormat {
    /// All formats.
    pub const ALL: [Self; 15] = [
        Self::Npz,
        Self::Pkl,
        Self::Csv,
        Self::Qpos,
        Self::Gmr,
        Self::UnitreeCsv,
        Self::Mjlab,
        Self::BeyondMimic,
        Self::IsaacLab,
        Self::ProtoMotions,
        Self::MimicKit,
        Self::Twist,
        Self::Asap,
        Self::Max,
        Self::Dynamics,
    ];

    /// The extension of the files in this format.
    pub const fn extension(self) -> &'static str {
        match self {
            Self::Pkl | Self::Gmr | Self::MimicKit | Self::Twist | Self::Asap => "pkl",
            Self::Csv | Self::UnitreeCsv => "csv",
            Self::Max => "json",
            _ => "npz",
        }
    }

    /// The name that users type.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Npz | Self::Pkl | Self::Csv => self.extension(),
            Self::Qpos => "qpos",
            Self::Gmr => "gmr",
            Self::UnitreeCsv => "unitree-csv",
            Self::Mjlab => "mjlab",
            Self::BeyondMimic => "beyondmimic",
            Self::IsaacLab => "isaaclab",
            Self::ProtoMotions => "protomotions",
            Self::MimicKit => "mimickit",
            Self::Twist => "twist",
            Self::Asap => "asap",
            Self::Max => "max",
            Self::Dynamics => "dynamics",
        }
    }

    /// The frame rate that readers of the format assume.
    pub fn rate(self) -> Option<f64> {
        match self {
            Self::UnitreeCsv => Some(30.0),
            Self::Mjlab | Self::BeyondMimic => Some(50.0),
            _ => None,
        }
    }

    /// The format of this name.
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
    /// [`Code::NoMotion`] without a motion; [`Code::Unrepresentable`] for several motions; [`Code::MissingFeature`] if
    /// this build cannot write NumPy archives.
    pub fn write(self, retargeting: &Retargeter) -> Result<Export> {
        let clips = retargeting.clips().iter();
        let mut motions = clips.filter_map(|clip| Some((clip.robot_motion.as_ref()?, &clip.provenance)));
        let (Some((motion, provenance)), Target::Robot(robot)) = (motions.next(), retargeting.target()) else {
            return Err(Diagnostic::new(Code::NoMotion, "there is no motion on a robot").into());
        };
        if motions.next().is_some() {
            let message = format!(
                "a {} file of a robot holds one motion; name only one motion",
                self.name()
            );
            return Err(Diagnostic::new(Code::Unrepresentable, message).into());
        }
        self.write_motion(motion, robot, provenance)
    }

    /// The file of a motion of `robot`.
    pub(super) fn write_motion(self, motion: &RobotMotion, robot: &Robot, provenance: &Provenance) -> Result<Export> {
        let metadata = serde_json::json!({
            "mocap": env!("CARGO_PKG_VERSION"),
            "robot": robot.name,
            "motion": motion.name,
            "origin": provenance,
        });
        let metadata = metadata.to_string();
        Ok(match self {
            Self::Pkl | Self::Gmr => Export::from(arrays::robot_pickle(motion)),
            Self::Csv | Self::UnitreeCsv => Export::from(arrays::robot_csv(motion, robot).into_bytes()),
            Self::Max => Export::from(trainers::for_max(motion, robot)?.into_bytes()),
            Self::MimicKit => Export::from(trainers::for_mimic_kit(motion, &metadata)),
            Self::Twist => Export::from(trainers::for_twist(motion, robot, &metadata)),
            Self::Asap => Export::from(trainers::for_asap(motion, robot, &metadata)?),
            _ => Export::from(self.archive(motion, robot, &metadata)?),
        })
    }

    #[cfg(feature = "npz")]
    #[expect(clippy::unnecessary_wraps, reason = "a build without archives fails")]
    fn archive(self, motion: &RobotMotion, robot: &Robot, metadata: &str) -> Result<Vec<u8>> {
        use mocap_retarget::robot::LinkOrder;

        use crate::arrays::npz::of_arrays;

        let tracking = |order| of_arrays(&trainers::for_tracking(motion, robot, order, metadata));
        Ok(match self {
            Self::Qpos => arrays::robot_qpos_npz(motion),
            Self::Mjlab => tracking(LinkOrder::DepthFirst),
            Self::BeyondMimic => tracking(LinkOrder::BreadthFirst),
            Self::IsaacLab => of_arrays(&trainers::for_isaac_lab(motion, robot, metadata)),
            Self::Dynamics => of_arrays(&trainers::for_dynamics(motion, robot, metadata)),
            Self::ProtoMotions => of_arrays(&trainers::for_proto_motions(motion, metadata)),
            _ => arrays::robot_npz(motion),
        })
    }

    #[cfg(not(feature = "npz"))]
    fn archive(self, _: &RobotMotion, _: &Robot, _: &str) -> Result<Vec<u8>> {
        let message = "this build cannot write NumPy's .npz";
        let help = "build it with the feature npz, or write .csv";
        Err(Diagnostic::new(Code::MissingFeature, message).help(help).into())
    }
}
