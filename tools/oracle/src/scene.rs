//! A common form for the scenes of both programs, so that a comparison is independent of the program.

use std::fmt;

use serde::Deserialize;
use serde::de::{Deserializer, Error, Visitor};

/// All compared data.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scene {
    pub nodes: Vec<Node>,
    pub meshes: Vec<Mesh>,
    pub materials: Vec<Material>,
    pub animations: Vec<Animation>,
}

#[derive(Clone, Debug, Default)]
pub(crate) struct Node {
    pub name: String,
    pub parent: Option<usize>,
    /// Node to parent, row by row.
    pub matrix: Vec<f64>,
    pub meshes: Vec<usize>,
}

#[derive(Clone, Debug, Default)]
pub(crate) struct Mesh {
    pub name: String,
    pub material: usize,
    pub vertices: Vec<Vec<f64>>,
    pub normals: Vec<Vec<f64>>,
    pub faces: Vec<Vec<usize>>,
    pub bones: Vec<Bone>,
}

#[derive(Clone, Debug, Default)]
pub(crate) struct Bone {
    pub name: String,
    /// Mesh to node in the bind pose, row by row.
    pub offset: Vec<f64>,
    /// Vertex index and weight.
    pub weights: Vec<(usize, f64)>,
}

#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Material {
    pub name: String,
    pub two_sided: bool,
}

#[derive(Clone, Debug, Default)]
pub(crate) struct Animation {
    pub name: String,
    pub ticks_per_second: f64,
    pub duration: f64,
    pub channels: Vec<Channel>,
}

#[derive(Clone, Debug, Default)]
pub(crate) struct Channel {
    pub node: String,
    pub positions: Vec<Key>,
    /// As w x y z.
    pub rotations: Vec<Key>,
    pub scalings: Vec<Key>,
}

impl Channel {
    pub(crate) fn keys(&self, track: Track) -> &[Key] {
        match track {
            Track::Position => &self.positions,
            Track::Rotation => &self.rotations,
            Track::Scaling => &self.scalings,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Track {
    Position,
    Rotation,
    Scaling,
}

impl Track {
    pub(crate) const ALL: [Self; 3] = [Self::Position, Self::Rotation, Self::Scaling];
}

impl fmt::Display for Track {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Position => "position_keys",
            Self::Rotation => "rotation_keys",
            Self::Scaling => "scaling_keys",
        })
    }
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Key {
    pub tick: f64,
    pub value: Vec<f64>,
}

impl Scene {
    /// The node that holds the mesh.
    pub(crate) fn holder(&self, mesh: usize) -> Option<usize> {
        self.nodes.iter().position(|node| node.meshes.contains(&mesh))
    }

    /// The position of the mesh's origin in the rest pose. The vertices of a skinned mesh already include this
    /// position.
    pub(crate) fn mesh_origin(&self, mesh: usize) -> [f64; 3] {
        match self.holder(mesh) {
            Some(holder) if self.meshes[mesh].bones.is_empty() => self.rest_position(holder),
            _ => [0.0; 3],
        }
    }

    /// The position of the node in the rest pose. BVH's rest pose has no rotations, so the position is the sum of the
    /// offsets.
    pub(crate) fn rest_position(&self, node: usize) -> [f64; 3] {
        let mut position = [0.0; 3];
        let mut at = Some(node);
        while let Some(node) = at.map(|index| &self.nodes[index]) {
            for (axis, part) in position.iter_mut().enumerate() {
                *part += node.matrix[4 * axis + 3];
            }
            at = node.parent;
        }
        position
    }
}

/// A JSON number, or the text or null in place of a number that JSON cannot represent.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Number(pub f64);

impl<'de> Deserialize<'de> for Number {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct NumberVisitor;
        impl Visitor<'_> for NumberVisitor {
            type Value = Number;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number, null, \"nan\", \"inf\" or \"-inf\"")
            }

            fn visit_f64<E: Error>(self, value: f64) -> Result<Number, E> {
                Ok(Number(value))
            }

            fn visit_i64<E: Error>(self, value: i64) -> Result<Number, E> {
                Ok(Number(value as f64))
            }

            fn visit_u64<E: Error>(self, value: u64) -> Result<Number, E> {
                Ok(Number(value as f64))
            }

            fn visit_unit<E: Error>(self) -> Result<Number, E> {
                Ok(Number(f64::NAN))
            }

            fn visit_str<E: Error>(self, value: &str) -> Result<Number, E> {
                value.parse().map(Number).map_err(E::custom)
            }
        }
        deserializer.deserialize_any(NumberVisitor)
    }
}

/// The numbers as plain floats.
pub(crate) fn floats(numbers: &[Number]) -> Vec<f64> {
    numbers.iter().map(|number| number.0).collect()
}
