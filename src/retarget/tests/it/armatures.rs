//! Characters whose armature is rotated, as Blender and VRoid write them. Motions to and from such characters are the
//! same as without the rotation.

use std::f32::consts::FRAC_PI_2;

use mocap::glam::{Mat4, Quat, Vec3};
use mocap::retarget::{RetargetOptions, Retargeter};
use mocap::scene::{Node, NodeId, NodeKind};
use mocap::{Importer, MemoryFile, Pose, Scene};
use serde_json::{Value, json};

const WALK: &str = "../../fixtures/real/cmu_12_01_walk.bvh";

/// Blender's quarter turn, and two rotations about no coordinate axis.
fn turns() -> [Quat; 3] {
    [
        Quat::from_rotation_x(-FRAC_PI_2),
        Quat::from_rotation_z(0.58),
        Quat::from_rotation_x(0.87) * Quat::from_rotation_y(0.4),
    ]
}

/// The bytes of a `.glb` or `.vrm` with a rotated node above its skeleton. With `world_stays`, the skeleton is rotated
/// back, so that the skin with its unchanged inverse bind matrices keeps its place.
fn with_armature(bytes: &[u8], turn: Quat, world_stays: bool) -> Vec<u8> {
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let mut file: Value = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
    let scene = file["scene"].as_u64().unwrap_or(0) as usize;
    let roots = file["scenes"][scene]["nodes"].as_array().unwrap().clone();
    let is_skeleton = |node: &Value| file["nodes"][node.as_u64().unwrap() as usize].get("mesh").is_none();
    let (skeleton, others): (Vec<Value>, Vec<Value>) = roots.into_iter().partition(is_skeleton);
    assert!(!skeleton.is_empty());
    for node in skeleton.iter().filter(|_| world_stays) {
        let node = &mut file["nodes"][node.as_u64().unwrap() as usize];
        let number = |of: &Value, at: usize| of[at].as_f64().unwrap_or(if at == 3 { 1.0 } else { 0.0 }) as f32;
        let (at, q) = (&node["translation"], &node["rotation"]);
        let back = turn.inverse();
        let at = back * Vec3::new(number(at, 0), number(at, 1), number(at, 2));
        let rotation = back * Quat::from_xyzw(number(q, 0), number(q, 1), number(q, 2), number(q, 3));
        node["translation"] = json!(at.to_array());
        node["rotation"] = json!(rotation.normalize().to_array());
    }
    let nodes = file["nodes"].as_array_mut().unwrap();
    nodes.push(json!({"name": "Armature", "rotation": turn.to_array(), "children": skeleton}));
    let armature = nodes.len() - 1;
    file["scenes"][scene]["nodes"] = json!([others, vec![json!(armature)]].concat());
    let mut text = serde_json::to_vec(&file).unwrap();
    text.resize(text.len().next_multiple_of(4), b' ');
    let rest = &bytes[20 + length..];
    let mut made = b"glTF\x02\0\0\0".to_vec();
    made.extend((20 + text.len() as u32 + rest.len() as u32).to_le_bytes());
    made.extend((text.len() as u32).to_le_bytes());
    made.extend(b"JSON");
    made.extend(&text);
    made.extend(rest);
    made
}

/// The walk, retargeted to a character.
fn on(bytes: &[u8], name: &str) -> Scene {
    let file = MemoryFile { name, bytes };
    let character = Importer::new().gltf_meshes(true).read_character(file, &[]).unwrap();
    let done = Retargeter::new(mocap::import(WALK).unwrap(), character, RetargetOptions::new()).unwrap();
    done.scene()
}

/// The world positions of joints by name, at some ticks: the joints of `names`, or all joints if `names` is empty.
fn positions(scene: &Scene, names: &[String]) -> Vec<Vec3> {
    let joints = names
        .iter()
        .map(|name| scene.nodes.iter().position(|node| node.name == *name).unwrap());
    let joints: Vec<usize> = joints.collect();
    let mut all = Vec::new();
    for tick in [0.0, 40.0, 111.0, 200.0, 333.0] {
        let pose = Pose::at_tick(scene, 0, tick).unwrap();
        all.extend(joints.iter().map(|joint| pose.position(NodeId::new(*joint))));
    }
    all
}

fn joint_names(scene: &Scene) -> Vec<String> {
    let joints = scene.nodes.iter().filter(|node| node.kind == NodeKind::Joint);
    joints
        .map(|node| node.name.clone())
        .filter(|name| !["Body", "Eyes", "Armature"].contains(&name.as_str()))
        .collect()
}

fn farthest(a: &[Vec3], b: &[Vec3]) -> f32 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max)
}

/// If the world does not change, the motion does not change: every joint stays within 0.1 mm.
#[test]
fn a_turned_armature_changes_nothing_of_a_motion_on_it() {
    for name in ["human_vrm0.vrm", "human_default.glb"] {
        let bytes = std::fs::read(format!("../../fixtures/characters/{name}")).unwrap();
        let plain = on(&bytes, name);
        let names = joint_names(&plain);
        assert!(names.len() > 40);
        for turn in turns() {
            let turned = on(&with_armature(&bytes, turn, true), name);
            assert!(turned.nodes.iter().any(|node| node.name == "Armature"));
            let off = farthest(&positions(&plain, &names), &positions(&turned, &names));
            assert!(off < 1e-4, "{name} {turn}: {off} m");
        }
    }
}

/// A character that leans or lies at rest together with its armature stands up in the motion. Each limb has the
/// direction that it has on a standing character, within 3 degrees.
#[test]
fn a_character_that_lies_with_its_armature_stands_up() {
    let name = "human_default.glb";
    let bytes = std::fs::read(format!("../../fixtures/characters/{name}")).unwrap();
    let plain = on(&bytes, name);
    let limbs = [
        ["spine05", "neck01"],
        ["upperleg01.L", "lowerleg01.L"],
        ["lowerleg01.R", "foot.R"],
        ["upperarm01.L", "lowerarm01.L"],
        ["lowerarm01.R", "wrist.R"],
    ];
    for turn in turns() {
        let turned = on(&with_armature(&bytes, turn, false), name);
        for limb in &limbs {
            let ends = limb.map(str::to_owned);
            let directions = |scene: &Scene| -> Vec<Vec3> {
                let all = positions(scene, &ends);
                all.chunks(2).map(|ends| (ends[1] - ends[0]).normalize()).collect()
            };
            // A figure is taken to face along its nearest axis, so a rotation about the vertical axis may remain.
            for (was, is) in directions(&plain).iter().zip(directions(&turned)) {
                let lean = (was.y.clamp(-1.0, 1.0).acos() - is.y.clamp(-1.0, 1.0).acos()).abs();
                assert!(lean.to_degrees() < 3.0, "{turn} {limb:?}: {was} {is}");
            }
        }
    }
}

/// A scene with a rotated group above its root. The root and its motion are rotated back.
fn scene_with_armature(scene: &Scene, turn: Quat) -> Scene {
    let back = turn.inverse();
    let mut made = scene.clone();
    made.nodes[0].transform = Mat4::from_quat(back) * made.nodes[0].transform;
    for node in &mut made.nodes {
        node.parent = Some(node.parent.map_or(NodeId(0), |parent| NodeId(parent.0 + 1)));
    }
    made.nodes.insert(
        0,
        Node {
            name: "Armature".to_owned(),
            kind: NodeKind::Group,
            transform: Mat4::from_quat(turn),
            ..Node::default()
        },
    );
    for bone in made.meshes.iter_mut().flat_map(|mesh| &mut mesh.bones) {
        bone.node.0 += 1;
    }
    for channel in made.animations.iter_mut().flat_map(|clip| &mut clip.channels) {
        let node = channel.node.unwrap();
        channel.node = Some(NodeId(node.0 + 1));
        if node.index() == 0 {
            channel.position_keys.values.iter_mut().for_each(|at| *at = back * *at);
            channel.rotation_keys.values.iter_mut().for_each(|q| *q = back * *q);
        }
    }
    made
}

/// The armature of the source is rotated, but the motion in the world does not change. So the motion of the character
/// changes by at most 0.1 mm.
#[test]
fn a_motion_comes_from_a_turned_armature_as_from_one_that_is_not() {
    let bytes = std::fs::read("../../fixtures/characters/human_vrm0.vrm").unwrap();
    let file = MemoryFile {
        name: "human_vrm0.vrm",
        bytes: &bytes,
    };
    let character = Importer::new().gltf_meshes(true).read_character(file, &[]).unwrap();
    for source in [
        WALK,
        "../../fixtures/skeletons/accad_run_turn.bvh",
        "../../fixtures/real/rokoko_dance.bvh",
    ] {
        let scene = mocap::import(source).unwrap();
        let on = |scene: Scene| {
            let done = Retargeter::new(scene, character.clone(), RetargetOptions::new()).unwrap();
            let scene = done.scene();
            positions(&scene, &joint_names(&scene))
        };
        let plain = on(scene.clone());
        for turn in turns() {
            let off = farthest(&plain, &on(scene_with_armature(&scene, turn)));
            assert!(off < 1e-3, "{source} {turn}: {off} m");
        }
    }
}
