//! Compares joint angles with the angles that a laboratory's program wrote into the file.

use glam::{DQuat, EulerRot};
use mocap_figure::joint_angles::Rotations;
use mocap_scene::scene::Scene;
use serde::Serialize;

use super::JointAngles;
use super::events::keeps_times;

/// Plug-in Gait's names of joint angles, without the letter of the side, and our columns for their x, y and z. An empty
/// name means that no column of ours has the same definition.
const JOINTS: [(&str, [&str; 3]); 4] = [
    (PELVIS, ["pelvis_tilt", "pelvis_list", "pelvis_rotation"]),
    ("HipAngles", ["hip_flexion", "hip_adduction", "hip_rotation"]),
    ("KneeAngles", ["knee_angle", "knee_adduction", "knee_rotation"]),
    ("AnkleAngles", ["ankle_angle", "", "ankle_rotation"]),
];

/// The pelvis angles, which have no side.
const PELVIS: &str = "PelvisAngles";

/// Factors, 1 or -1, that give pelvis columns the signs of Plug-in Gait. In Plug-in Gait three directions are positive:
/// a forward tilt, the foot's own side up, and its own side forward.
const SIGNS: [(&str, [f64; 3]); 2] = [("L", [-1.0, 1.0, -1.0]), ("R", [-1.0, -1.0, 1.0])];

/// The difference between an angle and the same angle in the file, in degrees.
///
/// [`JointAngles::beside_outputs`] has an example.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct OutputDifference {
    /// The label of the model output in the file.
    pub output: String,
    /// The column of [`JointAngles`].
    pub column: String,
    /// The mean of our angle minus the file's angle. Pelvis angles have the signs of the file here.
    pub mean: f64,
    /// The RMS of the difference about its mean.
    pub deviation: f64,
    /// The correlation of the two angles.
    pub correlation: f64,
}

impl JointAngles {
    /// Compares the angles with the angles that Plug-in Gait wrote into the source file. Empty if the file has none, or
    /// if a processing step changed the frames.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::biomechanics::JointAngles;
    ///
    /// let scene = mocap::import("fixtures/real/cmu_short.bvh")?;
    /// assert!(JointAngles::of(&scene)?.beside_outputs(&scene).is_empty()); // BVH has no outputs of a model
    /// # Ok::<(), mocap::Error>(())
    /// ```
    pub fn beside_outputs(&self, scene: &Scene) -> Vec<OutputDifference> {
        let outputs = scene.metadata.recorded.as_deref().filter(|_| keeps_times(scene));
        let mut found = Vec::new();
        for output in outputs.iter().flat_map(|recorded| &recorded.outputs) {
            let label = output.name.rsplit(':').next().unwrap_or_default();
            let (Some(side), Some(name)) = (label.get(..1), label.get(1..)) else {
                continue;
            };
            let Some((start, columns)) = JOINTS.iter().find(|(start, _)| name.starts_with(start)) else {
                continue;
            };
            let ahead = SIGNS.iter().find(|own| *start == PELVIS && own.0 == side);
            let ahead = ahead.and_then(|(_, signs)| self.pelvis_ahead(*columns, *signs));
            for (axis, column) in columns.iter().enumerate().filter(|(_, column)| !column.is_empty()) {
                let theirs = output.values.chunks_exact(3).map(|values| f64::from(values[axis]));
                let (column, own) = match &ahead {
                    Some(angles) => ((*column).to_owned(), Some(angles[axis].clone())),
                    None => {
                        let column = format!("{column}_{}", side.to_lowercase());
                        let own = self.column(&column).map(Iterator::collect);
                        (column, own)
                    }
                };
                let Some(own) = own.filter(|_| theirs.len() == self.frames()) else {
                    continue;
                };
                let pairs = own.into_iter().zip(theirs).filter(|(_, theirs)| !theirs.is_nan());
                found.extend(difference(&output.name, column, &pairs.collect::<Vec<_>>()));
            }
        }
        found
    }

    /// The pelvis angles relative to the laboratory axis that is nearest to the pelvis's facing direction, as Plug-in
    /// Gait defines them.
    fn pelvis_ahead(&self, columns: [&str; 3], signs: [f64; 3]) -> Option<[Vec<f64>; 3]> {
        let [tilt, list, rotation] = columns.map(|column| self.column(column).map(Iterator::collect::<Vec<f64>>));
        let (tilt, list, rotation) = (tilt?, list?, rotation?);
        let sum = |of: fn(f64) -> f64| rotation.iter().map(|angle| of(angle.to_radians())).sum::<f64>();
        let quarters = (sum(f64::sin).atan2(sum(f64::cos)).to_degrees() / 90.0).round();
        let back = DQuat::from_rotation_y((-90.0 * quarters).to_radians());
        let mut angles = columns.map(|_| Vec::new());
        let mut before = None;
        for ((tilt, list), rotation) in tilt.into_iter().zip(list).zip(rotation) {
            let [tilt, list, rotation] = [tilt, list, rotation].map(f64::to_radians);
            let turned = back * DQuat::from_euler(EulerRot::ZXY, tilt, list, rotation);
            let own = Rotations::PLAIN.of(turned, before);
            for axis in 0..3 {
                angles[axis].push(own[axis] * signs[axis]);
            }
            before = Some(own);
        }
        Some(angles)
    }
}

/// Compares pairs of angles, which may differ by whole revolutions.
fn difference(output: &str, column: String, pairs: &[(f64, f64)]) -> Option<OutputDifference> {
    let count = pairs.len() as f64;
    let (first_own, first_their) = *pairs.first()?;
    let turns = ((first_own - first_their) / 360.0).round() * 360.0;
    let mean = |of: &dyn Fn(&(f64, f64)) -> f64| pairs.iter().map(of).sum::<f64>() / count;
    let (own, their) = (mean(&|pair| pair.0 - turns), mean(&|pair| pair.1));
    let product = |a: &dyn Fn(&(f64, f64)) -> f64, b: &dyn Fn(&(f64, f64)) -> f64| mean(&|pair| a(pair) * b(pair));
    let off_own = |pair: &(f64, f64)| pair.0 - turns - own;
    let off_their = |pair: &(f64, f64)| pair.1 - their;
    let off = |pair: &(f64, f64)| off_own(pair) - off_their(pair);
    let sizes = product(&off_own, &off_own) * product(&off_their, &off_their);
    Some(OutputDifference {
        output: output.to_owned(),
        column,
        mean: own - their,
        deviation: product(&off, &off).sqrt(),
        correlation: product(&off_own, &off_their) / sizes.sqrt().max(f64::MIN_POSITIVE),
    })
}
