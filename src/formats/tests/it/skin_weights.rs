//! Vertices in glTF that more than four bones move.

use mocap::glam::{Mat4, Vec3};
use mocap::gltf::GltfOptions;
use mocap::scene::{Bone, Mesh, Node, NodeId, NodeKind, VertexWeight};
use mocap::{Importer, Pose, Scene};

/// The position of a vertex of the first mesh.
fn vertex(scene: &Scene, pose: &Pose, vertex: u32) -> Vec3 {
    let mesh = &scene.meshes[0];
    let moved = mesh.bones.iter().flat_map(|bone| {
        let matrix = pose.node_to_world[bone.node.index()] * bone.offset_matrix;
        let ties = bone.weights.iter().filter(move |tie| tie.vertex_id == vertex);
        ties.map(move |tie| tie.weight * matrix.transform_point3(mesh.vertices[vertex as usize]))
    });
    moved.sum()
}

fn through_glb(scene: &Scene) -> Scene {
    let glb = GltfOptions::default().write_glb(scene).unwrap();
    Importer::new().gltf_meshes(true).read(&glb, "written.glb").unwrap()
}

/// The sets of weights of the first primitive, as the crate `gltf` reads them.
fn sets(scene: &Scene) -> usize {
    let glb = GltfOptions::default().write_glb(scene).unwrap();
    let gltf::Gltf { document, blob } = gltf::Gltf::from_slice(&glb).unwrap();
    let buffer = blob.unwrap();
    let primitive = document.meshes().next().unwrap().primitives().next().unwrap();
    let reader = primitive.reader(|_| Some(&buffer));
    let of_set = |set| Some(reader.read_weights(set)?.into_f32().collect::<Vec<_>>());
    let all: Vec<_> = (0..).map_while(of_set).collect();
    for vertex in 0..all[0].len() {
        let sum: f32 = all.iter().flat_map(|set| set[vertex]).sum();
        assert!((sum - 1.0).abs() < 1e-6, "{sum}");
    }
    all.len()
}

/// Six bones move by (1, 0, 0), (2, 1, 0) and so on. The script next to the file computes the sum.
#[test]
fn six_bones_move_a_vertex_of_a_written_file() {
    let scene = mocap::import("../../fixtures/made/six_influences.fbx").unwrap();
    assert_eq!(sets(&scene), 2);
    for scene in [&scene, &through_glb(&scene)] {
        let second = scene.animations[0].ticks_per_second;
        let pose = Pose::at_tick(scene, 0, second).unwrap();
        let found = vertex(scene, &pose, 0);
        assert!(found.abs_diff_eq(Vec3::new(3.1, 1.4, 0.0), 1e-3), "{found}");
    }
}

/// Nine bones in three sets, with weights of 1/45, 2/45 and so on. Each bone moves the vertex by another amount.
#[test]
fn nine_bones_take_three_sets() {
    let mut scene = Scene::default();
    let named = |name: String, parent, x: f32| Node {
        name,
        kind: NodeKind::Joint,
        parent,
        transform: Mat4::from_translation(Vec3::X * x),
        ..Node::default()
    };
    scene.nodes.push(named("Root".to_owned(), None, 0.0));
    let mut mesh = Mesh {
        name: "Triangle".to_owned(),
        vertices: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
        indices: vec![0, 1, 2],
        ..Mesh::default()
    };
    for bone in 1..=9u16 {
        let node = NodeId::new(scene.nodes.len());
        scene
            .nodes
            .push(named(format!("Bone{bone}"), Some(NodeId::new(0)), f32::from(bone)));
        let weights = (0..3).map(|vertex_id| VertexWeight {
            vertex_id,
            weight: f32::from(bone) / 45.0,
        });
        mesh.bones.push(Bone {
            name: format!("Bone{bone}"),
            node,
            offset_matrix: Mat4::IDENTITY,
            weights: weights.collect(),
        });
    }
    scene.nodes[0].meshes.push(0);
    scene.meshes.push(mesh);
    scene.materials.push(mocap::scene::Material::default());
    scene.metadata.metres_per_unit = Some(1.0);
    assert_eq!(sets(&scene), 3);
    let again = through_glb(&scene);
    let found = vertex(&again, &Pose::rest(&again), 0);
    // The sum of the squares of 1 to 9, divided by 45.
    assert!(found.abs_diff_eq(Vec3::X * (285.0 / 45.0), 1e-3), "{found}");
}

/// A scene blends matrices, and warns about a file that blends dual quaternions.
#[test]
fn dual_quaternions_that_become_linear_are_told() {
    let linear = crate::fbx::textured("", "");
    let notes = |text: &str| -> Vec<String> {
        let scene = Importer::new().read(text.as_bytes(), "bar.fbx").unwrap();
        assert!(!scene.meshes.is_empty());
        let notes = scene.metadata.assumptions.iter().map(ToString::to_string);
        notes.filter(|note| note.contains("dual quaternions")).collect()
    };
    assert_eq!(notes(&linear), Vec::<String>::new());
    for (method, count) in [("Linear", 0), ("DualQuaternion", 1), ("Blend", 1)] {
        let skin = "Deformer: 4, \"Deformer::\", \"Skin\" {";
        let stated = linear.replace(skin, &format!("{skin}\n\t\tSkinningType: \"{method}\""));
        assert_ne!(stated, linear);
        assert_eq!(notes(&stated).len(), count, "{method}");
    }
}
