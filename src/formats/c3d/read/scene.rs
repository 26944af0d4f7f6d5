//! Makes nodes and channels from points.

use std::collections::HashMap;
use std::sync::Arc;

use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::math::up_axis::to_y_up;
use mocap_scene::scene::{AnalogChannel, Assumption, FileSpace, Format, Recording, Scene, Topic, UpAxis};

use super::Header;
use super::parameters::Parameters;
use super::points::Points;
use super::rotations::Segments;
use crate::points;
use crate::warnings::Warnings;

/// A skeleton of the segments if the file has no markers. Otherwise one group with one node for each point.
pub(super) fn build(
    parameters: &Parameters,
    header: &Header,
    (mut points, segments): (Points, Option<Segments>),
    mut recorded: Option<Recording>,
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
    let mut names = names(parameters, points.tracks.len());
    let outputs = outputs(parameters, &mut names, &mut points);
    if !outputs.is_empty() {
        recorded.get_or_insert_default().outputs = outputs;
    }
    if let Some(recorded) = &recorded {
        say(recorded, assume);
    }
    scene.metadata.recorded = recorded.map(Arc::new);
    if let Some(segments) = segments {
        if points.tracks.is_empty() && segments.add(&mut scene, up, warnings) {
            return scene;
        }
        let message = format!("the poses of {} segments in ROTATION were skipped", segments.count());
        let help = "mocap reads segments only from a file without markers whose segments have the names of Theia: \
                    pelvis, l_thigh, l_shank, ...";
        warnings.push(Code::IgnoredChannel, || {
            Diagnostic::new(Code::IgnoredChannel, message).help(help)
        });
    }

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

/// Removes the points that are not positions, such as joint angles, and returns them as channels.
fn outputs(parameters: &Parameters, names: &mut Vec<String>, points: &mut Points) -> Vec<AnalogChannel> {
    /// For each kind of points that are not positions: the parameter with their labels, and the parameter with their
    /// unit (Vicon's C3D manual).
    const KINDS: [[&str; 2]; 4] = [
        ["ANGLES", "ANGLE_UNITS"],
        ["FORCES", "FORCE_UNITS"],
        ["MOMENTS", "MOMENT_UNITS"],
        ["POWERS", "POWER_UNITS"],
    ];
    let mut units = HashMap::new();
    for [labels, unit] in KINDS {
        let unit = parameters.text("POINT", unit).unwrap_or_default();
        units.extend(
            parameters
                .all_texts("POINT", labels)
                .into_iter()
                .map(|label| (label, unit)),
        );
    }
    let mut found = Vec::new();
    let is_place: Vec<bool> = names.iter().map(|name| !units.contains_key(name.as_str())).collect();
    for (name, track) in std::iter::zip(&*names, &points.tracks) {
        let Some(unit) = units.get(name.as_str()) else { continue };
        let mut values = vec![f32::NAN; 3 * points.frames];
        for (tick, value) in std::iter::zip(&track.ticks, &track.positions) {
            values[3 * *tick as usize..][..3].copy_from_slice(&value.as_vec3().to_array());
        }
        found.push(AnalogChannel {
            name: name.clone(),
            unit: (*unit).to_owned(),
            values,
        });
    }
    let mut keep = is_place.iter();
    names.retain(|_| keep.next().is_none_or(|is_place| *is_place));
    let mut keep = is_place.iter();
    points.tracks.retain(|_| keep.next().is_none_or(|is_place| *is_place));
    found
}

/// Records the data other than motion, which motion formats cannot hold.
fn say(recorded: &Recording, mut assume: impl FnMut(Topic, &str, &str)) {
    let (channels, plates) = (recorded.channels.len(), recorded.plates.len());
    if channels > 0 {
        let rate = recorded.analog_rate;
        let choice = format!("{channels} analog channels at {rate} Hz, {plates} force plates");
        let reason = "motion formats cannot hold these data; mocap analog and mocap forces write them";
        assume(Topic::Analog, &choice, reason);
    }
    if !recorded.outputs.is_empty() {
        let choice = format!(
            "{} model outputs, such as {}",
            recorded.outputs.len(),
            recorded.outputs[0].name
        );
        let reason =
            "model outputs are not markers; mocap angles and mocap gait compare joint angles with model outputs";
        assume(Topic::Analog, &choice, reason);
    }
    if !recorded.events.is_empty() {
        let choice = format!("{} events", recorded.events.len());
        let reason = "motion formats cannot hold these data; mocap info lists them";
        assume(Topic::Events, &choice, reason);
    }
}

/// The reason for +Z up if the file does not state the up axis.
const UP_IS_OPEN: &str = "the file states no up axis; capture systems have +Z up";

/// The up axis: the y axis of the screen if the file states it, otherwise +Z.
pub(super) fn up_axis(parameters: &Parameters) -> (UpAxis, &'static str) {
    match parameters.text("POINT", "Y_SCREEN") {
        Some("+Y" | "Y") => (UpAxis::Y, "POINT:Y_SCREEN states it"),
        Some("+Z" | "Z") => (UpAxis::Z, "POINT:Y_SCREEN states it"),
        _ => (UpAxis::Z, UP_IS_OPEN),
    }
}

/// The labels, with a number for each point without a label.
fn names(parameters: &Parameters, count: usize) -> Vec<String> {
    let labels = parameters.labels();
    let name = |index: usize| match labels.get(index) {
        Some(label) if !label.is_empty() => (*label).to_owned(),
        _ => format!("Point_{}", index + 1),
    };
    (0..count).map(name).collect()
}
