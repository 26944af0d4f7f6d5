//! The skin of a character, deformed by its motion.

use std::path::PathBuf;

use mocap::glam::{Mat4, Vec3};
use mocap::scene::{Mesh, Primitive, Scene};
use mocap::{Pose, SkeletonMesh};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;

use crate::ReadOptions;
use crate::errors::to_python;
use crate::scene::posed;

/// The triangles of a file, with the motion that deforms them.
#[pyclass(frozen, module = "mocap")]
pub(crate) struct Skin {
    scene: Scene,
    /// The index of a node and of its mesh.
    parts: Vec<(usize, usize)>,
}

/// Reads the meshes of a file and its first animation.
#[pyfunction]
pub(crate) fn skin(py: Python<'_>, path: PathBuf, options: ReadOptions) -> PyResult<Skin> {
    let importer = options.reading()?.importer().hash(false);
    let importer = importer.skeleton_mesh(SkeletonMesh::Own).gltf_meshes(true);
    let scene = py.detach(|| importer.import(&path));
    let scene = scene.map_err(|error| to_python(py, &error))?;
    let nodes = scene.nodes.iter().enumerate();
    let parts = nodes.flat_map(|(node, held)| held.meshes.iter().map(move |mesh| (node, *mesh)));
    let is_drawn = |(_, mesh): &(usize, usize)| scene.meshes[*mesh].primitive == Primitive::Triangles;
    let parts = parts.filter(is_drawn).collect();
    Ok(Skin { scene, parts })
}

#[pymethods]
impl Skin {
    /// The name, the number of vertices and the linear colour of each part.
    fn parts(&self) -> Vec<(String, usize, [f32; 4])> {
        let part = |(node, mesh): &(usize, usize)| {
            let mesh = &self.scene.meshes[*mesh];
            let name = if mesh.name.is_empty() {
                &self.scene.nodes[*node].name
            } else {
                &mesh.name
            };
            let material = self.scene.materials.get(mesh.material_index);
            let surface = material.and_then(|material| material.surface.as_ref());
            let colour = surface.map_or([1.0; 4], |surface| surface.base_color.to_array());
            (name.clone(), mesh.vertices.len(), colour)
        };
        self.parts.iter().map(part).collect()
    }

    /// The triangles of a part, as indices of its vertices.
    fn triangles<'py>(&self, py: Python<'py>, part: usize) -> PyResult<Bound<'py, PyAny>> {
        let indices = self.mesh(part)?.indices.clone();
        let count = indices.len() / 3;
        Ok(PyArray1::from_vec(py, indices).reshape([count, 3])?.into_any())
    }

    /// The vertices of a part at a tick, in the world, in the unit of the file.
    fn vertices<'py>(&self, py: Python<'py>, part: usize, tick: f64) -> PyResult<Bound<'py, PyAny>> {
        let mesh = self.mesh(part)?;
        let deformed = py.detach(|| {
            let pose = posed(&self.scene, tick);
            deformed(mesh, &pose, pose.node_to_world[self.parts[part].0])
        });
        let values: Vec<f32> = deformed.iter().flat_map(Vec3::to_array).collect();
        Ok(PyArray1::from_vec(py, values)
            .reshape([mesh.vertices.len(), 3])?
            .into_any())
    }
}

impl Skin {
    fn mesh(&self, part: usize) -> PyResult<&Mesh> {
        let found = self.parts.get(part).map(|(_, mesh)| &self.scene.meshes[*mesh]);
        found.ok_or_else(|| pyo3::exceptions::PyIndexError::new_err("the skin has no such part"))
    }
}

/// Linear blend skinning. A vertex without a bone moves with the node that holds the mesh.
fn deformed(mesh: &Mesh, pose: &Pose, node_to_world: Mat4) -> Vec<Vec3> {
    let mut sums = vec![(Vec3::ZERO, 0.0); mesh.vertices.len()];
    for bone in &mesh.bones {
        let mesh_to_world = pose.node_to_world[bone.node.index()] * bone.offset_matrix;
        for weight in &bone.weights {
            let vertex = weight.vertex_id as usize;
            let moved = mesh_to_world.transform_point3(mesh.vertices[vertex]);
            sums[vertex].0 += weight.weight * moved;
            sums[vertex].1 += weight.weight;
        }
    }
    let vertices = std::iter::zip(&mesh.vertices, sums);
    let at = |(vertex, (sum, weight)): (&Vec3, (Vec3, f32))| match weight > 0.0 {
        true => sum / weight,
        false => node_to_world.transform_point3(*vertex),
    };
    vertices.map(at).collect()
}
