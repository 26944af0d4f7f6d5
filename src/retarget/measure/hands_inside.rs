//! Whether a hand is inside the skin of its own body: head, trunk or legs.
//!
//! The test is the generalized winding number of the faces that the arm does not move (Jacobson, Kavan, Sorkine-Hornung
//! 2013). It is 1 inside a closed surface and 0 outside. At an open surface, as at the shoulder, it is between 0 and 1.

use std::f32::consts::PI;

use glam::Vec3;
use mocap_figure::HumanoidBone as Bone;
use mocap_figure::body::Body;
use mocap_scene::scene::{Mesh, NodeId, Scene};

/// The winding number above which a point is inside.
const INSIDE: f32 = 0.5;

/// A hand with the skin around it.
pub(super) struct Hand {
    /// The vertices of the hand, each with the index of its mesh.
    vertices: Vec<(usize, usize)>,
    /// The faces that the arm does not move, each with the index of its mesh.
    shell: Vec<(usize, [usize; 3])>,
    /// The axis along which the skin is thinnest at rest: from front to back.
    depth: usize,
}

impl Hand {
    /// The hands of a body with these meshes that are outside the skin at rest. `at_rest` has the vertices of the
    /// meshes at rest.
    pub(super) fn of(scene: &Scene, body: &Body, meshes: &[&Mesh], at_rest: &[Vec<Vec3>]) -> Vec<Self> {
        let points = || at_rest.iter().flatten().filter(|point| point.is_finite());
        let least = points().fold(Vec3::MAX, |least, point| least.min(*point));
        let extent = points().fold(Vec3::MIN, |most, point| most.max(*point)) - least;
        let depth = extent.min_position();
        let joints: Vec<Vec<Option<NodeId>>> = meshes.iter().map(|mesh| strongest(mesh)).collect();
        let hands = [
            (Bone::LeftUpperArm, Bone::LeftHand),
            (Bone::RightUpperArm, Bone::RightHand),
        ];
        let hands = hands.into_iter().filter_map(|(arm, hand)| {
            let is_in = |bone: Bone| {
                let top = body.bones.get(&bone)?;
                Some(below(scene, *top))
            };
            let (arm, hand) = (is_in(arm)?, is_in(hand)?);
            let (mut vertices, mut shell) = (Vec::new(), Vec::new());
            for (index, (mesh, joints)) in meshes.iter().zip(&joints).enumerate() {
                let moves = |vertex: usize, by: &[bool]| joints[vertex].is_some_and(|joint| by[joint.index()]);
                vertices.extend(
                    (0..joints.len())
                        .filter(|vertex| moves(*vertex, &hand))
                        .map(|vertex| (index, vertex)),
                );
                for face in mesh.faces() {
                    let corners: Vec<usize> = face.iter().map(|vertex| *vertex as usize).collect();
                    let is_shell = |corner: &usize| *corner < joints.len() && !moves(*corner, &arm);
                    if corners.iter().all(is_shell) {
                        let fan = corners.windows(2).skip(1);
                        shell.extend(fan.map(|edge| (index, [corners[0], edge[0], edge[1]])));
                    }
                }
            }
            let hand = Self { vertices, shell, depth };
            Some(hand).filter(|hand| !hand.vertices.is_empty())
        });
        // A skin whose faces point inwards, or an open skin, is no evidence.
        hands.filter(|hand| !hand.is_inside(at_rest)).collect()
    }

    /// Whether the middle of the hand is inside head, trunk or legs. `vertices` are the vertices of each mesh in a
    /// pose.
    pub(super) fn is_inside(&self, vertices: &[Vec<Vec3>]) -> bool {
        let sum: Vec3 = self
            .vertices
            .iter()
            .map(|(mesh, vertex)| vertices[*mesh][*vertex])
            .sum();
        let middle = sum / self.vertices.len() as f32;
        let faces = || {
            self.shell
                .iter()
                .map(|(mesh, corners)| corners.map(|corner| vertices[*mesh][corner] - middle))
        };
        // A ray to the front excludes most points outside, and is cheap.
        let crossings: i32 = faces().map(|face| crossing(face, self.depth)).sum();
        crossings != 0 && faces().map(solid_angle).sum::<f32>() / (4.0 * PI) > INSIDE
    }
}

/// 1 or -1 if the half axis from the origin crosses a triangle, by the side that the triangle faces; else 0.
fn crossing([a, b, c]: [Vec3; 3], axis: usize) -> i32 {
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let beside = |of: usize| (a[of] > 0.0) == (b[of] > 0.0) && (b[of] > 0.0) == (c[of] > 0.0);
    if beside(u) || beside(v) {
        return 0;
    }
    let area = |one: Vec3, other: Vec3| one[u] * other[v] - one[v] * other[u];
    let (of_a, of_b, of_c) = (area(b, c), area(c, a), area(a, b));
    let sum = of_a + of_b + of_c;
    let is_within = (of_a > 0.0) == (of_b > 0.0) && (of_b > 0.0) == (of_c > 0.0) && sum != 0.0;
    let is_ahead = || (of_a * a[axis] + of_b * b[axis] + of_c * c[axis]) / sum > 0.0;
    match is_within && is_ahead() {
        true if sum > 0.0 => 1,
        true => -1,
        false => 0,
    }
}

/// The solid angle of a triangle seen from the origin (Van Oosterom, Strackee 1983).
fn solid_angle([a, b, c]: [Vec3; 3]) -> f32 {
    let (x, y, z) = (a.length(), b.length(), c.length());
    let above = a.dot(b.cross(c));
    2.0 * above.atan2(x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y)
}

/// For each node, whether it is `top` or a descendant of `top`.
fn below(scene: &Scene, top: NodeId) -> Vec<bool> {
    let mut below: Vec<bool> = Vec::with_capacity(scene.nodes.len());
    for (index, node) in scene.nodes.iter().enumerate() {
        let hangs = node.parent.is_some_and(|parent| below[parent.index()]);
        below.push(hangs || index == top.index());
    }
    below
}

/// The joint that moves each vertex most.
fn strongest(mesh: &Mesh) -> Vec<Option<NodeId>> {
    let mut strongest: Vec<(f32, Option<NodeId>)> = vec![(0.0, None); mesh.vertices.len()];
    for bone in &mesh.bones {
        for weight in &bone.weights {
            if let Some(most) = strongest.get_mut(weight.vertex_id as usize)
                && weight.weight > most.0
            {
                *most = (weight.weight, Some(bone.node));
            }
        }
    }
    strongest.into_iter().map(|(_, joint)| joint).collect()
}
