//! Bind poses of joints without a mesh. The test reads them with the readers of other programs, or by splitting the
//! text.

use std::fs;

use mocap::Exporter;
use mocap::glam::{DMat4, DVec3, Mat4, Vec3};
use mocap::scene::{Bone, Mesh, Node, NodeId, NodeKind, Primitive, Scene, VertexWeight};

/// An arm that hangs at rest, and was bound while it was stretched to the side. The hand, the end of the hand and the
/// root have no vertices. The root is seven metres before the arm.
fn arm() -> Scene {
    let node = |name: &str, parent: Option<usize>, place: Vec3| Node {
        name: name.into(),
        parent: parent.map(NodeId::new),
        transform: Mat4::from_translation(place),
        kind: NodeKind::Joint,
        ..Node::default()
    };
    let mut root = node("root", None, Vec3::new(0.0, 0.0, 7.0));
    root.meshes.push(0);
    let nodes = vec![
        root,
        node("arm", Some(0), Vec3::new(0.0, 1.0, -7.0)),
        node("hand", Some(1), Vec3::new(0.0, -1.0, 0.0)),
        node("end", Some(2), Vec3::new(0.0, -2.0, 0.0)),
    ];
    let bind = Mat4::from_translation(Vec3::Y) * Mat4::from_rotation_z(std::f32::consts::FRAC_PI_2);
    let weights = (0..3).map(|vertex_id| VertexWeight { vertex_id, weight: 1.0 });
    let mesh = Mesh {
        name: "skin".into(),
        primitive: Primitive::Triangles,
        vertices: vec![Vec3::Y, Vec3::new(1.0, 1.0, 0.0), Vec3::new(1.0, 1.5, 0.0)],
        normals: vec![Vec3::Z; 3],
        indices: vec![0, 1, 2],
        bones: vec![Bone {
            name: "arm".into(),
            node: NodeId::new(1),
            offset_matrix: bind.inverse(),
            weights: weights.collect(),
        }],
        ..Mesh::default()
    };
    let mut scene = Scene {
        nodes,
        meshes: vec![mesh],
        materials: vec![Default::default()],
        ..Scene::default()
    };
    scene.metadata.metres_per_unit = Some(1.0);
    scene
}

/// The positions of the joints of [`arm`] while it is stretched along +X, computed by hand.
const BOUND: [(&str, DVec3); 4] = [
    ("root", DVec3::new(0.0, 0.0, 7.0)),
    ("arm", DVec3::new(0.0, 1.0, 0.0)),
    ("hand", DVec3::new(1.0, 1.0, 0.0)),
    ("end", DVec3::new(3.0, 1.0, 0.0)),
];

/// The bytes of [`arm`] in the format of an extension.
fn written(extension: &str) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("arm").with_extension(extension);
    Exporter::new().export(&arm(), &path).unwrap();
    fs::read(path).unwrap()
}

#[track_caller]
fn check(name: &str, bind: DMat4, metres: f64) {
    let (_, expected) = BOUND.into_iter().find(|(known, _)| *known == name).unwrap();
    let found = bind.w_axis.truncate() * metres;
    assert!(found.abs_diff_eq(expected, 1e-5), "{name} is bound at {found}");
    // The arm and everything below it are rotated.
    let turned = if name == "root" { DVec3::X } else { DVec3::Y };
    assert!(
        bind.x_axis.truncate().normalize().abs_diff_eq(turned, 1e-5),
        "{name}: {bind}"
    );
}

#[test]
fn a_joint_without_a_bone_follows_the_bone_above_it_in_gltf() {
    let file = gltf::Gltf::from_slice(&written("glb")).unwrap();
    let skin = file.skins().next().unwrap();
    let reader = skin.reader(|_| file.blob.as_deref());
    let matrices: Vec<_> = reader.read_inverse_bind_matrices().unwrap().collect();
    assert_eq!(matrices.len(), BOUND.len());
    for (joint, matrix) in std::iter::zip(skin.joints(), matrices) {
        let bind = Mat4::from_cols_array_2d(&matrix).as_dmat4().inverse();
        check(joint.name().unwrap(), bind, 1.0);
    }
}

#[test]
fn a_joint_without_a_bone_follows_the_bone_above_it_in_usd() {
    let text = String::from_utf8(written("usda")).unwrap();
    let line = text.lines().find(|line| line.contains("bindTransforms = ")).unwrap();
    let (_, list) = line.split_once('=').unwrap();
    let numbers = list.split(|c: char| !(c.is_ascii_digit() || "+-.e".contains(c)));
    let numbers: Vec<f64> = numbers.filter_map(|number| number.parse().ok()).collect();
    assert_eq!(numbers.len(), 16 * BOUND.len(), "{line}");
    for (numbers, (name, _)) in std::iter::zip(numbers.chunks_exact(16), BOUND) {
        check(name, DMat4::from_cols_slice(numbers), 1.0);
    }
}

#[test]
fn a_joint_without_a_bone_follows_the_bone_above_it_in_fbx() {
    let bytes = written("fbx");
    let file = ufbx::load_memory(&bytes, ufbx::LoadOpts::default()).unwrap();
    let pose = file.poses.iter().find(|pose| pose.is_bind_pose).unwrap();
    let mut found = 0;
    for bone in &pose.bone_poses {
        let name = bone.bone_node.element.name.to_string();
        if BOUND.iter().any(|(known, _)| *known == name) {
            let m = &bone.bone_to_world;
            let columns = [m.m00, m.m10, m.m20, 0.0, m.m01, m.m11, m.m21, 0.0];
            let columns = [&columns[..], &[m.m02, m.m12, m.m22, 0.0, m.m03, m.m13, m.m23, 1.0]].concat();
            check(&name, DMat4::from_cols_slice(&columns), file.settings.unit_meters);
            found += 1;
        }
    }
    assert_eq!(found, BOUND.len());
}
