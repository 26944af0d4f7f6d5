//! Points without a skeleton, such as the markers of C3D and TRC: a group with a node for each.

use std::collections::HashMap;

use glam::{Mat4, Quat, Vec3};

use super::warnings::Warnings;
use crate::error::{Code, Diagnostic};
use crate::scene::{Animation, Channel, Keys, Node, NodeId, NodeKind, Scene};

/// The positions of one point, in the frames in which it was seen.
#[derive(Clone, Debug, Default)]
pub(crate) struct Track {
    pub(crate) name: String,
    pub(crate) ticks: Vec<f64>,
    pub(crate) positions: Vec<Vec3>,
}

/// Adds one group with one node for each point, and the motion, with warnings of names that occur twice and of gaps.
pub(crate) fn add(scene: &mut Scene, tracks: Vec<Track>, frames: usize, rate: f64, warnings: &mut Warnings) {
    report_duplicates(&tracks, warnings);
    scene.nodes.push(Node {
        name: "Markers".to_owned(),
        kind: NodeKind::Group,
        ..Node::default()
    });
    let mut channels = Vec::with_capacity(tracks.len());
    for track in tracks {
        report_gap(&track, frames, warnings);
        scene.nodes.push(Node {
            name: track.name.clone(),
            parent: Some(NodeId(0)),
            transform: Mat4::from_translation(track.positions.first().copied().unwrap_or_default()),
            ..Node::default()
        });
        channels.push(Channel {
            node_name: track.name,
            node: None,
            position_keys: Keys::at_ticks(track.positions, track.ticks),
            rotation_keys: Keys::constant(Quat::IDENTITY),
            scaling_keys: Keys::constant(Vec3::ONE),
        });
    }
    if frames == 0 {
        warnings.push(Code::NoMotion, || {
            Diagnostic::new(
                Code::NoMotion,
                "the file has no frames: the scene has markers and no animation",
            )
        });
    } else {
        scene.animations.push(Animation {
            name: "Motion".to_owned(),
            ticks_per_second: rate,
            duration: (frames - 1) as f64,
            channels,
        });
    }
}

/// The metres of a unit as capture files state it.
pub(crate) fn metres(unit: &str) -> Option<f64> {
    match unit.to_ascii_lowercase().as_str() {
        "mm" => Some(0.001),
        "cm" => Some(0.01),
        "m" => Some(1.0),
        "in" => Some(0.0254),
        _ => None,
    }
}

fn report_duplicates(tracks: &[Track], warnings: &mut Warnings) {
    let mut points_of_name = HashMap::<&str, usize>::new();
    for track in tracks {
        *points_of_name.entry(&track.name).or_default() += 1;
    }
    for track in tracks {
        // Each name once, at its first point.
        let name = track.name.as_str();
        let count = points_of_name.remove(name).unwrap_or_default();
        if count > 1 {
            warnings.push(Code::DuplicateName, || {
                Diagnostic::new(Code::DuplicateName, format!("{count} markers are called \"{name}\"")).in_joint(name)
            });
        }
    }
}

fn report_gap(track: &Track, frames: usize, warnings: &mut Warnings) {
    let missing = frames - track.ticks.len();
    if missing > 0 {
        warnings.push(Code::Gap, || {
            Diagnostic::new(
                Code::Gap,
                format!("the marker was not seen in {missing} of {frames} frames"),
            )
            .in_joint(&track.name)
        });
    }
}
