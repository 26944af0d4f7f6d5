//! What is known of a skeleton that was solved from markers.

use serde::{Deserialize, Serialize};

/// How well a skeleton that was solved from markers explains them, and how well its joints are known.
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
    /// Each marker that takes part.
    pub markers: Vec<SolvedMarker>,
    /// The distance of all markers from their bodies, as RMS in metres, in each second of the take.
    pub rms_of_seconds: Vec<f64>,
    /// Each joint but the root.
    pub joints: Vec<SolvedJoint>,
    /// Markers that had the labels of each other.
    pub swaps: Vec<SwappedMarkers>,
}

/// A marker beside the body that explains it.
///
/// [`MarkerSolution`] has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SolvedMarker {
    /// Its label in the file.
    pub label: String,
    /// The landmark that it is, as `docs/markers.md` names them.
    pub landmark: String,
    /// Its distance from where the body has it, as RMS in metres.
    pub rms: f64,
    /// The largest distance in metres, and its frame.
    pub worst: f64,
    /// The frame of the largest distance.
    pub worst_frame: usize,
    /// The part of the frames in which it is seen, 0 to 1.
    pub seen: f64,
    /// Frames in which it is so far from its body that it has little weight.
    pub far: usize,
}

/// A joint: how far it is from its parent, and how well that is known.
///
/// [`MarkerSolution`] has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SolvedJoint {
    /// Its name.
    pub name: String,
    /// The distance from its parent in metres.
    pub length: f64,
    /// The standard deviation of its position beside its parent in metres, from the covariance of the fit; `None` where
    /// it is not fitted.
    pub deviation: Option<f64>,
    /// Whether the motion determines it: the deviation is less than half of that of the regression alone.
    pub is_told: bool,
}

/// Two markers that had the labels of each other.
///
/// [`MarkerSolution`] has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SwappedMarkers {
    /// Their labels.
    pub labels: [String; 2],
    /// The first frame.
    pub first: usize,
    /// The last frame.
    pub last: usize,
}
