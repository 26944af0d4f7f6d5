//! The result of a comparison: distances and findings.

use std::fmt;

use mocap_scene::report::counted;
use serde::Serialize;

/// The deviation of a written file from its source.
///
/// [`Verification::of`](crate::verify::report::Verification::of) has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Verification {
    /// Frames that were compared, of all clips.
    pub frames: usize,
    /// Joints that were compared.
    pub joints: usize,
    /// End sites that were compared.
    pub end_sites: usize,
    /// The largest distance of a joint from its position in the source, in metres.
    pub max_error: f64,
    /// The root mean square (RMS) of all distances, in metres.
    pub rms_error: f64,
    /// The place and time of the largest distance. Absent if nothing was compared.
    pub worst: Option<LargestDeviation>,
    /// The largest rotation error, as the distance in metres by which it moves a point 3 cm from its joint. If the
    /// joint moves no other joint, its position error is added. In a skeleton smaller than a metre, the point is
    /// nearer, in proportion. If the file's rest pose may differ, as in files of other programs, rotations are relative
    /// to the first frame. Absent if nothing was compared.
    pub rotation_error: Option<f64>,
    /// The loss by resampling. Absent if the file has the frame rate of the source. The errors above do not contain
    /// this loss: they only cover the frames of the file.
    pub resampling: Option<Resampling>,
    /// The clips that were compared.
    pub clips: Vec<VerifiedClip>,
    /// Problems other than distances.
    pub findings: Vec<Finding>,
    /// Joints of the source that the file lacks.
    pub missing: Vec<String>,
    /// End sites of the source that the file lacks; many programs omit end sites.
    pub missing_end_sites: Vec<String>,
    /// Units of the file per unit of the source.
    pub metres_per_unit: f64,
    /// Whether the file records how it was converted.
    pub has_provenance: bool,
}

impl fmt::Display for Verification {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (frames, joints) = (counted(self.frames, "frame"), counted(self.joints, "joint"));
        let (end_sites, most, rms) = (counted(self.end_sites, "end site"), self.max_error, self.rms_error);
        let (most, rms) = (1000.0 * most, 1000.0 * rms);
        write!(
            f,
            "{frames}, {joints}, {end_sites}: error {most:.4} mm at most, {rms:.4} mm RMS"
        )?;
        if let Some(worst) = &self.worst {
            let (joint, frame, seconds) = (&worst.joint, worst.frame, worst.seconds);
            write!(f, "; largest at joint \"{joint}\", frame {frame}, {seconds:.3} s")?;
        }
        if let Some(lost) = &self.resampling {
            let (most, rms, frames) = (1000.0 * lost.max_error, 1000.0 * lost.rms_error, lost.frames);
            write!(
                f,
                "\nloss by resampling: error {most:.4} mm at most, {rms:.4} mm RMS, at the {frames} frames of the source"
            )?;
        }
        // Without a record in the file, the unit was inferred from the lengths of the figure.
        if !self.has_provenance && (self.metres_per_unit - 1.0).abs() > 1e-9 {
            let unit = self.metres_per_unit;
            write!(
                f,
                "\nunit of length: 1 unit of the source is {unit:.6} units of the file"
            )?;
        }
        for finding in &self.findings {
            write!(f, "\n{finding}")?;
        }
        if !self.missing_end_sites.is_empty() {
            write!(
                f,
                "\nend sites missing in the file: {}",
                self.missing_end_sites.join(", ")
            )?;
        }
        Ok(())
    }
}

impl Verification {
    /// Whether the file equals its source: there are no findings, and every joint is within the allowed distance, in
    /// metres, of its position.
    pub fn is_within(&self, max_error: f64) -> bool {
        // An error of NaN is never within the allowed distance.
        self.findings.is_empty()
            && self.max_error <= max_error
            && self.rotation_error.is_none_or(|error| error <= max_error)
    }
}

/// One clip of a file.
///
/// [`Verification::of`](crate::verify::report::Verification::of) has an example.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct VerifiedClip {
    /// The name of the clip in the source.
    pub name: String,
    /// Frames that were compared.
    pub frames: usize,
    /// The largest distance of a joint from its position in the source, in metres.
    pub max_error: f64,
}

/// The loss by resampling: the position errors of joints at the frames of the source, up to the last frame of the file.
///
/// [`Verification::of`](crate::verify::report::Verification::of) has an example.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Resampling {
    /// Frames of the source that were compared.
    pub frames: usize,
    /// The largest distance, in metres.
    pub max_error: f64,
    /// The root mean square (RMS) of all distances, in metres.
    pub rms_error: f64,
    /// The place and time of the largest distance.
    pub worst: Option<LargestDeviation>,
}

/// The place and time of the largest distance.
///
/// [`Verification::of`](crate::verify::report::Verification::of) has an example.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct LargestDeviation {
    /// The index of the clip in the source.
    pub clip: usize,
    /// The joint, by its name in the source.
    pub joint: String,
    /// The frame of the source, or the frame before the compared time.
    pub frame: usize,
    /// Seconds from the start of the file.
    pub seconds: f64,
}

/// A problem other than a distance.
///
/// [`Verification::of`](crate::verify::report::Verification::of) has an example.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Finding {
    /// The kind of the problem.
    pub kind: FindingKind,
    /// The problem, as one sentence without a full stop.
    pub message: String,
}

impl Finding {
    pub(super) fn new(kind: FindingKind, message: impl Into<String>) -> Self {
        let message = message.into();
        Self { kind, message }
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.kind.as_str(), self.message)
    }
}

/// The kinds of [`Finding`]s.
///
/// [`Verification::of`](crate::verify::report::Verification::of) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum FindingKind {
    /// The motion of the file starts after, or ends before, the source's motion.
    MissingFrames,
    /// The motion of the file continues after the end of the source's motion.
    ExtraFrames,
    /// The file holds values between its keys, but the source is linear there.
    Stepped,
    /// The file lacks a clip of the source.
    MissingClip,
    /// The file has an additional clip.
    ExtraClip,
    /// A clip has another name in a file that this crate wrote.
    RenamedClip,
    /// No two units of length have the ratio of the lengths in the file and its source, or the lengths are not in the
    /// unit that the file states.
    Unit,
    /// The up axis of the file's motion is not the axis that the file states.
    UpAxis,
    /// The file lacks a joint of the source.
    MissingJoint,
    /// A joint has another name in the file.
    RenamedJoint,
    /// A joint has another parent in the file.
    MovedJoint,
    /// A file that this crate wrote has an additional joint.
    ExtraJoint,
    /// In arrays, the rest offset of a joint differs from the source.
    Offset,
    /// In arrays, the rotation order of a joint differs from the source.
    RotationOrder,
    /// The bind pose of the file's skin differs from the source.
    Skin,
    /// A mesh or a morph target of the character differs in the file.
    Mesh,
    /// A material or a texture of the character differs in the file.
    Material,
    /// Other contents of the character's file differ.
    Character,
    /// Velocities in arrays do not match the positions.
    Velocity,
    /// An expression or the gaze of a VRM animation is not in the file.
    Face,
    /// A statement of the file about itself is wrong.
    Provenance,
}

impl FindingKind {
    /// The name of the kind in kebab case.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::MissingFrames => "missing-frames",
            Self::ExtraFrames => "extra-frames",
            Self::Stepped => "stepped",
            Self::MissingClip => "missing-clip",
            Self::ExtraClip => "extra-clip",
            Self::RenamedClip => "renamed-clip",
            Self::Unit => "unit",
            Self::UpAxis => "up-axis",
            Self::MissingJoint => "missing-joint",
            Self::RenamedJoint => "renamed-joint",
            Self::MovedJoint => "moved-joint",
            Self::ExtraJoint => "extra-joint",
            Self::Offset => "offset",
            Self::RotationOrder => "rotation-order",
            Self::Skin => "skin",
            Self::Mesh => "mesh",
            Self::Material => "material",
            Self::Character => "character",
            Self::Velocity => "velocity",
            Self::Face => "face",
            Self::Provenance => "provenance",
        }
    }
}
