//! Joints of the skin whose parents are not the joints that they follow.

use std::collections::BTreeMap;

use glam::{Mat4, Vec3};
use mocap::scene::{Bone, Mesh, Node, NodeId, NodeKind, VertexWeight};
use mocap::{Importer, Scene};
use mocap_figure::rig::Rig;

/// Joints with their parents and positions.
fn skeleton(joints: &[(&str, Option<usize>, [f32; 3])]) -> Scene {
    let at = |joint: usize| Vec3::from(joints[joint].2);
    let nodes = joints.iter().enumerate().map(|(index, (name, parent, _))| Node {
        name: (*name).to_owned(),
        parent: parent.map(NodeId::new),
        transform: Mat4::from_translation(at(index) - parent.map_or(Vec3::ZERO, at)),
        kind: if name.ends_with("End") {
            NodeKind::EndSite
        } else {
            NodeKind::Joint
        },
        ..Node::default()
    });
    Scene {
        nodes: nodes.collect(),
        ..Scene::default()
    }
}

/// A mesh with one triangle at each joint, which only this joint moves.
fn triangles(scene: &mut Scene, name: &str, at: &[(usize, [f32; 3])]) {
    let mut mesh = Mesh {
        name: name.to_owned(),
        ..Mesh::default()
    };
    let mut world: Vec<Vec3> = Vec::new();
    for node in &scene.nodes {
        let above = node.parent.map_or(Vec3::ZERO, |parent| world[parent.index()]);
        world.push(above + node.transform.w_axis.truncate());
    }
    for (joint, place) in at {
        let first = mesh.vertices.len() as u32;
        mesh.vertices
            .extend([Vec3::ZERO, 0.01 * Vec3::X, 0.01 * Vec3::Y].map(|offset| Vec3::from(*place) + offset));
        mesh.indices.extend(first..first + 3);
        mesh.bones.push(Bone {
            name: scene.nodes[*joint].name.clone(),
            node: NodeId::new(*joint),
            offset_matrix: Mat4::from_translation(-world[*joint]),
            weights: (first..first + 3)
                .map(|vertex_id| VertexWeight { vertex_id, weight: 1.0 })
                .collect(),
        });
    }
    scene.meshes.push(mesh);
}

fn followers(scene: &Scene) -> Vec<(String, String)> {
    let name = |node: NodeId| scene.nodes[node.index()].name.clone();
    let rig = Rig::new(scene, &BTreeMap::new());
    let followers = rig.iter().flat_map(Rig::followers);
    followers.map(|(joint, other)| (name(joint), name(other))).collect()
}

#[test]
fn joints_of_intact_rigs_follow_their_parents() {
    let folders = ["characters", "skeletons", "real", "dialects"];
    let mut tried = 0;
    for folder in folders {
        for file in std::fs::read_dir(format!("../../fixtures/{folder}")).unwrap() {
            let path = file.unwrap().path();
            let Ok(scene) = Importer::new().gltf_meshes(true).import(&path) else {
                continue;
            };
            assert_eq!(followers(&scene), [], "{}", path.display());
            tried += 1;
        }
    }
    assert!(tried > 30, "{tried}");
}

#[test]
fn a_hat_follows_the_head_and_what_lies_on_the_ground_nothing() {
    let body = [
        ("Root", None, [0.0, 0.0, 0.0]),
        ("Hips", Some(0), [0.0, 1.0, 0.0]),
        ("Spine", Some(1), [0.0, 1.2, 0.0]),
        ("Head", Some(2), [0.0, 1.6, 0.0]),
        ("Hat", Some(0), [0.0, 1.8, 0.0]),
        ("Box", Some(0), [1.0, 0.0, 0.0]),
    ];
    let mut scene = skeleton(&body);
    let of_body = [(1, [0.0, 1.0, 0.1]), (2, [0.0, 1.3, 0.1]), (3, [0.0, 1.75, 0.1])];
    triangles(&mut scene, "body", &of_body);
    triangles(&mut scene, "hat", &[(4, [0.0, 1.8, 0.1])]);
    triangles(&mut scene, "box", &[(5, [1.0, 0.0, 0.0])]);
    assert_eq!(followers(&scene), [("Hat".to_owned(), "Head".to_owned())]);
}

#[test]
fn a_foot_without_a_skin_follows_the_shin_that_ends_there() {
    let legs = [
        ("Root", None, [0.0, 0.0, 0.0]),
        ("Hips", Some(0), [0.0, 1.0, 0.0]),
        ("Thigh", Some(1), [0.1, 0.9, 0.0]),
        ("Shin", Some(2), [0.1, 0.5, 0.0]),
        ("ShinEnd", Some(3), [0.1, 0.1, 0.0]),
        ("Foot", Some(0), [0.1, 0.1, 0.0]),
        ("FootEnd", Some(5), [0.1, 0.0, 0.1]),
        ("Pole", Some(0), [0.1, 0.5, 0.5]),
    ];
    let scene = skeleton(&legs);
    assert_eq!(followers(&scene), [("Foot".to_owned(), "Shin".to_owned())]);
    // The rest pose of the rig equals the rest pose of the file.
    let rig = Rig::new(&scene, &BTreeMap::new()).unwrap();
    let (rest, in_rig) = (mocap::Pose::rest(&scene), mocap::Pose::rest(&rig.scene));
    for node in (0..legs.len()).map(NodeId::new) {
        assert!(in_rig.position(rig.node(node)).abs_diff_eq(rest.position(node), 1e-6));
    }
}
