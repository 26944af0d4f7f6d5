//! The fit of a skeleton to the markers that it was solved from.

use serde::{Deserialize, Serialize};

/// The fit of a skeleton to the markers that it was solved from, and the certainty of its joints.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// let importer = mocap::Importer::new().markers("auto");
/// let scene = importer.import("fixtures/markers/cmu_01_01.c3d")?;
/// let solved = scene.metadata.solved.as_ref().expect("there are markers");
/// assert!(solved.markers.iter().all(|marker| marker.seen > 0.9 && marker.rms < 0.03));
/// let thigh = solved.joints.iter().find(|joint| joint.name == "leftLowerLeg").expect("a knee");
/// assert!(thigh.length > 0.3 && thigh.is_told);
/// assert!(solved.swaps.is_empty());
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct MarkerSolution {
    /// The markers that were used.
    pub markers: Vec<SolvedMarker>,
    /// The RMS distance in metres of all markers from their bodies, for each second of the take.
    pub rms_of_seconds: Vec<f64>,
    /// All joints except the root.
    pub joints: Vec<SolvedJoint>,
    /// Markers that exchanged their labels.
    pub swaps: Vec<SwappedMarkers>,
    /// The joints with frames in which too few markers are seen to determine the joint.
    pub filled: Vec<FilledJoint>,
    /// The number of frames that were solved.
    pub frames: usize,
}

/// A marker's fit to the body.
///
/// [`MarkerSolution`] has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SolvedMarker {
    /// The label in the file.
    pub label: String,
    /// The landmark, by its name in `docs/markers.md`.
    pub landmark: String,
    /// The RMS distance in metres of the marker from its position on the body.
    pub rms: f64,
    /// The largest distance in metres.
    pub worst: f64,
    /// The frame of the largest distance.
    pub worst_frame: usize,
    /// The fraction of frames in which the marker is seen, from 0 to 1.
    pub seen: f64,
    /// The number of frames in which the marker is so far from its body that it has little weight.
    pub far: usize,
}

/// A joint: its distance from the parent, and the certainty of its position.
///
/// [`MarkerSolution`] has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SolvedJoint {
    /// The name of the joint.
    pub name: String,
    /// The distance from the parent in metres.
    pub length: f64,
    /// The standard deviation in metres of the position relative to the parent, from the covariance of the fit; `None`
    /// if the position was not fitted.
    pub deviation: Option<f64>,
    /// Whether the motion determines the position of this joint. It does if `deviation` is less than half of the
    /// standard deviation of the published regression.
    pub is_told: bool,
}

/// Two markers that exchanged their labels.
///
/// [`MarkerSolution`] has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SwappedMarkers {
    /// The two labels.
    pub labels: [String; 2],
    /// The first frame.
    pub first: usize,
    /// The last frame.
    pub last: usize,
}

/// A span of frames in which a joint's rotation is interpolated. A curve through the frames before and after the span
/// determines the rotation.
///
/// [`MarkerSolution`] has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct FilledJoint {
    /// The name of the joint.
    pub joint: String,
    /// The first frame.
    pub first: usize,
    /// The last frame.
    pub last: usize,
}
