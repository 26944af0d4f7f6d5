//! The common parts of the JSON of `assimp/dump.cpp` and of `mocap dump --json`.

use serde::Deserialize;

use crate::scene::{self, Number, Scene, floats};

#[derive(Deserialize)]
pub(crate) struct Dump<Node, Material, Channel> {
    nodes: Vec<Node>,
    meshes: Vec<Mesh>,
    materials: Vec<Material>,
    animations: Vec<Animation<Channel>>,
}

#[derive(Deserialize)]
struct Mesh {
    name: String,
    #[serde(alias = "material")]
    material_index: usize,
    vertices: Vec<Vec<Number>>,
    normals: Vec<Vec<Number>>,
    faces: Vec<Vec<usize>>,
    bones: Vec<Bone>,
}

#[derive(Deserialize)]
struct Bone {
    name: String,
    #[serde(alias = "offset")]
    offset_matrix: Vec<Number>,
    weights: Vec<(usize, Number)>,
}

#[derive(Deserialize)]
struct Animation<Channel> {
    name: String,
    ticks_per_second: Number,
    duration: Number,
    channels: Vec<Channel>,
}

impl<Node, Material, Channel> Dump<Node, Material, Channel>
where
    Material: Into<scene::Material>,
    Channel: Into<scene::Channel>,
{
    /// The scene; `nodes` makes its nodes.
    pub(crate) fn scene(self, nodes: impl FnOnce(Vec<Node>) -> Vec<scene::Node>) -> Scene {
        Scene {
            nodes: nodes(self.nodes),
            meshes: self.meshes.into_iter().map(mesh).collect(),
            materials: self.materials.into_iter().map(Into::into).collect(),
            animations: self.animations.into_iter().map(animation).collect(),
        }
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

fn animation<Channel: Into<scene::Channel>>(animation: Animation<Channel>) -> scene::Animation {
    scene::Animation {
        name: animation.name,
        ticks_per_second: animation.ticks_per_second.0,
        duration: animation.duration.0,
        channels: animation.channels.into_iter().map(Into::into).collect(),
    }
}
