//! Defines directions along axes, and kinds of rest poses.

use glam::Vec3;
use serde::{Deserialize, Serialize};

use mocap_scene::scene::UpAxis;

/// A direction along an axis of the file.
///
/// [`Figure`](crate::Figure) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[allow(missing_docs, reason = "each says itself")]
pub enum Axis {
    #[serde(rename = "x")]
    X,
    #[serde(rename = "y")]
    Y,
    #[serde(rename = "z")]
    Z,
    #[serde(rename = "-x")]
    NegX,
    #[serde(rename = "-y")]
    NegY,
    #[serde(rename = "-z")]
    NegZ,
    /// The direction is unknown, because the file does not show it.
    #[serde(rename = "unknown")]
    Unknown,
}

impl Axis {
    /// The axis nearest to a direction, and the cosine between the two.
    pub(super) fn nearest(vector: Vec3) -> (Self, f32) {
        let vector = vector.normalize_or_zero();
        let all = [
            (Self::X, vector.x),
            (Self::Y, vector.y),
            (Self::Z, vector.z),
            (Self::NegX, -vector.x),
            (Self::NegY, -vector.y),
            (Self::NegZ, -vector.z),
        ];
        all.into_iter()
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .unwrap_or((Self::Unknown, 0.0))
    }

    /// The unit vector of the axis; `None` if the axis is unknown.
    pub const fn direction(self) -> Option<Vec3> {
        match self {
            Self::X => Some(Vec3::X),
            Self::Y => Some(Vec3::Y),
            Self::Z => Some(Vec3::Z),
            Self::NegX => Some(Vec3::NEG_X),
            Self::NegY => Some(Vec3::NEG_Y),
            Self::NegZ => Some(Vec3::NEG_Z),
            Self::Unknown => None,
        }
    }

    /// The axis as an up axis; `None` if it cannot be an up axis.
    pub const fn up(self) -> Option<UpAxis> {
        match self {
            Self::Y => Some(UpAxis::Y),
            Self::Z => Some(UpAxis::Z),
            Self::NegY => Some(UpAxis::NegY),
            Self::NegZ => Some(UpAxis::NegZ),
            Self::X | Self::NegX | Self::Unknown => None,
        }
    }

    /// The name of the axis, such as `-y`.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::X => "x",
            Self::Y => "y",
            Self::Z => "z",
            Self::NegX => "-x",
            Self::NegY => "-y",
            Self::NegZ => "-z",
            Self::Unknown => "unknown",
        }
    }
}

impl From<UpAxis> for Axis {
    fn from(up: UpAxis) -> Self {
        match up {
            UpAxis::Y => Self::Y,
            UpAxis::Z => Self::Z,
            UpAxis::NegY => Self::NegY,
            UpAxis::NegZ => Self::NegZ,
        }
    }
}

/// The kind of a rest pose.
///
/// [`Figure`](crate::Figure) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum RestPose {
    /// The figure stands with its arms to the sides.
    TPose,
    /// The figure stands with its arms between sideways and down.
    APose,
    /// The figure stands with its arms down.
    IPose,
    /// The bones lie along axes and do not form a figure.
    Collapsed,
    /// Any other pose.
    Other,
}

impl RestPose {
    /// The name of the rest pose in JSON.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::TPose => "t-pose",
            Self::APose => "a-pose",
            Self::IPose => "i-pose",
            Self::Collapsed => "collapsed",
            Self::Other => "other",
        }
    }
}
