//! Takes a part of the body from another motion.

use std::fmt;

use mocap_scene::error::Result;
use mocap_scene::pose::Trs;
use mocap_scene::scene::Scene;
use serde::Serialize;

use super::body::figure_of;
use super::layer_part::LayerPart;
use super::pair::pair;
use super::quantity::counted;
use super::step::step;
use super::{Step, StepInput, StepKey, ValueKind};

step! {
    /// Takes the rotations of a part of the body from a second motion, which has the same joints. A rotation is
    /// relative to the parent joint. Both motions start at the same time. If the second motion ends first, the part of
    /// the body keeps its last pose.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::edit::{Layer, LayerPart, Step, StepInput};
    ///
    /// let mut scene = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
    /// let other = scene.clone();
    /// let report = Layer::new().part(LayerPart::Arms).apply(&mut scene, &StepInput::new().other(&other))?;
    /// assert_eq!(report.frames, 524);
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// The errors of [`Concat`](crate::Concat), and [`Code::NotHumanoid`](mocap_scene::Code::NotHumanoid).
    Layer {
        /// The number of the second motion among the inputs of a command, from 2. Default: the next one.
        with: Option<usize> = None, ValueKind::Input;
        /// The part of the body. Default: the spine and all joints above it, with the arms.
        part: LayerPart = LayerPart::default(), ValueKind::OneOf(LayerPart::NAMES);
    }
}

impl Step for Layer {
    const NAME: &'static str = "layer";
    const HELP: &'static str = "take a part of the body from the next input, or the input number N";
    const KEYS: &'static [StepKey] = Self::OPTIONS;
    const TAKES_OTHER: bool = true;
    const TAKES_BONES: bool = true;
    type Report = LayerReport;

    fn change(&self, scene: &mut Scene, input: &StepInput<'_>) -> Result<LayerReport> {
        let other = input.second::<Self>()?;
        let (mut frames, second) = pair(scene, input.animation, other)?;
        let figure = figure_of(scene, input.bones())?;
        let mut nodes = self.part.joints(scene, &figure.humanoid);
        nodes.retain(|node| frames.nodes().contains(node));
        let step = second.rate / frames.rate;
        let last = (second.len() - 1) as f64;
        for frame in 0..frames.len() {
            let row = second.row_at(frame as f64 * step);
            for node in &nodes {
                let column = second.nodes().iter().position(|other| other == node);
                if let (Some(own), Some(column)) = (frames.get(frame, *node), column) {
                    let rotation = row[column].rotation;
                    frames.set(frame, *node, Trs { rotation, ..own });
                }
            }
        }
        frames.write(scene, input.animation, &nodes, &[]);
        Ok(LayerReport {
            joints: nodes.len(),
            frames: frames.len().min((last / step) as usize + 1),
        })
    }

    fn with(&self) -> Option<usize> {
        self.with
    }
}

/// The report of [`Layer`].
///
/// [`Layer`](crate::Layer) has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct LayerReport {
    /// The number of joints whose rotations now come from the second motion.
    pub joints: usize,
    /// The number of frames until the end of the second motion. In later frames, the part of the body keeps its last
    /// pose.
    pub frames: usize,
}

impl fmt::Display for LayerReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} in {}",
            counted(self.joints, "joint"),
            counted(self.frames, "frame")
        )
    }
}
