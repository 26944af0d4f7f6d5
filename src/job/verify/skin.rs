//! Checks that the inverse bind matrices match the positions of a skin's joints.
//!
//! The compared value is the bind position of the first joint of a mesh relative to each other joint. This value does
//! not depend on the axes and the unit of the mesh, which are unknown.

use std::path::Path;

use glam::DMat4;
use mocap_formats::{FormatInfo, ReadOptions, Source};
use mocap_scene::error::{Code, Result};
use mocap_scene::scene::{Bone, Mesh, Scene};

use super::chain::Skeleton;
use super::change::Change;
use super::pairs::Pairs;
use super::{Finding, FindingKind};

/// The largest distance of a joint from its bind position, as a fraction of the largest distance of two joints of the
/// mesh. The error of the joint's axes is a fraction of their length. The tolerance is the rounding of products of
/// 32-bit matrices.
const SAME_PLACE: f64 = 1e-3;

/// The scene of a glTF file with its meshes. `row` describes the format of the file. With `of_nodes`, the rest pose is
/// the pose of the nodes, otherwise the bind pose of the skin.
pub(super) fn read(
    row: &FormatInfo,
    (bytes, name): (&[u8], &Path),
    open: &dyn Fn(&Path) -> Result<Vec<u8>>,
    of_nodes: bool,
) -> Result<Scene> {
    let folder = name.parent().unwrap_or("".as_ref());
    let source = Source {
        bytes,
        blocks: None,
        name,
        release: &|_| (),
        open: &|path| open(path.strip_prefix(folder).unwrap_or(path)),
        list: &|_| Vec::new(),
    };
    let options = ReadOptions {
        gltf_meshes: true,
        gltf_rest_of_nodes: of_nodes,
        ..ReadOptions::default()
    };
    row.read(&source, &options)
}

/// Finds joints of `output`, which this crate wrote, whose bind pose is not the rest pose of the source. Some outputs
/// have another rest pose on purpose. In these outputs, the bind pose may also be the file's rest pose, its first
/// frame, or the bind pose of the source after all steps, which `with_meshes` makes.
pub(super) fn find(
    source: &Scene,
    output: &Scene,
    (change, keeps_axes): (&Change, bool),
    with_meshes: &dyn Fn() -> Option<Scene>,
) -> Option<Finding> {
    let unread = output.warnings.iter().find(|warning| warning.code == Code::IgnoredMesh);
    if let Some(warning) = unread {
        let message = format!("the skin was not compared: {}", warning.message);
        return Some(Finding::new(FindingKind::Skin, message));
    }
    let mut poses = vec![own(output, None)];
    poses.extend((!output.animations.is_empty()).then(|| own(output, Some(0))));
    if keeps_axes && change.humanoid.is_none() {
        poses.extend(of_source(source, output, change.metres_per_unit, at_rest));
    }
    let mut wrong = wrong_of_all(output, &poses);
    if !wrong.is_empty()
        && let Some(source) = with_meshes()
    {
        poses.extend(of_source(&source, output, 1.0, at_rest));
        poses.extend(of_source(&source, output, 1.0, when_bound));
        wrong = wrong_of_all(output, &poses);
    }
    let (first, others) = wrong.split_first()?;
    let others = match others.len() {
        0 => String::new(),
        count => format!(" and {count} more"),
    };
    let message =
        format!("the skin is not bound to \"{first}\"{others} in the rest pose: an inverse bind matrix differs");
    Some(Finding::new(FindingKind::Skin, message))
}

/// The names of the bones of all meshes, each mesh in the pose that fits it best.
fn wrong_of_all(output: &Scene, poses: &[Vec<Option<DMat4>>]) -> Vec<String> {
    let meshes = output.meshes.iter().filter(|mesh| mesh.bones.len() > 1);
    let wrong = meshes.filter_map(|mesh| poses.iter().map(|pose| wrong_bones(mesh, pose)).min_by_key(Vec::len));
    wrong.flatten().collect()
}

/// The node-to-world matrix of every node of the file, in its rest pose or at the start of a clip.
fn own(output: &Scene, clip: Option<usize>) -> Vec<Option<DMat4>> {
    let mut world = Vec::new();
    Skeleton::of_scene(output, clip).world(0.0, &mut world);
    world.into_iter().map(Some).collect()
}

/// The node-to-world matrix of every node in the rest pose.
fn at_rest(source: &Scene) -> Vec<Option<DMat4>> {
    own(source, None)
}

/// The node-to-mesh matrix of every node in the bind pose. A node that is a bone only in the file keeps its rest
/// position relative to its nearest ancestor bone.
fn when_bound(source: &Scene) -> Vec<Option<DMat4>> {
    let mut bound = vec![None; source.nodes.len()];
    for bone in source.meshes.iter().flat_map(|mesh| &mesh.bones) {
        bound[bone.node.index()] = Some(bone.offset_matrix.as_dmat4().inverse());
    }
    // Parents precede their children.
    for (index, node) in source.nodes.iter().enumerate() {
        let parent = node
            .parent
            .map_or(DMat4::IDENTITY, |parent| bound[parent.index()].unwrap_or_default());
        bound[index].get_or_insert_with(|| parent * node.transform.as_dmat4());
    }
    bound
}

/// For each node of the file, the matrix of its node in the source, converted to the unit of the file; `None` for a
/// node that the source lacks.
fn of_source(
    source: &Scene,
    output: &Scene,
    scale: f64,
    matrices: fn(&Scene) -> Vec<Option<DMat4>>,
) -> Option<Vec<Option<DMat4>>> {
    let pairs = Pairs::new(&Skeleton::of_scene(source, None), &Skeleton::of_scene(output, None)).ok()?;
    let matrices = matrices(source);
    let mut found = vec![None; output.nodes.len()];
    for (a, b) in pairs.list {
        found[b] = matrices[a].map(|mut matrix| {
            matrix.w_axis = (matrix.w_axis.truncate() * scale).extend(1.0);
            matrix
        });
    }
    Some(found)
}

/// The names of the bones of a mesh whose bind pose differs from `pose`, or that `pose` lacks.
fn wrong_bones(mesh: &Mesh, pose: &[Option<DMat4>]) -> Vec<String> {
    let world_of = |bone: &Bone| pose.get(bone.node.index()).copied().flatten();
    let (mut known, mut wrong) = (Vec::new(), Vec::new());
    for bone in &mesh.bones {
        match world_of(bone) {
            Some(world) => known.push((bone, world)),
            None => wrong.push(bone.name.clone()),
        }
    }
    let Some(&(first, first_world)) = known.first() else {
        return wrong;
    };
    let first_bind = first.offset_matrix.as_dmat4().inverse();
    let others: Vec<_> = known
        .into_iter()
        .skip(1)
        .map(|(bone, world)| {
            let bound = bone.offset_matrix.as_dmat4() * first_bind;
            (bone, bound, world.inverse() * first_world)
        })
        .collect();
    let size = others
        .iter()
        .map(|(_, _, stands)| stands.w_axis.truncate().length())
        .fold(0.0, f64::max);
    let elsewhere = others.into_iter().filter(|(_, bound, stands)| {
        let axes = [
            (bound.x_axis, stands.x_axis),
            (bound.y_axis, stands.y_axis),
            (bound.z_axis, stands.z_axis),
        ];
        let has_axes = axes
            .into_iter()
            .all(|(bound, stands)| bound.distance(stands) <= SAME_PLACE * stands.length());
        let has_position = bound.w_axis.distance(stands.w_axis) <= SAME_PLACE * size;
        !(has_axes && has_position)
    });
    wrong.extend(elsewhere.map(|(bone, ..)| bone.name.clone()));
    wrong
}
