//! The scene: a node graph, meshes, materials and animations, in Assimp's terms. The types are plain data without
//! behaviour.
//!
//! Lengths are in the file's unit, coordinates are right-handed, matrices map column vectors (`node_to_parent *
//! point`), and quaternions are `x y z w` in memory. [`Scene::validate`](crate::Scene::validate) lists the rules for
//! every scene of this crate.
//!
//! Nodes, keys, and positions at a tick:
//!
//! ```
//! use mocap::glam::{Mat4, Quat, Vec3};
//! use mocap::scene::{Animation, Channel, Keys, Node, NodeId, NodeKind, Scene};
//!
//! let elbow = Node { name: "Elbow".into(), ..Node::default() };
//! let tip = Node {
//!     name: "EndSite_Elbow".into(),
//!     kind: NodeKind::EndSite,
//!     parent: Some(NodeId::new(0)),
//!     transform: Mat4::from_translation(Vec3::X),
//!     ..Node::default()
//! };
//! let bend = Channel {
//!     node_name: "Elbow".into(),
//!     position_keys: Keys::constant(Vec3::ZERO),
//!     rotation_keys: Keys::every_tick((0..=10).map(|tick| Quat::from_rotation_z(0.1 * tick as f32)).collect()),
//!     ..Channel::default()
//! };
//! let animation = Animation { ticks_per_second: 10.0, duration: 10.0, channels: vec![bend], ..Animation::default() };
//! let scene = Scene { nodes: vec![elbow, tip], animations: vec![animation], ..Scene::default() };
//! let pose = mocap::Pose::at_tick(&scene, 0, 10.0).unwrap();
//! assert!(pose.position(NodeId::new(1)).distance(Vec3::new(1f32.cos(), 1f32.sin(), 0.0)) < 1e-6);
//! ```
//!
//! A skin:
//!
//! ```
//! # std::env::set_current_dir("../..").unwrap();
//! use mocap::Importer;
//! use mocap::scene::{AlphaMode, Bone, Mesh, Primitive, Surface, VertexWeight, Wrap};
//!
//! let scene = Importer::new().gltf_meshes(true).import("fixtures/made/two_bones_textured.gltf")?;
//! let mesh: &Mesh = &scene.meshes[0];
//! assert_eq!((mesh.primitive, mesh.faces().len() * 3), (Primitive::Triangles, mesh.indices.len()));
//! let bone: &Bone = &mesh.bones[0];
//! assert_eq!(bone.name, scene.nodes[bone.node.index()].name);
//! let VertexWeight { vertex_id, weight } = bone.weights[0];
//! assert!((vertex_id as usize) < mesh.vertices.len() && weight <= 1.0);
//! let surface: Surface = scene.materials[mesh.material_index].surface.unwrap();
//! assert_eq!((surface.alpha, surface.wrap), (AlphaMode::Mask(0.5), [Wrap::Repeat; 2]));
//! assert_eq!(scene.textures[surface.texture.unwrap()].media_type, "image/png");
//! # Ok::<(), mocap::Error>(())
//! ```
//!
//! The origin of a scene, and the decisions about it:
//!
//! ```
//! # std::env::set_current_dir("../..").unwrap();
//! use mocap::Conversion;
//! use mocap::scene::{Confidence, RootOffset, RotationOrder, Topic, UpAxis};
//! use mocap::scene::report::AppliedStep;
//!
//! let mut scene = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
//! assert_eq!(scene.metadata.origin.as_ref().unwrap().name, "cmu_12_01_walk.bvh");
//! assert_eq!(scene.metadata.root_offset.as_ref().unwrap().policy, RootOffset::Replace);
//! assert_eq!(scene.nodes[0].source.unwrap().name, 2); // ROOT Hips is in line 2
//! assert_eq!(scene.nodes[0].rotation_order, Some(RotationOrder::Zyx));
//! let guesses = Conversion::new().apply(&mut scene)?;
//! let unit = guesses.iter().find(|guess| guess.topic == Topic::Unit).unwrap();
//! assert_eq!((unit.choice.as_str(), unit.confidence), ("cmu", Some(Confidence::Sure)));
//! assert_eq!((scene.metadata.metres_per_unit, scene.metadata.up), (Some(1.0), Some(UpAxis::Y)));
//! assert!(matches!(scene.metadata.steps[0], AppliedStep::ConvertUnits { up: UpAxis::Y, .. }));
//! # Ok::<(), mocap::Error>(())
//! ```

mod attribution;
mod clip_extras;
mod face;
mod face_shapes;
mod guess;
mod humanoid_bone;
#[doc(hidden)]
pub mod joint_tables;
mod ledger;
mod mesh;
mod metadata;
mod mmd;
mod morphs;
mod original;
mod recorded;
pub mod report;
#[doc(hidden)]
pub mod robot;
mod solved;
mod source_lines;

use glam::{Mat4, Quat, Vec3};
use serde::{Deserialize, Serialize};

#[doc(hidden)]
pub use self::clip_extras::ClipExtras;
pub use self::face::Face;
#[doc(hidden)]
pub use self::face_shapes::{FACE_SHAPES, face_shape};
pub use self::humanoid_bone::{HumanoidBone, Side};
pub use self::mesh::{AlphaMode, Bone, Material, Mesh, MorphTarget, Primitive, Surface, Texture, VertexWeight, Wrap};
pub use self::metadata::{Assumption, Confidence, Format, Metadata, RootOffset, Topic, UpAxis};
#[doc(hidden)]
pub use self::metadata::{FileSpace, UNNAMED_MOTION, format_name};
#[doc(hidden)]
pub use self::mmd::{MmdInherits, MmdModel};
#[doc(hidden)]
pub use self::original::{FbxOriginal, MorphCurves, Original, OriginalFile, SKELETON_MATERIAL};
pub use self::recorded::{AnalogChannel, Event, ForcePlate, Recording};
use self::report::{MarkerSolution, SourceLines};
use crate::error::Diagnostic;

/// The contents of one file.
///
/// `serde` writes and reads everything except the bytes of [`textures`](Self::textures), the
/// [`original`](Self::original), and [`recorded`](Metadata::recorded) and [`solved`](Metadata::solved) of the metadata.
/// A scene that another program wrote may break the rules of a scene: call [`validate`](Self::validate). `serde_json`
/// keeps every bit of a number only with its feature `float_roundtrip`.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// let scene = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
/// let text = serde_json::to_string(&scene).unwrap();
/// assert_eq!(serde_json::from_str::<mocap::Scene>(&text).unwrap(), scene);
/// # Ok::<(), mocap::Error>(())
/// ```
///
/// The [module](crate::scene) has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Scene {
    /// The node graph in depth-first order: the root first, parents before their children. [`NodeId`] indexes it.
    pub nodes: Vec<Node>,
    /// The meshes, indexed by [`Node::meshes`].
    pub meshes: Vec<Mesh>,
    /// The materials, indexed by [`Mesh::material_index`].
    pub materials: Vec<Material>,
    /// The textures, indexed by [`Surface::texture`].
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub textures: Vec<Texture>,
    /// The animations. A BVH file has at most one.
    pub animations: Vec<Animation>,
    /// The origin of the scene, and the assumptions of the reader.
    pub metadata: Metadata,
    /// The warnings of the reader, in the order of the file.
    pub warnings: Vec<Diagnostic>,
    /// The glTF or VRM file with meshes from which the scene was read. A glTF output keeps the other contents of this
    /// file.
    #[serde(skip)]
    pub original: Option<Original>,
}

impl Scene {
    /// The first node with this name, as in Assimp's `aiNode::FindNode`.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// let scene = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
    /// let head = scene.find_node("Head").unwrap();
    /// assert_eq!(scene.nodes[head.index()].name, "Head");
    /// assert_eq!(scene.find_node("head"), None);
    /// # Ok::<(), mocap::Error>(())
    /// ```
    pub fn find_node(&self, name: &str) -> Option<NodeId> {
        self.nodes.iter().position(|node| node.name == name).map(NodeId::new)
    }
}

/// The index of a node in [`Scene::nodes`].
///
/// The [module](crate::scene) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct NodeId(pub u32);

impl NodeId {
    /// The id of the node at `index` of [`Scene::nodes`].
    ///
    /// # Panics
    /// If `index` does not fit in 32 bits. This cannot happen within the default [`Limits`](crate::Limits).
    pub fn new(index: usize) -> Self {
        Self(u32::try_from(index).expect("a scene has fewer than 2^32 nodes"))
    }

    /// The index into [`Scene::nodes`].
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// The name of the group that a reader adds as the parent of several roots. Writers remove the group with this name.
#[doc(hidden)]
pub const GROUP_OF_ROOTS: &str = "Roots";

/// The kind of a node in its file.
///
/// The [module](crate::scene) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum NodeKind {
    /// A node that the file can animate.
    #[default]
    Joint,
    /// The unanimated tip of a chain in BVH.
    EndSite,
    /// A node that only groups others.
    Group,
}

/// A transform in the node graph.
///
/// The [module](crate::scene) has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Node {
    /// The name as in the file; an unnamed end site is called `EndSite_<parent>`. Names may repeat.
    pub name: String,
    /// The kind of the node in the file.
    pub kind: NodeKind,
    /// The parent; absent only for the root.
    pub parent: Option<NodeId>,
    /// Node to parent, in the rest pose. For BVH it is the translation by the OFFSET. [`Scene::update_node_matrices`]
    /// overwrites this matrix.
    pub transform: Mat4,
    /// Indices into [`Scene::meshes`].
    pub meshes: Vec<usize>,
    /// The order of the node's Euler angles in the file. Keys are quaternions and do not need the order, but writers of
    /// Euler angles do. Absent if the file has no Euler angles, or not exactly one rotation about each axis.
    pub rotation_order: Option<RotationOrder>,
    /// The lines of the file that describe the node. Absent for binary files.
    pub source: Option<SourceLines>,
    /// The humanoid bone of this node, as VRM files and VRM animations state it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub humanoid_bone: Option<HumanoidBone>,
    /// The role of this node in the face of a VRM animation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub face: Option<Face>,
}

/// The order of a node's three rotations about its axes.
///
/// The order is as in a matrix product on column vectors: `Zxy` is `Rz Rx Ry` (intrinsic rotations), as in CHANNELS of
/// BVH.
///
/// The [module](crate::scene) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[allow(missing_docs, reason = "each says itself")]
pub enum RotationOrder {
    Xyz,
    Xzy,
    Yxz,
    Yzx,
    Zxy,
    Zyx,
}

impl RotationOrder {
    /// All orders, by name.
    pub const ALL: [Self; 6] = [Self::Xyz, Self::Xzy, Self::Yxz, Self::Yzx, Self::Zxy, Self::Zyx];

    /// The axes in this order: 0 for x, 1 for y, 2 for z.
    pub const fn axes(self) -> [usize; 3] {
        match self {
            Self::Xyz => [0, 1, 2],
            Self::Xzy => [0, 2, 1],
            Self::Yxz => [1, 0, 2],
            Self::Yzx => [1, 2, 0],
            Self::Zxy => [2, 0, 1],
            Self::Zyx => [2, 1, 0],
        }
    }

    /// The order of these axes, if each axis occurs once.
    pub fn from_axes(axes: [usize; 3]) -> Option<Self> {
        Self::ALL.into_iter().find(|order| order.axes() == axes)
    }
}

/// Motion over time.
///
/// The [module](crate::scene) has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Animation {
    /// The name.
    pub name: String,
    /// Ticks per second. In BVH a tick is a frame, so this value is 1 / frame time.
    pub ticks_per_second: f64,
    /// The length in ticks, from the first frame to the last: the number of frames minus 1.
    pub duration: f64,
    /// One channel per joint, in the order of [`Scene::nodes`].
    pub channels: Vec<Channel>,
}

impl Animation {
    /// The number of frames: the whole ticks from 0 to the one nearest to [`duration`](Self::duration), both included.
    /// If a motion ends between two ticks and is nearer to the later tick, its last pose lasts until that tick.
    ///
    /// ```
    /// use mocap::scene::Animation;
    ///
    /// let frames = |duration| Animation { duration, ..Animation::default() }.frame_count();
    /// assert_eq!((frames(3.0), frames(3.4), frames(3.9999)), (4, 4, 5));
    /// ```
    pub fn frame_count(&self) -> usize {
        (self.duration.round() as usize).saturating_add(1)
    }

    /// Sorts the channels by their nodes. Channels of one node keep their order.
    #[doc(hidden)]
    pub fn sort_channels(&mut self) {
        self.channels.sort_by_key(|channel| channel.node);
    }

    /// The whole ticks within the motion: from 0 to the last at or before its end.
    #[doc(hidden)]
    pub fn whole_ticks(&self) -> impl Iterator<Item = f64> + use<> {
        (0..=self.duration as usize).map(|tick| tick as f64)
    }
}

/// All keys of one node.
///
/// The [module](crate::scene) has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Channel {
    /// The name of the driven node. If several joints have this name and [`node`](Self::node) does not distinguish
    /// them, channels and joints with this name are paired in their order.
    pub node_name: String,
    /// The driven node, if that node has the channel's name. Names may repeat or be empty; ids are unique. Readers set
    /// this field. With `None` the name decides.
    pub node: Option<NodeId>,
    /// Translation relative to the parent, in the file's unit. A BVH joint without position channels has one key, its
    /// OFFSET.
    pub position_keys: Keys<Vec3>,
    /// Rotation relative to the parent.
    pub rotation_keys: Keys<Quat>,
    /// Scale along the node's own axes.
    pub scaling_keys: Keys<Vec3>,
}

/// Values at ticks.
///
/// Ticks are stored only if they differ from 0, 1, 2, ... A constant track has one key, at tick 0.
///
/// The [module](crate::scene) has an example.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Keys<T> {
    /// The values, sorted by time.
    pub values: Vec<T>,
    /// Strictly increasing ticks, one per value; `None` means 0, 1, 2, ...
    pub ticks: Option<Vec<f64>>,
}

impl<T> Keys<T> {
    /// One value per tick, from tick 0.
    pub fn every_tick(values: Vec<T>) -> Self {
        Self { values, ticks: None }
    }

    /// One constant value.
    pub fn constant(value: T) -> Self {
        Self::every_tick(vec![value])
    }

    /// Values at strictly increasing ticks, one tick per value.
    pub fn at_ticks(values: Vec<T>, ticks: Vec<f64>) -> Self {
        let is_every_tick = ticks.iter().enumerate().all(|(index, &tick)| tick == index as f64);
        Self {
            values,
            ticks: (!is_every_tick).then_some(ticks),
        }
    }

    /// The number of keys.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Whether there is no key.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// The tick of key `index`.
    pub fn tick(&self, index: usize) -> f64 {
        self.ticks.as_ref().map_or(index as f64, |ticks| ticks[index])
    }
}

impl<T> Default for Keys<T> {
    fn default() -> Self {
        Self::every_tick(Vec::new())
    }
}
