//! Motions on other skeletons: laws for real motions and for the bodies of many programs.

use std::sync::LazyLock;

use mocap::compress::PackedClip;
use mocap::figure::report::Sides;
use mocap::figure::{Figure, Humanoid, HumanoidBone as Bone};
use mocap::glam::{Mat4, Quat, Vec3};
use mocap::retarget::report::Verdict;
use mocap::retarget::{PoseRetargetOptions, PoseRetargeter, Scale};
use mocap::scene::{Keys, Node, NodeId, NodeKind};
use mocap::{Binding, Code, Conversion, Limits, Pose, Scene};

use crate::characters::{character, motion};
use crate::truth::truth;

/// The characters, without their meshes.
const CHARACTERS: [&str; 6] = [
    "human_apose",
    "human_cmu",
    "human_default",
    "human_game_engine",
    "human_vrm0",
    "human_vrm1",
];

/// The number of frames of a motion in tests of whole clips.
const FRAMES: usize = 200;

/// The motions of humanoids among the fixtures, read once for all tests.
fn motions() -> &'static [(String, Scene)] {
    static MOTIONS: LazyLock<Vec<(String, Scene)>> = LazyLock::new(read_motions);
    &MOTIONS
}

fn read_motions() -> Vec<(String, Scene)> {
    let is_motion = |file: &String, truth: &serde_json::Value| {
        let is_large = file.contains("cmu_01_01") || file.contains("cmu_02_01") || file.contains("salsa");
        truth["humanoid"] == true && !file.contains("/human_") && !file.ends_with(".asf") && !is_large
    };
    let files = truth().into_iter().filter(|(file, truth)| is_motion(file, truth));
    let scenes = files.filter_map(|(file, _)| {
        let read = mocap::Importer::new().skeleton_mesh(mocap::SkeletonMesh::None);
        let mut scene = read.import(format!("../../fixtures/{file}")).ok()?;
        Conversion::new().apply(&mut scene).unwrap();
        // Whole clips are tested. Long clips get fewer frames, spread from the beginning to the end.
        if let Some(animation) = scene.animations.first()
            && animation.frame_count() > FRAMES
        {
            let fps = animation.ticks_per_second * FRAMES as f64 / animation.frame_count() as f64;
            scene.resample(fps, &Limits::default()).unwrap();
        }
        (!scene.animations.is_empty()).then_some((file, scene))
    });
    let scenes: Vec<_> = scenes.collect();
    assert!(scenes.len() > 12, "{}", scenes.len());
    scenes
}

/// The joints of bones by the side of the body, whatever their names are.
fn joints(scene: &Scene) -> impl Fn(Bone) -> Option<NodeId> + use<> {
    let found = Humanoid::of(scene);
    move |bone| match found.sides {
        Sides::Opposite => found.joint(bone.mirrored()),
        _ => found.joint(bone),
    }
}

/// The bones of arms and legs, each with the bone at its end.
const LIMBS: [(Bone, Bone); 8] = [
    (Bone::LeftUpperLeg, Bone::LeftLowerLeg),
    (Bone::LeftLowerLeg, Bone::LeftFoot),
    (Bone::RightUpperLeg, Bone::RightLowerLeg),
    (Bone::RightLowerLeg, Bone::RightFoot),
    (Bone::LeftUpperArm, Bone::LeftLowerArm),
    (Bone::LeftLowerArm, Bone::LeftHand),
    (Bone::RightUpperArm, Bone::RightLowerArm),
    (Bone::RightLowerArm, Bone::RightHand),
];

/// The directions of arms and legs; `None` for a limb without an end.
fn directions(pose: &Pose, joint: &impl Fn(Bone) -> Option<NodeId>) -> Vec<Option<Vec3>> {
    let way = |(from, to): (Bone, Bone)| (pose.position(joint(to)?) - pose.position(joint(from)?)).try_normalize();
    LIMBS.into_iter().map(way).collect()
}

fn angle(a: Quat, b: Quat) -> f32 {
    let between = a.inverse() * b;
    2.0 * between.xyz().length().atan2(between.w.abs())
}

/// A target with the motion of a source.
fn retargeted(source: &Scene, target: &Scene) -> Scene {
    let mut retargeter = PoseRetargeter::new(source, target, &PoseRetargetOptions::default()).unwrap();
    let animations = source
        .animations
        .iter()
        .map(|animation| retargeter.animation(source, animation));
    Scene {
        animations: animations.collect(),
        ..target.clone()
    }
}

/// Evenly spread frames of a motion.
fn frames(scene: &Scene, count: usize) -> impl Iterator<Item = f64> + use<> {
    let last = scene.animations[0].frame_count() - 1;
    (0..count).map(move |index| (index * last / (count - 1).max(1)) as f64)
}

/// The rotation about the up axis from the facing of one figure at rest to the facing of another.
fn turn(from: &Scene, to: &Scene) -> Quat {
    let heading = |scene: &Scene| {
        let facing = Figure::new(scene)
            .facing
            .value
            .direction()
            .filter(|facing| facing.y == 0.0);
        let facing = facing.unwrap_or(Vec3::Z);
        facing.x.atan2(facing.z)
    };
    Quat::from_rotation_y(heading(to) - heading(from))
}

/// The joints of this file move within their bones. A target keeps its bone lengths.
const MOVING_POSITIONS: &str = "real/perception_neuron_moving_positions.bvh";

/// The root of this body is a headset, so the body cannot be a target.
const HANGING: &str = "real/slimevr_headset_root.bvh";

/// The largest angle and the largest distance, in metres, between the joints of a whole clip and of its single poses.
fn off_between_clip_and_poses(source: &Scene, target: &Scene) -> (f32, f32) {
    let mut retargeter = PoseRetargeter::new(source, target, &PoseRetargetOptions::default()).unwrap();
    let animation = &source.animations[0];
    let clip = retargeter.animation(source, animation);
    let (from, to) = (Binding::new(source, animation), Binding::new(target, &clip));
    let (mut pose, mut single, mut of_clip) = (Pose::rest(source), Pose::rest(target), Pose::rest(target));
    let end = (animation.duration.fract() > 0.0).then_some(animation.duration);
    let (mut turned, mut moved) = (0.0_f32, 0.0_f32);
    for tick in frames(source, 13).chain(end) {
        pose.sample(&from, animation, tick);
        retargeter.pose(&pose, &mut single);
        of_clip.sample(&to, &clip, tick);
        for node in retargeter.driven() {
            let [a, b] =
                [&single, &of_clip].map(|pose| pose.node_to_world[node.index()].to_scale_rotation_translation());
            turned = turned.max(angle(a.1, b.1));
            moved = moved.max(a.2.distance(b.2));
        }
    }
    (turned, moved)
}

/// A whole clip is computed in blocks of frames, from chains of rotations. A single pose is computed from matrices.
#[test]
fn a_clip_is_its_poses() {
    let targets = ["human_cmu", "human_vrm0"].map(character);
    for (file, source) in motions() {
        for target in &targets {
            let (turned, moved) = off_between_clip_and_poses(source, target);
            assert!(turned < 1e-5 && moved < 1e-5, "{file}: {turned} rad, {moved} m");
        }
    }
}

/// Chains contain uniform scales, but not other scales. A clip may end between two frames.
#[test]
fn a_clip_of_a_scaled_body_is_its_poses() {
    let target = character("human_vrm1");
    for (bone, scale) in [
        ("Hips", Vec3::splat(2.0)),
        ("Spine", Vec3::splat(0.9)),
        ("Spine", Vec3::new(1.0, 1.5, 1.0)),
    ] {
        let mut source = motion("real/cmu_12_01_walk.bvh");
        source.animations[0].duration -= 0.5;
        let channels = &mut source.animations[0].channels;
        let channel = channels.iter_mut().find(|channel| channel.node_name == bone).unwrap();
        channel.scaling_keys = Keys::constant(scale);
        let (turned, moved) = off_between_clip_and_poses(&source, &target);
        assert!(turned < 1e-5 && moved < 1e-5, "{bone} {scale}: {turned} rad, {moved} m");
    }
}

#[test]
fn a_motion_onto_its_own_skeleton_is_the_same() {
    for (file, source) in motions()
        .iter()
        .filter(|(file, _)| file != MOVING_POSITIONS && file != HANGING)
    {
        let target = retargeted(source, source);
        let (from, to) = (&source.animations[0], &target.animations[0]);
        let bindings = (Binding::new(source, from), Binding::new(&target, to));
        let (mut a, mut b) = (Pose::rest(source), Pose::rest(&target));
        let driven: Vec<NodeId> = bindings.1.driven().map(|(node, _)| node).collect();
        assert!(driven.len() >= 11, "{file}: {}", driven.len());
        for tick in frames(source, 12) {
            a.sample(&bindings.0, from, tick);
            b.sample(&bindings.1, to, tick);
            for &node in &driven {
                let [was, is] = [&a, &b].map(|pose| pose.node_to_world[node.index()].to_scale_rotation_translation().1);
                let off = angle(was, is);
                assert!(
                    off < 1e-4,
                    "{file}: {} at {tick}: {off} rad",
                    source.nodes[node.index()].name
                );
            }
        }
    }
}

#[test]
fn every_limb_points_where_that_of_the_source_points() {
    let targets = CHARACTERS.map(|name| (name, character(name)));
    for (file, source) in motions() {
        let joint = joints(source);
        for (name, target) in &targets {
            // A body whose root is its head is as good a source as others.
            let mut retargeter = PoseRetargeter::new(source, target, &PoseRetargetOptions::default()).unwrap();
            let to_joint = joints(target);
            let turn = turn(source, target);
            let binding = Binding::new(source, &source.animations[0]);
            let (mut from, mut to) = (Pose::rest(source), Pose::rest(target));
            let (mut sum, mut count, mut worst) = (0.0, 0, 0.0_f32);
            for tick in frames(source, 8) {
                from.sample(&binding, &source.animations[0], tick);
                retargeter.pose(&from, &mut to);
                for (a, b) in std::iter::zip(directions(&from, &joint), directions(&to, &to_joint)) {
                    if let (Some(a), Some(b)) = (a, b) {
                        let off = (turn * a).angle_between(b).to_degrees();
                        (sum, count, worst) = (sum + off, count + 1, worst.max(off));
                    }
                }
            }
            let mean = sum / count as f32;
            assert!(count >= 8 * 4, "{file} on {name}: {count}");
            let words = format!("{file} on {name}: {mean} degrees in the mean, {worst} at most");
            // Two bodies with the same twist joints move joint by joint, although these joints are not on one line.
            let (mean_bound, bound) = if file.contains("makehuman") {
                (0.2, 0.5)
            } else {
                (0.02, 0.1)
            };
            assert!(mean < mean_bound && worst < bound, "{words}");
        }
    }
}

#[test]
fn a_motion_that_returns_is_the_same_within_a_degree() {
    for (file, name) in [
        ("real/cmu_12_01_walk.bvh", "human_game_engine"),
        ("real/cmu_12_01_walk.bvh", "human_default"),
        ("real/z_up_dab.bvh", "human_cmu"),
        ("real/motionbuilder_vicon_walk.bvh", "human_vrm0"),
        ("real/rokoko_dance.bvh", "human_vrm1"),
        ("skeletons/vicon_sword_attack.bvh", "human_apose"),
        ("skeletons/blender_rigify_names.bvh", "human_vrm1"),
    ] {
        let source = motion(file);
        let there = retargeted(&source, &character(name));
        let back = retargeted(&there, &source);
        let (from, to) = (&source.animations[0], &back.animations[0]);
        let bindings = (Binding::new(&source, from), Binding::new(&back, to));
        let (mut a, mut b) = (Pose::rest(&source), Pose::rest(&back));
        let (here, other) = (Humanoid::of(&source), Humanoid::of(&there));
        // If a spine has other joints, or only one body has a shoulder, each joint takes another share of the rotation.
        let returns = |bone: &Bone| {
            let is_spine = [Bone::Spine, Bone::Chest, Bone::UpperChest, Bone::Neck].contains(bone);
            !is_spine && other.bones.contains_key(bone)
        };
        let bones: Vec<Bone> = here.bones.keys().copied().filter(returns).collect();
        assert!(bones.len() >= 13, "{file}: {bones:?}");
        for tick in frames(&source, 6) {
            a.sample(&bindings.0, from, tick);
            b.sample(&bindings.1, to, tick);
            for &bone in &bones {
                let joint = here.joint(bone).unwrap();
                let [was, is] =
                    [&a, &b].map(|pose| pose.node_to_world[joint.index()].to_scale_rotation_translation().1);
                let off = angle(was, is).to_degrees();
                assert!(off < 1.0, "{file} by {name}: {bone:?} at {tick}: {off} degrees");
            }
        }
    }
}

#[test]
fn one_body_in_two_rest_poses_moves_alike() {
    let bodies = ["human_default", "human_apose"].map(character);
    let joints = bodies.each_ref().map(joints);
    for file in [
        "real/cmu_12_01_walk.bvh",
        "real/rokoko_dance.bvh",
        "real/run.fbx",
        "skeletons/accad_run_turn.bvh",
    ] {
        let source = motion(file);
        let moved = bodies.each_ref().map(|body| retargeted(&source, body));
        for tick in frames(&source, 20) {
            let [a, b] = moved.each_ref().map(|scene| Pose::at_tick(scene, 0, tick).unwrap());
            for (a, b) in std::iter::zip(directions(&a, &joints[0]), directions(&b, &joints[1])) {
                let off = a.unwrap().angle_between(b.unwrap()).to_degrees();
                assert!(off < 1.0, "{file} at {tick}: {off} degrees");
            }
        }
    }
}

/// CMU's own file of a take and its conversion to BVH differ in names, rest pose and unit.
#[test]
fn two_files_of_one_take_put_the_joints_of_a_character_in_the_same_places() {
    let [amc, bvh] = ["real/cmu_01_01.amc", "real/cmu_01_01.bvh"].map(motion);
    let target = character("human_vrm1");
    let joint = joints(&target);
    // Both maps name the joint that the BVH file calls the hand. They exclude thumbs, because only one skeleton has
    // them.
    let named = |names: [(Bone, Option<&str>); 4]| names.map(|(bone, name)| (bone, name.map(str::to_owned)));
    let wrists = [
        (Bone::LeftHand, Some("lwrist")),
        (Bone::RightHand, Some("rwrist")),
        (Bone::LeftThumbMetacarpal, None),
        (Bone::RightThumbMetacarpal, None),
    ];
    let hands = [
        (Bone::LeftHand, Some("LeftHand")),
        (Bone::RightHand, Some("RightHand")),
        (Bone::LeftThumbMetacarpal, None),
        (Bone::RightThumbMetacarpal, None),
    ];
    let moved = [(&amc, wrists), (&bvh, hands)].map(|(source, map)| {
        let options =
            PoseRetargetOptions::new().source(Humanoid::of(source).with_map(source, named(map).into()).unwrap());
        let mut retargeter = PoseRetargeter::new(source, &target, &options).unwrap();
        Scene {
            animations: vec![retargeter.animation(source, &source.animations[0])],
            ..target.clone()
        }
    });
    // The first frame of the BVH file is a rest pose that the take lacks.
    let frames = moved[0].animations[0].frame_count();
    assert_eq!(moved[1].animations[0].frame_count(), frames + 1);
    let mut worst = (0.0, Bone::Hips, 0.0);
    for tick in (0..frames).step_by(97).map(|tick| tick as f64) {
        let poses = [(&moved[0], tick), (&moved[1], tick + 1.0)];
        let [a, b] = poses.map(|(scene, tick)| Pose::at_tick(scene, 0, tick).unwrap());
        for &bone in Bone::ALL {
            if let Some(node) = joint(bone) {
                let off = a.position(node).distance(b.position(node));
                if off > worst.0 {
                    worst = (off, bone, tick);
                }
            }
        }
    }
    assert!(worst.0 < 0.01, "{worst:?}");
}

/// The nodes are rotated and scaled at rest, but the body is the same.
#[test]
fn nodes_that_are_turned_and_scaled_at_rest_move_as_before() {
    let source = motion("real/cmu_12_01_walk.bvh");
    let plain = character("human_vrm1");
    let mut changed = plain.clone();
    // The armature is in centimetres and lies on its back, and each joint has other axes.
    let mut axes = vec![Mat4::IDENTITY; changed.nodes.len()];
    for (index, node) in changed.nodes.iter_mut().enumerate() {
        let turned = Quat::from_euler(mocap::glam::EulerRot::XYZ, index as f32, 0.7 * index as f32, 0.2);
        axes[index] = Mat4::from_quat(turned.normalize());
        let parent = node.parent.map_or(Mat4::IDENTITY, |parent| axes[parent.index()]);
        node.transform = parent.inverse() * node.transform * axes[index];
    }
    let above = Mat4::from_scale_rotation_translation(Vec3::splat(0.01), Quat::from_rotation_x(-1.2), Vec3::X);
    let mut nodes = vec![Node {
        name: "Armature".to_owned(),
        kind: NodeKind::Group,
        transform: above,
        ..Node::default()
    }];
    nodes.extend(changed.nodes.into_iter().map(|node| Node {
        parent: Some(node.parent.map_or(NodeId(0), |parent| NodeId(parent.0 + 1))),
        transform: match node.parent {
            None => above.inverse() * node.transform,
            Some(_) => node.transform,
        },
        ..node
    }));
    let changed = Scene { nodes, ..plain.clone() };
    let moved = [&plain, &changed].map(|scene| retargeted(&source, scene));
    for tick in frames(&source, 10) {
        let [a, b] = moved.each_ref().map(|scene| Pose::at_tick(scene, 0, tick).unwrap());
        for index in 0..plain.nodes.len() {
            let (is, was) = (b.position(NodeId::new(index + 1)), a.position(NodeId::new(index)));
            assert!(
                is.distance(was) < 1e-3,
                "{} at {tick}: {is}, not {was}",
                plain.nodes[index].name
            );
        }
    }
}

/// The positions of the skin's vertices at a tick.
fn skinned(scene: &Scene, tick: f64) -> Vec<Vec3> {
    let pose = Pose::at_tick(scene, 0, tick).unwrap();
    let mesh = &scene.meshes[0];
    let mut vertices = vec![Vec3::ZERO; mesh.vertices.len()];
    for bone in &mesh.bones {
        let to_world = pose.node_to_world[bone.node.index()] * bone.offset_matrix;
        for weight in &bone.weights {
            let id = weight.vertex_id as usize;
            vertices[id] += weight.weight * to_world.transform_point3(mesh.vertices[id]);
        }
    }
    vertices
}

/// The bind pose stays, and the rest pose changes: arms are lowered by 45 degrees, each joint has other axes, and the
/// armature is in centimetres.
#[test]
fn the_skin_moves_as_before_where_the_rest_pose_is_another() {
    let read = mocap::Importer::new().skeleton_mesh(mocap::SkeletonMesh::Skinned);
    let plain = read.import("../../fixtures/skeletons/human_vrm1.gltf").unwrap();
    let mut changed = plain.clone();
    let rest = Pose::rest(&plain);
    let mut axes = vec![Mat4::IDENTITY; plain.nodes.len()];
    for (index, node) in changed.nodes.iter_mut().enumerate() {
        let turned = Quat::from_euler(mocap::glam::EulerRot::XYZ, 0.3 * index as f32, index as f32, 0.4);
        axes[index] = Mat4::from_quat(turned.normalize());
        // The space of each joint is in centimetres.
        axes[index] *= Mat4::from_scale(Vec3::splat(0.01));
        let parent = node.parent.map_or(Mat4::IDENTITY, |parent| axes[parent.index()]);
        node.transform = parent.inverse() * node.transform * axes[index];
    }
    for bone in &mut changed.meshes[0].bones {
        bone.offset_matrix = axes[bone.node.index()].inverse() * bone.offset_matrix;
    }
    for (bone, sign) in [(Bone::LeftUpperArm, -1.0), (Bone::RightUpperArm, 1.0)] {
        let arm = joints(&plain)(bone).unwrap();
        let down = Mat4::from_rotation_z(sign * std::f32::consts::FRAC_PI_4);
        let mut to_world = Pose::rest(&changed).node_to_world[arm.index()];
        let place = to_world.w_axis;
        assert!((place - rest.node_to_world[arm.index()].w_axis).length() < 1e-4);
        to_world = down * to_world;
        to_world.w_axis = place;
        let parent = changed.nodes[arm.index()].parent.unwrap();
        changed.nodes[arm.index()].transform = Pose::rest(&changed).node_to_world[parent.index()].inverse() * to_world;
    }
    for file in ["real/cmu_12_01_walk.bvh", "real/rokoko_dance.bvh"] {
        let source = motion(file);
        let moved = [&plain, &changed].map(|scene| retargeted(&source, scene));
        for tick in frames(&source, 6) {
            let [a, b] = moved.each_ref().map(|scene| skinned(scene, tick));
            assert!(a.len() > 1000, "{}", a.len());
            let off = std::iter::zip(&a, &b).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
            assert!(off < 0.005, "{file} at {tick}: {off} m");
        }
    }
}

#[test]
fn the_path_is_as_long_as_the_legs_ask_or_as_the_caller_says() {
    let source = motion("real/cmu_12_01_walk.bvh");
    let target = character("human_vrm0");
    let leg = |scene: &Scene| {
        let (pose, joint) = (Pose::rest(scene), joints(scene));
        let at = |bone| pose.position(joint(bone).unwrap());
        at(Bone::LeftUpperLeg).distance(at(Bone::LeftLowerLeg)) + at(Bone::LeftLowerLeg).distance(at(Bone::LeftFoot))
    };
    let path = |scene: &Scene| {
        let hips = joints(scene)(Bone::Hips).unwrap();
        let [first, last] =
            [0.0, scene.animations[0].duration].map(|tick| Pose::at_tick(scene, 0, tick).unwrap().position(hips));
        (last - first).length()
    };
    let scaled = |scale| {
        let options = PoseRetargetOptions::new().scale(scale);
        let mut retargeter = PoseRetargeter::new(&source, &target, &options).unwrap();
        let animations = vec![retargeter.animation(&source, &source.animations[0])];
        path(&Scene {
            animations,
            ..target.clone()
        })
    };
    let walked = path(&source);
    assert!(walked > 1.0, "{walked}");
    let legs = leg(&target) / leg(&source);
    assert!(legs < 0.9, "a child: {legs}");
    for (scale, factor) in [(Scale::Auto, legs), (Scale::None, 1.0), (Scale::Factor(2.0), 2.0)] {
        let is = scaled(scale);
        assert!(
            (is / walked - factor).abs() < 0.05 * factor,
            "{scale:?}: {is} of {walked}"
        );
    }
}

#[test]
fn feet_that_stand_stand_on_the_ground() {
    // The source is in metres with the floor at 0. The ankles of each character are above the floor by their own
    // height.
    let source = motion("real/cmu_12_01_walk.bvh");
    for name in CHARACTERS {
        let target = character(name);
        let (rest, joint) = (Pose::rest(&target), joints(&target));
        let feet = [Bone::LeftFoot, Bone::RightFoot].map(|foot| joint(foot).unwrap());
        let stands = feet
            .map(|foot| rest.position(foot).y)
            .into_iter()
            .fold(f32::INFINITY, f32::min);
        let moved = retargeted(&source, &target);
        let lowest = |tick| {
            let pose = Pose::at_tick(&moved, 0, tick).unwrap();
            feet.map(|foot| pose.position(foot).y)
                .into_iter()
                .fold(f32::INFINITY, f32::min)
        };
        let mut heights: Vec<f32> = frames(&source, 40).map(lowest).collect();
        heights.sort_unstable_by(f32::total_cmp);
        let middle = heights[heights.len() / 4];
        assert!((middle - stands).abs() < 0.02, "{name}: {middle}, and {stands} at rest");
    }
}

#[test]
fn what_is_no_humanoid_is_refused_with_the_reason() {
    let walk = motion("real/cmu_12_01_walk.bvh");
    let arm = mocap::import("../../fixtures/real/lecture_Test.bvh").unwrap();
    for (source, target, role) in [(&arm, &walk, "source"), (&walk, &arm, "target")] {
        let error = PoseRetargeter::new(source, target, &PoseRetargetOptions::default()).unwrap_err();
        assert_eq!(error.code(), Code::NotHumanoid);
        assert!(
            error.to_string().contains(&format!("the {role} is not a humanoid: ")),
            "{error}"
        );
    }
    // Hips cannot move a body whose root is its head.
    let hanging = motion(HANGING);
    let error = PoseRetargeter::new(&walk, &hanging, &PoseRetargetOptions::default()).unwrap_err();
    assert!(error.to_string().contains("is not below its hips"), "{error}");
    let options = PoseRetargetOptions::new().scale(Scale::Factor(0.0));
    let error = PoseRetargeter::new(&walk, &character("human_vrm1"), &options).unwrap_err();
    assert_eq!(error.code(), Code::InvalidValue);
}

#[test]
fn the_report_measures_what_is_there() {
    let source = motion("real/cmu_12_01_walk.bvh");
    let target = character("human_cmu");
    let mut retargeter = PoseRetargeter::new(&source, &target, &PoseRetargetOptions::default()).unwrap();
    let mut moved = retargeter.animation(&source, &source.animations[0]);
    let report = retargeter.measure(&source, &source.animations[0], &target, &moved);
    assert_eq!(report.verdict, Verdict::Good);
    assert_eq!(report.frames, source.animations[0].frame_count());
    assert_eq!(report.limbs.len(), 8);
    assert!(report.max_degrees < 0.1, "{}", report.max_degrees);
    let feet = report.feet.unwrap();
    assert!(feet.contact_frames > report.frames / 2, "{feet:?}");
    // On legs of other proportions, feet without a lock slide more.
    assert!(
        feet.source.skate < 0.1 && feet.source.skate < feet.target.skate,
        "{feet:?}"
    );

    // The left elbow is bent by 20 further degrees in every frame, so only the forearm deviates.
    let [node, hand] = [Bone::LeftLowerArm, Bone::LeftHand].map(|bone| joints(&target)(bone).unwrap());
    let forearm = target.nodes[hand.index()].transform.w_axis.truncate().normalize();
    let across = forearm.any_orthonormal_vector();
    let channel = moved
        .channels
        .iter_mut()
        .find(|channel| channel.node == Some(node))
        .unwrap();
    for rotation in &mut channel.rotation_keys.values {
        *rotation *= Quat::from_axis_angle(across, 20.0_f32.to_radians());
    }
    // The whole figure also sinks by 5 cm.
    for place in &mut moved.channels[0].position_keys.values {
        place.y -= 0.05;
    }
    let worse = retargeter.measure(&source, &source.animations[0], &target, &moved);
    for (limb, before) in std::iter::zip(&worse.limbs, &report.limbs) {
        let added = limb.mean_degrees - before.mean_degrees;
        let expected = if limb.bone == Bone::LeftLowerArm { 20.0 } else { 0.0 };
        assert!((added - expected).abs() < 0.1, "{limb:?}");
    }
    assert_eq!(worse.verdict, Verdict::Fair);
    let sunken = worse.feet.unwrap().target.deepest - feet.target.deepest;
    assert!((sunken - 0.05).abs() < 1e-4, "{sunken}");

    let lacks = |bone: Bone| {
        report
            .unmapped
            .iter()
            .find(|lack| lack.bone == bone)
            .map(|lack| lack.reason.as_str())
    };
    assert_eq!(lacks(Bone::LeftLowerArm), None);
    assert!(
        report
            .unmapped
            .iter()
            .all(|lack| lack.reason.contains("has no such joint")),
        "{:?}",
        report.unmapped
    );
}

#[test]
fn feet_that_are_locked_slide_no_more_than_those_of_the_source() {
    for (file, name) in [
        ("real/cmu_12_01_walk.bvh", "human_vrm0"),
        ("real/z_up_dab.bvh", "human_default"),
    ] {
        let (source, target) = (motion(file), character(name));
        let mut retargeter = PoseRetargeter::new(&source, &target, &PoseRetargetOptions::default()).unwrap();
        let free = retargeter.animation(&source, &source.animations[0]);
        let before = retargeter.measure(&source, &source.animations[0], &target, &free);
        assert!(before.slides(), "{file} on {name}: {:?}", before.feet);
        let mut locked = free.clone();
        let report = retargeter.lock_feet(&source, 0, &target, &mut locked).unwrap();
        assert!(report.slide_after < 0.1 * report.slide_before, "{report:?}");
        let after = retargeter.measure(&source, &source.animations[0], &target, &locked);
        let feet = after.feet.unwrap();
        assert!(
            feet.target.skate <= feet.source.skate + 0.005,
            "{file} on {name}: {feet:?}"
        );
        assert!(feet.target.fraction_below_floor <= 0.01, "{file} on {name}: {feet:?}");
        assert!(
            after.mean_degrees < 1.0 && !after.slides(),
            "{file} on {name}: {}",
            after.mean_degrees
        );
    }
    // On its own body, no foot starts to slide.
    let source = motion("real/cmu_12_01_walk.bvh");
    let own = retargeted(&source, &source);
    let retargeter = PoseRetargeter::new(&source, &source, &PoseRetargetOptions::default()).unwrap();
    let report = retargeter.measure(&source, &source.animations[0], &source, &own.animations[0]);
    assert!(!report.slides(), "{:?}", report.feet);
}

/// Packing moves a joint by at most 0.1 mm. The knees of this walk are straight for many frames. In these frames, such
/// a small change rotates the plane of a leg by any angle: the knees once jumped by 24 cm between frames.
#[test]
fn a_packed_walk_moves_the_knees_of_another_body_as_the_walk_does() {
    let (walk, target) = (motion("real/cmu_12_01_walk.bvh"), motion("real/rokoko_dance.bvh"));
    let clip = PackedClip::encode(&walk, 0, 1e-4).unwrap();
    let packed = mocap::Importer::new().read(clip.bytes(), "walk.mclip").unwrap();
    let moved = |source: &Scene| -> Vec<Vec<Vec3>> {
        let mut retargeter = PoseRetargeter::new(source, &target, &PoseRetargetOptions::default()).unwrap();
        let mut animation = retargeter.animation(source, &source.animations[0]);
        retargeter.lock_feet(source, 0, &target, &mut animation).unwrap();
        let binding = Binding::new(&target, &animation);
        let mut pose = Pose::rest(&target);
        let frames = 0..animation.frame_count();
        let positions = frames.map(|frame| {
            pose.sample(&binding, &animation, frame as f64);
            (0..target.nodes.len())
                .map(|node| pose.position(NodeId::new(node)))
                .collect()
        });
        positions.collect()
    };
    let (plain, packed) = (moved(&walk), moved(&packed));
    for (frame, (plain, packed)) in std::iter::zip(&plain, &packed).enumerate() {
        for (node, (plain, packed)) in std::iter::zip(plain, packed).enumerate() {
            let apart = plain.distance(*packed);
            assert!(apart < 0.005, "{} at frame {frame}: {apart} m", target.nodes[node].name);
        }
    }
}

/// The rest pose of a motion file need not show the rotation of a standing foot, but the motion does.
#[test]
fn a_foot_that_points_down_at_rest_stands_on_its_sole() {
    let plain = motion("real/cmu_12_01_walk.bvh");
    let mut pointed = plain.clone();
    for bone in [Bone::LeftFoot, Bone::RightFoot] {
        // The joint is rotated at rest by 20 degrees about the left-right axis. Its keys are changed, so that the
        // motion stays the same.
        let foot = joints(&plain)(bone).unwrap();
        pointed.nodes[foot.index()].transform *= Mat4::from_rotation_x(20.0_f32.to_radians());
    }
    let target = character("human_vrm1");
    let toes = [Bone::LeftToes, Bone::RightToes].map(|bone| joints(&target)(bone).unwrap());
    let moved = [&plain, &pointed].map(|source| retargeted(source, &target));
    for tick in frames(&plain, 20) {
        let [a, b] = moved.each_ref().map(|scene| Pose::at_tick(scene, 0, tick).unwrap());
        for toes in toes {
            let off = a.position(toes).distance(b.position(toes));
            assert!(off < 0.01, "{off} at {tick}");
        }
    }
    // In frames in which the body stands, no toe is below the floor.
    let retargeter = PoseRetargeter::new(&plain, &target, &PoseRetargetOptions::default()).unwrap();
    let report = retargeter.measure(&plain, &plain.animations[0], &target, &moved[0].animations[0]);
    assert!(
        report.feet.unwrap().target.fraction_below_floor < 0.01,
        "{:?}",
        report.feet
    );
}

/// The feet of a rest pose with its legs apart may be rolled outwards with the legs, as in CMU's database by 15 to 25
/// degrees. In the motion they stand on their soles.
#[test]
fn feet_that_are_rolled_at_rest_stand_on_their_soles() {
    let target = character("human_default");
    let (rest, joint) = (Pose::rest(&target), joints(&target));
    for file in [
        "real/cmu_12_01_walk.bvh",
        "real/cmu_01_01.bvh",
        "real/cmu_salsa_poser_names.bvh",
    ] {
        let moved = retargeted(&motion(file), &target);
        let poses: Vec<Pose> = frames(&moved, 100)
            .filter_map(|tick| Pose::at_tick(&moved, 0, tick))
            .collect();
        for foot in [Bone::LeftFoot, Bone::RightFoot] {
            let foot = joint(foot).unwrap();
            let mut heights: Vec<f32> = poses.iter().map(|pose| pose.position(foot).y).collect();
            heights.sort_unstable_by(f32::total_cmp);
            let stands = |pose: &&Pose| pose.position(foot).y <= heights[heights.len() * 2 / 5];
            // The height of the left edge of the foot above the right edge.
            let roll = |pose: &Pose| {
                let [here, there] = [pose, &rest].map(|pose| Quat::from_mat4(&pose.node_to_world[foot.index()]));
                (here * there.inverse() * Vec3::X).y.asin().to_degrees()
            };
            let mut rolls: Vec<f32> = poses.iter().filter(stands).map(roll).collect();
            rolls.sort_unstable_by(f32::total_cmp);
            let median = rolls[rolls.len() / 2];
            assert!(median.abs() < 6.0, "{file}: {median} degrees");
        }
    }
}

/// Nobody holds the head at a right angle to the chest all the time, whatever the bones of the rest pose show.
#[test]
fn heads_are_upright_on_the_average() {
    let target = character("human_vrm1");
    let (rest, joint) = (Pose::rest(&target), joints(&target));
    // A few frames are no evidence. Trackers that nobody wears are no evidence either: the file has a single odd pose.
    let is_worn = |(file, source): &&(String, Scene)| {
        source.animations[0].frame_count() >= 8 && file != "real/slimevr_headset_root.bvh"
    };
    for (file, source) in motions().iter().filter(is_worn) {
        let moved = retargeted(source, &target);
        let up = |pose: &Pose, bone: Bone| {
            let rotation = |pose: &Pose| {
                pose.node_to_world[joint(bone).unwrap().index()]
                    .to_scale_rotation_translation()
                    .1
            };
            rotation(pose) * rotation(&rest).inverse() * Vec3::Y
        };
        let poses: Vec<Pose> = frames(&moved, 40)
            .filter_map(|tick| Pose::at_tick(&moved, 0, tick))
            .collect();
        let cosines = poses
            .iter()
            .map(|pose| up(pose, Bone::Head).dot(up(pose, Bone::UpperChest)));
        let mean = cosines.sum::<f32>() / poses.len() as f32;
        assert!(mean > 0.6, "{file}: {mean}");
    }
}

/// All skeletons have similar collar bones. A computed rest pose does not show the rotation of their joints, but the
/// motion does.
#[test]
fn shoulders_are_on_the_average_as_at_rest() {
    let target = character("human_default");
    let joint = joints(&target);
    let rest = Pose::rest(&target);
    for (file, source) in motions() {
        let moved = retargeted(source, &target);
        let binding = Binding::new(&moved, &moved.animations[0]);
        let mut pose = Pose::rest(&target);
        for bone in [Bone::LeftShoulder, Bone::RightShoulder] {
            let shoulder = joint(bone).unwrap();
            let chest = target.nodes[shoulder.index()].parent.unwrap();
            let to_chest = |pose: &Pose| {
                let rotation = |node: NodeId| pose.node_to_world[node.index()].to_scale_rotation_translation().1;
                rotation(chest).inverse() * rotation(shoulder)
            };
            let mut sum = Vec3::ZERO;
            for tick in frames(source, 40) {
                pose.sample(&binding, &moved.animations[0], tick);
                let turn = to_chest(&pose) * to_chest(&rest).inverse();
                let (axis, angle) = if turn.w < 0.0 { -turn } else { turn }.to_axis_angle();
                sum += axis * angle;
            }
            let mean = (sum / 40.0).length().to_degrees();
            assert!(mean < 25.0, "{file}: {} is turned by {mean} degrees", bone.as_str());
        }
    }
}
