//! A motion on a target, with the report of its quality.

use std::fmt;

use mocap_formats::gltf::report::Provenance;
use mocap_scene::pose::FaceTrack;
use mocap_scene::scene::{Animation, Face, HumanoidBone};
use serde::Serialize;
use serde_json::Value;

use crate::quality::RetargetReport;
use crate::quality::Verdict;
use crate::robot::RobotMotion;
use crate::robot::report::RobotReport;
use mocap_figure::LimbAngles;

/// A motion on a target.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::retarget::{Retargeter, RetargetOptions};
///
/// let walk = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
/// let target = mocap::import("fixtures/skeletons/human_default.gltf")?;
/// let clip = Retargeter::new(walk, target, RetargetOptions::new())?.into_clips().remove(0);
/// assert_eq!(clip.animation.name, "cmu_12_01_walk");
/// assert_eq!(clip.provenance.source.unwrap().name, "cmu_12_01_walk.bvh");
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct RetargetedClip {
    /// The motion for [`Target::scene`](super::Target::scene), with a key at every tick.
    pub animation: Animation,
    /// The source of the motion, and every step. The last step is the retargeting.
    pub provenance: Provenance,
    /// The report of the retargeting.
    pub report: ClipReport,
    /// The positions of a robot's joints, if the target is a robot.
    pub robot_motion: Option<RobotMotion>,
    /// The face of the source, if the source is a VRM animation with a face.
    pub(crate) face: Vec<FaceTrack>,
    /// The extras of the clip in the source, with the times of their events.
    pub(super) extras: Option<Value>,
    /// The angles between the robot's limbs and the limbs of the source, if the target is a robot.
    pub(super) limb_angles: Option<Vec<LimbAngles>>,
}

impl RetargetedClip {
    pub(super) fn of_body(animation: Animation, report: RetargetReport) -> Self {
        Self {
            animation,
            provenance: Provenance::default(),
            report: ClipReport::Body(report),
            robot_motion: None,
            face: Vec::new(),
            extras: None,
            limb_angles: None,
        }
    }

    /// The clip of a face without a body: the body of the target does not move.
    pub(super) fn of_face(source: &Animation) -> Self {
        let animation = Animation {
            channels: Vec::new(),
            ..source.clone()
        };
        let report = RetargetReport {
            verdict: Verdict::Good,
            ..RetargetReport::of_limbs(animation.name.clone(), 0, 1.0, Vec::new())
        };
        Self::of_body(animation, report)
    }

    pub(super) fn of_robot(animation: Animation, report: RobotReport, motion: RobotMotion) -> Self {
        Self {
            animation,
            provenance: Provenance::default(),
            report: ClipReport::Robot(report),
            robot_motion: Some(motion),
            face: Vec::new(),
            extras: None,
            limb_angles: None,
        }
    }

    #[must_use]
    pub(super) fn with_limb_angles(mut self, angles: Vec<LimbAngles>) -> Self {
        self.limb_angles = Some(angles);
        self
    }

    /// Gives the clip the face of its source. A gaze is the rotation of the eyes. If the eyes cannot rotate, the
    /// written file has a warning.
    pub(super) fn set_face(&mut self, face: Vec<FaceTrack>) {
        let has_gaze = face.iter().any(|track| matches!(track.face, Face::LookAt { .. }));
        if let (ClipReport::Body(report), true) = (&mut self.report, has_gaze) {
            let is_eye = |bone: HumanoidBone| matches!(bone, HumanoidBone::LeftEye | HumanoidBone::RightEye);
            report.unmapped.retain(|unmapped| !is_eye(unmapped.bone));
        }
        self.face = face;
    }

    /// Renames the clip everywhere in the output.
    pub(super) fn rename(&mut self, name: String) {
        match &mut self.report {
            ClipReport::Body(report) => report.clip.clone_from(&name),
            ClipReport::Robot(report) => report.clip.clone_from(&name),
        }
        if let Some(motion) = &mut self.robot_motion {
            motion.name.clone_from(&name);
        }
        self.animation.name = name;
    }
}

/// The quality of a motion on its target. JSON has only the contained report, without the name of the variant.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::retarget::report::Verdict;
/// use mocap::retarget::{Retargeter, RetargetOptions};
///
/// let walk = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
/// let target = mocap::import("fixtures/skeletons/human_default.gltf")?;
/// let retargeting = Retargeter::new(walk, target, RetargetOptions::new())?;
/// assert_eq!(retargeting.clips()[0].report.verdict(), Verdict::Good);
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged)]
#[non_exhaustive]
pub enum ClipReport {
    /// A motion on the skeleton of a humanoid.
    Body(RetargetReport),
    /// A motion on a robot.
    Robot(RobotReport),
}

impl fmt::Display for ClipReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Body(report) => report.fmt(f),
            Self::Robot(report) => report.fmt(f),
        }
    }
}

impl ClipReport {
    /// Whether the motion is good enough to use unchanged.
    pub fn verdict(&self) -> Verdict {
        match self {
            Self::Body(report) => report.verdict,
            Self::Robot(report) => report.verdict,
        }
    }

    /// The reasons why the verdict is not good, the worst first; empty for a good verdict.
    #[doc(hidden)]
    pub fn reasons(&self) -> Vec<String> {
        match self {
            Self::Body(report) => report.reasons(),
            Self::Robot(report) => report.reasons(),
        }
    }

    /// The name of the clip.
    pub fn name(&self) -> &str {
        match self {
            Self::Body(report) => &report.clip,
            Self::Robot(report) => &report.clip,
        }
    }

    /// The mean angle between the limbs of the target and the limbs of the source, in degrees.
    pub fn mean_degrees(&self) -> f64 {
        match self {
            Self::Body(report) => report.mean_degrees,
            Self::Robot(report) => report.mean_degrees,
        }
    }

    /// The report of a motion on a skeleton.
    pub fn body(&self) -> Option<&RetargetReport> {
        match self {
            Self::Body(report) => Some(report),
            Self::Robot(_) => None,
        }
    }

    /// The report of a motion on a robot.
    pub fn robot(&self) -> Option<&RobotReport> {
        match self {
            Self::Body(_) => None,
            Self::Robot(report) => Some(report),
        }
    }
}
