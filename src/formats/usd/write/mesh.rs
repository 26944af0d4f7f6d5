//! Writes meshes: their geometry, and the joints that move them.

use std::borrow::Cow;

use glam::{DMat4, Vec3};
use mocap_scene::error::Result;
use mocap_scene::limits::is_plausible;
use mocap_scene::pose::complete_bind_pose;
use mocap_scene::scene::{Mesh, Primitive, Scene};

use super::material::Materials;
use super::skeleton::Skeleton;
use super::text;
use super::{ROOT, SKELETON, Stage, unrepresentable};
use crate::usd::SKELETON_MESH;

/// The largest difference between the bind poses of two meshes without a note, in the unit of the scene.
const SAME_POSE: f64 = 1e-3;

/// A written mesh: its index, and its transform to the bind pose of the skeleton.
pub(super) struct Bound {
    mesh: usize,
    node: usize,
    to_bind: DMat4,
}

/// Finds the bind pose of the skeleton. A USD skeleton has one bind pose, and each mesh has its own transform to the
/// bind pose.
pub(super) fn bind(scene: &Scene, skeleton: &mut Skeleton, notes: &mut Vec<String>) -> Result<Vec<Bound>> {
    let mut found = Vec::new();
    let placed = scene.nodes.iter().enumerate();
    let placed = placed.flat_map(|(node, own)| own.meshes.iter().map(move |mesh| (node, *mesh)));
    for (node, index) in placed.filter(|(_, mesh)| is_written(&scene.meshes[*mesh])) {
        let mesh = &scene.meshes[index];
        let offsets: Vec<(usize, DMat4)> = mesh
            .bones
            .iter()
            .map(|bone| (bone.node.index(), bone.offset_matrix.as_dmat4()))
            .collect();
        let is_sound = |(_, offset): &(usize, DMat4)| offset.inverse().is_finite();
        if let Some((joint, _)) = offsets.iter().find(|offset| !is_sound(offset)) {
            let message = format!("its bind pose in the mesh {:?} has no inverse", mesh.name);
            return Err(unrepresentable(&scene.nodes[*joint].name, message));
        }
        let shared = offsets
            .iter()
            .find_map(|(joint, offset)| Some(skeleton.bind[*joint]? * *offset));
        // Vertices are in the space of the first bound mesh.
        let to_bind = match offsets.is_empty() {
            true => skeleton.bound(node),
            false => shared.unwrap_or(DMat4::IDENTITY),
        };
        let mut farthest = 0.0_f64;
        for (joint, offset) in offsets {
            let bind = to_bind * offset.inverse();
            match skeleton.bind[joint] {
                Some(known) => farthest = farthest.max((known.w_axis - bind.w_axis).length()),
                None => skeleton.bind[joint] = Some(bind),
            }
        }
        if farthest > SAME_POSE {
            notes.push(format!(
                "the bind pose of the mesh {:?} differs from earlier meshes by {farthest:.4} units, so the mesh is \
                    displaced by that distance",
                mesh.name
            ));
        }
        found.push(Bound {
            mesh: index,
            node,
            to_bind,
        });
    }
    complete_bind_pose(&scene.nodes, &skeleton.rest, &mut skeleton.bind);
    // Place meshes without bones after all bind poses are known.
    for bound in &mut found {
        if scene.meshes[bound.mesh].bones.is_empty() {
            bound.to_bind = skeleton.bound(bound.node);
        }
    }
    Ok(found)
}

/// Whether a mesh is written. A mesh of points has no faces, and is not written.
pub(super) fn is_written(mesh: &Mesh) -> bool {
    mesh.primitive == Primitive::Triangles && !mesh.indices.is_empty()
}

impl Stage<'_> {
    pub(super) fn meshes(&mut self, bound: &[Bound], materials: &Materials) -> Result<()> {
        for bound in bound {
            self.mesh(bound, materials)?;
        }
        Ok(())
    }

    fn mesh(&mut self, bound: &Bound, materials: &Materials) -> Result<()> {
        let mesh = &self.scene.meshes[bound.mesh];
        check(mesh)?;
        // Animations have the weights of shapes. Without animation, bake the rest shape.
        let vertices = match self.scene.animations.is_empty() {
            true => Cow::Borrowed(mesh.vertices.as_slice()),
            false => mesh.vertices_without_targets(),
        };
        let name = self.names.unique(&mesh.name, "Mesh");
        let display = text::display_name(&mesh.name, &name).filter(|_| !mesh.name.is_empty());
        let mut metadata = vec!["prepend apiSchemas = [\"SkelBindingAPI\", \"MaterialBindingAPI\"]"];
        metadata.extend(display.as_deref());
        let out = &mut self.text;
        out.open("def Mesh", &name, &metadata);
        if self.scene.is_drawn_skeleton(mesh) {
            out.line(&format!("custom bool {SKELETON_MESH} = 1"));
        }
        let low = vertices.iter().copied().fold(Vec3::MAX, Vec3::min);
        let high = vertices.iter().copied().fold(Vec3::MIN, Vec3::max);
        out.list("float3[] extent", [low.to_array(), high.to_array()], text::tuple);
        let count = mesh.indices.len() / 3;
        let integer = |out: &mut String, number: u32| out.push_str(&number.to_string());
        out.list("int[] faceVertexCounts", std::iter::repeat_n(3, count), integer);
        out.list("int[] faceVertexIndices", mesh.indices.iter().copied(), integer);
        out.list("point3f[] points", vertices.iter().map(Vec3::to_array), text::tuple);
        if mesh.normals.len() == mesh.vertices.len() {
            out.list(
                "normal3f[] normals",
                mesh.normals.iter().map(Vec3::to_array),
                text::tuple,
            );
            within(out, &["interpolation = \"vertex\""]);
        }
        if mesh.texture_coords.len() == mesh.vertices.len() {
            // Texture coordinates start at the lower left corner of an image in USD, and at the upper left in a scene.
            let coords = mesh
                .texture_coords
                .iter()
                .map(|bind_line| [bind_line.x, 1.0 - bind_line.y]);
            out.list("texCoord2f[] primvars:st", coords, text::tuple);
            within(out, &["interpolation = \"vertex\""]);
        }
        out.line("uniform token subdivisionScheme = \"none\"");
        let surface = self.scene.materials.get(mesh.material_index);
        if surface.is_some_and(|material| material.two_sided) {
            out.line("uniform bool doubleSided = 1");
        }
        if let Some(material) = materials.path(mesh.material_index) {
            out.line(&format!("rel material:binding = <{material}>"));
        }
        out.line(&format!("rel skel:skeleton = </{ROOT}/{SKELETON}>"));
        let mut bind_line = String::from("matrix4d primvars:skel:geomBindTransform = ");
        text::matrix(&mut bind_line, bound.to_bind);
        out.line(&bind_line);
        self.ties(mesh, bound.node)?;
        self.shapes(bound.mesh, &name)?;
        self.text.close();
        Ok(())
    }

    /// Writes the joints and the weights of each vertex, the heaviest first. A mesh without bones follows its node.
    fn ties(&mut self, mesh: &Mesh, node: usize) -> Result<()> {
        let mut ties: Vec<Vec<(usize, f32)>> = vec![Vec::new(); mesh.vertices.len()];
        for bone in &mesh.bones {
            for tie in bone.weights.iter().filter(|tie| tie.weight > 0.0) {
                let Some(own) = ties.get_mut(tie.vertex_id as usize) else {
                    let message = format!("a bone of the mesh {:?} has a vertex that does not exist", mesh.name);
                    return Err(unrepresentable(&bone.name, message));
                };
                own.push((bone.node.index(), tie.weight));
            }
        }
        let (each, how) = match mesh.bones.first() {
            None => {
                ties = vec![vec![(node, 1.0)]];
                (1, "constant")
            }
            Some(first) => {
                for own in &mut ties {
                    own.sort_by(|a, b| b.1.total_cmp(&a.1));
                    // A vertex without weights follows the first bone.
                    if own.is_empty() {
                        own.push((first.node.index(), 1.0));
                    }
                    // USD sums the stated weights, and files round: a sum of 1.0001 moves a head by 0.1 mm.
                    let sum: f64 = own.iter().map(|tie| f64::from(tie.1)).sum();
                    own.iter_mut().for_each(|tie| tie.1 = (f64::from(tie.1) / sum) as f32);
                }
                (ties.iter().map(Vec::len).max().unwrap_or(1), "vertex")
            }
        };
        let rows = || {
            ties.iter()
                .flat_map(|own| (0..each).map(|index| own.get(index).copied().unwrap_or((own[0].0, 0.0))))
        };
        let metadata = [format!("elementSize = {each}"), format!("interpolation = \"{how}\"")];
        let metadata: Vec<&str> = metadata.iter().map(String::as_str).collect();
        let out = &mut self.text;
        out.list(
            "int[] primvars:skel:jointIndices",
            rows().map(|tie| tie.0),
            |out, joint| {
                out.push_str(&joint.to_string());
            },
        );
        within(out, &metadata);
        out.list(
            "float[] primvars:skel:jointWeights",
            rows().map(|tie| tie.1),
            |out, weight| {
                out.push_str(&weight.to_string());
            },
        );
        within(out, &metadata);
        Ok(())
    }
}

/// Appends the metadata of the last attribute.
fn within(out: &mut text::Text, metadata: &[&str]) {
    out.continue_line(" (");
    metadata.iter().for_each(|line| out.line(&format!("    {line}")));
    out.line(")");
}

fn check(mesh: &Mesh) -> Result<()> {
    let is_sound = |vertex: &Vec3| vertex.to_array().into_iter().all(|number| is_plausible(number.into()));
    let is_whole = mesh.indices.len().is_multiple_of(3)
        && mesh.indices.iter().all(|index| (*index as usize) < mesh.vertices.len());
    match is_whole && mesh.vertices.iter().all(is_sound) {
        true => Ok(()),
        false => {
            let message = format!(
                "a vertex of the mesh {:?} is not finite, or a face has a vertex that does not exist",
                mesh.name
            );
            Err(unrepresentable(&mesh.name, message))
        }
    }
}
