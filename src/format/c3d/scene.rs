//! Makes nodes and channels of points.

use std::collections::HashMap;

use glam::{Mat4, Quat, Vec3};

use super::Header;
use super::parameters::Parameters;
use super::points::{Points, Track};
use crate::error::{Code, Diagnostic};
use crate::format::warnings::Warnings;
use crate::math::up_axis::to_y_up;
use crate::scene::{Animation, Assumption, Channel, Format, Keys, Node, NodeId, NodeKind, Scene, Topic, UpAxis};

/// One group with one node for each point.
pub(super) fn build(parameters: &Parameters, header: &Header, points: Points, warnings: &mut Warnings) -> Scene {
    let mut scene = Scene::default();
    scene.metadata.format = Some(Format::C3d);
    scene.metadata.metres_per_unit = parameters.text("POINT", "UNITS").and_then(metres);
    let (up, reason) = up_axis(parameters);
    scene.metadata.up = Some(UpAxis::Y);
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
    if header.samples > 0 {
        assume(
            Topic::Analog,
            "analog samples were left out",
            "a scene cannot hold them",
        );
    }
    if parameters.has_events() {
        assume(Topic::Events, "events were left out", "a scene cannot hold them");
    }

    scene.nodes.push(Node {
        name: "Markers".to_owned(),
        kind: NodeKind::Group,
        ..Node::default()
    });
    let names = names(parameters, points.tracks.len(), warnings);
    let mut channels = Vec::with_capacity(points.tracks.len());
    for (name, track) in std::iter::zip(names, points.tracks) {
        report_gap(&name, &track, points.frames, warnings);
        let positions: Vec<Vec3> = track
            .positions
            .iter()
            .map(|&position| to_y_up(position.as_vec3(), up))
            .collect();
        scene.nodes.push(Node {
            name: name.clone(),
            parent: Some(NodeId(0)),
            transform: Mat4::from_translation(positions.first().copied().unwrap_or_default()),
            ..Node::default()
        });
        channels.push(Channel {
            node_name: name,
            node: None,
            position_keys: Keys::at_ticks(positions, track.ticks),
            rotation_keys: Keys::constant(Quat::IDENTITY),
            scaling_keys: Keys::constant(Vec3::ONE),
        });
    }
    if points.frames == 0 {
        warnings.push(Code::NoMotion, || {
            Diagnostic::new(
                Code::NoMotion,
                "the file has no frames: the scene has markers and no animation",
            )
        });
    } else {
        scene.animations.push(Animation {
            name: "Motion".to_owned(),
            ticks_per_second: header.frame_rate,
            duration: (points.frames - 1) as f64,
            channels,
        });
    }
    scene
}

fn metres(unit: &str) -> Option<f64> {
    match unit.to_ascii_lowercase().as_str() {
        "mm" => Some(0.001),
        "cm" => Some(0.01),
        "m" => Some(1.0),
        "in" => Some(0.0254),
        _ => None,
    }
}

/// The up axis is the screen's y axis, if the file states it.
fn up_axis(parameters: &Parameters) -> (UpAxis, &'static str) {
    match parameters.text("POINT", "Y_SCREEN") {
        Some("+Y" | "Y") => (UpAxis::Y, "POINT:Y_SCREEN says so"),
        Some("+Z" | "Z") => (UpAxis::Z, "POINT:Y_SCREEN says so"),
        _ => (UpAxis::Z, "the file does not say; capture systems have +Z up"),
    }
}

/// The labels, or a number for each point without one.
fn names(parameters: &Parameters, count: usize, warnings: &mut Warnings) -> Vec<String> {
    let labels = parameters.labels();
    let name = |index: usize| match labels.get(index) {
        Some(label) if !label.is_empty() => (*label).to_owned(),
        _ => format!("Point_{}", index + 1),
    };
    let names: Vec<String> = (0..count).map(name).collect();
    let mut points_of_name = HashMap::<&str, usize>::new();
    for name in &names {
        *points_of_name.entry(name).or_default() += 1;
    }
    for name in &names {
        // Each name once, at its first point.
        let count = points_of_name.remove(name.as_str()).unwrap_or_default();
        if count > 1 {
            warnings.push(Code::DuplicateName, || {
                Diagnostic::new(Code::DuplicateName, format!("{count} markers are called \"{name}\"")).in_joint(name)
            });
        }
    }
    names
}

fn report_gap(name: &str, track: &Track, frames: usize, warnings: &mut Warnings) {
    let missing = frames - track.ticks.len();
    if missing > 0 {
        warnings.push(Code::Gap, || {
            Diagnostic::new(
                Code::Gap,
                format!("the marker was not seen in {missing} of {frames} frames"),
            )
            .in_joint(name)
        });
    }
}
