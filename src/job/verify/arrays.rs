//! The comparison of arrays with their source: every position and every rotation, in the space of the file.

use glam::{DMat3, DMat4, DQuat, DVec3};

use super::chain::{self, Skeleton};
use super::change::Change;
use super::claims::claims;
use super::clip::{Errors, SKIN, name_of, worse};
use super::timeline::Timeline;
use super::{Finding, FindingKind, LargestDeviation, Verification, VerifiedClip};
use mocap_figure::Figure;
use mocap_formats::gltf::report::Provenance;
use mocap_scene::error::{Code, Diagnostic, Error, Result};
use mocap_scene::scene::{NodeKind, Scene, UpAxis};
use serde::Deserialize;

use crate::arrays::{Rotation, RotationSpace, Space};

/// The arrays of a file.
pub(super) struct ArrayFile {
    pub(super) header: Header,
    pub(super) frames: usize,
    /// Frames x joints x 3.
    pub(super) positions: Vec<f32>,
    /// Frames x joints x the width of a rotation.
    pub(super) rotations: Vec<f32>,
    /// Frames x joints x 3, if the file has velocities.
    pub(super) velocities: Option<Vec<f32>>,
}

/// The needed fields of the header.
#[derive(Deserialize)]
pub(super) struct Header {
    pub(super) frame_rate: f64,
    metres_per_unit: Option<f64>,
    up: Option<UpAxis>,
    space: Space,
    pub(super) rotation: Rotation,
    rotation_space: RotationSpace,
    pub(super) joints: Vec<Joint>,
    pub(super) provenance: Provenance,
}

/// A joint or an end site.
#[derive(Deserialize)]
pub(super) struct Joint {
    pub(super) name: String,
    pub(super) parent: Option<usize>,
    pub(super) end_site: bool,
    /// The letters of the rotation axes, in order.
    pub(super) rotation_order: Option<String>,
    /// The rest offset from its parent; without a parent, from the origin of the source.
    pub(super) offset: [f32; 3],
}

impl Header {
    /// Parses a header from JSON.
    pub(super) fn from_json(json: &str) -> Result<Self> {
        let header: Self =
            serde_json::from_str(json).map_err(|error| invalid(format!("the header is invalid: {error}")))?;
        let misplaced = |(joint, found): (usize, &Joint)| found.parent.is_some_and(|parent| parent >= joint);
        match header.joints.iter().enumerate().any(misplaced) {
            true => Err(invalid("a joint in the header precedes its parent")),
            false => Ok(header),
        }
    }
}

pub(super) const HELP: &str = "write it with `mocap fk SOURCE -o OUT.npz`, or OUT.csv";

/// The error of a broken file.
pub(super) fn invalid(message: impl Into<String>) -> Error {
    Diagnostic::new(Code::InvalidArrays, message).help(HELP).into()
}

/// Compares the arrays of a file with the first clip of their source. Missing joints are listed, but are not a finding:
/// arrays may have a selection of joints.
pub(super) fn compare(source: &Scene, file: &ArrayFile) -> Result<Verification> {
    let clip = (!source.animations.is_empty()).then_some(0);
    let ours = Skeleton::of_scene(source, clip);
    let node_of = nodes_of(&ours, file)?;
    let change = Change::recorded(&file.header.provenance.steps);
    let timeline = Timeline::new(source, clip, &change)?;
    let [joint_count, end_sites] = ours.count(node_of.iter().copied());
    let mut verification = Verification {
        joints: joint_count,
        end_sites,
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
    find_in_header(source, file, &mut verification.findings);
    verification.findings.extend(wrong_velocity(file));

    let metres = match file.header.metres_per_unit {
        Some(metres) => metres,
        None => Figure::new(source).survey.metres_per_unit / change.metres_per_unit,
    };
    let roots = ours.roots();
    let mut errors = Errors::default();
    errors.rotation = Some(0.0);
    let mut world = Vec::new();
    let frames = if clip.is_some() { file.frames } else { 0 };
    for frame in 0..frames {
        let tick = timeline.shown(timeline.tick(frame));
        ours.world(tick / timeline.rate, &mut world);
        for (joint, &node) in node_of.iter().enumerate() {
            let parent = file.header.joints[joint].parent.map(|parent| &world[node_of[parent]]);
            let row = frame * node_of.len() + joint;
            let (position, rotation) = expected(&change, file, &world[node], parent, &world[roots[node]]);
            let found = &file.positions[3 * row..][..3];
            let found = DVec3::new(found[0].into(), found[1].into(), found[2].into());
            errors.add(position.distance(found) * metres, || LargestDeviation {
                clip: 0,
                joint: file.header.joints[joint].name.clone(),
                frame: tick as usize,
                seconds: frame as f64 / file.header.frame_rate,
            });
            let found = decoded(file, row, file.header.joints[joint].rotation_order.as_deref());
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

/// Whether a joint has this name in the file. NumPy strings drop zeros at their end.
fn is_called(joint: &chain::Joint<'_>, name: &str) -> bool {
    [joint.name.as_str(), joint.name.trim_end_matches('\0')].contains(&name)
}

/// For each joint of the file, the joint of the source with the same name and kind. The source and the file have their
/// joints in the same order.
fn nodes_of(ours: &Skeleton, file: &ArrayFile) -> Result<Vec<usize>> {
    let mut node_of: Vec<usize> = Vec::with_capacity(file.header.joints.len());
    for Joint { name, end_site, .. } in &file.header.joints {
        let next = node_of.last().map_or(0, |last| last + 1);
        let is_it = |node: &usize| {
            let joint = &ours.joints[*node];
            is_called(joint, name) && joint.kind != NodeKind::Group && (joint.kind == NodeKind::EndSite) == *end_site
        };
        let node = (next..ours.joints.len()).find(is_it);
        node_of.push(node.ok_or_else(|| {
            let message = format!("the joint {name:?} of the file is not in its source, or not in this order");
            Diagnostic::new(Code::Unrepresentable, message).help("compare the file with the file that it was made from")
        })?);
    }
    Ok(node_of)
}

/// Finds joints with another parent, and missing or additional frames.
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
        let found = &file.header.joints[joint];
        if above != found.parent.map(|parent| node_of[parent]) {
            let message = format!("\"{}\" has another parent in the file", found.name);
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
    let message = format!("{name} has {} frames in the file; expected {expected}", file.frames);
    match file.frames.cmp(&expected) {
        std::cmp::Ordering::Less => findings.push(Finding::new(FindingKind::MissingFrames, message)),
        std::cmp::Ordering::Greater => findings.push(Finding::new(FindingKind::ExtraFrames, message)),
        std::cmp::Ordering::Equal => {}
    }
    let rate = timeline.frame_rate();
    if !source.animations.is_empty() && (file.header.frame_rate / rate - 1.0).abs() > 1e-9 {
        let message = format!(
            "{name} has {} frames per second in the file; expected {rate}",
            file.header.frame_rate
        );
        findings.push(Finding::new(FindingKind::Provenance, message));
    }
}

/// Finds offsets and rotation orders that differ from the source.
fn find_in_skeleton(source: &Scene, file: &ArrayFile, node_of: &[usize], change: &Change, findings: &mut Vec<Finding>) {
    /// The rounding of 32-bit products, as a fraction of the farthest position.
    const ROUNDING: f64 = 1e-5;
    let mut world = Vec::new();
    Skeleton::of_scene(source, None).world(0.0, &mut world);
    let origin = |matrix: &DMat4| matrix.w_axis.truncate();
    let farthest = world.iter().map(|matrix| origin(matrix).length()).fold(0.0, f64::max) * change.metres_per_unit;
    for (joint, &index) in node_of.iter().enumerate() {
        let in_file = &file.header.joints[joint];
        let name = &in_file.name;
        let parent = in_file.parent.map(|parent| world[node_of[parent]].inverse());
        let expected = origin(&(parent.unwrap_or(DMat4::IDENTITY) * world[index])) * change.metres_per_unit;
        let found = DVec3::from(in_file.offset.map(f64::from));
        let distance = expected.distance(found);
        if distance.is_nan() || distance > ROUNDING * farthest {
            let message = format!("the offset of \"{name}\" is {found:.6}; expected {expected:.6}");
            findings.push(Finding::new(FindingKind::Offset, message));
        }
        let order = source.nodes[index].rotation_order;
        let axes = order.map_or_else(Vec::new, |order| order.axes().to_vec());
        let order: String = axes.into_iter().map(|axis| ['X', 'Y', 'Z'][axis]).collect();
        let found = in_file.rotation_order.as_deref().unwrap_or_default();
        if found != order {
            let message =
                format!("the rotation order of \"{name}\" is {found:?} in the file, but {order:?} in its source");
            findings.push(Finding::new(FindingKind::RotationOrder, message));
        }
    }
}

/// Finds a header with a wrong unit, axis, source or frame count.
fn find_in_header(source: &Scene, file: &ArrayFile, findings: &mut Vec<Finding>) {
    let Header {
        metres_per_unit,
        up,
        provenance,
        ..
    } = &file.header;
    let stated = super::units::Space {
        metres_per_unit: *metres_per_unit,
        up: *up,
    };
    let expected = super::units::Space::recorded(source, &provenance.steps);
    expected.find(stated, true, findings);
    if let (None, Some(metres)) = (expected.metres_per_unit, stated.metres_per_unit) {
        let message = format!("the file states a unit of {metres} m, which neither its source nor a step states");
        findings.push(Finding::new(FindingKind::Unit, message));
    }
    if let (None, Some(up)) = (expected.up, stated.up) {
        let up = up.as_str();
        let message = format!("the file states the up axis {up}, which neither its source nor a step states");
        findings.push(Finding::new(FindingKind::UpAxis, message));
    }
    claims(source, provenance, Some(file.frames as u64), findings);
}

/// Finds a velocity that is not the central difference of the positions, one-sided at the ends.
fn wrong_velocity(file: &ArrayFile) -> Option<Finding> {
    /// The rounding of 32-bit numbers, as a fraction of the positions.
    const ROUNDING: f64 = 1e-6;
    let velocities = file.velocities.as_ref()?;
    let width = 3 * file.header.joints.len();
    let position = |frame: usize, column: usize| f64::from(file.positions[width * frame + column]);
    for frame in 0..file.frames {
        let (before, after) = (frame.saturating_sub(1), (frame + 1).min(file.frames - 1));
        let rate = file.header.frame_rate / (after - before).max(1) as f64;
        for column in 0..width {
            let (from, to) = (position(before, column), position(after, column));
            let (expected, found) = ((to - from) * rate, f64::from(velocities[width * frame + column]));
            let allowed = ROUNDING * ((from.abs() + to.abs()) * rate + expected.abs());
            if (expected - found).abs() <= allowed {
                continue;
            }
            let name = &file.header.joints[column / 3].name;
            let message = format!("the velocity of \"{name}\" in frame {frame} is {found}; expected {expected:.6}");
            return Some(Finding::new(FindingKind::Velocity, message));
        }
    }
    None
}

/// The position and the rotation that the file should have. `world` and the other matrices belong to the source.
fn expected(change: &Change, file: &ArrayFile, world: &DMat4, parent: Option<&DMat4>, root: &DMat4) -> (DVec3, DMat3) {
    let origin = |matrix: &DMat4| matrix.w_axis.truncate();
    let in_parent = parent.map(|parent| parent.inverse() * *world);
    let position = match (file.header.space, &in_parent) {
        (Space::World, _) | (Space::Local, None) => change.apply(origin(world)),
        (Space::Root, _) => change.apply(origin(world)) - change.apply(origin(root)),
        // Lengths are in the file's unit, but axes are the parent's.
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
fn decoded(file: &ArrayFile, row: usize, order: Option<&str>) -> DMat3 {
    let width = file.header.rotation.width();
    let values = file.rotations[width * row..][..width]
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
            let order = order.unwrap_or("XYZ");
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
