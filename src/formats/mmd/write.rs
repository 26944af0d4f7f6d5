//! Writes `.vmd`: keys of bones and morphs at 30 frames per second, for models with these names.
//!
//! A scene on the skeleton of an MMD model is written for that model. The motion of any other humanoid is written for
//! the bones that nearly all models have, with generic proportions. In both cases the leg IK is turned off, so that
//! legs rotate by their own keys. Values are linear between keys. A key that equals both neighbours is dropped.

mod bones;
mod bytes;

use std::collections::HashSet;

use glam::{DQuat, DVec3, Vec3};
use mocap_figure::vrm_humanoid::vrm_humanoid_shown;
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::limits::{FrameBudget, Limits};
use mocap_scene::pose::{Binding, FaceTrack, Pose};
use mocap_scene::scene::{Animation, Channel, Face, Format, Scene};

use self::bones::Bones;
use super::{FRAME_RATE, METRES_PER_UNIT, generic, names};
use crate::ledger::{joints_left_out, positions_left_out};
use crate::written::unit_warning;
use crate::{Export, ExportFile, WriteOptions, numbers};

/// The largest rounding difference: of quaternion components, and of positions in units.
const ROUNDED: f64 = 1e-6;

/// The right-handed keys of a bone at every frame: its offset from its rest position, in units, and its rotation.
pub(super) struct BoneTrack {
    pub(super) name: String,
    pub(super) keys: Vec<(DVec3, DQuat)>,
}

/// The weights of a morph at every frame.
pub(super) struct MorphTrack {
    pub(super) name: String,
    pub(super) weights: Vec<f32>,
}

pub(crate) fn files(scene: &Scene, options: &WriteOptions) -> Result<Export> {
    numbers::check(scene)?;
    let Some(animation) = scene.animations.first() else {
        let message = "the scene has no motion, but a VMD file consists of motion";
        return Err(Diagnostic::new(Code::NoMotion, message)
            .help("name a file with a motion")
            .into());
    };
    let is_unknown = scene.metadata.metres_per_unit.is_none();
    let mut written = Export {
        warnings: Vec::from_iter(unit_warning(scene, "VMD").filter(|_| is_unknown)),
        ..Export::default()
    };
    let model = scene.metadata.mmd.as_deref().filter(|_| is_on_model(scene));
    let humanoid;
    let (shown, bones) = match model {
        Some(model) => (scene, Bones::of_model(scene, model)),
        None => {
            humanoid = vrm_humanoid_shown(scene, options.whole.as_deref(), options.humanoid.clone())?;
            let (left_out, lost) = joints_left_out(scene, &humanoid);
            let losses = [lost, positions_left_out(scene, &humanoid)];
            written.losses.extend(losses.into_iter().filter(|loss| loss.count > 0));
            written.notes.extend((!left_out.is_empty()).then(|| {
                format!(
                    "joints: {} dropped, because they are not usual MMD bones",
                    left_out.join(", ")
                )
            }));
            written.warnings.push(for_usual_models());
            (&humanoid, Bones::of_humanoid(&humanoid))
        }
    };
    check_length(animation, bones.count())?;
    let mut tracks = bone_tracks(shown, &bones);
    let mut taken = HashSet::new();
    tracks.retain(|track| is_writable(&track.name, &mut taken, &mut written));
    let mut morphs = morph_tracks(scene, animation, model.is_some(), &mut written);
    taken.clear();
    morphs.retain(|track| is_writable(&track.name, &mut taken, &mut written));
    written.nodes = tracks.len();
    let bytes = bytes::file(&bones.model, &tracks, &morphs, &bones.ik)?;
    written.files = vec![ExportFile::new(&options.name, bytes)];
    Ok(written)
}

/// Whether the nodes are bones of an MMD model.
fn is_on_model(scene: &Scene) -> bool {
    matches!(scene.metadata.format, Some(Format::Vmd | Format::Pmx))
}

fn for_usual_models() -> Diagnostic {
    let arms = generic::ARMS;
    let message = format!(
        "a VMD has no skeleton, so the motion is for the usual MMD bones with arms lowered by {arms} degrees: limb \
            directions are kept, but joint positions assume a body with usual proportions"
    );
    Diagnostic::new(Code::Unrepresentable, message)
        .help("write it for a specific model: mocap retarget INPUT MODEL.pmx -o OUTPUT.vmd")
}

/// Whether a name can be written in addition to the `taken` names. Adds a note if the name cannot be written.
fn is_writable(name: &str, taken: &mut HashSet<Vec<u8>>, written: &mut Export) -> bool {
    let reason = match names::key(name) {
        Some(key) if key.is_empty() => "it is empty",
        Some(key) => {
            if taken.insert(key) {
                return true;
            }
            "another name has the same first 15 bytes, the limit of a VMD"
        }
        None => "Shift-JIS lacks some of its characters",
    };
    written
        .notes
        .push(format!("names: \"{name}\" dropped, because {reason}"));
    false
}

/// Refuses a motion whose few keys are hours apart, for example because of a wrong frame rate.
fn check_length(animation: &Animation, bones: usize) -> Result<()> {
    let keys = |channel: &Channel| (channel.rotation_keys.len() + channel.position_keys.len()) as u64;
    let stated: u64 = animation.channels.iter().map(keys).sum();
    let seconds = animation.duration / animation.ticks_per_second;
    // A frame has seven numbers for each bone.
    FrameBudget::stated_by(&Limits::default(), stated).frames((seconds * FRAME_RATE).ceil(), 7 * bones)?;
    Ok(())
}

/// The ticks of the frames of the file, including the end of the motion.
fn ticks(animation: &Animation) -> impl Iterator<Item = f64> + use<> {
    let per_frame = animation.ticks_per_second / FRAME_RATE;
    // A motion that ends within a thousandth of a frame ends at that frame.
    let last = (animation.duration / per_frame - 1e-3).ceil().max(0.0) as u64;
    (0..=last).map(move |frame| frame as f64 * per_frame)
}

fn bone_tracks(scene: &Scene, bones: &Bones) -> Vec<BoneTrack> {
    let Some(animation) = scene.animations.first() else {
        return Vec::new();
    };
    let units = scene.metadata.metres_per_unit.unwrap_or(1.0) / METRES_PER_UNIT;
    let binding = Binding::new(scene, animation);
    let mut pose = Pose::rest(scene);
    let rest = bones.placed(&pose, units);
    let mut tracks: Vec<BoneTrack> = bones.tracks();
    for tick in ticks(animation) {
        pose.sample(&binding, animation, tick);
        for (track, key) in tracks.iter_mut().zip(bones.keys(&rest, &bones.placed(&pose, units))) {
            track.keys.push(key);
        }
    }
    let moves = |track: &BoneTrack| {
        track
            .keys
            .iter()
            .any(|key| !is_near(*key, (DVec3::ZERO, DQuat::IDENTITY)))
    };
    tracks.retain(moves);
    tracks
}

/// Whether two keys are equal except for rounding.
pub(super) fn is_near((p, q): (DVec3, DQuat), (p2, q2): (DVec3, DQuat)) -> bool {
    p.abs_diff_eq(p2, ROUNDED) && (q.abs_diff_eq(q2, ROUNDED) || q.abs_diff_eq(-q2, ROUNDED))
}

/// The weights of the expressions of a face.
fn morph_tracks(scene: &Scene, animation: &Animation, on_model: bool, written: &mut Export) -> Vec<MorphTrack> {
    let mut morphs: Vec<MorphTrack> = Vec::new();
    for FaceTrack { node, face, keys } in scene.face_tracks(animation) {
        let name = match &face {
            Face::LookAt { .. } => {
                written
                    .notes
                    .push("face: lookAt dropped, because a VMD has no gaze".to_owned());
                continue;
            }
            _ if on_model => node.name.clone(),
            Face::Preset(preset) => match names::morph(preset) {
                Some(name) => name.to_owned(),
                None => preset.clone(),
            },
            Face::Custom(name) => name.clone(),
        };
        let weight = |tick: f64| keys.position_keys.sample(tick).unwrap_or(Vec3::ZERO).x;
        let weights: Vec<f32> = ticks(animation).map(weight).collect();
        if weights.iter().any(|weight| *weight != 0.0) {
            morphs.push(MorphTrack { name, weights });
        }
    }
    morphs
}
