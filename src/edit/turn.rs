//! Rotates a motion about the vertical axis.

use std::fmt;

use glam::{Mat4, Quat, Vec3};
use mocap_figure::axes::angle_about;
use mocap_figure::{Axis, HumanoidBone as Bone};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::pose::Pose;
use mocap_scene::scene::Scene;
use serde::Serialize;

use super::body::figure_of;
use super::carrier::{Carrier, move_all};
use super::frames::Frames;
use super::quantity::degrees;
use super::step::step;
use super::{Step, StepInput, StepKey, ValueKind};

step! {
    /// Rotates a motion about the vertical line through the figure's position in the first frame. The step rotates by a
    /// given angle, or until the figure faces a given direction in the first frame. It also rotates everything else
    /// that the animation moves. Give either `by` or `facing`.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::edit::{Step, StepInput, Turn};
    /// use mocap::figure::Axis;
    ///
    /// let mut scene = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
    /// let report = Turn::new().facing(Some(Axis::X)).apply(&mut scene, &StepInput::new())?;
    /// assert!((85.0..95.0).contains(&report.by)); // from +Z
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// - [`Code::NoMotion`] if the scene lacks the animation
    /// - [`Code::InvalidValue`] without an angle or a direction, with both, and for a direction that is not level
    /// - [`Code::NotHumanoid`] for a direction, if the skeleton shows no facing
    Turn {
        /// The angle in degrees, counterclockwise as seen from above.
        by: Option<f64> = None, ValueKind::Degrees;
        /// The axis of the scene along which the figure faces in the first frame of the result.
        facing: Option<Axis> = None, ValueKind::OneOf(&["x", "-x", "y", "-y", "z", "-z"]);
    }
}

impl Step for Turn {
    const NAME: &'static str = "turn";
    const HELP: &'static str = "turn about the vertical, by an angle or to look along an axis";
    const KEYS: &'static [StepKey] = Self::OPTIONS;
    const TAKES_BONES: bool = true;
    type Report = TurnReport;

    fn change(&self, scene: &mut Scene, input: &StepInput<'_>) -> Result<TurnReport> {
        let mut frames = Frames::new(scene, input.animation, &[])?;
        frames.require_nodes()?;
        let carrier = Carrier::new(scene, &frames);
        let refuse = |message: String| Err(Diagnostic::new(Code::InvalidValue, message).into());
        let by = match (self.by, self.facing) {
            (Some(by), None) if by.is_finite() => by.to_radians() as f32,
            (Some(by), None) => return refuse(format!("by must be a finite angle in degrees, got {by}")),
            (None, Some(axis)) => {
                let direction = axis.direction().filter(|axis| axis.dot(carrier.up).abs() < 0.5);
                let Some(direction) = direction else {
                    return refuse(format!("facing takes an axis along the ground, got {}", axis.as_str()));
                };
                angle_about(carrier.up, looks(scene, &frames, input, carrier.up)?, direction).unwrap_or(0.0)
            }
            _ => return refuse("turn takes either by=DEGREES or facing=AXIS".to_owned()),
        };
        let pivot = carrier.position(&frames.row(0));
        let turn = Mat4::from_quat(Quat::from_axis_angle(carrier.up, by));
        let motion = Mat4::from_translation(pivot) * turn * Mat4::from_translation(-pivot);
        let moved = move_all(scene, &mut frames, motion);
        frames.write(scene, input.animation, &moved, &moved);
        Ok(TurnReport { by: by.to_degrees() })
    }
}

/// The direction that the figure faces in the first frame. It is perpendicular to the lines from hip joint to hip joint
/// and from shoulder to shoulder.
fn looks(scene: &Scene, frames: &Frames, input: &StepInput<'_>, up: Vec3) -> Result<Vec3> {
    let bones = figure_of(scene, input.bones())?.humanoid.with_sides_of_the_body();
    let mut pose = Pose::rest(scene);
    frames.pose(0, &mut pose);
    let line = |(left, right): (Bone, Bone)| {
        let (left, right) = (bones.joint(left)?, bones.joint(right)?);
        (pose.position(left) - pose.position(right)).try_normalize()
    };
    let lines = [
        (Bone::LeftUpperLeg, Bone::RightUpperLeg),
        (Bone::LeftUpperArm, Bone::RightUpperArm),
    ];
    let left: Vec3 = lines.into_iter().filter_map(line).sum();
    let forward = left.cross(up);
    let nowhere = "the figure does not stand upright in the first frame, so its facing is undefined";
    (forward.length() > 0.1).then_some(forward).ok_or_else(|| {
        Diagnostic::new(Code::NotHumanoid, nowhere)
            .help("turn the motion by an angle: by=90")
            .into()
    })
}

/// The report of [`Turn`].
///
/// [`Turn`](crate::Turn) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct TurnReport {
    /// The angle in degrees, counterclockwise as seen from above.
    pub by: f32,
}

impl fmt::Display for TurnReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "by {}", degrees(self.by))
    }
}
