//! What a comparison tells: distances, and what is wrong beside them.

use std::fmt;

use mocap_scene::report::counted;
use serde::Serialize;

/// How far a written file is from its source.
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
    /// The root of the mean square of all distances, in metres.
    pub rms_error: f64,
    /// Where and when the largest distance is. Absent where nothing was compared.
    pub worst: Option<LargestDeviation>,
    /// The largest distance in metres by which the rotation of a joint alone moves a point 3 cm from it. If it moves no
    /// other joint, the distance of the joint is added. In a skeleton smaller than a metre the point is nearer, in
    /// proportion. Where the joints of the file may stand otherwise at rest, as in files of other programs, rotations
    /// count from those of the first frame. Absent where nothing was compared.
    pub rotation_error: Option<f64>,
    /// What the motion lost by another frame rate. Absent where it has its own. It is not part of the errors above:
    /// those are about the frames that the file has.
    pub resampling: Option<Resampling>,
    /// The clips that were compared.
    pub clips: Vec<VerifiedClip>,
    /// What is wrong beside distances.
    pub findings: Vec<Finding>,
    /// Joints of the source that the file does not have.
    pub missing: Vec<String>,
    /// End sites of the source that the file does not have; many programs leave them out.
    pub missing_end_sites: Vec<String>,
    /// Units of the file in one of the source.
    pub metres_per_unit: f64,
    /// Whether the file itself says how it was converted.
    pub has_provenance: bool,
}

impl fmt::Display for Verification {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (frames, joints) = (counted(self.frames, "frame"), counted(self.joints, "joint"));
        let (end_sites, most, rms) = (counted(self.end_sites, "end site"), self.max_error, self.rms_error);
        let (most, rms) = (1000.0 * most, 1000.0 * rms);
        write!(
            f,
            "{frames}, {joints}, {end_sites}: {most:.4} mm at most, {rms:.4} mm RMS"
        )?;
        if let Some(worst) = &self.worst {
            let (joint, frame, seconds) = (&worst.joint, worst.frame, worst.seconds);
            write!(f, "; at most at joint \"{joint}\", frame {frame}, {seconds:.3} s")?;
        }
        if let Some(lost) = &self.resampling {
            let (most, rms, frames) = (1000.0 * lost.max_error, 1000.0 * lost.rms_error, lost.frames);
            write!(
                f,
                "\nthe other frame rate: {most:.4} mm at most, {rms:.4} mm RMS, at the {frames} frames of the source"
            )?;
        }
        // What a conversion did is in the file; else the unit is found from the lengths of the figure.
        if !self.has_provenance && (self.metres_per_unit - 1.0).abs() > 1e-9 {
            let unit = self.metres_per_unit;
            write!(f, "\nanother unit of length: 1 of the source is {unit:.6} of the file")?;
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
    /// Whether the file is what its source is: nothing was found, and no joint is farther from its position, in metres,
    /// than allowed.
    pub fn is_within(&self, max_error: f64) -> bool {
        // A NaN is not within anything.
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
    /// Its name in the source.
    pub name: String,
    /// Frames that were compared.
    pub frames: usize,
    /// The largest distance of a joint from its position in the source, in metres.
    pub max_error: f64,
}

/// What a motion lost by another frame rate: how far the joints are from their positions at the frames of the source,
/// up to the last frame of the file.
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
    /// The root of the mean square of all distances, in metres.
    pub rms_error: f64,
    /// Where and when the largest distance is.
    pub worst: Option<LargestDeviation>,
}

/// Where and when the largest distance is.
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
    /// The frame of the source, or that before it.
    pub frame: usize,
    /// Seconds from the start of the file.
    pub seconds: f64,
}

/// Something that is wrong beside distances.
///
/// [`Verification::of`](crate::verify::report::Verification::of) has an example.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Finding {
    /// What kind of thing.
    pub kind: FindingKind,
    /// What exactly, as one sentence without a full stop.
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
    /// The motion of the file starts later or ends earlier than that of the source.
    MissingFrames,
    /// The motion of the file continues after the end of the source's motion.
    ExtraFrames,
    /// The file holds values between its keys, but the source is linear there.
    Stepped,
    /// The source has a clip that the file does not have.
    MissingClip,
    /// The file has a clip that the source does not have.
    ExtraClip,
    /// A clip has another name in the file, which this crate wrote.
    RenamedClip,
    /// The ratio of lengths in the file and in its source is not that of two units of length, or the lengths are in
    /// another unit than the file states.
    Unit,
    /// Another axis points up in the file than it states.
    UpAxis,
    /// The source has a joint that the file does not have.
    MissingJoint,
    /// A joint has another name in the file.
    RenamedJoint,
    /// A joint has another parent in the file.
    MovedJoint,
    /// The file, which this crate wrote, has a joint that the source does not have.
    ExtraJoint,
    /// The offset of a joint at rest is another in arrays.
    Offset,
    /// The order of the rotations of a joint is another in arrays.
    RotationOrder,
    /// The skin of the file is tied to other positions or rotations of its joints than those of the source.
    Skin,
    /// A mesh of the character, or a morph target, is another in the file.
    Mesh,
    /// A material of the character, or a texture, is another in the file.
    Material,
    /// Something else of the character's file is another.
    Character,
    /// Velocities in arrays are not those of the positions.
    Velocity,
    /// An expression or the gaze of a VRM animation is not in the file.
    Face,
    /// What the file says of itself is not so.
    Provenance,
}

impl FindingKind {
    /// Its name in kebab case.
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
