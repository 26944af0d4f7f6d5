//! The unit and the axes of the output.

use glam::{Mat4, Vec3};
use mocap_figure::Figure;
use mocap_figure::convert::{Needs, Space};
use mocap_formats::gltf::report::Provenance;
use mocap_scene::error::Result;
use mocap_scene::math::up_axis;
use mocap_scene::scene::report::AppliedStep;
use mocap_scene::scene::{Scene, Topic, UpAxis};

use crate::arrays::ArrayOptions;

/// The conversion of a scene's coordinates to the coordinates of the output.
pub(super) struct Frame {
    /// Units of the output per unit of the scene.
    pub(super) scale: f32,
    /// The matrix from the scene's axes to the output's axes, if they differ.
    pub(super) turn: Option<Mat4>,
    /// Metres per unit of the output: stated by the file or the caller, or guessed if an array needs the unit.
    /// Otherwise `None`.
    pub(super) metres_per_unit: Option<f64>,
    /// The up axis of the output: stated by the file or the caller, or guessed if an array needs the axis. Otherwise
    /// `None`.
    pub(super) up: Option<UpAxis>,
    /// The figure, if any guess needs it.
    pub(super) figure: Option<Figure>,
}

impl Frame {
    /// Guesses only what is needed, and adds each guess and the conversion to `provenance`.
    pub(super) fn new(scene: &Scene, options: &ArrayOptions, provenance: &mut Provenance) -> Result<Self> {
        let output = Space {
            metres_per_unit: options.out_metres_per_unit,
            up: options.out_up,
        };
        let named = Space {
            metres_per_unit: options.metres_per_unit,
            up: options.up,
        };
        output.check()?;
        named.check()?;
        let needs_ground = options.contacts.is_some();
        let mut file = named.or_stated(&scene.metadata);
        let needs = Needs {
            unit: file.metres_per_unit.is_none() && (output.metres_per_unit.is_some() || needs_ground),
            up: file.up.is_none() && (output.up.is_some() || needs_ground),
        };
        let needs_feet = options
            .contacts
            .as_ref()
            .is_some_and(|contacts| contacts.feet.is_none());
        let mut figure = None;
        if needs.unit || needs.up || needs_feet || !options.bones.is_empty() {
            let found = figure.insert(Figure::mapped(scene, &options.bones)?);
            let survey = &found.survey;
            let topics = [(needs.unit, Topic::Unit), (needs.up, Topic::Up)];
            let needed = topics.into_iter().filter(|(is_needed, _)| *is_needed);
            provenance
                .assumptions
                .extend(needed.filter_map(|(_, topic)| named.guess(topic, survey)));
            file = named.or_found(&scene.metadata, survey, needs);
        }
        let turns = matches!((file.up, output.up), (Some(file), Some(output)) if file != output);
        let scales =
            matches!((file.metres_per_unit, output.metres_per_unit), (Some(file), Some(output)) if file != output);
        // A unit or an axis that the file does not state is recorded too. The header then shows the origin of this
        // value.
        if turns || scales || file != Space::default().or_stated(&scene.metadata) {
            // An unknown unit or axis is not converted. The step records 1 m to 1 m, or +Y to +Y.
            let (from, up) = (file.metres_per_unit.unwrap_or(1.0), file.up.unwrap_or_default());
            provenance.steps.push(AppliedStep::ConvertUnits {
                metres_per_unit: from,
                up,
                out_metres_per_unit: output.metres_per_unit.unwrap_or(from),
                out_up: output.up.unwrap_or(up),
            });
        }
        Ok(Self {
            scale: match (file.metres_per_unit, output.metres_per_unit) {
                (Some(file), Some(output)) => (file / output) as f32,
                _ => 1.0,
            },
            turn: match (file.up, output.up) {
                (Some(file), Some(output)) if file != output => Some(up_axis::from_to(file, output)),
                _ => None,
            },
            metres_per_unit: output.metres_per_unit.or(file.metres_per_unit),
            up: output.up.or(file.up),
            figure,
        })
    }

    /// The up direction in the output.
    pub(super) fn up(&self) -> Vec3 {
        match self.up.unwrap_or_default() {
            UpAxis::Y => Vec3::Y,
            UpAxis::Z => Vec3::Z,
            UpAxis::NegY => Vec3::NEG_Y,
            UpAxis::NegZ => Vec3::NEG_Z,
        }
    }
}
