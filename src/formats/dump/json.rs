//! The scene as JSON. These structs and the file `scene.schema.json` define its form.

use glam::{Mat4, Quat, Vec3};
use serde::Serialize;

use mocap_scene::error::Diagnostic;
use mocap_scene::scene::{
    Animation, Bone, Channel, Keys, Material, Mesh, Metadata, Node, NodeId, NodeKind, Primitive, RotationOrder, Scene,
    VertexWeight,
};

/// A scene in its JSON form. Serialise it with `serde_json`, in one line or pretty-printed.
///
/// Matrices are 16 numbers row by row, as the course prints them. Lengths are in the file's unit, times in ticks.
///
/// ```
/// use mocap::dump::SceneView;
/// use mocap::scene::{Node, Scene};
///
/// let scene = Scene { nodes: vec![Node::default()], ..Scene::default() };
/// let json = serde_json::to_value(SceneView::new(&scene)).unwrap();
/// assert_eq!(json["nodes"][0]["matrix"][15], 1.0);
/// ```
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SceneView<'a> {
    /// The origin of the scene, and the assumptions.
    metadata: &'a Metadata,
    /// The warnings of the reader.
    warnings: &'a [Diagnostic],
    /// The nodes in depth-first order.
    nodes: Vec<NodeView<'a>>,
    /// The meshes. Nodes refer to them by index.
    meshes: Vec<MeshView<'a>>,
    /// The materials. Meshes refer to them by index.
    materials: &'a [Material],
    /// The animations.
    animations: Vec<AnimationView<'a>>,
}

/// A node.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct NodeView<'a> {
    /// The name. Names may repeat.
    name: &'a str,
    /// `joint`, `end_site` or `group`.
    kind: NodeKind,
    /// The index of the parent; null for the root.
    parent: Option<usize>,
    /// Node to parent, row by row.
    matrix: [f32; 16],
    /// Indices of meshes.
    meshes: &'a [usize],
    /// The order of the node's Euler angles in the file, such as `ZXY`; null if it has none.
    rotation_order: Option<RotationOrder>,
}

/// A mesh, in the space of the node that holds it.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct MeshView<'a> {
    /// The name of the mesh.
    name: &'a str,
    /// Index of the material.
    material_index: usize,
    /// `triangles` or `points`.
    primitive: Primitive,
    /// Positions: x, y, z.
    vertices: Vec<[f32; 3]>,
    /// Unit normals, one per vertex: x, y, z.
    normals: Vec<[f32; 3]>,
    /// Vertex indices, three per triangle, one per point.
    faces: Vec<&'a [u32]>,
    /// Bindings of vertices to nodes.
    bones: Vec<BoneView<'a>>,
}

/// A bone.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct BoneView<'a> {
    /// Name of the node.
    name: &'a str,
    /// Index of the node.
    node: usize,
    /// Mesh space to the node's space in the rest pose, row by row.
    offset_matrix: [f32; 16],
    /// Vertex index and weight.
    weights: Vec<(u32, f32)>,
}

/// An animation.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct AnimationView<'a> {
    /// The name of the animation.
    name: &'a str,
    /// Ticks per second.
    ticks_per_second: f64,
    /// The length in ticks.
    duration: f64,
    /// One channel per joint.
    channels: Vec<ChannelView<'a>>,
}

/// The keys of one node.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct ChannelView<'a> {
    /// Name of the node.
    node_name: &'a str,
    /// Tick, then x, y, z.
    position_keys: Vec<(f64, [f32; 3])>,
    /// Tick, then x, y, z, w of a unit quaternion.
    rotation_keys_xyzw: Vec<(f64, [f32; 4])>,
    /// Tick, then x, y, z.
    scaling_keys: Vec<(f64, [f32; 3])>,
}

impl<'a> SceneView<'a> {
    /// The view of a scene.
    pub fn new(scene: &'a Scene) -> Self {
        Self {
            metadata: &scene.metadata,
            warnings: &scene.warnings,
            nodes: scene.nodes.iter().map(NodeView::new).collect(),
            meshes: scene.meshes.iter().map(MeshView::new).collect(),
            materials: &scene.materials,
            animations: scene.animations.iter().map(AnimationView::new).collect(),
        }
    }
}

impl<'a> NodeView<'a> {
    fn new(node: &'a Node) -> Self {
        Self {
            name: &node.name,
            kind: node.kind,
            parent: node.parent.map(NodeId::index),
            matrix: rows(node.transform),
            meshes: &node.meshes,
            rotation_order: node.rotation_order,
        }
    }
}

impl<'a> MeshView<'a> {
    fn new(mesh: &'a Mesh) -> Self {
        Self {
            name: &mesh.name,
            material_index: mesh.material_index,
            primitive: mesh.primitive,
            vertices: mesh.vertices.iter().map(Vec3::to_array).collect(),
            normals: mesh.normals.iter().map(Vec3::to_array).collect(),
            faces: mesh.faces().collect(),
            bones: mesh.bones.iter().map(BoneView::new).collect(),
        }
    }
}

impl<'a> BoneView<'a> {
    fn new(bone: &'a Bone) -> Self {
        let pair = |&VertexWeight { vertex_id, weight }: &VertexWeight| (vertex_id, weight);
        Self {
            name: &bone.name,
            node: bone.node.index(),
            offset_matrix: rows(bone.offset_matrix),
            weights: bone.weights.iter().map(pair).collect(),
        }
    }
}

impl<'a> AnimationView<'a> {
    fn new(animation: &'a Animation) -> Self {
        Self {
            name: &animation.name,
            ticks_per_second: animation.ticks_per_second,
            duration: animation.duration,
            channels: animation.channels.iter().map(ChannelView::new).collect(),
        }
    }
}

impl<'a> ChannelView<'a> {
    fn new(channel: &'a Channel) -> Self {
        Self {
            node_name: &channel.node_name,
            position_keys: timed(&channel.position_keys, Vec3::to_array),
            rotation_keys_xyzw: timed(&channel.rotation_keys, Quat::to_array),
            scaling_keys: timed(&channel.scaling_keys, Vec3::to_array),
        }
    }
}

/// Pairs of a tick and the value as an array.
fn timed<T, const N: usize>(keys: &Keys<T>, array: impl Fn(&T) -> [f32; N]) -> Vec<(f64, [f32; N])> {
    let pairs = keys.values.iter().enumerate();
    pairs.map(|(index, value)| (keys.tick(index), array(value))).collect()
}

fn rows(matrix: Mat4) -> [f32; 16] {
    matrix.transpose().to_cols_array()
}
