//! ARKit's shapes of a face on a character. A morph target with the name of a shape shows the shape. Without such a
//! target, an expression with the same meaning shows it.

use std::collections::BTreeMap;

use glam::Vec3;
use mocap_scene::pose::{FaceTrack, Trs};
use mocap_scene::scene::{Channel, Face, Keys, face_shape};
use serde_json::Value;

use super::binds::{Expression, MorphBind, names_of_targets};

/// The shapes of each VRM 1.0 preset, and the weight that each shape adds, by Apple's description of the shapes. The
/// other presets of VRM match no shape, or only several shapes together.
const PRESETS: [(&str, &[(&str, f32)]); 9] = [
    ("blinkLeft", &[("eyeBlinkLeft", 1.0)]),
    ("blinkRight", &[("eyeBlinkRight", 1.0)]),
    ("blink", &[("eyeBlinkLeft", 0.5), ("eyeBlinkRight", 0.5)]),
    ("aa", &[("jawOpen", 1.0)]),
    ("ou", &[("mouthPucker", 1.0)]),
    ("oh", &[("mouthFunnel", 1.0)]),
    ("happy", &[("mouthSmileLeft", 0.5), ("mouthSmileRight", 0.5)]),
    ("sad", &[("mouthFrownLeft", 0.5), ("mouthFrownRight", 0.5)]),
    (
        "surprised",
        &[("browInnerUp", 0.5), ("eyeWideLeft", 0.25), ("eyeWideRight", 0.25)],
    ),
];

/// The ARKit shape of a face part; `None` for presets and for the gaze.
fn shape_of(face: &Face) -> Option<&'static str> {
    match face {
        Face::Custom(name) => face_shape(name),
        Face::Preset(_) | Face::LookAt { .. } => None,
    }
}

/// An expression for each morph target that has the name of a shape, unless the file has an expression for the shape.
pub(super) fn of_targets(root: &Value, known: &[Expression]) -> Vec<Expression> {
    let mut binds: BTreeMap<&'static str, Vec<MorphBind>> = BTreeMap::new();
    for node in 0..root["nodes"].as_array().map_or(0, Vec::len) {
        for (target, name) in names_of_targets(root, node).enumerate() {
            if let Some(shape) = name.as_str().and_then(face_shape) {
                let bind = MorphBind {
                    node,
                    target,
                    weight: 1.0,
                };
                binds.entry(shape).or_default().push(bind);
            }
        }
    }
    let is_new = |shape: &&str| !known.iter().any(|own| own.is_of(&Face::Custom((*shape).to_owned())));
    let new = binds.into_iter().filter(|(shape, _)| is_new(shape));
    new.map(|(shape, binds)| Expression::of_shape(shape, binds)).collect()
}

/// The presets of the character that a shape moves.
pub(super) fn presets_of<'a>(
    face: &Face,
    expressions: &'a [Expression],
) -> impl Iterator<Item = &'static str> + use<'a> {
    let shape = shape_of(face);
    let moved = move |(preset, parts): &(&'static str, &[(&str, f32)])| {
        parts.iter().any(|(part, _)| Some(*part) == shape) && has(expressions, preset)
    };
    PRESETS.into_iter().filter(moved).map(|(preset, _)| preset)
}

fn has(expressions: &[Expression], preset: &str) -> bool {
    let preset = Face::Preset(preset.to_owned());
    let is_there = |face: &Face| expressions.iter().any(|own| own.is_of(face) && !own.binds.is_empty());
    let one_eyed = ["blinkLeft", "blinkRight"].map(|name| Face::Preset(name.to_owned()));
    // `blink` counts only if the character cannot close each eye separately.
    is_there(&preset) && !(preset.name() == "blink" && one_eyed.iter().any(is_there))
}

/// Tracks of presets, computed from shapes that are not expressions of the character. A preset with its own track keeps
/// this track.
pub(super) fn presets(tracks: &[FaceTrack], expressions: &[Expression]) -> Vec<FaceTrack> {
    let is_lacking = |track: &&FaceTrack| !expressions.iter().any(|own| own.is_of(&track.face));
    let lacking: Vec<&FaceTrack> = tracks.iter().filter(is_lacking).collect();
    let preset = |(preset, parts): (&str, &[(&str, f32)])| {
        let face = Face::Preset(preset.to_owned());
        let is_moved = tracks.iter().any(|track| track.face.is_part(&face));
        if is_moved || !has(expressions, preset) {
            return None;
        }
        let of_shape = |(shape, part): &(&str, f32)| {
            let mut own = lacking.iter().filter(|track| shape_of(&track.face) == Some(*shape));
            own.next().map(|track| (*track, *part))
        };
        let parts: Vec<(&FaceTrack, f32)> = parts.iter().filter_map(of_shape).collect();
        let first = parts.first()?.0;
        let keys = parts.iter().map(|(track, _)| &track.keys.position_keys);
        let mut ticks: Vec<f64> = keys
            .flat_map(|keys| (0..keys.len()).map(|key| keys.tick(key)))
            .collect();
        ticks.sort_unstable_by(f64::total_cmp);
        ticks.dedup();
        let at = |tick: &f64| {
            let weight =
                |(track, part): &(&FaceTrack, f32)| part * track.keys.sample(*tick, Trs::IDENTITY).translation.x;
            parts.iter().map(weight).sum::<f32>().clamp(0.0, 1.0) * Vec3::X
        };
        Some(FaceTrack {
            node: first.node.clone(),
            face,
            keys: Channel {
                position_keys: Keys::at_ticks(ticks.iter().map(at).collect(), ticks),
                ..first.keys.clone()
            },
        })
    };
    PRESETS.into_iter().filter_map(preset).collect()
}
