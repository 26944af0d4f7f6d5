//! The arrays of this program, as `mocap fk` writes them, converted back to the scene.

use glam::{DMat3, DQuat, DVec3, Mat4, Vec3};
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::math::rotation::euler_rot;
use mocap_scene::scene::{Channel, Format, GROUP_OF_ROOTS, Keys, Node, NodeId, NodeKind, RotationOrder, Scene, UpAxis};
use serde::Deserialize;
use serde_json::value::RawValue;

use super::Reader;
use crate::Failure;
use crate::array_files::read::ndarray::{Entries, NdArray};
use crate::frames::add_animation;
use crate::warnings::Warnings;

/// Whether this program wrote the arrays.
pub(super) fn is_own(entries: &Entries<'_>) -> bool {
    let header = entries.get("header").map(NdArray::texts).unwrap_or_default();
    header.first().is_some_and(|text| text.starts_with("{\"frame_rate\":"))
        && ["positions", "rotations"]
            .into_iter()
            .all(|name| entries.get(name).is_some())
}

/// The fields of the header that describe the numbers.
#[derive(Deserialize)]
struct Header {
    /// The digits of the frame rate in the file. The frame rate is the nearest double.
    frame_rate: Box<RawValue>,
    metres_per_unit: Option<f64>,
    up: Option<UpAxis>,
    space: String,
    rotation: String,
    rotation_space: String,
    joints: Vec<Joint>,
}

#[derive(Deserialize)]
struct Joint {
    #[doc(hidden)]
    pub name: String,
    #[doc(hidden)]
    pub parent: Option<usize>,
    offset: [f32; 3],
    end_site: bool,
    rotation_order: Option<RotationOrder>,
}

fn invalid(message: String) -> Failure {
    Box::new(Diagnostic::new(Code::UnexpectedToken, message).help("write it again with mocap fk"))
}

pub(super) fn scene(reader: &Reader<'_, '_>, format: Format, warnings: &mut Warnings) -> Result<Scene, Failure> {
    let text = reader.entries.get("header").map(NdArray::texts).unwrap_or_default();
    let header: Header = serde_json::from_str(text.first().map_or("", String::as_str)).map_err(|error| {
        invalid(format!(
            "the header of the arrays is not one that mocap writes: {error}"
        ))
    })?;
    let count = header.joints.len();
    let width = match header.rotation.as_str() {
        "quat" => 4,
        "6d" => 6,
        "matrix" => 9,
        _ => 3,
    };
    let (frames, positions) = reader.numbers("positions", None, &[count, 3])?;
    let widths: &[usize] = if width == 9 { &[count, 3, 3] } else { &[count, width] };
    let (_, rotations) = reader.numbers("rotations", Some(frames), widths)?;
    of_numbers(header, frames, &positions, &rotations, reader, format, warnings)
}

/// Makes the scene from the numbers of every frame and joint.
fn of_numbers(
    header: Header,
    frames: usize,
    positions: &[f64],
    rotations: &[f64],
    reader: &Reader<'_, '_>,
    format: Format,
    warnings: &mut Warnings,
) -> Result<Scene, Failure> {
    let count = header.joints.len();
    let parents: Vec<Option<usize>> = header.joints.iter().map(|joint| joint.parent).collect();
    if let Some(index) = (0..count).find(|index| parents[*index].is_some_and(|parent| parent >= *index)) {
        return Err(invalid(format!("the parent of the joint {index} does not precede it")));
    }
    if count == 0 {
        return Err(invalid("the header of the arrays names no joints".to_owned()));
    }
    if header.space != "world" {
        let message = format!(
            "the positions of the arrays are relative to {}, so the root path is lost",
            header.space
        );
        return Err(Box::new(
            Diagnostic::new(Code::UnexpectedToken, message)
                .expected_found("positions in the world", header.space.clone())
                .help("write them in world space"),
        ));
    }
    let ids = ids(&parents);
    let mut scene = Scene::default();
    let group = (ids.first() != Some(&NodeId::new(0))).then_some(NodeId::new(0));
    scene.nodes = vec![Node::default(); count + usize::from(group.is_some())];
    if group.is_some() {
        scene.nodes[0].name = GROUP_OF_ROOTS.to_owned();
        scene.nodes[0].kind = NodeKind::Group;
    }
    scene.metadata.format = Some(format);
    scene.metadata.metres_per_unit = header.metres_per_unit;
    scene.metadata.up = header.up;
    let width = rotations.len().checked_div(frames * count).unwrap_or(4);
    let is_world = header.rotation_space == "world";
    let (mut world, mut channels) = (Vec::<Vec<DQuat>>::with_capacity(count), Vec::with_capacity(count));
    for (index, joint) in header.joints.iter().enumerate() {
        let read = |frame: usize| {
            let row = &rotations[width * (frame * count + index)..][..width];
            rotation(row, joint.rotation_order)
        };
        let own: Vec<DQuat> = (0..frames).map(read).collect();
        let above = parents[index];
        let to_world = |frame: usize, own: DQuat| above.map_or(own, |parent| world[parent][frame] * own);
        let to_parent = |frame: usize, own: DQuat| above.map_or(own, |parent| world[parent][frame].inverse() * own);
        let pairs = || own.iter().copied().enumerate();
        let (in_world, local): (Vec<DQuat>, Vec<DQuat>) = match is_world {
            true => (own.clone(), pairs().map(|(frame, own)| to_parent(frame, own)).collect()),
            false => (pairs().map(|(frame, own)| to_world(frame, own)).collect(), own.clone()),
        };
        let at = |frame: usize, joint: usize| DVec3::from_slice(&positions[3 * (frame * count + joint)..][..3]);
        let offset = Vec3::from(joint.offset);
        let position_at = |frame: usize| match above {
            None => at(frame, index).as_vec3(),
            Some(parent) => (world[parent][frame].inverse() * (at(frame, index) - at(frame, parent))).as_vec3(),
        };
        let root_path: Vec<Vec3> = (0..frames).map(position_at).collect();
        world.push(in_world);
        let id = ids[index];
        scene.nodes[id.index()] = Node {
            name: joint.name.clone(),
            kind: if joint.end_site {
                NodeKind::EndSite
            } else {
                NodeKind::Joint
            },
            parent: above.map(|parent| ids[parent]).or(group),
            transform: Mat4::from_translation(offset),
            rotation_order: joint.rotation_order,
            ..Node::default()
        };
        let unseen = root_path.iter().filter(|position| !position.is_finite()).count();
        if unseen > 0 && above.is_none() {
            warnings.push(Code::Gap, || {
                let message = format!("the point was not seen in {unseen} of {frames} frames");
                Diagnostic::new(Code::Gap, message).in_joint(&joint.name)
            });
        }
        if !joint.end_site {
            channels.push(channel(joint, id, above.is_none(), root_path, local));
        }
    }
    channels.sort_by_key(|channel| channel.node.map(NodeId::index));
    let stated: f64 = header.frame_rate.get().parse().unwrap_or(0.0);
    let rate = reader.options.frame_rate_or(stated);
    add_animation(&mut scene, (frames, rate?), channels, "a skeleton", warnings);
    Ok(scene)
}

/// The node of each joint, depth-first. Several roots get a common parent, which is the first node.
fn ids(parents: &[Option<usize>]) -> Vec<NodeId> {
    let mut children = vec![Vec::new(); parents.len()];
    let mut open = Vec::new();
    for (index, parent) in parents.iter().enumerate().rev() {
        match parent {
            Some(parent) => children[*parent].push(index),
            None => open.push(index),
        }
    }
    let mut next = usize::from(open.len() != 1);
    let mut ids = vec![NodeId::new(0); parents.len()];
    while let Some(index) = open.pop() {
        ids[index] = NodeId::new(next);
        next += 1;
        open.append(&mut children[index]);
    }
    ids
}

/// The channel of a joint. A joint other than the root that keeps its position relative to its parent has a constant
/// position.
fn channel(joint: &Joint, id: NodeId, is_root: bool, root_path: Vec<Vec3>, rotations: Vec<DQuat>) -> Channel {
    /// The rounding error of 32-bit positions, as a fraction of their size.
    const ROUNDING: f32 = 1e-5;
    let offset = Vec3::from(joint.offset);
    let largest = root_path
        .iter()
        .map(|position| position.abs().max_element())
        .fold(offset.length(), f32::max);
    let moves = root_path
        .iter()
        .any(|position| position.distance(offset) > ROUNDING * largest.max(1.0));
    Channel {
        node_name: joint.name.clone(),
        node: Some(id),
        position_keys: match is_root || moves {
            true => {
                let frames = root_path.len();
                let seen = root_path.into_iter().enumerate().filter(|(_, at)| at.is_finite());
                let (ticks, seen) = seen.map(|(frame, at)| (frame as f64, at)).unzip();
                Keys::of_point(seen, ticks, frames)
            }
            false => Keys::constant(offset),
        },
        rotation_keys: Keys::every_tick(
            rotations
                .into_iter()
                .map(|rotation| rotation.normalize().as_quat())
                .collect(),
        ),
        scaling_keys: Keys::constant(Vec3::ONE),
    }
}

/// The rotation in a row of numbers. The count of numbers shows which form of [`Rotation`](mocap_scene::scene) the row
/// has.
fn rotation(row: &[f64], order: Option<RotationOrder>) -> DQuat {
    let vector = |at: usize| DVec3::from_slice(&row[at..at + 3]);
    let of_columns = |x: DVec3, y: DVec3| {
        let x = x.normalize_or(DVec3::X);
        let y = (y - x * x.dot(y)).normalize_or(x.any_orthonormal_vector());
        DQuat::from_mat3(&DMat3::from_cols(x, y, x.cross(y)))
    };
    let rotation = match row.len() {
        4 => DQuat::from_slice(row),
        6 => of_columns(vector(0), vector(3)),
        9 => DQuat::from_mat3(&DMat3::from_cols_slice(row).transpose()),
        _ => {
            let order = order.unwrap_or(RotationOrder::Xyz);
            let [a, b, c] = order.axes().map(|axis| row[axis].to_radians());
            DQuat::from_euler(euler_rot(order), a, b, c)
        }
    };
    match rotation.is_finite() && rotation.length_squared() > 1e-6 {
        true => rotation.normalize(),
        false => DQuat::IDENTITY,
    }
}
