//! One array of positions, (frames, joints, 3): points without a skeleton, as the markers of C3D.

use glam::{Mat4, Quat, Vec3};

use super::{KNOWN, Reader, refused};
use crate::error::{Code, Diagnostic};
use crate::format::Failure;
use crate::format::array_files::motion::Motion;
use crate::format::array_files::ndarray::{Entries, NdArray};
use crate::format::warnings::Warnings;
use crate::limits::{is_plausible, limit_exceeded};
use crate::scene::{Animation, Assumption, Channel, Confidence, Format, Keys, Node, NodeId, NodeKind, Scene, Topic};
use crate::solve::{humanml3d, skeletons};

/// Frames per second of arrays that do not say, but for those of HumanML3D, which has 22 joints.
const USUAL_RATE: f64 = 30.0;

/// The array of a file that has one, or that of positions.
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
    // A network's output may have an axis for one of many.
    let shape = match array.shape.as_slice() {
        [1, shape @ ..] if shape.len() == 3 => shape,
        shape => shape,
    };
    let (&[frames, count, 3], true) = (shape, array.is_number()) else {
        let found = refused("the array is no motion that is known", reader.entries);
        return Err(Box::new(
            found
                .expected_found("(frames, joints, 3)", array.shape_text())
                .help(KNOWN),
        ));
    };
    let (_, numbers) = reader.numbers_of("of the file", array, None, &[count, 3])?;
    of_numbers(reader, (frames, count), &numbers, format, warnings)
}

/// HumanML3D's numbers, as points of the joints of SMPL. `None` where the array has another width.
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
    scene.nodes.push(Node {
        name: "Points".to_owned(),
        kind: NodeKind::Group,
        ..Node::default()
    });
    let names = names(reader.entries, count, &mut scene.metadata.assumptions);
    let mut channels = Vec::with_capacity(count);
    for (index, name) in names.into_iter().enumerate() {
        let (mut ticks, mut positions) = (Vec::new(), Vec::new());
        for frame in 0..frames {
            let place = &numbers[3 * (frame * count + index)..][..3];
            if place.iter().all(|number| is_plausible(*number)) {
                ticks.push(frame as f64);
                positions.push(Vec3::new(place[0] as f32, place[1] as f32, place[2] as f32));
            }
        }
        let missing = frames - ticks.len();
        if missing > 0 {
            warnings.push(Code::Gap, || {
                let message = format!("the point is not finite in {missing} of {frames} frames");
                Diagnostic::new(Code::Gap, message).in_joint(&name)
            });
        }
        let id = NodeId::new(scene.nodes.len());
        scene.nodes.push(Node {
            name: name.clone(),
            parent: Some(NodeId(0)),
            transform: Mat4::from_translation(positions.first().copied().unwrap_or_default()),
            ..Node::default()
        });
        channels.push(Channel {
            node_name: name,
            node: Some(id),
            position_keys: Keys::at_ticks(positions, ticks),
            rotation_keys: Keys::constant(Quat::IDENTITY),
            scaling_keys: Keys::constant(Vec3::ONE),
        });
    }
    if frames == 0 {
        warnings.push(Code::NoMotion, || {
            Diagnostic::new(
                Code::NoMotion,
                "the array has no frames: the scene has points and no animation",
            )
        });
    } else {
        scene.animations.push(Animation {
            name: "Motion".to_owned(),
            ticks_per_second: motion.frame_rate,
            duration: (frames - 1) as f64,
            channels,
        });
    }
    Ok(scene)
}

/// The names of the points: those of the file, or of the joints of SMPL where there are as many, or numbers.
fn names(entries: &Entries<'_>, count: usize, assumptions: &mut Vec<Assumption>) -> Vec<String> {
    let stated = entries.first(&["names", "joint_names"]).map(NdArray::texts);
    if let Some(names) = stated.filter(|names| names.len() == count) {
        return names;
    }
    match skeletons::smpl(count) {
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
