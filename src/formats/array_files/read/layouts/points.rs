//! One array of positions, (frames, joints, 3): points without a skeleton, like the markers of C3D.

use glam::DVec3;
use mocap_scene::limits::{is_plausible, limit_exceeded};
use mocap_scene::scene::joint_tables;
use mocap_scene::scene::{Assumption, Confidence, Format, Scene, Topic};

use super::plausible::check_humanml3d;
use super::{KNOWN, Reader, refused};
use crate::Failure;
use crate::array_files::read::humanml3d;
use crate::array_files::read::motion::Motion;
use crate::array_files::read::ndarray::{Entries, NdArray};
use crate::points::{self, Kind, Track};
use crate::warnings::Warnings;

/// The frame rate in frames per second of arrays that do not state one. HumanML3D, which has 22 joints, has its own
/// frame rate.
const USUAL_RATE: f64 = 30.0;

/// The only array of a file, or the array of positions.
pub(super) fn only_array<'e, 'a>(entries: &'e Entries<'a>) -> Option<&'e NdArray<'a>> {
    const NAMES: &[&str] = &["positions", "joints", "keypoints3d", "joints3d", "keypoints"];
    let mut motions = entries
        .arrays
        .iter()
        .filter(|(_, array)| array.is_number() && array.shape.len() >= 2);
    let only = (motions.next(), motions.next());
    entries.first(NAMES).or(match only {
        (Some((_, array)), None) => Some(array),
        _ => None,
    })
}

/// A group with a point for each joint.
pub(super) fn scene(
    reader: &Reader<'_, '_>,
    array: &NdArray<'_>,
    format: Format,
    warnings: &mut Warnings,
) -> Result<Scene, Failure> {
    // The output of a network may have a batch axis of length 1.
    let shape = match array.shape.as_slice() {
        [1, shape @ ..] if shape.len() == 3 => shape,
        shape => shape,
    };
    let (&[frames, count, 3], true) = (shape, array.is_number()) else {
        let found = refused("the shape of the array fits no known layout of motions", reader.entries);
        return Err(Box::new(
            found
                .expected_found("(frames, joints, 3)", array.shape_text())
                .help(KNOWN),
        ));
    };
    let (_, numbers) = reader.numbers_of("of the file", array, None, &[count, 3])?;
    of_numbers(reader, (frames, count), &numbers, format, warnings)
}

/// HumanML3D's numbers as points of the SMPL joints. `None` if the array has another width.
pub(super) fn of_humanml3d(
    reader: &Reader<'_, '_>,
    array: &NdArray<'_>,
    format: Format,
    warnings: &mut Warnings,
) -> Result<Option<Scene>, Failure> {
    let [.., humanml3d::NUMBERS] = array.shape.as_slice() else {
        return Ok(None);
    };
    let (frames, rows) = reader.numbers_of("of the file", array, None, &[humanml3d::NUMBERS])?;
    check_humanml3d(&rows)?;
    let joints = humanml3d::joints(&rows);
    let numbers: Vec<f64> = joints.iter().flatten().flat_map(glam::DVec3::to_array).collect();
    of_numbers(reader, (frames, humanml3d::JOINTS), &numbers, format, warnings).map(Some)
}

fn of_numbers(
    reader: &Reader<'_, '_>,
    (frames, count): (usize, usize),
    numbers: &[f64],
    format: Format,
    warnings: &mut Warnings,
) -> Result<Scene, Failure> {
    let most = reader.options.limits.max_nodes;
    if count >= most {
        return Err(Box::new(limit_exceeded(
            format!("at most {most} nodes"),
            format!("{count} joints"),
        )));
    }
    let mut motion = Motion::default();
    let usual = if count == humanml3d::JOINTS {
        humanml3d::RATE
    } else {
        USUAL_RATE
    };
    reader.frame_rate(usual, &mut motion)?;
    let mut scene = Scene::default();
    scene.metadata.format = Some(format);
    scene.metadata.assumptions = motion.assumptions;
    let names = names(reader.entries, count, &mut scene.metadata.assumptions);
    let tracks = names.into_iter().enumerate().map(|(index, name)| {
        let (mut ticks, mut positions) = (Vec::new(), Vec::new());
        for frame in 0..frames {
            let position = &numbers[3 * (frame * count + index)..][..3];
            if position.iter().all(|number| is_plausible(*number)) {
                ticks.push(frame as f64);
                positions.push(DVec3::from_slice(position).as_vec3());
            }
        }
        Track {
            name,
            ticks,
            positions,
            zeros: 0,
        }
    });
    points::add(
        &mut scene,
        Kind::POINTS,
        tracks.collect(),
        (frames, motion.frame_rate),
        warnings,
    );
    Ok(scene)
}

/// The names of the points: the file's names, or the names of SMPL joints if the count fits, or numbers.
fn names(entries: &Entries<'_>, count: usize, assumptions: &mut Vec<Assumption>) -> Vec<String> {
    let stated = entries.first(&["names", "joint_names"]).map(NdArray::texts);
    if let Some(names) = stated.filter(|names| names.len() == count) {
        return names;
    }
    match joint_tables::smpl(count) {
        Some(joints) => {
            assumptions.push(Assumption {
                topic: Topic::Layout,
                choice: format!("the joints of SMPL, {count} of them"),
                reason: format!("{count} positions a frame have no names"),
                confidence: Some(Confidence::Likely),
            });
            joints.into_iter().map(|joint| joint.name).collect()
        }
        None => (0..count).map(|index| format!("Point_{index}")).collect(),
    }
}
