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
    /// The figure, where something is to be known of it.
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
        // What the file does not state is recorded too, so that an output tells whether its header is right.
        if turns || scales || file != Space::default().or_stated(&scene.metadata) {
            // What is unknown stays, and is written as from 1 m to 1 m, or from +Y to +Y.
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

    /// Up in the output.
    pub(super) fn up(&self) -> Vec3 {
        match self.up.unwrap_or_default() {
            UpAxis::Y => Vec3::Y,
            UpAxis::Z => Vec3::Z,
            UpAxis::NegY => Vec3::NEG_Y,
            UpAxis::NegZ => Vec3::NEG_Z,
        }
    }
}
