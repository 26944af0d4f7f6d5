//! Writes morph targets: blend shapes of meshes, and their weights in animations.
//!
//! An animation has one weight for each shape name, for all meshes. So morph targets with the same name share a weight
//! if they move in the same way. Otherwise the targets get different names.

use mocap_scene::error::Result;
use mocap_scene::scene::{MorphTarget, Scene};

use super::animation::ticks;
use super::mesh::is_written;
use super::names::Names;
use super::text;
use super::{ROOT, Stage, unrepresentable};
use crate::morph_targets;
use crate::unique_names::UniqueNames;

/// The shapes of a scene.
#[derive(Default)]
pub(super) struct Shapes {
    /// For each mesh, the index in `moved` of each target.
    of_mesh: Vec<Vec<usize>>,
    /// The names by which animations move targets, each with the mesh and the index of one target.
    moved: Vec<(String, usize, usize)>,
}

impl Shapes {
    pub(super) fn of(scene: &Scene) -> Self {
        let mut shapes = Self::default();
        let mut names = UniqueNames::default();
        for (index, mesh) in scene.meshes.iter().enumerate() {
            let mut of_mesh = Vec::new();
            let written = mesh.morph_targets.iter().filter(|_| is_written(mesh));
            for (target_index, target) in written.enumerate() {
                let is_it = |(at, (_, mesh, other)): (usize, &(String, usize, usize))| {
                    let other = &scene.meshes[*mesh].morph_targets[*other];
                    let is_alike = other.name == target.name
                        && other.weight == target.weight
                        && other.weight_keys == target.weight_keys;
                    // A mesh with two targets of one name has two shapes.
                    is_alike && !of_mesh.contains(&at)
                };
                let known = shapes.moved.iter().enumerate().find(|known| is_it(*known));
                let known = known.map(|(at, _)| at);
                of_mesh.push(known.unwrap_or_else(|| {
                    let name = names.first_free(target.name.clone(), str::to_owned);
                    shapes.moved.push((name, index, target_index));
                    shapes.moved.len() - 1
                }));
            }
            shapes.of_mesh.push(of_mesh);
        }
        shapes
    }

    fn name(&self, place: usize) -> &str {
        &self.moved[place].0
    }
}

fn quoted(out: &mut String, name: &str) {
    out.push_str(&text::quoted(name));
}

impl Stage<'_> {
    /// Writes the blend shapes of a mesh, at the end of its prim.
    pub(super) fn shapes(&mut self, index: usize, prim: &str) -> Result<()> {
        let mesh = &self.scene.meshes[index];
        if mesh.morph_targets.is_empty() {
            return Ok(());
        }
        morph_targets::check(mesh).map_err(|message| unrepresentable(&mesh.name, message))?;
        let mut names = Names::default();
        let prims = mesh.morph_targets.iter();
        let prims: Vec<String> = prims.map(|target| names.unique(&target.name, "Shape")).collect();
        let out = &mut self.text;
        let tokens = self.shapes.of_mesh[index].iter().map(|place| self.shapes.name(*place));
        out.list("uniform token[] skel:blendShapes", tokens, quoted);
        out.list("rel skel:blendShapeTargets", &prims, |out, shape| {
            out.push_str(&format!("</{ROOT}/{prim}/{shape}>"));
        });
        for (target, shape) in std::iter::zip(&mesh.morph_targets, &prims) {
            let display = text::display_name(&target.name, shape);
            let metadata: Vec<&str> = display.as_deref().into_iter().collect();
            out.open("def BlendShape", shape, &metadata);
            let offsets = target.offsets.iter().map(glam::Vec3::to_array);
            out.list("uniform vector3f[] offsets", offsets, text::tuple);
            if !target.normal_offsets.is_empty() {
                let normals = target.normal_offsets.iter().map(glam::Vec3::to_array);
                out.list("uniform vector3f[] normalOffsets", normals, text::tuple);
            }
            out.list("uniform int[] pointIndices", &target.vertex_ids, |out, vertex| {
                out.push_str(&vertex.to_string());
            });
            out.close();
        }
        Ok(())
    }

    /// Writes the weights of all shapes in the animation `index`, whose ticks last `codes` time codes.
    pub(super) fn weights(&mut self, index: usize, codes: f64) {
        let targets: Vec<&MorphTarget> = self
            .shapes
            .moved
            .iter()
            .map(|(_, mesh, target)| &self.scene.meshes[*mesh].morph_targets[*target])
            .collect();
        if targets.is_empty() {
            return;
        }
        let keys = || targets.iter().map(|target| target.weight_keys.get(index));
        let ticks = ticks(keys().flatten());
        let at = |tick: usize| {
            let of_target = |target: &&MorphTarget| {
                let keys = target.weight_keys.get(index);
                keys.and_then(|keys| keys.sample(ticks[tick])).unwrap_or(target.weight)
            };
            targets.iter().map(of_target).collect()
        };
        let times: Vec<f64> = ticks.iter().map(|tick| tick * codes).collect();
        let names = self.shapes.moved.iter().map(|(name, ..)| name.as_str());
        self.text.list("uniform token[] blendShapes", names, quoted);
        self.text
            .samples("float[] blendShapeWeights", &times, at, |out, weight: f32| {
                // Turns -0 into 0.
                out.push_str(&(weight + 0.0).to_string());
            });
    }
}
