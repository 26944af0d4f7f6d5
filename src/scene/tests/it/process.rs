//! The processing steps, on scenes that are built here.

mod collapse_keys;

use mocap::glam::{Mat4, Quat, Vec3};
use mocap::process::SkeletonMesh;
use mocap::scene::{Bone, Material, Mesh, Node, NodeId, NodeKind, Primitive, Scene, VertexWeight};
use proptest::prelude::*;

/// Nodes at rest; each row has the name, the index of the parent and the offset.
fn skeleton(nodes: &[(&str, Option<usize>, [f32; 3])]) -> Scene {
    let nodes = nodes.iter().map(|&(name, parent, offset)| Node {
        name: name.to_owned(),
        parent: parent.map(NodeId::new),
        transform: Mat4::from_translation(offset.into()),
        ..Node::default()
    });
    Scene {
        nodes: nodes.collect(),
        ..Scene::default()
    }
}

/// The skeleton of the lecture: `Shoulder -- 2 --> Elbow -- 1.5 --> Wrist -- 0.5 --> EndSite_Wrist`.
fn arm() -> Scene {
    skeleton(&[
        ("Shoulder", None, [0.0, 0.0, 0.0]),
        ("Elbow", Some(0), [2.0, 0.0, 0.0]),
        ("Wrist", Some(1), [1.5, 0.0, 0.0]),
        ("EndSite_Wrist", Some(2), [0.5, 0.0, 0.0]),
    ])
}

fn with_mesh(mut scene: Scene, kind: SkeletonMesh) -> Scene {
    scene.add_skeleton_mesh(kind);
    scene
}

fn meshes_of_nodes(scene: &Scene) -> Vec<Vec<usize>> {
    scene.nodes.iter().map(|node| node.meshes.clone()).collect()
}

/// For each mesh: the numbers of vertices, faces and bones.
fn counts(scene: &Scene) -> Vec<[usize; 3]> {
    let count = |mesh: &Mesh| [mesh.vertices.len(), mesh.faces().len(), mesh.bones.len()];
    scene.meshes.iter().map(count).collect()
}

mod skeleton_meshes {
    use super::*;

    #[test]
    fn segmented_hangs_each_piece_on_its_node() {
        let scene = with_mesh(arm(), SkeletonMesh::Segmented);
        assert_eq!(meshes_of_nodes(&scene), [[0], [1], [2], [3]]);
        assert_eq!(counts(&scene), [[12, 4, 0], [12, 4, 0], [12, 4, 0], [24, 8, 0]]);
        assert_eq!(scene.materials[0].name, "SkeletonMaterial");
        assert!(scene.materials[0].two_sided);
        let knob = &scene.meshes[3];
        assert!(
            knob.vertices
                .iter()
                .all(|vertex| (vertex.length() - 0.5 * 0.18).abs() < 1e-7)
        );
    }

    #[test]
    fn skinned_is_one_mesh_on_the_root_with_a_bone_a_piece() {
        let scene = with_mesh(arm(), SkeletonMesh::Skinned);
        assert_eq!(meshes_of_nodes(&scene), [vec![0], vec![], vec![], vec![]]);
        assert_eq!(counts(&scene), [[60, 20, 4]]);
        let bones: Vec<_> = scene.meshes[0]
            .bones
            .iter()
            .map(|bone| (bone.node.index(), bone.weights.len()))
            .collect();
        assert_eq!(bones, [(0, 12), (1, 12), (2, 12), (3, 24)]);
        let wrist = &scene.meshes[0].bones[2];
        assert_eq!(wrist.offset_matrix, Mat4::from_translation(Vec3::new(-3.5, 0.0, 0.0)));
    }

    #[test]
    fn a_node_whose_children_stand_in_its_place_has_no_piece() {
        let twins = [
            ("Hips", None, [0.0; 3]),
            ("L", Some(0), [0.0; 3]),
            ("Tip", Some(1), [1.0, 0.0, 0.0]),
        ];
        let segmented = with_mesh(skeleton(&twins), SkeletonMesh::Segmented);
        assert_eq!(meshes_of_nodes(&segmented), [vec![], vec![0], vec![1]]);
        let skinned = with_mesh(skeleton(&twins), SkeletonMesh::Skinned);
        assert_eq!(counts(&skinned), [[36, 12, 2]]);
    }

    /// The points of a C3D file are children of a group, far from the group's position.
    #[test]
    fn a_group_has_no_pointers_and_its_points_small_knobs() {
        let mut scene = skeleton(&[
            ("Markers", None, [0.0, 0.0, 0.0]),
            ("LASI", Some(0), [900.0, 1000.0, 900.0]),
            ("RASI", Some(0), [900.0, 1000.0, 1100.0]),
        ]);
        scene.nodes[0].kind = NodeKind::Group;
        scene.add_skeleton_mesh(SkeletonMesh::Segmented);
        assert_eq!(meshes_of_nodes(&scene), [vec![], vec![0], vec![1]]);
        // A hundredth of the distance between the two points, which is 200.
        let is_tip = |vertex: &Vec3| (vertex.length() - 2.0).abs() < 1e-5;
        assert!(scene.meshes.iter().all(|mesh| mesh.vertices.iter().all(is_tip)));
    }

    #[test]
    fn nothing_to_draw_is_no_mesh() {
        for kind in [SkeletonMesh::Segmented, SkeletonMesh::Skinned] {
            assert_eq!(with_mesh(Scene::default(), kind), Scene::default());
            let stacked = skeleton(&[
                ("a", None, [0.0; 3]),
                ("b", Some(0), [0.0; 3]),
                ("c", Some(1), [1e-7, 0.0, 0.0]),
            ]);
            let scene = with_mesh(stacked, kind);
            // Both links are too short for a pointer, but the free end still has its knob.
            assert_eq!(scene.meshes.len(), 1);
            assert_eq!(scene.meshes[0].vertices.len(), 24);
        }
        assert_eq!(with_mesh(arm(), SkeletonMesh::None), arm());
    }

    #[test]
    fn bones_undo_a_rest_pose_that_turns() {
        let mut scene = arm();
        scene.nodes[1].transform =
            Mat4::from_rotation_translation(Quat::from_rotation_z(0.5), Vec3::new(2.0, 0.0, 0.0));
        scene.nodes[2].transform =
            Mat4::from_rotation_translation(Quat::from_rotation_x(0.7), Vec3::new(1.5, 0.0, 0.0));
        let node_to_world = scene.nodes[..3]
            .iter()
            .fold(Mat4::IDENTITY, |product, node| product * node.transform);
        scene.add_skeleton_mesh(SkeletonMesh::Skinned);
        let wrist = &scene.meshes[0].bones[2];
        assert!((wrist.offset_matrix * node_to_world).abs_diff_eq(Mat4::IDENTITY, 1e-6));
        assert_eq!(scene.validate(), []);
    }

    #[test]
    fn huge_and_tiny_links_stay_finite_and_their_normals_unit() {
        for length in [1e-20, 1e-6, 1e-3, 1e3, 1e15, 1e30] {
            let chain = [
                ("a", None, [0.0; 3]),
                ("b", Some(0), [0.0, length, 0.0]),
                ("c", Some(1), [length; 3]),
            ];
            let scene = with_mesh(skeleton(&chain), SkeletonMesh::Segmented);
            assert_eq!(scene.validate(), [], "{length}");
        }
    }
}

mod deboned {
    use super::*;

    #[test]
    fn the_arm_is_the_segmented_arm() {
        let mut scene = with_mesh(arm(), SkeletonMesh::Skinned);
        scene.debone();
        assert_same_within_rounding(&scene, &with_mesh(arm(), SkeletonMesh::Segmented));
    }

    #[test]
    fn a_part_within_a_hundredth_of_the_origin_is_transformed_too() {
        let small = [("a", None, [0.005, 0.0, 0.0]), ("b", Some(0), [0.004, 0.0, 0.0])];
        let mut scene = with_mesh(skeleton(&small), SkeletonMesh::Skinned);
        scene.debone();
        assert_same_within_rounding(&scene, &with_mesh(skeleton(&small), SkeletonMesh::Segmented));
    }

    /// Three triangles in a row: the first follows `a`, the second mixes `a` and `b`, the third follows `c`.
    #[test]
    fn a_face_that_two_bones_move_keeps_both() {
        let bone = |index: usize, name: &str, vertices: &[u32]| Bone {
            name: name.to_owned(),
            node: NodeId::new(index),
            offset_matrix: Mat4::from_translation(Vec3::new(-(index as f32), 0.0, 0.0)),
            weights: vertices
                .iter()
                .map(|&vertex_id| VertexWeight { vertex_id, weight: 1.0 })
                .collect(),
        };
        let mut scene = skeleton(&[
            ("a", None, [0.0; 3]),
            ("b", Some(0), [1.0, 0.0, 0.0]),
            ("c", Some(1), [1.0, 0.0, 0.0]),
        ]);
        scene.materials.push(Material::default());
        scene.nodes[0].meshes.push(0);
        scene.meshes.push(Mesh {
            vertices: (0..9).map(|x| Vec3::new(x as f32, (x % 3) as f32, 0.0)).collect(),
            normals: vec![Vec3::Z; 9],
            indices: (0..9).collect(),
            bones: vec![
                bone(0, "a", &[0, 1, 2, 3]),
                bone(1, "b", &[4, 5]),
                bone(2, "c", &[6, 7, 8]),
            ],
            ..Mesh::default()
        });
        assert_eq!(scene.validate(), []);
        scene.debone();
        assert_eq!(scene.validate(), []);
        assert_eq!(meshes_of_nodes(&scene), [vec![0], vec![], vec![1]]);
        assert_eq!(counts(&scene), [[6, 2, 2], [3, 1, 0]]);
        assert_eq!(scene.meshes[0].bones[1].weights[0].vertex_id, 4);
        assert_eq!(scene.meshes[1].vertices[0], Vec3::new(4.0, 0.0, 0.0));
    }
}

mod joined {
    use super::*;

    #[test]
    fn equal_children_share_their_pointer() {
        let three = [
            ("Chest", None, [0.0; 3]),
            ("Neck", Some(0), [0.0, 5.0, 0.0]),
            ("LCollar", Some(0), [0.0, 5.0, 0.0]),
            ("RCollar", Some(0), [0.0, 5.0, 0.0]),
        ];
        let mut scene = with_mesh(skeleton(&three), SkeletonMesh::Segmented);
        assert_eq!(counts(&scene)[0], [36, 12, 0]);
        scene.join_identical_vertices();
        assert_eq!(counts(&scene)[0], [12, 12, 0]);
        assert_eq!(scene.meshes[0].indices[..3], scene.meshes[0].indices[12..15]);
        assert_eq!(scene.validate(), []);
    }

    /// `P` has the links `P -> B` and `P -> A`. `A` is at the position of `P`, and has the link `A -> C`. So two
    /// pointers start at one position.
    #[test]
    fn vertices_of_different_bones_stay_apart() {
        let twins = [
            ("P", None, [0.0; 3]),
            ("A", Some(0), [0.0; 3]),
            ("C", Some(1), [0.0, 3.0, 0.0]),
            ("B", Some(0), [0.0, 3.0, 0.0]),
        ];
        let mut scene = with_mesh(skeleton(&twins), SkeletonMesh::Skinned);
        let before = scene.clone();
        scene.join_identical_vertices();
        assert_eq!(scene, before);
    }
}

mod degenerates {
    use super::*;

    #[test]
    fn knobs_without_a_size_in_several_places_stay_points() {
        let nodes = [
            ("Wrist", None, [0.0; 3]),
            ("Thumb", Some(0), [1.0, 0.0, 0.0]),
            ("EndSite_Thumb", Some(1), [0.0; 3]),
            ("Finger", Some(0), [0.0, 1.0, 0.0]),
            ("EndSite_Finger", Some(3), [0.0; 3]),
        ];
        let mut scene = with_mesh(skeleton(&nodes), SkeletonMesh::Skinned);
        scene.find_degenerates();
        scene.remove_sizeless_meshes();
        assert_eq!(counts(&scene), [[16, 16, 2], [24, 8, 1]]);
        scene.debone();
        assert_eq!(meshes_of_nodes(&scene), [vec![2], vec![], vec![0], vec![], vec![1]]);
    }

    #[test]
    fn a_knob_without_a_size_becomes_points_and_goes() {
        let nodes = [
            ("Wrist", None, [0.0; 3]),
            ("Thumb", Some(0), [1.0, 0.0, 0.0]),
            ("EndSite_Thumb", Some(1), [0.0; 3]),
        ];
        let mut scene = with_mesh(skeleton(&nodes), SkeletonMesh::Skinned);
        assert_eq!(counts(&scene), [[36, 12, 2]]);
        scene.find_degenerates();
        assert_eq!(counts(&scene), [[8, 8, 1], [12, 4, 1]]);
        assert_eq!(scene.meshes[0].primitive, Primitive::Points);
        assert_eq!(scene.nodes[0].meshes, [0, 1]);
        assert_eq!(scene.validate(), []);
        scene.remove_sizeless_meshes();
        assert_eq!(counts(&scene), [[12, 4, 1]]);
        assert_eq!(meshes_of_nodes(&scene), [vec![0], vec![], vec![]]);
    }

    #[test]
    fn a_scene_without_degenerate_triangles_stays() {
        let mut scene = with_mesh(arm(), SkeletonMesh::Skinned);
        let before = scene.clone();
        scene.find_degenerates();
        scene.remove_sizeless_meshes();
        assert_eq!(scene, before);
    }

    #[test]
    fn segments_without_a_size_go_and_the_others_move_up() {
        let nodes = [
            ("Root", None, [0.0; 3]),
            ("Zero", Some(0), [0.0; 3]),
            ("Tip", Some(0), [1.0, 0.0, 0.0]),
        ];
        let mut scene = with_mesh(skeleton(&nodes), SkeletonMesh::Segmented);
        assert_eq!(meshes_of_nodes(&scene), [[0], [1], [2]]);
        scene.remove_sizeless_meshes();
        assert_eq!(meshes_of_nodes(&scene), [vec![0], vec![], vec![1]]);
        assert_eq!(scene.meshes.len(), 2);
    }
}

/// Equal except for the last digits, which the transform through the space of the whole mesh changes.
fn assert_same_within_rounding(a: &Scene, b: &Scene) {
    assert_eq!(meshes_of_nodes(a), meshes_of_nodes(b));
    assert_eq!(counts(a), counts(b));
    for (mesh, other) in a.meshes.iter().zip(&b.meshes) {
        assert_eq!(mesh.indices, other.indices);
        for (vertex, other) in mesh.vertices.iter().zip(&other.vertices) {
            assert!(vertex.abs_diff_eq(*other, 1e-4), "{vertex} {other}");
        }
        for (normal, other) in mesh.normals.iter().zip(&other.normals) {
            assert!(normal.abs_diff_eq(*other, 1e-5), "{normal} {other}");
        }
    }
}

prop_compose! {
    /// Up to 30 nodes in depth-first order. Offsets are often zero, and often equal.
    fn any_skeleton()(links in prop::collection::vec((0usize..4, prop::array::uniform3(-2i8..3)), 1..30)) -> Scene {
        let mut scene = Scene::default();
        let mut path = Vec::new();
        for (index, (up, offset)) in links.into_iter().enumerate() {
            let depth = path.len().saturating_sub(up).max(1).min(path.len());
            path.truncate(depth);
            scene.nodes.push(Node {
                name: format!("node {index}"),
                parent: path.last().copied().map(NodeId::new),
                transform: Mat4::from_translation(Vec3::from(offset.map(f32::from)) * 7.3),
                ..Node::default()
            });
            path.push(index);
        }
        scene
    }
}

proptest! {
    #[test]
    fn debone_turns_skinned_into_segmented(skeleton in any_skeleton()) {
        let mut deboned = with_mesh(skeleton.clone(), SkeletonMesh::Skinned);
        prop_assert_eq!(deboned.validate(), []);
        deboned.debone();
        prop_assert_eq!(deboned.validate(), []);
        assert_same_within_rounding(&deboned, &with_mesh(skeleton, SkeletonMesh::Segmented));
    }

    #[test]
    fn every_step_leaves_a_valid_scene_valid(skeleton in any_skeleton()) {
        for kind in [SkeletonMesh::Segmented, SkeletonMesh::Skinned] {
            let mut scene = with_mesh(skeleton.clone(), kind);
            let steps = [
                Scene::find_degenerates,
                Scene::remove_sizeless_meshes,
                Scene::join_identical_vertices,
                Scene::debone,
            ];
            for step in steps {
                step(&mut scene);
                prop_assert_eq!(scene.validate(), []);
            }
        }
    }

    /// Joining changes the storage of corners, not their positions.
    #[test]
    fn joined_faces_have_the_same_corners(skeleton in any_skeleton()) {
        let before = with_mesh(skeleton, SkeletonMesh::Skinned);
        let mut after = before.clone();
        after.join_identical_vertices();
        let corners = |scene: &Scene| -> Vec<Vec3> {
            let meshes = scene.meshes.iter();
            meshes.flat_map(|mesh| mesh.indices.iter().map(|&index| mesh.vertices[index as usize])).collect()
        };
        prop_assert_eq!(corners(&before), corners(&after));
    }
}
