//! Compares two scenes value by value.

use std::fmt::{self, Debug};

use crate::scene::{Key, Scene, Track};

/// The counts of a mesh, as [`Place::Mesh`] names them.
pub(crate) const VERTEX_COUNT: &str = "vertices.len";
pub(crate) const NORMAL_COUNT: &str = "normals.len";
pub(crate) const FACE_COUNT: &str = "faces.len";
pub(crate) const BONE_COUNT: &str = "bones.len";

/// The place of a difference between two scenes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Place {
    /// The number of nodes, meshes, materials or animations.
    Count(&'static str),
    Node(usize, &'static str),
    /// A value of a mesh, or one of its counts.
    Mesh(usize, &'static str),
    Vertex(usize, usize),
    Normal(usize, usize),
    Faces(usize),
    Bone(usize, usize, &'static str),
    Material(usize),
    Animation(&'static str),
    /// The name of the node that a channel drives.
    Channel(usize),
    KeyCount(usize, Track),
    Key(usize, Track, usize),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Count(what) => write!(f, "number of {what}"),
            Self::Node(node, what) => write!(f, "nodes[{node}].{what}"),
            Self::Mesh(mesh, what) => write!(f, "meshes[{mesh}].{what}"),
            Self::Vertex(mesh, vertex) => write!(f, "meshes[{mesh}].vertices[{vertex}]"),
            Self::Normal(mesh, vertex) => write!(f, "meshes[{mesh}].normals[{vertex}]"),
            Self::Faces(mesh) => write!(f, "meshes[{mesh}].faces"),
            Self::Bone(mesh, bone, what) => write!(f, "meshes[{mesh}].bones[{bone}].{what}"),
            Self::Material(material) => write!(f, "materials[{material}]"),
            Self::Animation(what) => write!(f, "animation.{what}"),
            Self::Channel(channel) => write!(f, "channels[{channel}].node_name"),
            Self::KeyCount(channel, track) => write!(f, "number of channels[{channel}].{track}"),
            Self::Key(channel, track, key) => write!(f, "channels[{channel}].{track}[{key}]"),
        }
    }
}

/// A difference between two scenes: its place, and both values.
#[derive(Clone, Debug)]
pub(crate) struct Difference {
    pub place: Place,
    pub assimp: String,
    pub ours: String,
}

/// The outcome of comparing two scenes.
#[derive(Debug, Default)]
pub(crate) struct Comparison {
    /// The number of equal values.
    pub equal: usize,
    pub differences: Vec<Difference>,
}

/// Whether two numbers count as equal: within 1e-5, relative above 1. Two NaN are equal.
pub(crate) fn close(a: f64, b: f64) -> bool {
    let near = || a.is_finite() && (a - b).abs() <= 1e-5 * a.abs().max(1.0);
    a == b || (a.is_nan() && b.is_nan()) || near()
}

/// Whether all numbers of two lists are [`close`].
pub(crate) fn all_close(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(&a, &b)| close(a, b))
}

impl Comparison {
    /// Compares two scenes. If a count differs, only the items that both scenes have are compared.
    pub(crate) fn of(assimp: &Scene, ours: &Scene) -> Self {
        let mut comparison = Self::default();
        comparison.nodes(assimp, ours);
        comparison.meshes(assimp, ours);
        comparison.materials(assimp, ours);
        comparison.animations(assimp, ours);
        comparison
    }

    fn record(&mut self, place: Place, equal: bool, assimp: &dyn Debug, ours: &dyn Debug) {
        if equal {
            self.equal += 1;
        } else {
            let (assimp, ours) = (format!("{assimp:?}"), format!("{ours:?}"));
            self.differences.push(Difference { place, assimp, ours });
        }
    }

    fn exactly<T: PartialEq + Debug>(&mut self, place: Place, assimp: &T, ours: &T) {
        self.record(place, assimp == ours, assimp, ours);
    }

    fn nearly(&mut self, place: Place, assimp: &[f64], ours: &[f64]) {
        self.record(place, all_close(assimp, ours), &assimp, &ours);
    }

    fn nodes(&mut self, assimp: &Scene, ours: &Scene) {
        self.exactly(Place::Count("nodes"), &assimp.nodes.len(), &ours.nodes.len());
        for (i, (a, b)) in assimp.nodes.iter().zip(&ours.nodes).enumerate() {
            self.exactly(Place::Node(i, "name"), &a.name, &b.name);
            self.exactly(Place::Node(i, "parent"), &a.parent, &b.parent);
            self.exactly(Place::Node(i, "meshes"), &a.meshes, &b.meshes);
            self.nearly(Place::Node(i, "transform"), &a.matrix, &b.matrix);
        }
    }

    fn meshes(&mut self, assimp: &Scene, ours: &Scene) {
        self.exactly(Place::Count("meshes"), &assimp.meshes.len(), &ours.meshes.len());
        for (i, (a, b)) in assimp.meshes.iter().zip(&ours.meshes).enumerate() {
            self.exactly(Place::Mesh(i, "name"), &a.name, &b.name);
            self.exactly(Place::Mesh(i, "material_index"), &a.material, &b.material);
            self.exactly(Place::Mesh(i, VERTEX_COUNT), &a.vertices.len(), &b.vertices.len());
            self.exactly(Place::Mesh(i, NORMAL_COUNT), &a.normals.len(), &b.normals.len());
            self.exactly(Place::Mesh(i, FACE_COUNT), &a.faces.len(), &b.faces.len());
            self.exactly(Place::Mesh(i, BONE_COUNT), &a.bones.len(), &b.bones.len());
            for (k, (a, b)) in a.vertices.iter().zip(&b.vertices).enumerate() {
                self.nearly(Place::Vertex(i, k), a, b);
            }
            for (k, (a, b)) in a.normals.iter().zip(&b.normals).enumerate() {
                self.nearly(Place::Normal(i, k), a, b);
            }
            self.exactly(Place::Faces(i), &a.faces, &b.faces);
            for (k, (a, b)) in a.bones.iter().zip(&b.bones).enumerate() {
                self.exactly(Place::Bone(i, k, "name"), &a.name, &b.name);
                self.nearly(Place::Bone(i, k, "offset_matrix"), &a.offset, &b.offset);
                self.exactly(Place::Bone(i, k, "weights"), &a.weights, &b.weights);
            }
        }
    }

    fn materials(&mut self, assimp: &Scene, ours: &Scene) {
        self.exactly(
            Place::Count("materials"),
            &assimp.materials.len(),
            &ours.materials.len(),
        );
        for (i, (a, b)) in assimp.materials.iter().zip(&ours.materials).enumerate() {
            self.exactly(Place::Material(i), a, b);
        }
    }

    fn animations(&mut self, assimp: &Scene, ours: &Scene) {
        self.exactly(
            Place::Count("animations"),
            &assimp.animations.len(),
            &ours.animations.len(),
        );
        // A BVH file has at most one.
        let (Some(a), Some(b)) = (assimp.animations.first(), ours.animations.first()) else {
            return;
        };
        self.exactly(Place::Animation("name"), &a.name, &b.name);
        self.exactly(Place::Animation("duration"), &a.duration, &b.duration);
        self.nearly(
            Place::Animation("ticks_per_second"),
            &[a.ticks_per_second],
            &[b.ticks_per_second],
        );
        self.exactly(Place::Animation("channels.len"), &a.channels.len(), &b.channels.len());
        for (i, (a, b)) in a.channels.iter().zip(&b.channels).enumerate() {
            self.exactly(Place::Channel(i), &a.node, &b.node);
            for track in Track::ALL {
                self.keys(i, track, a.keys(track), b.keys(track));
            }
        }
    }

    fn keys(&mut self, channel: usize, track: Track, assimp: &[Key], ours: &[Key]) {
        self.exactly(Place::KeyCount(channel, track), &assimp.len(), &ours.len());
        for (i, (a, b)) in assimp.iter().zip(ours).enumerate() {
            let equal = a.tick == b.tick && all_close(&a.value, &b.value);
            self.record(Place::Key(channel, track, i), equal, a, b);
        }
    }
}
