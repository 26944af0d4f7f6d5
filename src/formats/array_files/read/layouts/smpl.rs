//! Motions of SMPL, SMPL-H and SMPL-X, and of SOMA in the same form: rotations as axis times angle.

use glam::{DQuat, DVec3, Vec3};
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::scene::joint_tables;
use mocap_scene::scene::{Confidence, Topic, UpAxis};

use super::Reader;
use super::plausible::check_radians;
use crate::Failure;
use crate::array_files::read::motion::{Motion, named};
use crate::array_files::read::ndarray::{Entries, NdArray};
use crate::array_files::read::proportions::{self, HEIGHT, SMPL_ROOT};

/// The frame rate in frames per second that publishers state if files do not.
const USUAL_RATE: f64 = 30.0;

/// Whether the arrays are in AMASS's layout.
pub(super) fn is_poses(entries: &Entries<'_>) -> bool {
    entries.get("poses").is_some() || entries.get("smpl_poses").is_some()
}

/// AMASS: `poses`, (frames, 156) for SMPL-H, 165 for SMPL-X, 72 for SMPL or 66 for the body, and `trans`.
pub(super) fn of_poses(reader: &Reader<'_, '_>) -> Result<Motion, Failure> {
    let entries = reader.entries;
    let name = if entries.get("poses").is_some() {
        "poses"
    } else {
        "smpl_poses"
    };
    let Some(array) = entries.get(name) else {
        return Err(missing(name, entries));
    };
    let width: usize = array.shape.iter().skip(1).product();
    let joints = joint_tables::smpl(width / 3).filter(|_| width.is_multiple_of(3));
    let Some(joints) = joints else {
        return Err(Box::new(
            Diagnostic::new(Code::RowLength, format!("the array {name} does not fit an SMPL body")).expected_found(
                "(frames, 66), (frames, 72), (frames, 156) or (frames, 165)",
                array.shape_text(),
            ),
        ));
    };
    let (frames, poses) = reader.numbers_of(name, array, None, &[joints.len(), 3])?;
    let mut motion = Motion {
        rotations: tracks(name, &poses, joints.len())?,
        joints,
        ..Motion::default()
    };
    let names = ["trans", "smpl_trans", "transl"];
    let name = names.into_iter().find(|name| entries.get(name).is_some());
    set_root(reader, &mut motion, name, frames, "")?;
    // AMASS states its rate, and defines +Z as up. Other data sets use only the names of its arrays.
    let is_amass = entries.first(&["mocap_framerate", "mocap_frame_rate"]).is_some();
    if is_amass {
        motion.up = UpAxis::Z;
    } else {
        guess_up(&mut motion);
    }
    reader.frame_rate(USUAL_RATE, &mut motion)?;
    say_of_body(reader, &mut motion, "");
    Ok(motion)
}

/// The path of the best dictionary with `global_orient` and `body_pose`. World coordinates are better than camera
/// coordinates, and results are better than inputs.
pub(super) fn dictionary(entries: &Entries<'_>) -> Option<String> {
    let names = entries.arrays.iter().map(|(name, _)| name.as_str());
    let prefixes = names.filter_map(|name| name.strip_suffix("body_pose"));
    let has_root = |prefix: &&str| entries.get(&format!("{prefix}global_orient")).is_some();
    let cost = |prefix: &&str| {
        let of = |word: &str, cost: usize| if prefix.contains(word) { cost } else { 0 };
        (
            of("incam", 4) + of("pred", 2) + of("net_outputs", 2) + of("static", 1),
            prefix.len(),
        )
    };
    prefixes.filter(has_root).min_by_key(cost).map(str::to_owned)
}

/// SMPL-X dictionaries, of GVHMR and of GEM-X. In GEM-X `body_pose` has SOMA's 76 joints other than the root.
pub(super) fn of_dictionary(reader: &Reader<'_, '_>, prefix: &str) -> Result<Motion, Failure> {
    let entries = reader.entries;
    let name = |own: &str| format!("{prefix}{own}");
    let (frames, root) = reader.numbers(&name("global_orient"), None, &[3])?;
    let body_name = name("body_pose");
    let Some(array) = entries.get(&body_name) else {
        return Err(missing(&body_name, entries));
    };
    let axes = if array.shape.len() > 2 && array.shape[0] == 1 {
        2
    } else {
        1
    };
    let width: usize = array.shape.iter().skip(axes).product();
    let (joints, is_soma) = match width {
        228 => (joint_tables::soma(77), true),
        63 => (
            joint_tables::smpl(if has_hands(entries, prefix) { 55 } else { 22 }),
            false,
        ),
        69 => (joint_tables::smpl(24), false),
        _ => (None, false),
    };
    let Some(joints) = joints else {
        return Err(Box::new(
            Diagnostic::new(Code::RowLength, format!("the array {body_name} fits no known body")).expected_found(
                "63 numbers per frame for SMPL-X, 69 for SMPL or 228 for SOMA",
                array.shape_text(),
            ),
        ));
    };
    let (_, body) = reader.numbers_of(&body_name, array, Some(frames), &[width / 3, 3])?;
    let mut rotations = tracks(&name("global_orient"), &root, 1)?;
    rotations.extend(tracks(&body_name, &body, width / 3)?);
    if joints.len() == 55 {
        for (own, count) in [
            ("jaw_pose", 1),
            ("leye_pose", 1),
            ("reye_pose", 1),
            ("left_hand_pose", 15),
            ("right_hand_pose", 15),
        ] {
            let own = name(own);
            let numbers = match entries.get(&own) {
                Some(_) => reader.numbers(&own, Some(frames), &[count, 3])?.1,
                None => vec![0.0; frames * count * 3],
            };
            rotations.extend(tracks(&own, &numbers, count)?);
        }
    }
    let mut motion = Motion {
        rotations,
        joints,
        ..Motion::default()
    };
    let translation = ["transl", "trans"]
        .map(name)
        .into_iter()
        .find(|name| entries.get(name).is_some());
    let root = set_root(reader, &mut motion, translation.as_deref(), frames, prefix)?;
    if is_soma {
        // SOMA's translation is the displacement of its root from the rest pose, in which the feet are on the ground.
        let rest = motion.rest.first().copied().unwrap_or_default();
        let lowest = motion.rest.iter().map(|joint| joint.y).fold(rest.y, f32::min);
        let ground = if reader.options.body.is_some() { lowest } else { 0.0 };
        let moved = rest - Vec3::Y * ground - root;
        motion
            .root
            .iter_mut()
            .for_each(|position| *position += moved.as_dvec3());
    }
    guess_up(&mut motion);
    reader.frame_rate(USUAL_RATE, &mut motion)?;
    say_of_body(reader, &mut motion, prefix);
    Ok(motion)
}

/// Whether both hands are given joint by joint, with 45 numbers each. Arrays with fewer numbers are coefficients of a
/// hand model.
fn has_hands(entries: &Entries<'_>, prefix: &str) -> bool {
    ["left_hand_pose", "right_hand_pose"].into_iter().all(|own| {
        let hand = entries.get(&format!("{prefix}{own}"));
        hand.is_some_and(|hand| hand.shape.iter().skip(1).product::<usize>() == 45)
    })
}

/// Arrays without names: PHUMA has 69 numbers per frame, and Motion-X has 322. `None` for other widths.
pub(super) fn of_flat(reader: &Reader<'_, '_>, array: &NdArray<'_>) -> Result<Option<Motion>, Failure> {
    let &[frames, width] = array.shape.as_slice() else {
        return Ok(None);
    };
    // The column of the translation, and the columns of the rotations of root, body, jaw, eyes and hands.
    let (what, joints, root_column, order): (_, _, _, &[(usize, usize)]) = match width {
        69 => ("PHUMA's: translation 3, orientation 3, body 63", 22, 0, &[(3, 22)]),
        322 => (
            "Motion-X's: root 3, body 63, hands 90, jaw 3, expression 50, face 100, translation 3, betas 10",
            55,
            309,
            &[(0, 22), (156, 1), (0, 0), (0, 0), (66, 30)],
        ),
        _ => return Ok(None),
    };
    let (_, numbers) = reader.numbers_of("of the file", array, None, &[width])?;
    let part = |begin: usize, count: usize| -> Vec<f64> {
        numbers
            .chunks_exact(width)
            .flat_map(|row| &row[begin..begin + count])
            .copied()
            .collect()
    };
    let mut rotations = Vec::new();
    for (begin, count) in order {
        match count {
            // A count of 0 stands for an eye without columns, which does not move.
            0 => rotations.push(vec![DQuat::IDENTITY; frames]),
            count => rotations.extend(tracks("of the file", &part(*begin, 3 * count), *count)?),
        }
    }
    let joints = joint_tables::smpl(joints).unwrap_or_default();
    let mut motion = Motion {
        joints,
        rotations,
        root: vectors(&part(root_column, 3)),
        ..Motion::default()
    };
    let root = set_rest(reader, &mut motion, "")?;
    motion.root.iter_mut().for_each(|position| *position += root.as_dvec3());
    let reason = format!("{width} numbers per frame have no names");
    motion.assume(Topic::Layout, what, reason, Confidence::Likely);
    guess_up(&mut motion);
    reader.frame_rate(USUAL_RATE, &mut motion)?;
    say_of_body(reader, &mut motion, "");
    Ok(Some(motion))
}

/// Sets the rest positions of the joints. Sets the root position of each frame to the rest position of the root plus
/// the translation in the array `name`. Positions are relative to the template's origin. Returns the rest position of
/// the root.
fn set_root(
    reader: &Reader<'_, '_>,
    motion: &mut Motion,
    name: Option<&str>,
    frames: usize,
    prefix: &str,
) -> Result<Vec3, Failure> {
    motion.root = match name {
        Some(name) => vectors(&reader.numbers(name, Some(frames), &[3])?.1),
        None => vec![DVec3::ZERO; frames],
    };
    let root = set_rest(reader, motion, prefix)?;
    motion.root.iter_mut().for_each(|position| *position += root.as_dvec3());
    Ok(root)
}

/// Sets the joints at rest: from the given body, or else from the file if this program wrote it, or else from generic
/// proportions. Returns the root position relative to the template's origin.
fn set_rest(reader: &Reader<'_, '_>, motion: &mut Motion, prefix: &str) -> Result<Vec3, Failure> {
    let count = motion.joints.len();
    let first = |rest: &[Vec3]| rest.first().copied().unwrap_or_default();
    if let Some(body) = &reader.options.body {
        let betas = reader.entries.get(&format!("{prefix}betas"));
        let betas = betas.map_or_else(Vec::new, NdArray::numbers);
        motion.rest = body.rest(&motion.joints, &betas);
        return Ok(if body.is_model() {
            first(&motion.rest)
        } else {
            SMPL_ROOT
        });
    }
    if let Some(rest) = reader.entries.get(REST_JOINTS) {
        let (_, numbers) = reader.numbers_of(REST_JOINTS, rest, Some(count), &[3])?;
        motion.rest = vectors(&numbers).into_iter().map(DVec3::as_vec3).collect();
        return Ok(first(&motion.rest));
    }
    motion.rest = proportions::rest(&motion.joints);
    Ok(SMPL_ROOT)
}

/// The array of our own files with the rest joints of the body, in metres.
const REST_JOINTS: &str = "rest_joints";

fn guess_up(motion: &mut Motion) {
    let (up, confidence) = motion.up_of_body();
    motion.up = up;
    motion.assume(
        Topic::Up,
        format!("{} is up", named(up)),
        "the spine points in this direction on average",
        confidence,
    );
}

/// Records where bone lengths and hands come from.
fn say_of_body(reader: &Reader<'_, '_>, motion: &mut Motion, prefix: &str) {
    let entries = reader.entries;
    let betas = entries.get(&format!("{prefix}betas"));
    if let Some(body) = &reader.options.body {
        let used = body.coefficients().min(betas.map_or(0, NdArray::count));
        let (choice, reason) = match used {
            0 if body.is_model() => (
                "the mean shape of the model",
                "the file has no shape coefficients".to_owned(),
            ),
            0 => ("the bones of the given body", "a figure has one shape".to_owned()),
            _ => ("the given model", format!("with {used} coefficients of the file")),
        };
        motion.assume(Topic::Body, choice, reason, Confidence::Sure);
    } else if entries.get(REST_JOINTS).is_none() {
        let choice = format!("generic proportions, {HEIGHT:.2} m tall");
        let is_shaped = betas.is_some() || entries.get(&format!("{prefix}identity_coeffs")).is_some();
        let reason = match is_shaped {
            true => "the shape coefficients of the file need their body model: name the model as the body",
            false => "arrays of rotations have no bone lengths: name a body",
        };
        motion.assume(Topic::Body, choice, reason, Confidence::Unsure);
    }
    if motion.joints.len() >= 52 {
        motion.assume(
            Topic::Hands,
            "finger rotations are relative to a flat hand",
            "the arrays do not state the rest pose of the hands; AMASS and Motion-X use a flat hand",
            Confidence::Likely,
        );
    }
}

/// A track for each of `joints` joints, from the rows of rotations in the array `name`.
fn tracks(name: &str, numbers: &[f64], joints: usize) -> Result<Vec<Vec<DQuat>>, Failure> {
    let rows = numbers.chunks_exact(3 * joints.max(1));
    let frames = rows.len().max(1) as f64;
    let mut tracks = vec![Vec::with_capacity(rows.len()); joints];
    let mut means = vec![0.0; joints];
    for row in rows {
        let vectors = row.as_chunks::<3>().0.iter().map(|vector| DVec3::from_array(*vector));
        for ((track, mean), vector) in tracks.iter_mut().zip(&mut means).zip(vectors) {
            *mean += vector.length() / frames;
            track.push(DQuat::from_scaled_axis(vector));
        }
    }
    check_radians(name, means)?;
    Ok(tracks)
}

fn vectors(numbers: &[f64]) -> Vec<DVec3> {
    numbers
        .as_chunks::<3>()
        .0
        .iter()
        .map(|xyz| DVec3::from_array(*xyz))
        .collect()
}

fn missing(name: &str, entries: &Entries<'_>) -> Failure {
    Box::new(
        Diagnostic::new(Code::MissingKeyword, format!("the array {name} is missing"))
            .expected_found(format!("an array {name}"), entries.describe()),
    )
}
