//! The links of a robot as meshes, for pictures.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DVec3, Mat4, Vec3};
use mocap_scene::scene::robot::{Placement, ShapeKind};
use mocap_scene::scene::{Bone, Material, Mesh, NodeId, Primitive, Scene, VertexWeight};

use super::Robot;
use super::capsule::{Capsule, THICKNESS, capsules_of};

/// The number of corners around a capsule.
const AROUND: usize = 16;
/// The number of rings of each end of a capsule.
const RINGS: usize = 5;

/// Adds a mesh for each link to a scene with the nodes of [`robot_scene`](crate::robot::robot_scene), for pictures. A
/// link has the triangles of its mesh files, if [`Importer::robot_meshes`](mocap_io::Importer::robot_meshes) read them.
/// Else it has the capsules within its shapes, as for collisions. Without shapes, it has lines to the joints of its
/// children.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::retarget::robot::{add_links, robot_scene};
///
/// let robot = mocap::Importer::new().import_robot("fixtures/robots/h1.urdf")?;
/// let mut scene = robot_scene(&robot);
/// add_links(&robot, &mut scene);
/// assert!(scene.meshes.len() > 15);
/// # Ok::<(), mocap::Error>(())
/// ```
pub fn add_links(robot: &Robot, scene: &mut Scene) {
    let material_index = scene.materials.len();
    scene.materials.push(Material {
        name: "links".to_owned(),
        two_sided: true,
        surface: None,
    });
    for link in 0..robot.links.len().min(scene.nodes.len()) {
        let Some((vertices, normals, indices)) = files_of(robot, link).or_else(|| body_of(robot, link)) else {
            continue;
        };
        let weight = |vertex_id| VertexWeight { vertex_id, weight: 1.0 };
        let name = robot.links[link].name.clone();
        scene.nodes[link].meshes.push(scene.meshes.len());
        scene.meshes.push(Mesh {
            name: format!("{name} link"),
            primitive: Primitive::Triangles,
            bones: vec![Bone {
                name,
                node: NodeId::new(link),
                offset_matrix: Mat4::IDENTITY,
                weights: (0..vertices.len() as u32).map(weight).collect(),
            }],
            vertices,
            normals,
            indices,
            material_index,
            ..Mesh::default()
        });
    }
}

/// The triangles of the mesh files of a link: of its visual shapes, or else of its collision shapes.
fn files_of(robot: &Robot, link: usize) -> Option<Surface> {
    let surfaces = |collides: bool| {
        let shapes = robot.links[link]
            .shapes
            .iter()
            .filter(move |shape| shape.collides == collides);
        shapes.filter_map(|shape| match &shape.kind {
            ShapeKind::Mesh {
                surface: Some(mesh), ..
            } => Some((shape.origin, mesh)),
            _ => None,
        })
    };
    let are_seen = surfaces(false).next().is_some();
    let (mut vertices, mut normals, mut indices) = Surface::default();
    for (origin, mesh) in surfaces(!are_seen) {
        let first = vertices.len() as u32;
        let matrix = origin.to_matrix();
        vertices.extend(mesh.vertices.iter().map(|vertex| matrix.transform_point3(*vertex)));
        normals.extend(
            mesh.normals
                .iter()
                .map(|normal| matrix.transform_vector3(*normal).normalize_or(*normal)),
        );
        indices.extend(mesh.indices.iter().map(|index| first + index));
    }
    (!indices.is_empty()).then_some((vertices, normals, indices))
}

fn body_of(robot: &Robot, link: usize) -> Option<Surface> {
    let mut capsules = capsules_of(robot, &[(Placement::IDENTITY, link)]);
    if capsules.is_empty() {
        capsules = lines_to_children(robot, link);
    }
    (!capsules.is_empty()).then(|| surface_of(&capsules))
}

fn lines_to_children(robot: &Robot, link: usize) -> Vec<Capsule> {
    let children = robot.links.iter().filter(|child| child.parent == Some(link));
    let ends = children.map(|child| child.joint.origin.translation);
    let far = ends.filter(|end| end.length() > 0.0);
    far.map(|end| Capsule {
        ends: [DVec3::ZERO, end],
        radius: THICKNESS * end.length(),
    })
    .collect()
}

/// Vertices, normals, and corners of triangles.
type Surface = (Vec<Vec3>, Vec<Vec3>, Vec<u32>);

/// The triangles of capsules.
pub fn surface_of(capsules: &[Capsule]) -> Surface {
    let (mut vertices, mut normals, mut indices) = (Vec::new(), Vec::new(), Vec::new());
    for Capsule { ends, radius } in capsules {
        let axis = (ends[1] - ends[0]).normalize_or(DVec3::Z);
        let (across, aside) = axis.any_orthonormal_pair();
        let first = vertices.len();
        // From one pole to the other, with both equators.
        for (end, side) in [(ends[0], -1.0), (ends[1], 0.0)] {
            for ring in 0..=RINGS {
                let latitude = FRAC_PI_2 * (side + ring as f64 / RINGS as f64);
                for step in 0..AROUND {
                    let turn = TAU * step as f64 / AROUND as f64;
                    let out = across * turn.cos() + aside * turn.sin();
                    let normal = out * latitude.cos() + axis * latitude.sin();
                    vertices.push((end + normal * *radius).as_vec3());
                    normals.push(normal.as_vec3());
                }
            }
        }
        for row in 0..2 * RINGS + 1 {
            for step in 0..AROUND {
                let at = |row: usize, step: usize| (first + row * AROUND + step % AROUND) as u32;
                let [a, b, c, d] = [
                    at(row, step),
                    at(row, step + 1),
                    at(row + 1, step + 1),
                    at(row + 1, step),
                ];
                indices.extend([a, b, c, a, c, d]);
            }
        }
    }
    (vertices, normals, indices)
}
