//! Tests of `--bone-axis`: joint axes along bones in the outputs of jobs.

use mocap::glam::{Mat4, Vec3};
use mocap::job::Job;

use mocap::scene::NodeId;
use mocap::{Binding, Importer, Pose, Scene};
use serde_json::{Value, json};

fn made(job: &Value) -> Scene {
    let (written, _) = Job::from_json(&job.to_string()).unwrap().make(&[]).unwrap();
    let name = job["write"]["output"].as_str().unwrap();
    let bytes = written.into_bytes().unwrap();
    Importer::new().gltf_meshes(true).read(&bytes, name).unwrap()
}

/// The largest angle in degrees between +Y of a joint and the line to its only child.
fn off_child(scene: &Scene) -> f32 {
    let rest = Pose::rest(scene);
    let mut farthest = 0.0_f32;
    for index in 0..scene.nodes.len() {
        let node = NodeId::new(index);
        let mut children = (0..scene.nodes.len()).filter(|child| scene.nodes[*child].parent == Some(node));
        let (Some(child), None) = (children.next(), children.next()) else {
            continue;
        };
        let line = rest.position(NodeId::new(child)) - rest.position(node);
        let is_group = scene.nodes[index].kind == mocap::scene::NodeKind::Group;
        if line.length() > 1e-3 && !is_group {
            let y = rest.node_to_world[index].y_axis.truncate();
            farthest = farthest.max(y.angle_between(line).to_degrees());
        }
    }
    farthest
}

/// The vertices of all skins at a tick, by the weighted sum of the matrices of their bones.
fn vertices(scene: &Scene, tick: f64) -> Vec<Vec3> {
    let animation = &scene.animations[0];
    let mut pose = Pose::rest(scene);
    pose.sample(&Binding::new(scene, animation), animation, tick);
    let mut all = Vec::new();
    for mesh in scene.meshes.iter().filter(|mesh| !mesh.bones.is_empty()) {
        let mut matrices = vec![Mat4::ZERO; mesh.vertices.len()];
        for bone in &mesh.bones {
            let matrix = pose.node_to_world[bone.node.index()] * bone.offset_matrix;
            for weight in &bone.weights {
                matrices[weight.vertex_id as usize] += weight.weight * matrix;
            }
        }
        let moved = mesh.vertices.iter().zip(matrices);
        all.extend(moved.map(|(vertex, matrix)| matrix.transform_point3(*vertex)));
    }
    all
}

#[test]
fn a_motion_is_written_with_bones_along_y() {
    for (write, allowed) in [
        (json!({"output": "a.glb", "bone-axis": "y"}), 0.1),
        (json!({"output": "a.fbx", "bone-axis": "y"}), 0.1),
        (json!({"output": "a.fbx", "fbx": {"target": "blender"}}), 0.1),
        (json!({"output": "a.fbx", "fbx": {"target": "unreal"}}), 180.0),
        (
            json!({"output": "a.fbx", "bone-axis": "none", "fbx": {"target": "blender"}}),
            180.0,
        ),
    ] {
        let found = off_child(&made(
            &json!({"source": {"inputs": ["../../fixtures/real/cmu_short.bvh"]}, "write": write}),
        ));
        assert!(found <= allowed && (allowed < 1.0 || found > 80.0), "{write}: {found}");
    }
}

/// The joint frames of a skinned character change, and its bind pose changes with them. Every vertex keeps its
/// position.
#[test]
fn a_skin_deforms_as_without_it() {
    let onto = |axis: &str| {
        made(&json!({
            "source": {"inputs": ["../../fixtures/real/cmu_short.bvh"]},
            "target": {"character": {"file": "../../fixtures/characters/human_game_engine.glb"}},
            "write": {"output": "a.fbx", "bone-axis": axis},
        }))
    };
    let (plain, along) = (onto("none"), onto("y"));
    assert!(off_child(&plain) > 10.0 && off_child(&along) < 0.1);
    for tick in [0.0, 20.5, 70.0] {
        let [a, b] = [&plain, &along].map(|scene| vertices(scene, tick));
        assert!(a.len() > 10_000 && a.len() == b.len());
        let farthest = a.iter().zip(&b).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
        let metres = f64::from(farthest) * plain.metadata.metres_per_unit.unwrap();
        assert!(metres < 2e-5, "{metres} m at tick {tick}");
    }
}

#[test]
fn a_character_that_is_passed_through_refuses_it() {
    for onto in [
        Value::Null,
        json!({"character": {"file": "../../fixtures/characters/human_default.glb"}}),
    ] {
        let motion = if onto.is_null() {
            "../../fixtures/characters/human_default.glb"
        } else {
            "../../fixtures/real/cmu_short.bvh"
        };
        let job =
            json!({"source": {"inputs": [motion]}, "target": onto, "write": {"output": "a.glb", "bone-axis": "y"}});
        let error = Job::from_json(&job.to_string())
            .unwrap()
            .make(&[])
            .unwrap_err()
            .to_string();
        assert!(error.contains("`bone_axis`"), "{error}");
    }
}
