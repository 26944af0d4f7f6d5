//! The JSON of `assimp/dump.cpp`.

use serde::Deserialize;

use crate::json::Dump;
use crate::scene::{self, Number, Scene, floats};

/// Assimp's answer: a scene, or the reason why it refuses the file.
#[derive(Deserialize)]
#[serde(untagged)]
enum Answer {
    Refused { error: String },
    Scene(Dump<Node, Material, Channel>),
}

#[derive(Deserialize)]
struct Node {
    name: String,
    nchild: usize,
    matrix: Vec<Number>,
    meshes: Vec<usize>,
}

#[derive(Deserialize)]
struct Material {
    properties: Vec<Property>,
}

#[derive(Deserialize)]
struct Property {
    key: String,
    value: serde_json::Value,
}

#[derive(Deserialize)]
struct Channel {
    node: String,
    pos: Vec<Vec<Number>>,
    rot_wxyz: Vec<Vec<Number>>,
    scl: Vec<Vec<Number>>,
}

/// The scene, or Assimp's reason for refusing the file.
pub(crate) fn read(json: &str) -> serde_json::Result<Result<Scene, String>> {
    Ok(match serde_json::from_str(json)? {
        Answer::Refused { error } => Err(error),
        Answer::Scene(dump) => Ok(dump.scene(|list| nodes(&list))),
    })
}

/// Assimp gives a node's parent by name, and names repeat. So the counts of children in depth-first order determine the
/// parent.
fn nodes(nodes: &[Node]) -> Vec<scene::Node> {
    let mut open: Vec<(usize, usize)> = Vec::new();
    let mut out = Vec::new();
    for (index, node) in nodes.iter().enumerate() {
        while open.last().is_some_and(|&(_, children_left)| children_left == 0) {
            open.pop();
        }
        let parent = open.last_mut().map(|(parent, children_left)| {
            *children_left -= 1;
            *parent
        });
        open.push((index, node.nchild));
        out.push(scene::Node {
            name: node.name.clone(),
            parent,
            matrix: floats(&node.matrix),
            meshes: node.meshes.clone(),
        });
    }
    out
}

impl From<Material> for scene::Material {
    fn from(material: Material) -> Self {
        let value = |key| {
            material
                .properties
                .iter()
                .find(|property| property.key == key)
                .map(|property| &property.value)
        };
        Self {
            name: value("?mat.name")
                .and_then(|value| value.as_str())
                .unwrap_or_default()
                .to_owned(),
            two_sided: value("$mat.twosided").is_some_and(|value| value[0] != 0),
        }
    }
}

impl From<Channel> for scene::Channel {
    fn from(channel: Channel) -> Self {
        let keys = |keys: Vec<Vec<Number>>| {
            keys.iter()
                .map(|key| scene::Key {
                    tick: key[0].0,
                    value: floats(&key[1..]),
                })
                .collect()
        };
        Self {
            node: channel.node,
            positions: keys(channel.pos),
            rotations: keys(channel.rot_wxyz),
            scalings: keys(channel.scl),
        }
    }
}
