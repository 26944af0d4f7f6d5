//! Compares two scenes.

use std::fmt;

use mocap::glam::{DVec3, Mat4, Quat, Vec3};
use mocap::scene::{Channel, Keys, Mesh, Primitive, Scene};

use super::truth::{Flags, Number, Truth, TruthChannel, TruthMesh};

/// A difference between the two scenes.
#[derive(Debug)]
pub(crate) struct Difference {
    pub(crate) file: String,
    pub(crate) flags: Flags,
    /// The differing place, from the general to the specific: `mesh 3 vertices`.
    pub(crate) place: String,
    pub(crate) ours: String,
    pub(crate) theirs: String,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            file,
            flags,
            place,
            ours,
            theirs,
        } = self;
        write!(f, "{file} {}: {place}: {ours}, Assimp {theirs}", flags.name())
    }
}

pub(crate) struct Comparison {
    file: String,
    flags: Flags,
    reach: f64,
    differences: Vec<Difference>,
}

/// The tolerance as a fraction of a number, or as an absolute value for numbers below 1.
const TOLERANCE: f64 = 1e-5;

impl Comparison {
    /// `reach` is the largest coordinate of the file's mesh in the rest pose.
    pub(crate) fn new(file: &str, flags: Flags, reach: f64) -> Self {
        Self {
            file: file.to_owned(),
            flags,
            reach,
            differences: Vec::new(),
        }
    }

    pub(crate) fn run(mut self, ours: &Scene, theirs: &Truth) -> Vec<Difference> {
        self.nodes(ours, theirs);
        self.equal("materials", ours.materials.len(), theirs.materials.len());
        self.equal("meshes", ours.meshes.len(), theirs.meshes.len());
        for (index, (mesh, truth)) in ours.meshes.iter().zip(&theirs.meshes).enumerate() {
            self.mesh(&format!("mesh {index}"), mesh, truth);
        }
        self.equal("animations", ours.animations.len(), theirs.animations.len());
        for (animation, truth) in ours.animations.iter().zip(&theirs.animations) {
            self.equal("animation name", &animation.name, &truth.name);
            self.numbers(
                "ticks per second",
                [animation.ticks_per_second],
                [truth.ticks_per_second],
            );
            self.numbers("duration", [animation.duration], [truth.duration]);
            self.equal("channels", animation.channels.len(), truth.channels.len());
            for (channel, truth) in animation.channels.iter().zip(&truth.channels) {
                self.channel(channel, truth);
            }
        }
        self.differences
    }

    fn nodes(&mut self, ours: &Scene, theirs: &Truth) {
        self.equal("nodes", ours.nodes.len(), theirs.nodes.len());
        for (node, truth) in ours.nodes.iter().zip(&theirs.nodes) {
            let place = format!("node {}", truth.name);
            let parent = node.parent.map(|parent| ours.nodes[parent.index()].name.clone());
            self.equal(&format!("{place} name"), &node.name, &truth.name);
            self.equal(&format!("{place} parent"), &parent, &truth.parent);
            self.equal(&format!("{place} meshes"), &node.meshes, &truth.meshes);
            self.numbers(&format!("{place} matrix"), rows(node.transform), truth.matrix);
        }
    }

    fn mesh(&mut self, place: &str, mesh: &Mesh, truth: &TruthMesh) {
        // Assimp has one bit for each kind of face.
        let primitive_types = match mesh.primitive {
            Primitive::Points => 1,
            Primitive::Triangles => 4,
        };
        let faces: Vec<Vec<u32>> = mesh.faces().map(<[u32]>::to_vec).collect();
        self.equal(&format!("{place} name"), &mesh.name, &truth.name);
        self.equal(&format!("{place} material"), mesh.material_index, truth.material);
        self.equal(&format!("{place} primitive"), primitive_types, truth.primitive_types);
        self.equal(&format!("{place} faces"), &faces, &truth.faces);
        self.equal(
            &format!("{place} vertices count"),
            mesh.vertices.len(),
            truth.vertices.len(),
        );
        let positions = mesh.vertices.iter().flat_map(Vec3::to_array).map(f64::from);
        self.numbers(
            &format!("{place} vertices"),
            positions,
            truth.vertices.as_flattened().iter().copied(),
        );
        self.normals(&format!("{place} normals"), mesh, truth);
        self.equal(&format!("{place} bones"), mesh.bones.len(), truth.bones.len());
        for (bone, truth) in mesh.bones.iter().zip(&truth.bones) {
            let place = format!("{place} bone {}", truth.name);
            let weights: Vec<_> = bone
                .weights
                .iter()
                .map(|tie| (tie.vertex_id, f64::from(tie.weight)))
                .collect();
            self.equal(&format!("{place} name"), &bone.name, &truth.name);
            self.equal(&format!("{place} weights"), &weights, &truth.weights);
            self.numbers(
                &format!("{place} offset matrix"),
                rows(bone.offset_matrix),
                truth.offset,
            );
        }
    }

    /// Compares directions. The length of Assimp's normals is twice the area of their face, unless Assimp normalizes
    /// them.
    ///
    /// Assimp places the piece of mesh of each joint in the whole skeleton, far from the origin, and rounds the
    /// positions. Then it computes normals from them, so the error grows as the face gets smaller. Our normals come
    /// from the piece before it is placed.
    fn normals(&mut self, place: &str, mesh: &Mesh, truth: &TruthMesh) {
        self.equal(&format!("{place} count"), mesh.normals.len(), truth.normals.len());
        let rounding = self.reach * f64::from(f32::EPSILON);
        for face in mesh.faces() {
            let [a, b, c] = [0, 1, 2].map(|corner| corner.min(face.len() - 1)).map(|corner| {
                let vertex = face[corner] as usize;
                mesh.vertices[vertex].as_dvec3()
            });
            let longest = (b - a).length().max((c - b).length()).max((a - c).length());
            let lowest = (b - a).cross(c - a).length() / longest;
            // A face without an area has the normal X in both scenes, so there is no rounding.
            let tolerance = if lowest > 0.0 {
                TOLERANCE.max(2.0 * rounding / lowest)
            } else {
                TOLERANCE
            };
            for &vertex in face {
                let Some(truth) = truth.normals.get(vertex as usize) else {
                    return;
                };
                let direction = DVec3::from_array(*truth).normalize();
                let off = (mesh.normals[vertex as usize].as_dvec3() - direction)
                    .abs()
                    .max_element();
                if off > tolerance {
                    return self.push(
                        place,
                        format!("{:?}", mesh.normals[vertex as usize]),
                        format!("{direction:?}"),
                    );
                }
            }
        }
    }

    fn channel(&mut self, channel: &Channel, truth: &TruthChannel) {
        let place = format!("channel {}", truth.node);
        let vector = |value: &Vec3| value.to_array().to_vec();
        self.equal(&format!("{place} name"), &channel.node_name, &truth.node);
        self.keys(
            &format!("{place} positions"),
            &channel.position_keys,
            &truth.pos,
            vector,
        );
        self.rotations(&format!("{place} rotations"), &channel.rotation_keys, &truth.rot_wxyz);
        self.keys(&format!("{place} scales"), &channel.scaling_keys, &truth.scl, vector);
    }

    /// A quaternion with the other sign is the same rotation, but counts as a separate difference.
    fn rotations(&mut self, place: &str, keys: &Keys<Quat>, truth: &[Vec<Number>]) {
        let mut keys = keys.clone();
        let mut flipped = 0;
        for (rotation, truth) in keys.values.iter_mut().zip(truth) {
            let [w, x, y, z] = [1, 2, 3, 4].map(|part| truth[part].value() as f32);
            if rotation.dot(Quat::from_xyzw(x, y, z, w)) < 0.0 {
                *rotation = -*rotation;
                flipped += 1;
            }
        }
        self.equal(&format!("{place} of the other sign"), flipped, 0);
        self.keys(place, &keys, truth, |value| vec![value.w, value.x, value.y, value.z]);
    }

    fn keys<T>(&mut self, place: &str, keys: &Keys<T>, truth: &[Vec<Number>], numbers: impl Fn(&T) -> Vec<f32>) {
        self.equal(&format!("{place} count"), keys.len(), truth.len());
        for (index, (value, truth)) in keys.values.iter().zip(truth).enumerate() {
            let value = numbers(value).into_iter().map(f64::from);
            let key = std::iter::once(keys.tick(index)).chain(value);
            self.numbers(place, key, truth.iter().map(Number::value));
        }
    }

    fn equal<T: PartialEq + fmt::Debug>(&mut self, place: &str, ours: T, theirs: T) {
        if ours != theirs {
            self.push(place, format!("{ours:?}"), format!("{theirs:?}"));
        }
    }

    /// Records the first pair of numbers that differs.
    fn numbers(&mut self, place: &str, ours: impl IntoIterator<Item = f64>, theirs: impl IntoIterator<Item = f64>) {
        let known = self.differences.last().is_some_and(|last| last.place == place);
        let mut pairs = ours.into_iter().zip(theirs);
        let near = |(a, b): &(f64, f64)| (a - b).abs() <= TOLERANCE * b.abs().max(1.0);
        if let Some((a, b)) = pairs.find(|pair| !near(pair)).filter(|_| !known) {
            self.push(place, a.to_string(), b.to_string());
        }
    }

    fn push(&mut self, place: &str, ours: String, theirs: String) {
        self.differences.push(Difference {
            file: self.file.clone(),
            flags: self.flags,
            place: place.to_owned(),
            ours,
            theirs,
        });
    }
}

fn rows(matrix: Mat4) -> [f64; 16] {
    matrix.transpose().to_cols_array().map(f64::from)
}
