//! Tests meshes and skins of glTF files.

use gltf::mesh::util::{ReadJoints, ReadWeights};
use mocap::glam::{DVec3, Mat4, Vec3};
use mocap::gltf::{Document, GltfOptions};
use mocap::process::SkeletonMesh;
use mocap::scene::{Material, Mesh, Node, NodeId, NodeKind, Primitive, Scene, VertexWeight};

use super::read::Read;
use super::scenes::{assert_same_motion, node, walker, with_skinned_mesh, world_of_scene};

#[test]
fn a_skinned_mesh_stands_at_the_scene_root_and_follows_its_joints() {
    let scene = with_skinned_mesh(walker(50));
    let read = Read::scene(&scene);
    let roots: Vec<_> = read
        .document
        .default_scene()
        .unwrap()
        .nodes()
        .map(|node| node.index())
        .collect();
    assert_eq!(roots, [0, 5]);
    let holder = read.document.nodes().nth(5).unwrap();
    let skin = holder.skin().unwrap();
    assert_eq!(skin.skeleton().unwrap().index(), 0);
    let joints: Vec<_> = skin.joints().map(|joint| joint.index()).collect();
    assert_eq!(joints, [0, 1, 2, 3, 4]);

    let primitive = holder.mesh().unwrap().primitives().next().unwrap();
    assert!(
        primitive.get(&gltf::Semantic::Normals).is_none(),
        "flat faces need no normals"
    );
    let reader = primitive.reader(|_| Some(&read.bin));
    let vertices: Vec<_> = reader.read_positions().unwrap().map(Vec3::from).collect();
    let Some(ReadJoints::U8(vertex_joints)) = reader.read_joints(0) else {
        panic!("five joints fit 8 bits")
    };
    let Some(ReadWeights::U8(weights)) = reader.read_weights(0) else {
        panic!("weights are 8 bits")
    };
    let inverse_bind: Vec<_> = skin
        .reader(|_| Some(&read.bin))
        .read_inverse_bind_matrices()
        .unwrap()
        .collect();
    let world = read.world(0.25);
    let expected = world_of_scene(&scene, 30);
    for ((vertex, joint), weight) in vertices.iter().zip(vertex_joints).zip(weights) {
        assert_eq!((&joint[1..], weight), (&[0, 0, 0][..], [255, 0, 0, 0]));
        let joint = usize::from(joint[0]);
        let bind = Mat4::from_cols_array_2d(&inverse_bind[joint]).as_dmat4();
        let moved = (world[joint] * bind).transform_point3(vertex.as_dvec3());
        // The triangle of each joint has its corners at (0 0 0), (0 1 0) and (1 0 0) in the joint's space.
        let corners = [DVec3::ZERO, DVec3::Y, DVec3::X].map(|corner| expected[joint].transform_point3(corner));
        assert!(corners.iter().any(|corner| corner.distance(moved) < 1e-4), "{moved}");
    }

    // The corners run counter-clockwise around the normal of the scene's mesh.
    let indices: Vec<_> = reader
        .read_indices()
        .unwrap()
        .into_u32()
        .map(|index| vertices[index as usize])
        .collect();
    assert_eq!(indices.len(), 15);
    for face in indices.chunks_exact(3) {
        assert!((face[1] - face[0]).cross(face[2] - face[0]).z > 0.0);
    }
}

#[test]
fn rigid_meshes_stay_on_their_nodes_and_need_no_skin() {
    let mut scene = walker(3);
    for (place, index) in [0, 3].into_iter().enumerate() {
        scene.meshes.push(Mesh {
            vertices: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::X, Vec3::Y, Vec3::ONE],
            indices: (0..6).collect(),
            ..Mesh::default()
        });
        scene.nodes[index].meshes.push(place);
    }
    scene.materials.push(Material::default());
    let document = Document::new(&scene, &GltfOptions::default()).unwrap();
    assert_eq!(
        (document.report().joints, document.report().vertices),
        (0, 8),
        "equal vertices are joined"
    );
    let read = Read::glb(&document.to_glb().unwrap());
    assert_eq!(read.document.skins().len(), 0);
    let holders: Vec<_> = read
        .document
        .nodes()
        .filter(|node| node.mesh().is_some())
        .map(|n| n.index())
        .collect();
    assert_eq!(holders, [0, 3]);
}

/// Joints at one position have no link to draw. A client that needs a mesh for the skin gets a mesh that moves with the
/// joint.
#[test]
fn a_skeleton_without_extent_has_a_marker() {
    for kind in [SkeletonMesh::Skinned, SkeletonMesh::Segmented] {
        let centre = Vec3::new(1.0, 2.0, 3.0);
        let mut scene = Scene {
            nodes: vec![node("a", None, centre), node("b", Some(0), Vec3::ZERO)],
            ..Scene::default()
        };
        scene.add_skeleton_mesh(kind);
        let read = Read::scene(&scene);
        assert_eq!(read.document.skins().next().unwrap().joints().len(), 2);
        let holder = read.document.nodes().nth(2).unwrap();
        assert!(holder.skin().is_some());
        let primitive = holder.mesh().unwrap().primitives().next().unwrap();
        let reader = primitive.reader(|_| Some(&read.bin));
        let vertices: Vec<_> = reader.read_positions().unwrap().map(Vec3::from).collect();
        assert_eq!(vertices.len(), 6);
        let centre = Vec3::new(1.0, 2.0, 3.0);
        assert!(
            vertices
                .iter()
                .all(|vertex| (vertex.distance(centre) - 0.01).abs() < 1e-6)
        );
        let corners: Vec<_> = reader
            .read_indices()
            .unwrap()
            .into_u32()
            .map(|index| vertices[index as usize])
            .collect();
        assert_eq!(corners.len(), 24);
        for face in corners.chunks_exact(3) {
            let outward = (face[1] - face[0]).cross(face[2] - face[0]);
            assert!(outward.dot(face[0] - centre) > 0.0, "{face:?}");
        }
    }
}

#[test]
fn points_and_smooth_normals_are_kept() {
    let mut scene = walker(3);
    let cloud = Mesh {
        primitive: Primitive::Points,
        vertices: vec![Vec3::ZERO, Vec3::X, Vec3::X],
        indices: vec![0, 1, 2],
        ..Mesh::default()
    };
    let smooth = Mesh {
        vertices: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
        normals: vec![Vec3::Z, Vec3::new(0.6, 0.0, 0.8), Vec3::new(0.0, 0.6, 0.8)],
        indices: vec![0, 1, 2],
        ..Mesh::default()
    };
    scene.meshes = vec![cloud, smooth];
    scene.materials.push(Material::default());
    scene.nodes[1].meshes = vec![0, 1];
    let read = Read::scene(&scene);
    let mesh = read.document.nodes().nth(1).unwrap().mesh().unwrap();
    let primitives: Vec<_> = mesh.primitives().collect();
    assert_eq!(primitives[0].mode(), gltf::mesh::Mode::Points);
    assert_eq!(primitives[1].mode(), gltf::mesh::Mode::Triangles);
    let reader = primitives[1].reader(|_| Some(&read.bin));
    let normals: Vec<_> = reader.read_normals().unwrap().map(Vec3::from).collect();
    assert_eq!(normals, scene.meshes[1].normals);
}

#[test]
fn three_hundred_joints_have_16_bit_indices() {
    let nodes = (0..300)
        .map(|index: u32| node(&format!("j{index}"), index.checked_sub(1), Vec3::Y))
        .collect();
    let scene = with_skinned_mesh(Scene {
        nodes,
        ..Scene::default()
    });
    let read = Read::scene(&scene);
    let primitive = read.document.meshes().next().unwrap().primitives().next().unwrap();
    let Some(ReadJoints::U16(joints)) = primitive.reader(|_| Some(&read.bin)).read_joints(0) else {
        panic!("300 joints do not fit 8 bits")
    };
    let last = joints.map(|joints| joints[0]).max();
    assert_eq!(last, Some(299));
}

#[test]
fn the_four_joints_of_a_vertex_share_255() {
    let mut scene = with_skinned_mesh(walker(2));
    for (bone, weight) in scene.meshes[0].bones.iter_mut().zip([0.0, 0.3, 0.3, 0.2, 0.1001]) {
        bone.weights.retain(|tie| tie.vertex_id != 0);
        bone.weights.push(VertexWeight { vertex_id: 0, weight });
    }
    let read = Read::scene(&scene);
    let primitive = read.document.meshes().next().unwrap().primitives().next().unwrap();
    let reader = primitive.reader(|_| Some(&read.bin));
    let Some(ReadJoints::U8(mut joints)) = reader.read_joints(0) else {
        panic!("five joints fit 8 bits")
    };
    let Some(ReadWeights::U8(mut weights)) = reader.read_weights(0) else {
        panic!("weights are 8 bits")
    };
    assert_eq!(joints.next(), Some([1, 2, 3, 4]));
    // The weights 0.3, 0.3, 0.2 and 0.1001 of 0.9001, in 255ths.
    assert_eq!(weights.next(), Some([85, 85, 57, 28]));
}

#[test]
fn two_skeletons_share_one_skin_under_their_group() {
    let mut scene = walker(5);
    let group = Node {
        kind: NodeKind::Group,
        ..node("Roots", None, Vec3::ZERO)
    };
    scene.nodes.insert(0, group);
    for node in &mut scene.nodes[1..] {
        node.parent = Some(node.parent.map_or(NodeId(0), |parent| NodeId(parent.0 + 1)));
    }
    scene.nodes.push(node("Prop", Some(0), Vec3::X));
    let scene = with_skinned_mesh(scene);
    let read = Read::scene(&scene);
    let skin = read.document.skins().next().unwrap();
    assert_eq!(skin.skeleton().unwrap().name(), Some("Roots"));
    let joints: Vec<_> = skin.joints().map(|joint| joint.index()).collect();
    assert_eq!(joints, [1, 2, 3, 4, 5, 6]);
    assert_same_motion(&scene, &read, 5, 170.0 * 1e-6);
}
