//! Points without a skeleton, such as the markers of C3D and TRC: a group with a node for each point.

use std::collections::HashMap;

use glam::{Mat4, Quat, Vec3};
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::scene::{Channel, Keys, Node, NodeId, NodeKind, Scene};

use super::frames::add_animation;
use super::warnings::Warnings;

/// The positions of one point, in the frames in which it was seen.
#[derive(Clone, Debug, Default)]
pub(crate) struct Track {
    pub(crate) name: String,
    pub(crate) ticks: Vec<f64>,
    pub(crate) positions: Vec<Vec3>,
    /// The number of frames in which zeros count as not seen.
    pub(crate) zeros: usize,
}

/// The names for the points of a format.
#[derive(Clone, Copy)]
pub(crate) struct Kind {
    /// The name of the group.
    group: &'static str,
    one: &'static str,
}

impl Kind {
    pub(crate) const MARKERS: Self = Self {
        group: "Markers",
        one: "marker",
    };
    pub(crate) const POINTS: Self = Self {
        group: "Points",
        one: "point",
    };
}

/// Adds one group with one node for each point, and the motion of all `frames` at `rate` frames per second. Warns about
/// duplicate names and about gaps.
pub(crate) fn add(
    scene: &mut Scene,
    kind: Kind,
    tracks: Vec<Track>,
    (frames, rate): (usize, f64),
    warnings: &mut Warnings,
) {
    report_duplicates(kind, &tracks, warnings);
    scene.nodes.push(Node {
        name: kind.group.to_owned(),
        kind: NodeKind::Group,
        ..Node::default()
    });
    let mut channels = Vec::with_capacity(tracks.len());
    for track in tracks {
        report_gap(kind, &track, frames, warnings);
        let id = NodeId::new(scene.nodes.len());
        scene.nodes.push(Node {
            name: track.name.clone(),
            parent: Some(NodeId(0)),
            transform: Mat4::from_translation(track.positions.first().copied().unwrap_or_default()),
            ..Node::default()
        });
        channels.push(Channel {
            node_name: track.name,
            node: Some(id),
            position_keys: Keys::of_point(track.positions, track.ticks, frames),
            rotation_keys: Keys::constant(Quat::IDENTITY),
            scaling_keys: Keys::constant(Vec3::ONE),
        });
    }
    add_animation(scene, (frames, rate), channels, &kind.group.to_lowercase(), warnings);
}

/// The metres per unit, for the units in capture files.
pub(crate) fn metres(unit: &str) -> Option<f64> {
    match unit.to_ascii_lowercase().as_str() {
        "mm" => Some(0.001),
        "cm" => Some(0.01),
        "m" => Some(1.0),
        "in" => Some(0.0254),
        _ => None,
    }
}

fn report_duplicates(kind: Kind, tracks: &[Track], warnings: &mut Warnings) {
    let mut points_of_name = HashMap::<&str, usize>::new();
    for track in tracks {
        *points_of_name.entry(&track.name).or_default() += 1;
    }
    for track in tracks {
        // One warning for each duplicate name, at its first point.
        let name = track.name.as_str();
        let count = points_of_name.remove(name).unwrap_or_default();
        if count > 1 {
            warnings.push(Code::DuplicateName, || {
                Diagnostic::new(
                    Code::DuplicateName,
                    format!("{count} {} are called \"{name}\"", kind.group.to_lowercase()),
                )
                .in_joint(name)
            });
        }
    }
}

/// Treats a marker at the origin as unseen if the marker is there in all frames, or if it would otherwise jump to the
/// origin. Capture systems write zeros for unseen markers.
pub(crate) fn leave_out_zeros(track: &mut Track) {
    let at_zero = |position: &&Vec3| **position == Vec3::ZERO;
    let zeros = track.positions.iter().filter(at_zero).count();
    if zeros == 0 || (zeros < track.positions.len() && !jumps_to_zero(&track.positions)) {
        return;
    }
    track.zeros = zeros;
    let mut positions = track.positions.iter();
    track.ticks.retain(|_| positions.next() != Some(&Vec3::ZERO));
    track.positions.retain(|position| *position != Vec3::ZERO);
}

/// Whether all other positions are farther from the origin than a few of the longest steps between them.
fn jumps_to_zero(positions: &[Vec3]) -> bool {
    /// The number of longest steps by which all other positions must be farther from the origin. A marker does not jump
    /// that far and back.
    const STEPS: f32 = 4.0;
    let others = positions.iter().filter(|position| **position != Vec3::ZERO);
    let nearest = others.map(|position| position.length()).fold(f32::INFINITY, f32::min);
    let pairs = positions.windows(2).filter(|pair| !pair.contains(&Vec3::ZERO));
    let longest = pairs.map(|pair| pair[0].distance(pair[1])).fold(0.0, f32::max);
    nearest > STEPS * longest
}

fn report_gap(kind: Kind, track: &Track, frames: usize, warnings: &mut Warnings) {
    let missing = frames - track.ticks.len();
    if missing > 0 {
        warnings.push(Code::Gap, || {
            let mut message = format!("the {} was not seen in {missing} of {frames} frames", kind.one);
            if track.zeros > 0 {
                message += &format!(
                    "; in {} of these frames, the file has the position 0, 0, 0",
                    track.zeros
                );
            }
            Diagnostic::new(Code::Gap, message).in_joint(&track.name)
        });
    }
}
