//! VRM animations: the contents of the files, their motion compared with the sources, and reading.

use std::collections::BTreeMap;

use mocap::figure::{Humanoid, HumanoidBone as Bone, vrm_humanoid};
use mocap::glam::{Mat4, Quat, Vec3};
use mocap::gltf::GltfOptions;
use mocap::retarget::{PoseRetargetOptions, PoseRetargeter};
use mocap::scene::{Confidence, Format, Keys, NodeId};
use mocap::verify::report::FindingKind;
use mocap::verify::report::Verification;
use mocap::vrma::VrmaOptions;
use mocap::{Binding, Code, Conversion, Importer, Pose, Scene};
use serde_json::Value;

use crate::characters::{character, motion};
use crate::sample::Sample;

/// Bones whose directions are compared, each with the bone at its end.
const LIMBS: [(Bone, Bone); 8] = [
    (Bone::LeftUpperArm, Bone::LeftLowerArm),
    (Bone::LeftLowerArm, Bone::LeftHand),
    (Bone::LeftUpperLeg, Bone::LeftLowerLeg),
    (Bone::LeftLowerLeg, Bone::LeftFoot),
    (Bone::RightUpperArm, Bone::RightLowerArm),
    (Bone::RightLowerArm, Bone::RightHand),
    (Bone::RightUpperLeg, Bone::RightLowerLeg),
    (Bone::RightLowerLeg, Bone::RightFoot),
];

/// The JSON and the buffer of a `.glb`.
fn parts(glb: &[u8]) -> (Value, Vec<u8>) {
    let glb = gltf::Glb::from_slice(glb).unwrap();
    let json = serde_json::from_slice(&glb.json).unwrap();
    (json, glb.bin.unwrap_or_default().into_owned())
}

/// The same `.glb` with another JSON.
fn with_json(glb: &[u8], json: &Value) -> Vec<u8> {
    let mut glb = gltf::Glb::from_slice(glb).unwrap();
    glb.json = serde_json::to_vec(json).unwrap().into();
    glb.to_vec().unwrap()
}

fn written(scene: &Scene) -> Vec<u8> {
    VrmaOptions::default().write(scene).unwrap().0
}

fn read(bytes: &[u8]) -> Scene {
    Importer::new().read(bytes, "a.vrma").unwrap()
}

/// The sources, each with the rotation about the up axis, in degrees, after which it faces +Z at rest.
fn sources() -> Vec<(String, Scene, f32)> {
    let mut sources: Vec<_> = [
        "real/cmu_12_01_walk.bvh",
        "real/rokoko_dance.bvh",
        "real/cmu_02_01.amc",
        "real/mocopi_jump_six_channels.bvh",
        "real/z_up_dab.bvh",
        "skeletons/accad_run_turn.bvh",
        "skeletons/animics_all_along_z.bvh",
        "skeletons/blender_rigify_names.bvh",
    ]
    .map(|file| (file.to_owned(), motion(file), 0.0))
    .to_vec();
    // A VRM 0 character faces -Z, and so does its motion.
    let walk = motion("real/cmu_12_01_walk.bvh");
    let mut turned = character("human_vrm0");
    let mut retargeter = PoseRetargeter::new(&walk, &turned, &PoseRetargetOptions::default()).unwrap();
    turned.animations = vec![retargeter.animation(&walk, &walk.animations[0])];
    sources.push(("human_vrm0".to_owned(), turned, 180.0));
    sources
}

/// Whether no node has a rotation, as in the T-pose of a VRM animation.
fn no_node_is_turned(json: &serde_json::Value) -> bool {
    let nodes = json["nodes"].as_array().unwrap();
    nodes.iter().all(|node| node["rotation"].is_null())
}

#[test]
fn the_file_is_what_the_specification_demands() {
    for (file, scene, _) in sources() {
        let (json, _) = parts(&written(&scene));
        let extension = &json["extensions"]["VRMC_vrm_animation"];
        assert_eq!(extension["specVersion"], "1.0", "{file}");
        assert_eq!(json["extensionsUsed"], serde_json::json!(["VRMC_vrm_animation"]));
        assert_eq!((json["meshes"].as_array(), json["skins"].as_array()), (None, None));
        let bones = extension["humanoid"]["humanBones"].as_object().unwrap();
        let node = |bone: &str| bones.get(bone).and_then(|bone| bone["node"].as_u64());
        for bone in Bone::REQUIRED {
            assert!(node(bone.as_str()).is_some(), "{file}: {}", bone.as_str());
        }
        assert!(node("leftEye").is_none() && node("rightEye").is_none(), "{file}");
        // The T-pose has no rotations. Its arms point sideways, its legs down, and the hips are above the ground.
        for node in json["nodes"].as_array().unwrap() {
            assert!(node["rotation"].is_null() && node["scale"].is_null(), "{file}: {node}");
        }
        let rest = Pose::rest(&read(&written(&scene)));
        let at = |bone: Bone| rest.position(NodeId::new(node(bone.as_str()).unwrap() as usize));
        for (from, to) in LIMBS {
            let expected = match from.as_str() {
                name if name.contains("Leg") => Vec3::NEG_Y,
                name if name.starts_with("left") => Vec3::X,
                _ => Vec3::NEG_X,
            };
            let way = at(to) - at(from);
            assert!(
                way == Vec3::ZERO || way.angle_between(expected) < 1e-3,
                "{file}: {from:?} {way}"
            );
        }
        let (hips, foot) = (at(Bone::Hips), at(Bone::LeftFoot));
        assert!(
            hips.x == 0.0 && hips.z == 0.0 && foot.y > -0.02 && foot.y < 0.25 * hips.y,
            "{file}: {hips} {foot}"
        );
        // The channels are rotations, and the path of the hips.
        for animation in json["animations"].as_array().unwrap() {
            for channel in animation["channels"].as_array().unwrap() {
                let target = &channel["target"];
                let is_hips = target["node"].as_u64() == node("hips");
                assert!(
                    target["path"] == "rotation" || (is_hips && target["path"] == "translation"),
                    "{target}"
                );
            }
        }
    }
}

/// The test uses only the two scenes: the directions of limbs, and the rotation of each bone since the first frame.
#[test]
fn the_motion_is_that_of_the_source() {
    for (file, scene, heading) in sources() {
        let read = read(&written(&scene));
        let (ours, theirs) = (Humanoid::of(&scene), Humanoid::of(&read));
        let heading = Quat::from_rotation_y(heading.to_radians());
        let (from, to) = (&scene.animations[0], &read.animations[0]);
        assert_eq!(from.frame_count(), to.frame_count(), "{file}");
        let (from_binding, to_binding) = (Binding::new(&scene, from), Binding::new(&read, to));
        let (mut here, mut there) = (Pose::rest(&scene), Pose::rest(&read));
        let rotation = |pose: &Pose, node: NodeId| pose.node_to_world[node.index()].to_scale_rotation_translation().1;
        let mut first: BTreeMap<Bone, (Quat, Quat)> = BTreeMap::new();
        for tick in (0..from.frame_count()).step_by(7) {
            here.sample(&from_binding, from, tick as f64);
            there.sample(&to_binding, to, tick as f64);
            for (bone, end) in LIMBS {
                let (Some(bone), Some(end)) = (
                    ours.joint(bone).zip(theirs.joint(bone)),
                    ours.joint(end).zip(theirs.joint(end)),
                ) else {
                    continue;
                };
                let expected = heading * (here.position(end.0) - here.position(bone.0));
                let way = there.position(end.1) - there.position(bone.1);
                let angle = way.angle_between(expected).to_degrees();
                assert!(
                    angle < 0.05,
                    "{file}, {tick}: {:?} is {angle} degrees off",
                    read.nodes[bone.1.index()].name
                );
            }
            let bones = theirs
                .bones
                .iter()
                .filter_map(|(bone, joint)| Some((*bone, ours.joint(*bone)?, joint.joint)));
            for (bone, a, b) in bones {
                let now = (heading * rotation(&here, a), rotation(&there, b));
                let first = *first.entry(bone).or_insert(now);
                let (ours, theirs) = (now.0 * first.0.inverse(), now.1 * first.1.inverse());
                // The cosine of a small angle is too coarse.
                let off = ours * theirs.inverse();
                let angle = 2.0 * off.xyz().length().asin().to_degrees();
                assert!(
                    angle < 0.1,
                    "{file}, {tick}: {bone:?} has turned by {angle} degrees more"
                );
            }
        }
    }
}

#[test]
fn verify_finds_nothing_in_what_is_written_and_finds_what_is_changed() {
    let source = mocap::import("../../fixtures/real/cmu_short.bvh").unwrap();
    let mut scene = source.clone();
    Conversion::new()
        .trim(mocap::convert::Moment::Frame(3), None)
        .frame_rate(30.0)
        .apply(&mut scene)
        .unwrap();
    let bytes = written(&scene);
    let verified = Verification::of(&source, &bytes).unwrap();
    assert!(verified.is_within(1e-5), "{verified:?}");
    assert!(
        verified.rotation_error.is_some_and(|error| error < 1e-5),
        "{verified:?}"
    );

    let (json, bin) = parts(&bytes);
    // `verify` finds a changed rotation.
    let mut changed = bytes.clone();
    let channels = json["animations"][0]["channels"].as_array().unwrap();
    let rotation = channels
        .iter()
        .rposition(|channel| channel["target"]["path"] == "rotation")
        .unwrap();
    let sampler = &json["animations"][0]["samplers"][rotation];
    let accessor = &json["accessors"][sampler["output"].as_u64().unwrap() as usize];
    let view = &json["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
    let at = changed.len() - bin.len() + view["byteOffset"].as_u64().unwrap_or(0) as usize;
    let last = at + 16 * (accessor["count"].as_u64().unwrap() as usize - 1);
    changed[last..last + 16].copy_from_slice(&[0.6_f32, 0.0, 0.0, 0.8].map(f32::to_le_bytes).concat());
    assert!(!Verification::of(&source, &changed).unwrap().is_within(1e-3));
    // `verify` finds a raised path.
    let mut lifted = json.clone();
    let steps = lifted["asset"]["extras"]["mocap"]["steps"].as_array_mut().unwrap();
    steps.last_mut().unwrap()["lift"] = 0.1.into();
    assert!(
        !Verification::of(&source, &with_json(&bytes, &lifted))
            .unwrap()
            .is_within(1e-3)
    );
    // `verify` finds that the file does not state a bone.
    let mut lacking = json;
    let bones = &mut lacking["extensions"]["VRMC_vrm_animation"]["humanoid"]["humanBones"];
    bones.as_object_mut().unwrap().remove("leftHand");
    let found = Verification::of(&source, &with_json(&bytes, &lacking))
        .unwrap()
        .findings;
    assert_eq!(found[0].kind, FindingKind::MissingJoint);
    assert!(found[0].message.contains("leftHand"), "{}", found[0]);
}

/// At another rate, the rest pose in the first frame and the jump after it keep their times.
#[test]
fn another_rate_keeps_the_frames_around_a_cut() {
    let source = mocap::import("../../fixtures/real/cmu_12_01_walk.bvh").unwrap();
    let mut scene = source.clone();
    Conversion::new().frame_rate(30.0).apply(&mut scene).unwrap();
    let verified = Verification::of(&source, &written(&scene)).unwrap();
    assert!(verified.is_within(1e-5), "{verified:?}");
    assert_eq!(verified.frames, 132);
}

#[test]
fn compression_keeps_its_bound_and_the_t_pose() {
    let scene = motion("real/cmu_12_01_walk.bvh");
    let options = VrmaOptions::new().gltf(
        GltfOptions::new()
            .error_bound(Some(0.001.into()))
            .compression(mocap::gltf::Compression::Int16),
    );
    let (bytes, report) = options.write(&scene).unwrap();
    assert!(report.achieved.unwrap().max_error <= 0.001 && bytes.len() < written(&scene).len() / 2);
    let source = mocap::import("../../fixtures/real/cmu_12_01_walk.bvh").unwrap();
    assert!(Verification::of(&source, &bytes).unwrap().is_within(0.001));
    let (json, _) = parts(&bytes);
    let channels = json["animations"][0]["channels"].as_array().unwrap();
    let paths = channels
        .iter()
        .filter(|channel| channel["target"]["path"] == "translation");
    assert_eq!(paths.count(), 1);
    assert!(no_node_is_turned(&json));
}

/// A bone that does not move may still have another rotation than in the T-pose.
#[test]
fn a_pose_that_is_held_stays_in_the_motion() {
    let mut scene = motion("real/cmu_12_01_walk.bvh");
    let held: Vec<_> = scene.animations[0]
        .channels
        .iter()
        .map(|channel| channel.rotation_keys.values[100 % channel.rotation_keys.len()])
        .collect();
    for (channel, rotation) in scene.animations[0].channels.iter_mut().zip(held) {
        channel.rotation_keys = Keys::constant(rotation);
    }
    let (json, _) = parts(&written(&scene));
    assert!(no_node_is_turned(&json));
    let read = read(&written(&scene));
    let at = |scene: &Scene| {
        let pose = Pose::at_tick(scene, 0, 200.0).unwrap();
        let joint = |bone| Humanoid::of(scene).joint(bone).unwrap();
        pose.position(joint(Bone::LeftHand)) - pose.position(joint(Bone::LeftUpperArm))
    };
    assert!(at(&scene).angle_between(at(&read)) < 1e-3);
}

#[test]
fn what_is_no_humanoid_is_refused_with_the_reason() {
    let refused = |scene: &Scene, options: &VrmaOptions| options.write(scene).unwrap_err();
    let error = refused(&motion("real/hand_take.c3d"), &VrmaOptions::default());
    assert_eq!(error.code(), Code::NotHumanoid);
    assert!(error.to_string().contains("the source is not a humanoid: "), "{error}");

    let scene = motion("real/slimevr_headset_root.bvh");
    let error = refused(&scene, &VrmaOptions::default());
    assert_eq!(error.code(), Code::NotHumanoid);
    assert!(error.to_string().contains("leftUpperArm"), "{error}");

    let still = character("human_vrm1");
    assert_eq!(refused(&still, &VrmaOptions::default()).code(), Code::NoMotion);
    let unconverted = mocap::import("../../fixtures/real/cmu_short.bvh").unwrap();
    assert_eq!(refused(&unconverted, &VrmaOptions::default()).code(), Code::UnknownUnit);
}

/// If the origin is at the hips, the feet are below the origin, and would be below the ground of every player.
#[test]
fn a_motion_below_the_origin_is_raised_to_the_ground() {
    let scene = motion("real/cmu_12_01_walk.bvh");
    let mut sunk = scene.clone();
    for value in &mut sunk.animations[0].channels[0].position_keys.values {
        value.y -= 1.0;
    }
    let (plain, raised) = (vrm_humanoid(&scene, None).unwrap(), vrm_humanoid(&sunk, None).unwrap());
    let height = |scene: &Scene| scene.animations[0].channels[0].position_keys.values[100].y;
    assert!(
        (height(&plain) - height(&raised)).abs() < 0.08,
        "{} {}",
        height(&plain),
        height(&raised)
    );
    assert!(raised.nodes[0].transform.w_axis.y > 0.5);
}

#[test]
fn a_vrm_animation_states_its_bones() {
    let read = read(&written(&motion("real/cmu_12_01_walk.bvh")));
    assert_eq!(read.metadata.format, Some(Format::Vrma));
    let found = Humanoid::of(&read);
    let thigh = &found.bones[&Bone::LeftUpperLeg];
    assert_eq!(read.nodes[thigh.joint.index()].name, "LeftUpLeg");
    assert_eq!(thigh.confidence, Confidence::Sure);
    assert_eq!(thigh.reason, "the file states the bones");

    // Names have no meaning, and the contents determine the format.
    let (mut json, _) = parts(&written(&motion("real/cmu_12_01_walk.bvh")));
    for (index, node) in json["nodes"].as_array_mut().unwrap().iter_mut().enumerate() {
        node["name"] = format!("n{index}").into();
        node.as_object_mut().unwrap().remove("extras");
    }
    let bytes = with_json(&written(&motion("real/cmu_12_01_walk.bvh")), &json);
    let nameless = Importer::new().read(&bytes, "take.bin").unwrap();
    assert_eq!(nameless.metadata.format, Some(Format::Vrma));
    assert_eq!(Humanoid::of(&nameless).bones.len(), found.bones.len());
    json["extensions"]["VRMC_vrm_animation"]["humanoid"]["humanBones"]["hips"]["node"] = 99.into();
    let error = Importer::new()
        .read(&with_json(&bytes, &json), "take.vrma")
        .unwrap_err();
    assert_eq!(error.code(), Code::InvalidGltf);
    assert!(error.to_string().contains("humanBones/hips/node"), "{error}");
    let bones = &mut json["extensions"]["VRMC_vrm_animation"]["humanoid"]["humanBones"];
    bones.as_object_mut().unwrap().remove("hips");
    let error = Importer::new()
        .read(&with_json(&bytes, &json), "take.vrma")
        .unwrap_err();
    assert!(error.to_string().contains("no node is the bone hips"), "{error}");
}

/// A character moves equally by the source and by its VRM animation.
#[test]
fn a_character_moves_by_the_animation_as_by_its_source() {
    let sources = sources().into_iter().filter(|(_, _, heading)| *heading == 0.0);
    for (file, scene, _) in Sample::new().some(sources, 4) {
        let over = read(&written(&scene));
        let target = character("human_vrm1");
        let moved = |source: &Scene| {
            let mut retargeter = PoseRetargeter::new(source, &target, &PoseRetargetOptions::default()).unwrap();
            let animation = retargeter.animation(source, &source.animations[0]);
            Scene {
                animations: vec![animation],
                ..target.clone()
            }
        };
        let (direct, over) = (moved(&scene), moved(&over));
        for tick in (0..direct.animations[0].frame_count()).step_by(41) {
            let [a, b] = [&direct, &over].map(|scene| Pose::at_tick(scene, 0, tick as f64).unwrap());
            for (from, to) in LIMBS {
                let joint = |bone| Humanoid::of(&target).joint(bone).unwrap();
                let way = |pose: &Pose| pose.position(joint(to)) - pose.position(joint(from));
                let angle = way(&a).angle_between(way(&b)).to_degrees();
                assert!(angle < 0.1, "{file}, {tick}: {from:?} is {angle} degrees off");
            }
        }
    }
}

/// A VRM animation is glTF with joints, so it is converted like glTF. VRM requires feet, and this file lacks one. The
/// reader adds it between the shin and the toes, which keep their positions.
#[test]
fn toes_without_a_foot_stay_where_they_are() {
    let whole = written(&motion("real/cmu_12_01_walk.bvh"));
    let (mut json, _) = parts(&whole);
    let bones = &mut json["extensions"]["VRMC_vrm_animation"]["humanoid"]["humanBones"];
    assert!(bones.as_object_mut().unwrap().remove("leftFoot").is_some());
    assert!(bones.get("leftToes").is_some());
    let without = read(&with_json(&whole, &json));
    let verified = Verification::of(&without, &written(&without)).unwrap();
    assert!(verified.is_within(1e-4), "{verified:?}");
}

#[test]
fn an_animation_becomes_bvh_and_glb() {
    let scene = read(&written(&motion("real/cmu_short.bvh")));
    let text = mocap::bvh::BvhOptions::default().write(&scene).unwrap();
    assert!(Verification::of(&scene, &text).unwrap().is_within(1e-4));
    let glb = GltfOptions::default().write_glb(&scene).unwrap();
    assert!(Verification::of(&scene, &glb).unwrap().is_within(1e-5));
    assert_eq!(
        scene.nodes[1].transform,
        Mat4::from_translation(scene.nodes[1].transform.w_axis.truncate())
    );
    // The scene is written as a VRM animation again, and does not change.
    let again = read(&written(&scene));
    for (a, b) in scene.nodes.iter().zip(&again.nodes) {
        assert!(
            a.transform.abs_diff_eq(b.transform, 1e-5) && a.humanoid_bone == b.humanoid_bone,
            "{}",
            a.name
        );
    }
}

/// Any bytes give an error or a valid scene.
#[test]
fn damaged_files_are_errors_or_valid_scenes() {
    let mut scene = motion("real/cmu_short.bvh");
    Conversion::new()
        .trim(None, mocap::convert::Moment::Frame(2))
        .apply(&mut scene)
        .unwrap();
    let bytes = written(&scene);
    let survive = |bytes: &[u8]| {
        if let Ok(scene) = Importer::new().read(bytes, "a.vrma") {
            assert_eq!(scene.validate(), []);
            let _ = VrmaOptions::default().write(&scene);
        }
    };
    for end in (0..bytes.len()).step_by(397) {
        survive(&bytes[..end]);
    }
    for at in (0..bytes.len()).step_by(211) {
        let mut changed = bytes.clone();
        changed[at] ^= 0x15;
        survive(&changed);
    }
}
