//! The JSON of `mocap dump --json`.

use serde::Deserialize;

use crate::scene::{self, Number, Scene, floats};

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
    parent: Option<usize>,
    /// Row by row.
    matrix: Vec<Number>,
    meshes: Vec<usize>,
}

#[derive(Deserialize)]
struct Mesh {
    name: String,
    material_index: usize,
    vertices: Vec<Vec<Number>>,
    normals: Vec<Vec<Number>>,
    faces: Vec<Vec<usize>>,
    bones: Vec<Bone>,
}

#[derive(Deserialize)]
struct Bone {
    name: String,
    offset_matrix: Vec<Number>,
    weights: Vec<(usize, Number)>,
}

#[derive(Deserialize)]
struct Material {
    name: String,
    two_sided: bool,
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
    node_name: String,
    position_keys: Keys,
    rotation_keys_xyzw: Keys,
    scaling_keys: Keys,
}

/// Ticks and values.
type Keys = Vec<(f64, Vec<Number>)>;

pub fn read(json: &str) -> serde_json::Result<Scene> {
    let dump: Dump = serde_json::from_str(json)?;
    Ok(Scene {
        nodes: dump.nodes.into_iter().map(node).collect(),
        meshes: dump.meshes.into_iter().map(mesh).collect(),
        materials: dump.materials.into_iter().map(material).collect(),
        animations: dump.animations.into_iter().map(animation).collect(),
    })
}

fn node(node: Node) -> scene::Node {
    scene::Node {
        name: node.name,
        parent: node.parent,
        matrix: floats(&node.matrix),
        meshes: node.meshes,
    }
}

fn mesh(mesh: Mesh) -> scene::Mesh {
    let vectors = |values: Vec<Vec<Number>>| values.iter().map(|value| floats(value)).collect();
    scene::Mesh {
        name: mesh.name,
        material: mesh.material_index,
        vertices: vectors(mesh.vertices),
        normals: vectors(mesh.normals),
        faces: mesh.faces,
        bones: mesh.bones.into_iter().map(bone).collect(),
    }
}

fn bone(bone: Bone) -> scene::Bone {
    scene::Bone {
        name: bone.name,
        offset: floats(&bone.offset_matrix),
        weights: bone
            .weights
            .into_iter()
            .map(|(vertex, weight)| (vertex, weight.0))
            .collect(),
    }
}

fn material(material: Material) -> scene::Material {
    scene::Material {
        name: material.name,
        two_sided: material.two_sided,
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
    scene::Channel {
        node: channel.node_name,
        positions: keys(channel.position_keys, |value| value),
        rotations: keys(channel.rotation_keys_xyzw, |xyzw| {
            vec![xyzw[3], xyzw[0], xyzw[1], xyzw[2]]
        }),
        scalings: keys(channel.scaling_keys, |value| value),
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
