//! The rules of the scene, each violated in turn.

use mocap::glam::{Mat4, Quat, Vec3};
use mocap::process::SkeletonMesh;
use mocap::process::report::Rule;
use mocap::scene::{Animation, Channel, Keys, Node, NodeId, Scene, VertexWeight};

fn animated_arm() -> Scene {
    let joint = |name: &str, parent: Option<u32>, x: f32| Node {
        name: name.to_owned(),
        parent: parent.map(NodeId),
        transform: Mat4::from_translation(Vec3::new(x, 0.0, 0.0)),
        ..Node::default()
    };
    let mut scene = Scene {
        nodes: vec![
            joint("Shoulder", None, 0.0),
            joint("Elbow", Some(0), 2.0),
            joint("Wrist", Some(1), 1.5),
            joint("EndSite_Wrist", Some(2), 0.5),
        ],
        ..Scene::default()
    };
    scene.add_skeleton_mesh(SkeletonMesh::Skinned);
    scene.animations.push(Animation {
        ticks_per_second: 10.0,
        duration: 2.0,
        channels: vec![Channel {
            node_name: "Elbow".to_owned(),
            node: None,
            position_keys: Keys::constant(Vec3::X),
            rotation_keys: Keys {
                values: vec![Quat::IDENTITY; 2],
                ticks: Some(vec![0.0, 2.0]),
            },
            scaling_keys: Keys::constant(Vec3::ONE),
        }],
        ..Animation::default()
    });
    scene
}

fn channel(scene: &mut Scene) -> &mut Channel {
    &mut scene.animations[0].channels[0]
}

type Break = (Rule, fn(&mut Scene));

/// A violation of each rule.
const BREAKS: &[Break] = &[
    (Rule::OneRoot, |scene| scene.nodes[2].parent = None),
    (Rule::DepthFirst, |scene| scene.nodes[1].parent = Some(NodeId(3))),
    (Rule::NodeTransform, |scene| scene.nodes[1].transform.x_axis.w = 1.0),
    (Rule::NodeTransform, |scene| {
        scene.nodes[1].transform.x_axis.x = f32::NAN;
    }),
    (Rule::NodeMeshes, |scene| scene.nodes[1].meshes.push(1)),
    (Rule::NodeMeshes, |scene| scene.nodes[0].meshes.push(0)),
    (Rule::MeshMaterial, |scene| scene.materials.clear()),
    (Rule::MeshNormals, |scene| scene.meshes[0].normals[7] *= 1.01),
    (Rule::MeshNormals, |scene| scene.meshes[0].normals.truncate(59)),
    (Rule::MeshVertices, |scene| {
        scene.meshes[0].vertices[0].x = f32::INFINITY;
    }),
    (Rule::MeshIndices, |scene| scene.meshes[0].indices[0] = 60),
    (Rule::MeshIndices, |scene| scene.meshes[0].indices.truncate(59)),
    (Rule::BoneNode, |scene| scene.meshes[0].bones[1].node = NodeId(9)),
    (Rule::BoneNode, |scene| scene.meshes[0].bones[1].name.push('x')),
    (Rule::BoneOffset, |scene| {
        scene.meshes[0].bones[1].offset_matrix.x_axis.x = 0.0;
    }),
    (Rule::BoneWeights, |scene| {
        scene.meshes[0].bones[1].weights.push(VertexWeight {
            vertex_id: 99,
            weight: 1.0,
        });
    }),
    (Rule::WeightSum, |scene| {
        scene.meshes[0].bones[1].weights[0].weight = 0.5;
    }),
    (Rule::AnimationTime, |scene| scene.animations[0].ticks_per_second = 0.0),
    (Rule::AnimationTime, |scene| {
        scene.animations[0].duration = f64::INFINITY;
    }),
    (Rule::ChannelNode, |scene| channel(scene).node_name.push('x')),
    (Rule::ChannelNode, |scene| channel(scene).node = Some(NodeId(0))),
    (Rule::ChannelNode, |scene| channel(scene).node = Some(NodeId(99))),
    (Rule::ChannelNode, |scene| {
        let second = channel(scene).clone();
        scene.animations[0].channels.push(second);
    }),
    (Rule::KeyTicks, |scene| {
        channel(scene).rotation_keys.ticks = Some(vec![1.0, 1.0]);
    }),
    (Rule::KeyTicks, |scene| {
        channel(scene).rotation_keys.ticks = Some(vec![1.0]);
    }),
    (Rule::KeyTicks, |scene| {
        channel(scene).rotation_keys.ticks = Some(vec![1.0, 2.5]);
    }),
    (Rule::KeyTicks, |scene| {
        channel(scene).scaling_keys = Keys::every_tick(vec![Vec3::ONE; 4]);
    }),
    (Rule::KeyValues, |scene| {
        channel(scene).position_keys.values[0].z = f32::NAN;
    }),
    (Rule::UnitRotations, |scene| {
        channel(scene).rotation_keys.values[1] = Quat::from_xyzw(0.0, 0.0, 0.0, 1.01);
    }),
];

#[test]
fn each_rule_names_what_breaks_it_and_nothing_else_does() {
    assert_eq!(animated_arm().validate(), []);
    for (rule, break_it) in BREAKS {
        let mut scene = animated_arm();
        break_it(&mut scene);
        let rules: Vec<Rule> = scene.validate().iter().map(|violation| violation.rule).collect();
        assert_eq!(rules, [*rule]);
    }
}

#[test]
fn every_rule_is_tested_and_numbered_in_order() {
    for (index, rule) in Rule::ALL.iter().enumerate() {
        assert_eq!(rule.number() as usize, index + 1);
        assert!(BREAKS.iter().any(|(broken, _)| broken == rule), "{rule}");
    }
}
