//! The sole of a foot in the skin of a character.

use std::collections::HashMap;
use std::f32::consts::TAU;

use glam::Vec3;

use mocap_figure::body::Body;
use mocap_scene::pose::Pose;
use mocap_scene::scene::{Mesh, NodeId, Scene};

/// The largest height of a sole's vertex above the floor, as a fraction of the leg.
const SOLE: f32 = 0.025;

/// The number of horizontal directions in which the outermost vertices are searched: one every ten degrees.
const DIRECTIONS: usize = 36;

/// The tangents of the angles by which the searched directions point down. The lowest edge of a tilted foot, or of a
/// foot that points down, is below the horizontal outline of the foot.
const SLOPES: [f32; 3] = [0.0, 0.5, 1.5];

/// The smallest total skin weight of the foot's joints at which a vertex belongs to the foot.
const OF_FOOT: f32 = 0.9;

/// A foot in a skin.
pub(super) struct Skin {
    pub(super) ankle: NodeId,
    /// The joint of the toes, or else the ankle.
    pub(super) toes: NodeId,
    /// The height of the floor.
    pub(super) floor: f32,
}

/// A vertex of a sole.
#[derive(Clone)]
pub(super) struct Vertex {
    /// The position of the vertex at rest.
    pub(super) at_rest: Vec3,
    /// The nodes that move the vertex, each with its weight, and the position of the vertex in the space of the node.
    pub(super) parts: Vec<(NodeId, f32, Vec3)>,
    /// The joint with most of the weight: the ankle or the toes.
    pub(super) of: NodeId,
}

impl Vertex {
    /// The position in a pose.
    pub(super) fn at(&self, pose: &Pose) -> Vec3 {
        let part = |(node, fraction, at_rest): &(NodeId, f32, Vec3)| {
            *fraction * pose.node_to_world[node.index()].transform_point3(*at_rest)
        };
        self.parts.iter().map(part).sum()
    }
}

/// The vertices of a mesh. `of` is the joint with the largest weight.
pub(super) fn vertices(mesh: &Mesh, pose: &Pose) -> impl Iterator<Item = Vertex> {
    let mut parts: Vec<Vec<(NodeId, f32, Vec3)>> = vec![Vec::new(); mesh.vertices.len()];
    for bone in &mesh.bones {
        for weight in bone.weights.iter().filter(|weight| weight.weight > 0.0) {
            let vertex = weight.vertex_id as usize;
            if let (Some(parts), Some(at)) = (parts.get_mut(vertex), mesh.vertices.get(vertex)) {
                parts.push((bone.node, weight.weight, bone.offset_matrix.transform_point3(*at)));
            }
        }
    }
    let vertex = |mut parts: Vec<(NodeId, f32, Vec3)>| {
        let whole: f32 = parts.iter().map(|(_, weight, _)| weight).sum();
        parts.iter_mut().for_each(|(_, weight, _)| *weight /= whole);
        let (of, ..) = *parts.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
        let mut vertex = Vertex {
            at_rest: Vec3::ZERO,
            parts,
            of,
        };
        vertex.at_rest = vertex.at(pose);
        vertex.at_rest.is_finite().then_some(vertex)
    };
    parts.into_iter().filter_map(vertex)
}

impl Skin {
    /// The outermost vertices of the sole: vertices that move with the ankle, and vertices that move with the toes.
    pub(super) fn sole(&self, body: &Body, scene: &Scene) -> Vec<Vertex> {
        let pose = Pose::rest(scene);
        let vertices: Vec<Vertex> = scene
            .own_meshes()
            .flat_map(|mesh| self.vertices(mesh, body, &pose))
            .collect();
        let is_low = |vertex: &&Vertex| vertex.at_rest.dot(body.up()) - self.floor < SOLE * body.leg;
        let mut sole = Vec::new();
        for joint in if self.ankle == self.toes {
            vec![self.ankle]
        } else {
            vec![self.ankle, self.toes]
        } {
            let low: Vec<&Vertex> = vertices
                .iter()
                .filter(is_low)
                .filter(|vertex| vertex.of == joint)
                .collect();
            let mut outermost: Vec<usize> = Vec::new();
            for slope in SLOPES {
                for direction in 0..DIRECTIONS {
                    let (sin, cos) = (TAU * direction as f32 / DIRECTIONS as f32).sin_cos();
                    let out = body.axes * Vec3::new(cos, -slope, sin);
                    let far = |vertex: &usize| low[*vertex].at_rest.dot(out);
                    outermost.extend((0..low.len()).max_by(|a, b| far(a).total_cmp(&far(b))));
                }
            }
            outermost.sort_unstable();
            outermost.dedup();
            sole.extend(outermost.into_iter().map(|vertex| low[vertex].clone()));
        }
        sole
    }

    /// The vertices of a mesh that move with the foot.
    fn vertices(&self, mesh: &Mesh, body: &Body, pose: &Pose) -> Vec<Vertex> {
        let is_below = |node: NodeId, other: NodeId| node == other || body.depends_on(node, other);
        let mut parts: HashMap<u32, Vec<(NodeId, f32, Vec3)>> = HashMap::new();
        for bone in mesh.bones.iter().filter(|bone| is_below(bone.node, self.ankle)) {
            for weight in &bone.weights {
                if let Some(vertex) = mesh.vertices.get(weight.vertex_id as usize) {
                    let part = (bone.node, weight.weight, bone.offset_matrix.transform_point3(*vertex));
                    parts.entry(weight.vertex_id).or_default().push(part);
                }
            }
        }
        let vertex = |mut parts: Vec<(NodeId, f32, Vec3)>| {
            let whole: f32 = parts.iter().map(|(_, fraction, _)| fraction).sum();
            if whole < OF_FOOT {
                return None;
            }
            for (_, fraction, _) in &mut parts {
                *fraction /= whole;
            }
            let at_rest = |(node, fraction, at_rest): &(NodeId, f32, Vec3)| {
                *fraction * pose.node_to_world[node.index()].transform_point3(*at_rest)
            };
            let of_toes = parts.iter().filter(|(node, _, _)| is_below(*node, self.toes));
            let of_toes: f32 = of_toes.map(|(_, fraction, _)| fraction).sum();
            Some(Vertex {
                at_rest: parts.iter().map(at_rest).sum(),
                of: if of_toes > 0.5 { self.toes } else { self.ankle },
                parts,
            })
        };
        let mut ids: Vec<u32> = parts.keys().copied().collect();
        ids.sort_unstable();
        ids.into_iter().filter_map(|id| vertex(parts.remove(&id)?)).collect()
    }
}
