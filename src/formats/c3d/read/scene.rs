//! Makes nodes and channels of points.

use std::sync::Arc;

use mocap_scene::math::up_axis::to_y_up;
use mocap_scene::scene::{Assumption, FileSpace, Format, Recording, Scene, Topic, UpAxis};

use super::Header;
use super::parameters::Parameters;
use super::points::Points;
use crate::points;
use crate::warnings::Warnings;

/// One group with one node for each point.
pub(super) fn build(
    parameters: &Parameters,
    header: &Header,
    points: Points,
    recorded: Option<Recording>,
    warnings: &mut Warnings,
) -> Scene {
    let mut scene = Scene::default();
    scene.metadata.format = Some(Format::C3d);
    scene.metadata.metres_per_unit = parameters.text("POINT", "UNITS").and_then(points::metres);
    let (up, reason) = up_axis(parameters);
    scene.metadata.up = Some(UpAxis::Y);
    scene.metadata.file_space = FileSpace {
        up: Some(up),
        up_is_guess: reason == UP_IS_OPEN,
        ..FileSpace::default()
    };
    let mut assume = |topic: Topic, choice: &str, reason: &str| {
        scene.metadata.assumptions.push(Assumption {
            topic,
            choice: choice.to_owned(),
            reason: reason.to_owned(),
            confidence: None,
        });
    };
    if up == UpAxis::Z {
        assume(Topic::UpAxis, "+Z was up, and is +Y now", reason);
    }
    if let Some(recorded) = &recorded {
        say(recorded, assume);
    }
    scene.metadata.recorded = recorded.map(Arc::new);

    let names = names(parameters, points.tracks.len());
    let tracks = std::iter::zip(names, points.tracks).map(|(name, track)| {
        let positions = track.positions.iter();
        let mut found = points::Track {
            name,
            positions: positions.map(|position| to_y_up(position.as_vec3(), up)).collect(),
            ticks: track.ticks,
            zeros: 0,
        };
        if !track.is_measured_at_zero {
            points::leave_out_zeros(&mut found);
        }
        found
    });
    let tracks = tracks.collect();
    let frames = (points.frames, header.frame_rate);
    points::add(&mut scene, points::Kind::MARKERS, tracks, frames, warnings);
    scene
}

/// Says what is there beside motion, which outputs of motion cannot hold.
fn say(recorded: &Recording, mut assume: impl FnMut(Topic, &str, &str)) {
    let (channels, plates) = (recorded.channels.len(), recorded.plates.len());
    if channels > 0 {
        let rate = recorded.analog_rate;
        let choice = format!("{channels} analog channels at {rate} Hz, {plates} force plates");
        let reason = "outputs of motion cannot hold them: mocap analog and mocap forces write them";
        assume(Topic::Analog, &choice, reason);
    }
    if !recorded.events.is_empty() {
        let choice = format!("{} events", recorded.events.len());
        let reason = "outputs of motion cannot hold them: mocap info lists them";
        assume(Topic::Events, &choice, reason);
    }
}

/// Why +Z is up where the file leaves it open.
const UP_IS_OPEN: &str = "the file does not say; capture systems have +Z up";

/// The up axis is the screen's y axis, if the file states it.
pub(super) fn up_axis(parameters: &Parameters) -> (UpAxis, &'static str) {
    match parameters.text("POINT", "Y_SCREEN") {
        Some("+Y" | "Y") => (UpAxis::Y, "POINT:Y_SCREEN says so"),
        Some("+Z" | "Z") => (UpAxis::Z, "POINT:Y_SCREEN says so"),
        _ => (UpAxis::Z, UP_IS_OPEN),
    }
}

/// The labels, or a number for each point without one.
fn names(parameters: &Parameters, count: usize) -> Vec<String> {
    let labels = parameters.labels();
    let name = |index: usize| match labels.get(index) {
        Some(label) if !label.is_empty() => (*label).to_owned(),
        _ => format!("Point_{}", index + 1),
    };
    (0..count).map(name).collect()
}
