//! Tests of motions on characters: in place, with root motion, and several in one file.

use mocap::convert::RootMotion;
use mocap::gltf::GltfOptions;
use mocap::job::{Job, Maker, MotionJob, Notice};
use mocap::scene::NodeId;
use mocap::{Binding, Conversion, Importer, Pose, Scene};
use serde_json::{Value, json};

const WALK: &str = "../../fixtures/real/cmu_12_01_walk.bvh";
const HERO: &str = "../../fixtures/characters/human_game_engine.glb";

fn made(source: &Value, onto: &Value, output: &str) -> Scene {
    let job = json!({"source": source, "target": {"character": onto}, "write": {"output": output}});
    let (written, _) = Job::from_json(&job.to_string()).unwrap().make(&[]).unwrap();
    Importer::new().read(&written.into_bytes().unwrap(), output).unwrap()
}

fn at(scene: &Scene, name: &str) -> NodeId {
    NodeId::new(scene.nodes.iter().position(|node| node.name == name).unwrap())
}

fn pose(scene: &Scene, frame: usize) -> Pose {
    let mut pose = Pose::rest(scene);
    pose.sample(
        &Binding::new(scene, &scene.animations[0]),
        &scene.animations[0],
        frame as f64,
    );
    pose
}

fn walk(root: &str) -> Scene {
    let source = json!({"inputs": [WALK], "frames": {"root": root}});
    made(&source, &json!({"file": HERO}), "hero.glb")
}

/// With root motion, every joint below the hips stays at its place, and the node above has the motion over the ground.
#[test]
fn root_motion_goes_to_the_uppermost_node_and_nothing_moves() {
    let (plain, moved) = (walk("keep"), walk("extract"));
    let (hips, top) = (at(&plain, "pelvis"), NodeId(0));
    let last = plain.animations[0].frame_count() - 1;
    let mut travelled = 0.0_f32;
    for frame in [0, last / 3, last] {
        let (a, b) = (pose(&plain, frame), pose(&moved, frame));
        for (index, (a, b)) in a.node_to_world.iter().zip(&b.node_to_world).enumerate() {
            let is_below = std::iter::successors(Some(NodeId::new(index)), |node| plain.nodes[node.index()].parent);
            if is_below.into_iter().any(|node| node == hips) {
                let distance = a.w_axis.distance(b.w_axis);
                assert!(distance < 1e-5, "{}: {distance}", plain.nodes[index].name);
            }
        }
        // The rest position of the node is below the hips.
        let rest = Pose::rest(&moved);
        let beside = rest.position(hips) - rest.position(top);
        let heading = b.node_to_world[top.index()] * rest.node_to_world[top.index()].inverse();
        let below = b.position(top) + heading.transform_vector3(beside) - b.position(hips);
        assert!(below.x.abs() < 1e-4 && below.z.abs() < 1e-4, "{below}");
        travelled = travelled.max(b.position(top).distance(rest.position(top)));
    }
    assert!(travelled > 1.0, "{travelled}");
}

/// A character whose hips are its root gets a node above them. The rest of its file is unchanged.
#[test]
fn root_motion_of_a_character_whose_hips_are_its_root_goes_to_a_node_above_them() {
    let folder = tempfile::tempdir().unwrap();
    let hero = folder.path().join("hero.glb");
    let mut scene = mocap::import("../../fixtures/real/cmu_short.bvh").unwrap();
    mocap::Conversion::new().apply(&mut scene).unwrap();
    std::fs::write(&hero, GltfOptions::default().write_glb(&scene).unwrap()).unwrap();
    let json = |bytes: &[u8]| -> Value { serde_json::from_slice(&gltf::Glb::from_slice(bytes).unwrap().json).unwrap() };
    for (target, output) in [
        (hero.to_str().unwrap(), "hero.glb"),
        ("../../fixtures/real/cmu_short.bvh", "hero.fbx"),
    ] {
        let moved = |root: &str| {
            let source = json!({"inputs": [WALK], "frames": {"root": root}});
            let onto = json!({"file": target, "replace-animations": output == "hero.glb"});
            let job = json!({"source": source, "target": {"character": onto}, "write": {"output": output}});
            let (written, _) = Job::from_json(&job.to_string()).unwrap().make(&[]).unwrap();
            let bytes = written.into_bytes().unwrap();
            (Importer::new().read(&bytes, output).unwrap(), bytes)
        };
        let ((plain, _), (moved, bytes)) = (moved("keep"), moved("extract"));
        let (root, hips) = (at(&moved, "Root"), at(&moved, "Hips"));
        assert_eq!(moved.nodes[hips.index()].parent, Some(root), "{output}");
        let metres = moved.metadata.metres_per_unit.unwrap_or(1.0) as f32;
        let last = moved.animations[0].frame_count() - 1;
        for frame in [0, last / 3, last] {
            let (a, b) = (pose(&plain, frame), pose(&moved, frame));
            for node in &plain.nodes {
                let distance = a
                    .position(at(&plain, &node.name))
                    .distance(b.position(at(&moved, &node.name)));
                assert!(distance * metres < 1e-4, "{output}, {}: {distance}", node.name);
            }
            assert!((b.position(root).y * metres).abs() < 1e-5, "{output}");
        }
        let travelled = pose(&moved, 0)
            .position(root)
            .distance(pose(&moved, last).position(root));
        assert!(travelled * metres > 1.0, "{output}: {travelled}");
        if output == "hero.glb" {
            let (before, after) = (json(&std::fs::read(&hero).unwrap()), json(&bytes));
            let (nodes, more) = (before["nodes"].as_array().unwrap(), after["nodes"].as_array().unwrap());
            assert_eq!((&more[..nodes.len()], more.len()), (&nodes[..], nodes.len() + 1));
            assert!(
                after["scenes"][0]["nodes"]
                    .as_array()
                    .unwrap()
                    .contains(&json!(nodes.len()))
            );
            for part in ["meshes", "skins", "materials"] {
                assert_eq!(before[part], after[part], "{part}");
            }
        }
    }
}

#[test]
fn in_place_keeps_the_hips_over_one_point_at_their_height() {
    let (plain, still) = (walk("keep"), walk("in-place"));
    let hips = at(&plain, "pelvis");
    let start = pose(&plain, 0).position(hips);
    let last = plain.animations[0].frame_count() - 1;
    for frame in [0, last / 2, last] {
        let (was, is) = (pose(&plain, frame).position(hips), pose(&still, frame).position(hips));
        assert!((is.x - start.x).abs() < 1e-5 && (is.z - start.z).abs() < 1e-5 && (is.y - was.y).abs() < 1e-5);
    }
    assert!(pose(&plain, last).position(hips).distance(start) > 1.0);
}

/// Clips get the requested names, as many as there are.
#[test]
fn clips_have_the_names_that_are_asked_for() {
    let source = json!({"inputs": [WALK, "../../fixtures/real/cmu_short.bvh"]});
    let onto = |names: Value| json!({"file": HERO, "names-of-clips": names});
    let scene = made(&source, &onto(json!(["stroll", "stroll"])), "hero.glb");
    let names: Vec<&str> = scene.animations.iter().map(|clip| clip.name.as_str()).collect();
    assert_eq!(names, ["stroll", "stroll_2"]);
    let job = json!({"source": source, "target": {"character": onto(json!(["a"]))}, "write": {"output": "hero.glb"}});
    let error = Job::from_json(&job.to_string()).unwrap().make(&[]).unwrap_err();
    assert_eq!(error.diagnostic().message, "1 names are given for 2 clips");
}

/// A file without a motion is skipped and reported. The other motions are in the output.
#[test]
fn a_bad_file_among_several_is_left_out() {
    let job = json!({
        "source": {"inputs": [WALK, "../../fixtures/broken/letter_in_motion.bvh", "../../fixtures/real/cmu_short.bvh"]},
        "target": {"character": {"file": HERO}},
        "write": {"output": "hero.glb"},
    });
    let (_, report) = Job::from_json(&job.to_string()).unwrap().make(&[]).unwrap();
    assert_eq!(report.clips.len(), 2);
    let problem = report.problem.unwrap();
    assert!(
        problem.starts_with("skipped motions: 1; the first is ../../fixtures/broken/"),
        "{problem}"
    );
}

/// An FBX file has one rate: the rate of the fastest clip, at which no key of a slower clip is lost.
#[test]
fn fbx_with_clips_of_two_rates_has_that_of_the_fastest() {
    let source = json!({"inputs": ["../../fixtures/real/z_up_dab.bvh", WALK]});
    let scene = made(&source, &json!({"file": HERO}), "hero.fbx");
    let own = |file: &str| mocap::import(file).unwrap().animations[0].ticks_per_second;
    let [slow, fast] = ["../../fixtures/real/z_up_dab.bvh", WALK].map(own);
    assert!(slow < fast, "{slow} {fast}");
    for clip in &scene.animations {
        assert!((clip.ticks_per_second - fast).abs() < 0.1, "{}", clip.ticks_per_second);
    }
}

/// A motion without a name gets the name of its file.
#[test]
fn a_converted_motion_is_called_after_its_file() {
    for output in ["a.glb", "a.fbx"] {
        let job = json!({"source": {"inputs": [WALK]}, "write": {"output": output}});
        let (written, _) = Job::from_json(&job.to_string()).unwrap().make(&[]).unwrap();
        let scene = Importer::new().read(&written.into_bytes().unwrap(), output).unwrap();
        assert_eq!(scene.animations[0].name, "cmu_12_01_walk", "{output}");
    }
}

/// The ground is horizontal in the world: `arm.usda` has a rotated and scaled group above its root.
#[test]
fn the_ground_is_level_below_a_group_that_is_rotated() {
    let converted = |root: RootMotion| {
        let mut scene = mocap::import("../../fixtures/made/arm.usda").unwrap();
        Conversion::new().root(root).apply(&mut scene).unwrap();
        scene
    };
    let (plain, in_place, moved) = (
        converted(RootMotion::Keep),
        converted(RootMotion::InPlace),
        converted(RootMotion::Extract),
    );
    let place = |scene: &Scene, name: &str, frame: usize| pose(scene, frame).position(at(scene, name));
    let mut travelled = 0.0_f32;
    for frame in 0..plain.animations[0].frame_count() {
        let (start, now) = (place(&plain, "Base", 0), place(&plain, "Base", frame));
        travelled = travelled.max((now - start).with_y(0.0).length());
        let stays = place(&in_place, "Base", frame);
        assert!(stays.distance(start.with_y(now.y)) < 1e-5, "{frame}: {stays}");
        for name in ["Base", "Arm", "Tail", "Hand"] {
            let (a, b) = (place(&plain, name, frame), place(&moved, name, frame));
            assert!(a.distance(b) < 1e-5, "{frame}, {name}: {a} {b}");
        }
        let root = place(&moved, "Root", frame) - place(&moved, "Root", 0);
        let expected = (now - start).with_y(0.0);
        assert!(root.distance(expected) < 1e-5, "{frame}: {root} {expected}");
    }
    assert!(travelled > 0.05, "{travelled}");
}

/// The soles of a skin are used for every output: a file that keeps the skin, a file that gets the skin, and a file
/// without a skin.
#[test]
fn the_ground_under_a_skin_is_the_same_in_every_format() {
    let folder = tempfile::tempdir().unwrap();
    let hero = folder.path().join("hero.glb");
    let character = json!({"character": {"file": "../../fixtures/characters/human_default.glb"}});
    let onto = json!({"source": {"inputs": [WALK]}, "target": character, "write": {"output": hero}});
    Job::from_json(&onto.to_string()).unwrap().run().unwrap();
    let floor_in = |write: Value| -> String {
        let job = json!({"source": {"inputs": [hero]}, "steps": ["ground"], "write": write});
        let job: MotionJob = serde_json::from_value(job).unwrap();
        let mut floor = None;
        let output = job.write.output.clone();
        let mut hear = |notice: Notice<'_>| {
            if let Notice::Step(report) = notice {
                floor = Some(report.to_string());
            }
        };
        let maker = Maker::new(&job, &[], &mut |_| ()).unwrap();
        let made = maker.make(&job.source.inputs, &output, &mut hear).unwrap();
        made.written.save(&output, &job.policy()).unwrap();
        let verified = job.verify_output(made.scene, &output).unwrap();
        assert!(verified.is_within(1e-3), "{write}: {:?}", verified.findings);
        floor.unwrap()
    };
    let of_kept = floor_in(json!({"output": folder.path().join("kept.glb")}));
    for name in ["o.fbx", "o.usda", "o.bvh", "o.mclip"] {
        assert_eq!(floor_in(json!({"output": folder.path().join(name)})), of_kept, "{name}");
    }
    let alone = json!({"output": folder.path().join("alone.glb"), "skeleton-only": true});
    assert_eq!(floor_in(alone), of_kept);
}
