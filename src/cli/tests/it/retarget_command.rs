//! Tests `mocap retarget`, run as a program.

use std::path::Path;
use std::process::Output;

use serde_json::Value;

use crate::at_root;
use crate::program::{command, words};

const WALK: &str = "fixtures/skeletons/bvhtoolbox_walk01.bvh";
const CHARACTER: &str = "fixtures/skeletons/human_vrm1.gltf";

fn retarget(arguments: &[&str], output: &Path) -> Output {
    command(&["retarget"])
        .args(arguments)
        .arg("-o")
        .arg(output)
        .output()
        .unwrap()
}

#[test]
fn several_motions_become_clips_of_the_character() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.gltf");
    let output = retarget(
        &[WALK, "fixtures/real/cmu_short.bvh", "--character", CHARACTER, "--json"],
        &path,
    );
    assert!(output.status.success(), "{}", words(&output));
    let scene = mocap::import(&path).unwrap();
    let names: Vec<_> = scene
        .animations
        .iter()
        .map(|animation| animation.name.as_str())
        .collect();
    assert_eq!(names, ["bvhtoolbox_walk01", "cmu_short"]);
    let reports: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(reports[1]["clip"], "cmu_short");
    assert_eq!(reports[0]["verdict"], "good");
    assert_eq!(reports[0]["limbs"][0]["bone"], "leftUpperLeg");

    // The character's own motions stay when more are added, and an option drops them.
    let more = folder.path().join("more.gltf");
    let out = path.to_str().unwrap();
    assert!(retarget(&[WALK, out], &more).status.success());
    let names: Vec<_> = mocap::import(&more)
        .unwrap()
        .animations
        .into_iter()
        .map(|animation| animation.name)
        .collect();
    assert_eq!(names, ["bvhtoolbox_walk01", "cmu_short", "bvhtoolbox_walk01_2"]);
    let alone = folder.path().join("alone.gltf");
    assert!(retarget(&[WALK, out, "--replace-animations"], &alone).status.success());
    assert_eq!(mocap::import(&alone).unwrap().animations.len(), 1);
}

#[test]
fn a_skeleton_is_written_in_any_format() {
    let folder = tempfile::tempdir().unwrap();
    let target = "fixtures/skeletons/xsens_names_tpose.bvh";
    for name in ["out.bvh", "out.glb", "out.gltf"] {
        let path = folder.path().join(name);
        let output = retarget(&[WALK, "--to-skeleton", target], &path);
        assert!(output.status.success(), "{}", words(&output));
        let (scene, source) = (mocap::import(&path).unwrap(), mocap::import(at_root(WALK)).unwrap());
        assert_eq!(
            scene.animations[0].frame_count(),
            source.animations[0].frame_count(),
            "{name}"
        );
        assert!(scene.nodes.iter().any(|node| node.name == "RightWrist"), "{name}");
    }
}

#[test]
fn what_cannot_be_done_is_refused_with_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |arguments: &[&str], name: &str, code: i32, reason: &str| {
        let path = folder.path().join(name);
        let output = retarget(arguments, &path);
        assert_eq!(output.status.code(), Some(code), "{}", words(&output));
        assert!(words(&output).contains(reason), "{}", words(&output));
        path.exists()
    };
    let arm = "fixtures/real/lecture_Test.bvh";
    assert!(!refused(&[arm, CHARACTER], "a.gltf", 1, "the source is not a humanoid"));
    assert!(!refused(&[WALK, arm], "a.glb", 1, "the target is not a humanoid"));
    assert!(!refused(&[WALK], "a.glb", 2, "name a motion, then a character"));
    assert!(!refused(&[WALK, CHARACTER], "a.glb", 2, "must end in .gltf"));
    assert!(!refused(
        &[CHARACTER, CHARACTER],
        "a.gltf",
        1,
        "the file contains no motion"
    ));
    assert!(!refused(
        &[WALK, CHARACTER, "--scale", "0"],
        "a.gltf",
        2,
        "expected auto, none or a factor"
    ));
    // The file is written and the limbs are compared: no angle is exactly 0.
    assert!(refused(
        &[WALK, CHARACTER, "--max-angle", "0"],
        "a.gltf",
        1,
        "has an error of"
    ));
    // The limbs have the same directions. The lines of the trunk belong to another body.
    let path = folder.path().join("b.gltf");
    let free = |most: &'static str| [WALK, CHARACTER, "--feet", "free", "--max-angle", most];
    let output = retarget(&free("1"), &path);
    assert!(words(&output).contains("the trunk at"), "{}", words(&output));
    assert!(retarget(&free("15"), &folder.path().join("c.gltf")).status.success());
}

#[test]
fn a_vrm_animation_is_written_with_the_body_of_the_character() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.vrma");
    let output = retarget(&[WALK, CHARACTER], &path);
    assert!(output.status.success(), "{}", words(&output));
    let scene = mocap::import(&path).unwrap();
    assert_eq!(scene.metadata.format, Some(mocap::Format::Vrma));
    assert_eq!(scene.animations[0].name, "bvhtoolbox_walk01");
    // The character's hips are 0.86 m over the ground.
    let hips = scene.nodes[0].transform.w_axis.y;
    assert!((0.8..0.95).contains(&hips), "{hips}");
}

/// The output keeps the file of a character, so only the animations are mocap's.
#[test]
fn an_output_is_replaced_by_the_same_command_alone() {
    let folder = tempfile::tempdir().unwrap();
    let character = folder.path().join("hero.gltf");
    std::fs::copy(at_root(CHARACTER), &character).unwrap();
    let hero = character.to_str().unwrap();
    for name in ["out.gltf", "out.vrma"] {
        let path = folder.path().join(name);
        let first = retarget(&[WALK, hero], &path);
        assert!(first.status.success(), "{}", words(&first));
        let bytes = std::fs::read(&path).unwrap();
        assert!(retarget(&[WALK, hero], &path).status.success(), "{name}");
        assert_eq!(std::fs::read(&path).unwrap(), bytes, "{name}");
        // Another scale gives other bytes.
        let other = retarget(&[WALK, hero, "--scale", "1.5"], &path);
        assert!(other.status.success(), "{}", words(&other));
        assert_ne!(std::fs::read(&path).unwrap(), bytes, "{name}");
        // Another motion would replace this motion.
        let taken = retarget(&["fixtures/real/cmu_short.bvh", hero], &path);
        assert!(words(&taken).contains("output-exists"), "{}", words(&taken));
    }
    // The character itself is an input, not an output of this program.
    assert!(words(&retarget(&[WALK, hero], &character)).contains("output-is-input"));
    let other = folder.path().join("other.gltf");
    std::fs::copy(at_root(CHARACTER), &other).unwrap();
    assert!(words(&retarget(&[WALK, hero], &other)).contains("output-exists"));
}

#[test]
fn added_animations_say_where_they_are_from() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.gltf");
    assert!(retarget(&[WALK, CHARACTER], &path).status.success());
    let written: Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
    let recorded = &written["animations"][0]["extras"]["mocap"];
    let hash = |path: &str| -> String {
        use sha2::Digest;
        let digest = sha2::Sha256::digest(std::fs::read(at_root(path)).unwrap());
        digest.iter().map(|byte| format!("{byte:02x}")).collect()
    };
    assert_eq!(recorded["source"]["name"], "bvhtoolbox_walk01.bvh");
    assert_eq!(recorded["source"]["sha256"], hash(WALK).as_str());
    let step = recorded["steps"].as_array().unwrap().last().unwrap();
    assert_eq!(step["step"], "retarget");
    assert_eq!(step["onto"]["source"]["name"], "human_vrm1.gltf");
    assert_eq!(step["onto"]["source"]["sha256"], hash(CHARACTER).as_str());
}

/// Joints on another body have other positions, so their distances are not compared.
#[test]
fn verify_refuses_motion_on_another_skeleton() {
    let folder = tempfile::tempdir().unwrap();
    for (name, target) in [
        ("out.gltf", CHARACTER),
        ("out.vrma", CHARACTER),
        ("out.fbx", "fixtures/skeletons/xsens_names_tpose.bvh"),
        ("out.glb", "fixtures/skeletons/xsens_names_tpose.bvh"),
    ] {
        let path = folder.path().join(name);
        let made = retarget(&[WALK, target], &path);
        assert!(made.status.success(), "{}", words(&made));
        let verified = command(&["verify"])
            .args([WALK, path.to_str().unwrap()])
            .output()
            .unwrap();
        assert_eq!(verified.status.code(), Some(1), "{}", words(&verified));
        let file = Path::new(target).file_name().unwrap().to_str().unwrap();
        assert!(
            words(&verified).contains(&format!("the motion was retargeted to the skeleton of \"{file}\"")),
            "{name}: {}",
            words(&verified)
        );
    }
}

/// As in `mocap edit`. A motion without an initial rest pose keeps all its frames.
#[test]
fn a_rest_pose_before_the_motion_is_left_out_and_that_is_said() {
    let folder = tempfile::tempdir().unwrap();
    for (motion, name, dropped) in [("fixtures/real/cmu_short.bvh", "a.gltf", 1), (WALK, "b.gltf", 0)] {
        let path = folder.path().join(name);
        let output = retarget(&[motion, CHARACTER], &path);
        assert!(output.status.success(), "{}", words(&output));
        assert_eq!(
            words(&output)
                .contains("the first frame, a rest pose, is dropped: tick 0 of the output is tick 1 of the file"),
            dropped == 1,
            "{}",
            words(&output)
        );
        let frames = |path: &Path| mocap::import(path).unwrap().animations[0].frame_count();
        assert_eq!(frames(&path), frames(Path::new(&at_root(motion))) - dropped, "{motion}");
    }
}
