//! The JSON of `assimp/dump.cpp`.

use serde::Deserialize;

use crate::scene::{self, Number, Scene, floats};

/// What Assimp answered: a scene, or why it refuses the file.
#[derive(Deserialize)]
#[serde(untagged)]
enum Answer {
    Refused { error: String },
    Scene(Dump),
}

#[derive(Deserialize)]
struct Dump {
    nodes: Vec<Node>,
    meshes: Vec<Mesh>,
    materials: Vec<Material>,
    animations: Vec<Animation>,
}

#[derive(Deserialize)]
struct Node {
    name: String,
    nchild: usize,
    matrix: Vec<Number>,
    meshes: Vec<usize>,
}

#[derive(Deserialize)]
struct Mesh {
    name: String,
    material: usize,
    vertices: Vec<Vec<Number>>,
    normals: Vec<Vec<Number>>,
    faces: Vec<Vec<usize>>,
    bones: Vec<Bone>,
}

#[derive(Deserialize)]
struct Bone {
    name: String,
    offset: Vec<Number>,
    weights: Vec<(usize, Number)>,
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
struct Animation {
    name: String,
    ticks_per_second: Number,
    duration: Number,
    channels: Vec<Channel>,
}

#[derive(Deserialize)]
struct Channel {
    node: String,
    pos: Vec<Vec<Number>>,
    rot_wxyz: Vec<Vec<Number>>,
    scl: Vec<Vec<Number>>,
}

/// The scene, or Assimp's reason for refusing the file.
pub fn read(json: &str) -> serde_json::Result<Result<Scene, String>> {
    Ok(match serde_json::from_str(json)? {
        Answer::Refused { error } => Err(error),
        Answer::Scene(dump) => Ok(Scene {
            nodes: nodes(&dump.nodes),
            meshes: dump.meshes.into_iter().map(mesh).collect(),
            materials: dump.materials.iter().map(material).collect(),
            animations: dump.animations.into_iter().map(animation).collect(),
        }),
    })
}

/// Assimp names a node's parent, and names repeat; the counts of children, depth-first, say which node it is.
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

fn mesh(mesh: Mesh) -> scene::Mesh {
    let vectors = |values: Vec<Vec<Number>>| values.iter().map(|value| floats(value)).collect();
    scene::Mesh {
        name: mesh.name,
        material: mesh.material,
        vertices: vectors(mesh.vertices),
        normals: vectors(mesh.normals),
        faces: mesh.faces,
        bones: mesh.bones.into_iter().map(bone).collect(),
    }
}

fn bone(bone: Bone) -> scene::Bone {
    scene::Bone {
        name: bone.name,
        offset: floats(&bone.offset),
        weights: bone
            .weights
            .into_iter()
            .map(|(vertex, weight)| (vertex, weight.0))
            .collect(),
    }
}

fn material(material: &Material) -> scene::Material {
    let value = |key| {
        material
            .properties
            .iter()
            .find(|property| property.key == key)
            .map(|property| &property.value)
    };
    scene::Material {
        name: value("?mat.name")
            .and_then(|value| value.as_str())
            .unwrap_or_default()
            .to_owned(),
        two_sided: value("$mat.twosided").is_some_and(|value| value[0] != 0),
    }
}

fn animation(animation: Animation) -> scene::Animation {
    scene::Animation {
        name: animation.name,
        ticks_per_second: animation.ticks_per_second.0,
        duration: animation.duration.0,
        channels: animation.channels.into_iter().map(channel).collect(),
    }
}

fn channel(channel: Channel) -> scene::Channel {
    let keys = |keys: Vec<Vec<Number>>| {
        keys.iter()
            .map(|key| scene::Key {
                tick: key[0].0,
                value: floats(&key[1..]),
            })
            .collect()
    };
    scene::Channel {
        node: channel.node,
        positions: keys(channel.pos),
        rotations: keys(channel.rot_wxyz),
        scalings: keys(channel.scl),
    }
}
