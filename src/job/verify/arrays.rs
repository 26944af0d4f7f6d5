//! The comparison of arrays with their source: every position and every rotation as the file gives it, in its space.

use glam::{DMat3, DMat4, DQuat, DVec3};

use super::chain::{Joint, Skeleton};
use super::change::Change;
use super::clip::{Errors, SKIN, name_of, roots, worse};
use super::timeline::Timeline;
use super::{Finding, FindingKind, Verification, VerifiedClip, Worst};
use mocap_figure::Figure;
use mocap_formats::gltf::Provenance;
use mocap_scene::error::{Code, Diagnostic, Error, Result};
use mocap_scene::scene::{NodeKind, Scene};
use serde::Deserialize;

use crate::arrays::{Rotation, RotationSpace, Space};

/// The arrays of a file.
pub(super) struct ArrayFile {
    pub(super) header: Header,
    pub(super) frame_rate: f64,
    pub(super) frames: usize,
    pub(super) names: Vec<String>,
    pub(super) parents: Vec<Option<usize>>,
    pub(super) end_sites: Vec<bool>,
    /// The letters of the axes; empty for a joint without an order.
    pub(super) rotation_orders: Vec<String>,
    /// Of each joint from its parent at rest; without a parent, from the origin of the source.
    pub(super) offsets: Vec<[f32; 3]>,
    /// Frames x joints x 3.
    pub(super) positions: Vec<f32>,
    /// Frames x joints x `width`.
    pub(super) rotations: Vec<f32>,
    pub(super) width: usize,
}

/// What is needed of the header.
#[derive(Deserialize)]
pub(super) struct Header {
    pub(super) metres_per_unit: Option<f64>,
    pub(super) space: Space,
    pub(super) rotation: Rotation,
    pub(super) rotation_space: RotationSpace,
    pub(super) provenance: Provenance,
}

impl Header {
    /// A header from its JSON.
    pub(super) fn from_json(json: &str) -> Result<Self> {
        serde_json::from_str(json).map_err(|error| invalid(format!("the header is not as expected: {error}")))
    }
}

pub(super) const HELP: &str = "write it with `mocap fk SOURCE -o OUT.npz`, or OUT.csv";

/// The error of a file that is broken.
pub(super) fn invalid(message: impl Into<String>) -> Error {
    Diagnostic::new(Code::InvalidArrays, message).help(HELP).into()
}

/// Compares the arrays of a file with the first clip of their source. Joints that the file does not have are listed,
/// and are no finding: arrays may have a choice of them.
pub(super) fn compare(source: &Scene, file: &ArrayFile) -> Result<Verification> {
    let clip = (!source.animations.is_empty()).then_some(0);
    let ours = Skeleton::of_scene(source, clip);
    let node_of = nodes_of(&ours, file)?;
    let change = Change::recorded(&file.header.provenance.steps);
    let timeline = Timeline::new(source, clip, &change)?;
    let mut verification = Verification {
        joints: node_of.len(),
        metres_per_unit: change.metres_per_unit,
        has_provenance: true,
        ..Verification::default()
    };
    let joints = ours.joints.iter().enumerate();
    for (_, joint) in joints.filter(|(index, _)| !node_of.contains(index)) {
        match joint.kind {
            NodeKind::Joint => verification.missing.push(joint.name.clone()),
            NodeKind::EndSite => verification.missing_end_sites.push(joint.name.clone()),
            NodeKind::Group => {}
        }
    }
    find(source, file, &ours, &node_of, &timeline, &mut verification.findings);
    find_in_skeleton(source, file, &node_of, &change, &mut verification.findings);

    let metres = match file.header.metres_per_unit {
        Some(metres) => metres,
        None => Figure::new(source).survey.metres_per_unit / change.metres_per_unit,
    };
    let roots = roots(&ours);
    let cuts = match clip.filter(|_| timeline.is_resampled) {
        Some(clip) => source.cuts(clip),
        None => Vec::new(),
    };
    let mut errors = Errors::default();
    errors.rotation = Some(0.0);
    let mut world = Vec::new();
    let frames = if clip.is_some() { file.frames } else { 0 };
    for frame in 0..frames {
        let tick = timeline.tick(frame, &cuts);
        ours.world(tick / timeline.rate, &mut world);
        for (joint, &node) in node_of.iter().enumerate() {
            let parent = file.parents[joint].map(|parent| &world[node_of[parent]]);
            let row = frame * node_of.len() + joint;
            let (position, rotation) = expected(&change, file, &world[node], parent, &world[roots[node]]);
            let found = &file.positions[3 * row..][..3];
            let found = DVec3::new(found[0].into(), found[1].into(), found[2].into());
            errors.add(position.distance(found) * metres, || Worst {
                clip: 0,
                joint: file.names[joint].clone(),
                frame: tick as usize,
                seconds: frame as f64 / file.frame_rate,
            });
            let found = decoded(file, row, &file.rotation_orders[joint]);
            errors.add_rotation(
                (0..3)
                    .map(|axis| rotation.col(axis).distance(found.col(axis)) * SKIN)
                    .fold(0.0, worse),
            );
        }
        errors.frames += 1;
    }
    verification.frames = errors.frames;
    verification.max_error = errors.max;
    verification.rms_error = errors.rms();
    verification.rotation_error = errors.rotation;
    verification.clips.extend(clip.map(|clip| VerifiedClip {
        name: source.animations[clip].name.clone(),
        frames: errors.frames,
        max_error: errors.max,
    }));
    verification.worst = errors.worst;
    Ok(verification)
}

/// Whether a joint has a name of the file. Texts of NumPy have no zeros at their end.
fn is_called(joint: &Joint<'_>, name: &str) -> bool {
    [joint.name.as_str(), joint.name.trim_end_matches('\0')].contains(&name)
}

/// The joint of the source for each of the file: the next of its name and kind, in the order of both.
fn nodes_of(ours: &Skeleton, file: &ArrayFile) -> Result<Vec<usize>> {
    let mut node_of: Vec<usize> = Vec::with_capacity(file.names.len());
    for (name, is_end_site) in std::iter::zip(&file.names, &file.end_sites) {
        let next = node_of.last().map_or(0, |last| last + 1);
        let is_it = |node: &usize| {
            let joint = &ours.joints[*node];
            is_called(joint, name) && joint.kind != NodeKind::Group && (joint.kind == NodeKind::EndSite) == *is_end_site
        };
        let node = (next..ours.joints.len()).find(is_it);
        node_of.push(node.ok_or_else(|| {
            let message = format!("the joint {name:?} of the file is not in its source, or not in this order");
            Diagnostic::new(Code::Unrepresentable, message).help("compare it with the file it was made from")
        })?);
    }
    Ok(node_of)
}

/// Finds joints on other parents, and frames that are too few or too many.
fn find(
    source: &Scene,
    file: &ArrayFile,
    ours: &Skeleton,
    node_of: &[usize],
    timeline: &Timeline,
    findings: &mut Vec<Finding>,
) {
    for (joint, &node) in node_of.iter().enumerate() {
        let mut above = ours.joints[node].parent;
        while let Some(node) = above.filter(|node| !node_of.contains(node)) {
            above = ours.joints[node].parent;
        }
        if above != file.parents[joint].map(|parent| node_of[parent]) {
            let message = format!("\"{}\" has another parent in the file", file.names[joint]);
            findings.push(Finding::new(FindingKind::MovedJoint, message));
        }
    }
    let name = match source.animations.is_empty() {
        true => "the motion".to_owned(),
        false => name_of(source, 0),
    };
    let expected = if source.animations.is_empty() {
        0
    } else {
        timeline.whole_frames()
    };
    let message = format!(
        "{name} has {} frames in the file, and would have {expected}",
        file.frames
    );
    match file.frames.cmp(&expected) {
        std::cmp::Ordering::Less => findings.push(Finding::new(FindingKind::MissingFrames, message)),
        std::cmp::Ordering::Greater => findings.push(Finding::new(FindingKind::ExtraFrames, message)),
        std::cmp::Ordering::Equal => {}
    }
    let rate = timeline.frame_rate();
    if !source.animations.is_empty() && (file.frame_rate / rate - 1.0).abs() > 1e-9 {
        let message = format!(
            "{name} has {} frames a second in the file, and would have {rate}",
            file.frame_rate
        );
        findings.push(Finding::new(FindingKind::Provenance, message));
    }
}

/// Finds offsets and orders of rotations that are not those of the source.
fn find_in_skeleton(source: &Scene, file: &ArrayFile, node_of: &[usize], change: &Change, findings: &mut Vec<Finding>) {
    /// As a fraction of the farthest position: what 32-bit products round.
    const ROUNDING: f64 = 1e-5;
    let mut world = Vec::new();
    Skeleton::of_scene(source, None).world(0.0, &mut world);
    let origin = |matrix: &DMat4| matrix.w_axis.truncate();
    let farthest = world.iter().map(|matrix| origin(matrix).length()).fold(0.0, f64::max) * change.metres_per_unit;
    for (joint, &index) in node_of.iter().enumerate() {
        let name = &file.names[joint];
        let parent = file.parents[joint].map(|parent| world[node_of[parent]].inverse());
        let expected = origin(&(parent.unwrap_or(DMat4::IDENTITY) * world[index])) * change.metres_per_unit;
        let found = DVec3::from(file.offsets[joint].map(f64::from));
        let distance = expected.distance(found);
        if distance.is_nan() || distance > ROUNDING * farthest {
            let message = format!("the offset of \"{name}\" is {found:.6}, and would be {expected:.6}");
            findings.push(Finding::new(FindingKind::Offset, message));
        }
        let order = source.nodes[index].rotation_order;
        let axes = order.map_or_else(Vec::new, |order| order.axes().to_vec());
        let order: String = axes.into_iter().map(|axis| ['X', 'Y', 'Z'][axis]).collect();
        let found = &file.rotation_orders[joint];
        if *found != order {
            let message = format!(
                "the rotations of \"{name}\" are in the order {found:?} in the file, and {order:?} in its source"
            );
            findings.push(Finding::new(FindingKind::RotationOrder, message));
        }
    }
}

/// The position and the rotation that the file should have. `world` and the others are those of the source.
fn expected(change: &Change, file: &ArrayFile, world: &DMat4, parent: Option<&DMat4>, root: &DMat4) -> (DVec3, DMat3) {
    let origin = |matrix: &DMat4| matrix.w_axis.truncate();
    let in_parent = parent.map(|parent| parent.inverse() * *world);
    let position = match (file.header.space, &in_parent) {
        (Space::World, _) | (Space::Local, None) => change.apply(origin(world)),
        (Space::Root, _) => change.apply(origin(world)) - change.apply(origin(root)),
        // Lengths have another unit, but the axes are the parent's.
        (Space::Local, Some(matrix)) => origin(matrix) * change.metres_per_unit,
    };
    let axes = |matrix: &DMat4| [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|axis| axis.truncate().normalize());
    let [x, y, z] = match (file.header.rotation_space, &in_parent) {
        (RotationSpace::Local, Some(matrix)) => axes(matrix),
        _ => axes(world).map(|axis| change.turn(axis)),
    };
    (position, DMat3::from_cols(x, y, z))
}

/// A rotation of the file as a matrix.
fn decoded(file: &ArrayFile, row: usize, order: &str) -> DMat3 {
    let values = file.rotations[file.width * row..][..file.width]
        .iter()
        .map(|value| f64::from(*value));
    let values: Vec<f64> = values.collect();
    match file.header.rotation {
        Rotation::Quaternion => DMat3::from_quat(DQuat::from_slice(&values).normalize()),
        Rotation::SixD => {
            let (x, y) = (DVec3::from_slice(&values), DVec3::from_slice(&values[3..]));
            DMat3::from_cols(x, y, x.cross(y))
        }
        Rotation::Matrix => DMat3::from_cols_slice(&values).transpose(),
        Rotation::Euler => {
            let order = if order.is_empty() { "XYZ" } else { order };
            order.chars().fold(DMat3::IDENTITY, |matrix, axis| {
                matrix
                    * match axis {
                        'X' => DMat3::from_rotation_x(values[0].to_radians()),
                        'Y' => DMat3::from_rotation_y(values[1].to_radians()),
                        _ => DMat3::from_rotation_z(values[2].to_radians()),
                    }
            })
        }
    }
}
