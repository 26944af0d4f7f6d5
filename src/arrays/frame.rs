//! The unit and the axes of the output.

use glam::{Mat4, Vec3, Vec4};

use crate::arrays::{Options, unknown_option};
use crate::error::Result;
use crate::scene::{Assumption, Scene, Topic, UpAxis};
use crate::skeleton;

/// How the coordinates of a scene become those of the output.
pub(super) struct Frame {
    /// Units of the output in one of the scene.
    pub(super) scale: f32,
    /// The scene's axes to those of the output, where they differ.
    pub(super) turn: Option<Mat4>,
    /// Metres in one unit of the output, where the file, the caller or a need for it says so.
    pub(super) metres_per_unit: Option<f64>,
    /// The axis of the output that points up, likewise.
    pub(super) up: Option<UpAxis>,
}

impl Frame {
    /// Guesses only what is needed, and adds each guess to `assumptions`.
    pub(super) fn new(scene: &Scene, options: &Options, assumptions: &mut Vec<Assumption>) -> Result<Self> {
        for metres in [options.metres_per_unit, options.file_metres_per_unit]
            .into_iter()
            .flatten()
        {
            if !(metres.is_finite() && metres > 0.0) {
                let message = "the unit asked for is no unit";
                return Err(unknown_option(message, "metres, above 0", metres.to_string()));
            }
        }
        let needs_ground = options.contacts.is_some();
        let stated_metres = options.file_metres_per_unit.or(scene.metadata.metres_per_unit);
        let guesses_unit = stated_metres.is_none() && (options.metres_per_unit.is_some() || needs_ground);
        let guesses_up = options.file_up.is_none() && (options.up.is_some() || needs_ground);
        let guess = (guesses_unit || guesses_up).then(|| skeleton::survey(scene));
        if let Some(guess) = &guess {
            let is_used = |topic| (topic == Topic::Unit && guesses_unit) || (topic == Topic::Up && guesses_up);
            assumptions.extend(guess.assumptions().into_iter().filter(|guess| is_used(guess.topic)));
        }
        let file_metres = stated_metres.or_else(|| guess.as_ref().map(|guess| guess.unit.value.metres()));
        let file_up = options.file_up.or_else(|| guess.as_ref().map(|guess| guess.up.value));
        Ok(Self {
            scale: match (file_metres, options.metres_per_unit) {
                (Some(file), Some(output)) => (file / output) as f32,
                _ => 1.0,
            },
            turn: turn(file_up, options.up),
            metres_per_unit: options.metres_per_unit.or(file_metres),
            up: options.up.or(file_up),
        })
    }

    /// How high a point of the output is.
    pub(super) fn height(&self, point: Vec3) -> f32 {
        match self.up.unwrap_or_default() {
            UpAxis::Y => point.y,
            UpAxis::Z => point.z,
        }
    }
}

/// A quarter turn about X, or none.
fn turn(from: Option<UpAxis>, to: Option<UpAxis>) -> Option<Mat4> {
    match (from?, to?) {
        (UpAxis::Z, UpAxis::Y) => Some(Mat4::from_cols(Vec4::X, Vec4::NEG_Z, Vec4::Y, Vec4::W)),
        (UpAxis::Y, UpAxis::Z) => Some(Mat4::from_cols(Vec4::X, Vec4::Z, Vec4::NEG_Y, Vec4::W)),
        _ => None,
    }
}
