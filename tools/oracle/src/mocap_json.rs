//! The JSON of `mocap dump --json`.

use serde::Deserialize;

use crate::json::Dump;
use crate::scene::{self, Number, Scene, floats};

#[derive(Deserialize)]
struct Node {
    name: String,
    parent: Option<usize>,
    /// Row by row.
    matrix: Vec<Number>,
    meshes: Vec<usize>,
}

#[derive(Deserialize)]
struct Material {
    name: String,
    two_sided: bool,
}

#[derive(Deserialize)]
struct Channel {
    node_name: String,
    position_keys: Keys,
    rotation_keys_xyzw: Keys,
    scaling_keys: Keys,
}

/// Ticks and values.
type Keys = Vec<(f64, Vec<Number>)>;

pub(crate) fn read(json: &str) -> serde_json::Result<Scene> {
    let dump: Dump<Node, Material, Channel> = serde_json::from_str(json)?;
    Ok(dump.scene(|nodes| nodes.into_iter().map(Into::into).collect()))
}

impl From<Node> for scene::Node {
    fn from(node: Node) -> Self {
        Self {
            name: node.name,
            parent: node.parent,
            matrix: floats(&node.matrix),
            meshes: node.meshes,
        }
    }
}

impl From<Material> for scene::Material {
    fn from(material: Material) -> Self {
        Self {
            name: material.name,
            two_sided: material.two_sided,
        }
    }
}

impl From<Channel> for scene::Channel {
    fn from(channel: Channel) -> Self {
        Self {
            node: channel.node_name,
            positions: keys(channel.position_keys, |value| value),
            rotations: keys(channel.rotation_keys_xyzw, |xyzw| {
                vec![xyzw[3], xyzw[0], xyzw[1], xyzw[2]]
            }),
            scalings: keys(channel.scaling_keys, |value| value),
        }
    }
}

fn keys(keys: Keys, reorder: fn(Vec<f64>) -> Vec<f64>) -> Vec<scene::Key> {
    keys.into_iter()
        .map(|(tick, value)| scene::Key {
            tick,
            value: reorder(floats(&value)),
        })
        .collect()
}
