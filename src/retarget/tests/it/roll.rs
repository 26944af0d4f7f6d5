//! The roll of bones if the rest pose does not show it: the hinges of the motion determine it.

use mocap::figure::report::Sides;
use mocap::figure::report::TPoseReason;
use mocap::figure::{Axis, Figure, Humanoid, HumanoidBone as Bone};
use mocap::glam::{Mat4, Quat, Vec3};
use mocap::retarget::report::Aspect;
use mocap::retarget::report::Verdict;
use mocap::retarget::{PoseRetargetOptions, PoseRetargeter};
use mocap::scene::{Format, Keys};
use mocap::{Conversion, Exporter, Importer, Pose, Scene, SkeletonMesh};

use crate::characters::{character, motion};
use crate::sample::Sample;

/// Files in whose rest pose the figure does not stand.
const COLLAPSED: [&str; 5] = [
    "real/rokoko_dance.bvh",
    "real/additive_root_walk.bvh",
    "skeletons/vicon_sword_attack.bvh",
    "skeletons/animics_all_along_z.bvh",
    "skeletons/accad_run_turn.bvh",
];

const LIMBS: [Bone; 8] = [
    Bone::LeftUpperLeg,
    Bone::LeftLowerLeg,
    Bone::RightUpperLeg,
    Bone::RightLowerLeg,
    Bone::LeftUpperArm,
    Bone::LeftLowerArm,
    Bone::RightUpperArm,
    Bone::RightLowerArm,
];

/// The same motion in the world, with the coordinate frame of every joint rotated by its own rotation. `start` chooses
/// these rotations.
pub(crate) fn with_other_frames(scene: &Scene, start: f32) -> Scene {
    let mut turned = scene.clone();
    let frame = |node: usize| {
        let turn = node as f32 + start;
        Quat::from_euler(
            mocap::glam::EulerRot::XYZ,
            2.4 * turn + 1.0,
            1.7 * turn - 0.5,
            0.9 * turn,
        )
    };
    let above = |node: usize| {
        let parent = scene.nodes[node].parent;
        parent.map_or(Quat::IDENTITY, |parent| frame(parent.index()))
    };
    for (index, node) in turned.nodes.iter_mut().enumerate() {
        node.transform = Mat4::from_quat(above(index).inverse()) * node.transform * Mat4::from_quat(frame(index));
    }
    for channel in turned
        .animations
        .iter_mut()
        .flat_map(|animation| &mut animation.channels)
    {
        let Some(node) = channel.node else { continue };
        let (back, own) = (above(node.index()).inverse(), frame(node.index()));
        for key in &mut channel.rotation_keys.values {
            *key = (back * *key * own).normalize();
        }
        for key in &mut channel.position_keys.values {
            *key = back * *key;
        }
    }
    turned
}

/// The rotations of a character's limbs with a motion, at some ticks.
fn limbs(source: &Scene, target: &Scene) -> Vec<Vec<Quat>> {
    let duration = source.animations[0].duration;
    let ticks: Vec<f64> = (0..8).map(|at| (duration * f64::from(at) / 8.0).floor()).collect();
    rotations(source, target, &LIMBS, &ticks)
}

/// The world rotations of bones of a character with a motion, at some ticks.
pub(crate) fn rotations(source: &Scene, target: &Scene, of: &[Bone], ticks: &[f64]) -> Vec<Vec<Quat>> {
    let mut retargeter = PoseRetargeter::new(source, target, &PoseRetargetOptions::default()).unwrap();
    let animation = retargeter.animation(source, &source.animations[0]);
    let moved = Scene {
        animations: vec![animation],
        ..target.clone()
    };
    let bones = Humanoid::of(target);
    let at_tick = |tick: &f64| {
        let pose = Pose::at_tick(&moved, 0, *tick).unwrap();
        let rotation = |bone: &Bone| {
            let matrix = pose.node_to_world[bones.joint(*bone).unwrap().index()];
            matrix.to_scale_rotation_translation().1
        };
        of.iter().map(rotation).collect()
    };
    ticks.iter().map(at_tick).collect()
}

/// Compares two motions of a character.
pub(crate) fn assert_alike(was: &[Vec<Quat>], is: &[Vec<Quat>], bones: &[Bone], what: &str) {
    for (was, is) in std::iter::zip(was, is) {
        for ((was, is), bone) in std::iter::zip(was, is).zip(bones) {
            let off = was.angle_between(*is).to_degrees();
            assert!(off < 2.0, "{what}: {} {off} degrees", bone.as_str());
        }
    }
}

/// Some frames of a motion, and the number of the first.
fn some_frames(scene: &Scene, sample: &mut Sample) -> (Scene, usize) {
    let count = scene.animations[0].frame_count();
    let size = (count / 5).max(20);
    let first = sample.below(count - size);
    let mut cut = scene.clone();
    cut.trim(first as f64, (first + size - 1) as f64);
    (cut, first)
}

#[test]
fn frames_of_a_motion_retarget_as_they_do_in_the_whole() {
    let mut sample = Sample::new();
    let target = character("human_game_engine");
    let bones: Vec<Bone> = [&LIMBS[..], &[Bone::Hips, Bone::Neck, Bone::Head]].concat();
    for file in ["real/rokoko_dance.bvh", "skeletons/vicon_sword_attack.bvh"] {
        let source = motion(file);
        let (cut, first) = some_frames(&source, &mut sample);
        let ticks: Vec<f64> = (0..20).map(f64::from).collect();
        let of_whole: Vec<f64> = ticks.iter().map(|tick| tick + first as f64).collect();
        let whole = rotations(&source, &target, &bones, &of_whole);
        let what = format!("{file} from frame {first} on");
        assert_alike(&whole, &rotations(&cut, &target, &bones, &ticks), &bones, &what);
    }
}

/// If the figure stands in the rest pose, the rest pose determines the roll of a foot's sole, whichever frames are
/// retargeted. In CMU's rest pose the legs are apart, and the feet are rolled with the legs.
#[test]
fn feet_of_any_frames_stand_as_in_the_whole() {
    let mut sample = Sample::new();
    let target = character("human_game_engine");
    let feet = [Bone::LeftFoot, Bone::RightFoot];
    for file in ["cmu_12_01_walk", "cmu_01_01", "cmu_salsa_poser_names", "z_up_dab"] {
        let source = motion(&format!("real/{file}.bvh"));
        let (cut, first) = some_frames(&source, &mut sample);
        let ticks: Vec<f64> = (0..20).map(f64::from).collect();
        let of_whole: Vec<f64> = ticks.iter().map(|tick| tick + first as f64).collect();
        let whole = rotations(&source, &target, &feet, &of_whole);
        let what = format!("{file} from frame {first} on");
        assert_alike(&whole, &rotations(&cut, &target, &feet, &ticks), &feet, &what);
    }
}

/// This body stands above the origin with its head towards -Y. At rest it lies along +Z, and only its hands move.
#[test]
fn any_frames_of_a_body_that_stands_have_one_up_axis() {
    let mut sample = Sample::new();
    let source = mocap::import("../../fixtures/skeletons/animics_all_along_z.bvh").unwrap();
    for _ in 0..8 {
        let (cut, first) = some_frames(&source, &mut sample);
        let up = Figure::new(&cut).up;
        assert_eq!(up.value, Axis::NegY, "from frame {first} on: {}", up.reason);
    }
}

/// Bones with arbitrary directions at rest may look like a standing body.
#[test]
fn a_rest_pose_by_chance_does_not_exchange_the_sides() {
    let mut sample = Sample::new();
    let source = motion("real/motionbuilder_vicon_walk.bvh");
    for _ in 0..12 {
        let start = sample.below(1000) as f32;
        let sides = Figure::new(&with_other_frames(&source, start)).humanoid.sides;
        assert_ne!(sides, Sides::Opposite, "frames turned from {start} on");
    }
}

/// The knuckles are children of joints that are not bones.
#[test]
fn hands_do_not_depend_on_the_frames_of_joints() {
    let mut sample = Sample::new();
    let target = character("human_game_engine");
    let bones = [Bone::LeftHand, Bone::RightHand];
    for file in ["real/rokoko_dance.bvh", "real/additive_root_walk.bvh"] {
        let source = motion(file);
        let start = sample.below(1000) as f32;
        let ticks: Vec<f64> = (0..20).map(f64::from).collect();
        let expected = rotations(&source, &target, &bones, &ticks);
        let turned = rotations(&with_other_frames(&source, start), &target, &bones, &ticks);
        assert_alike(&expected, &turned, &bones, &format!("{file} turned from {start} on"));
    }
}

/// A dancer lifts the heels: the median slope from ankle to toes is 56 degrees down. A character has this slope, except
/// for the difference of the soles.
#[test]
fn a_dancer_who_lifts_the_heels_lifts_them_on_a_character() {
    let source = motion("real/rokoko_dance.bvh");
    let target = character("human_game_engine");
    let mut retargeter = PoseRetargeter::new(&source, &target, &PoseRetargetOptions::default()).unwrap();
    let moved = Scene {
        animations: vec![retargeter.animation(&source, &source.animations[0])],
        ..target
    };
    let down = |scene: &Scene, ankle: &str, toes: &str| {
        let node = |name: &str| scene.nodes.iter().position(|node| node.name == name).unwrap();
        let (ankle, toes) = (node(ankle), node(toes));
        let frames = (0..source.animations[0].frame_count()).step_by(10);
        let mut angles: Vec<f32> = frames
            .map(|frame| {
                let pose = Pose::at_tick(scene, 0, frame as f64).unwrap();
                let at = |node: usize| pose.node_to_world[node].w_axis.truncate();
                (at(ankle) - at(toes)).normalize().y.asin().to_degrees()
            })
            .collect();
        angles.sort_unstable_by(f32::total_cmp);
        angles[angles.len() / 2]
    };
    for (of_source, of_target) in [
        (["LeftFoot", "LeftToeBase"], ["foot_l", "ball_l"]),
        (["RightFoot", "RightToeBase"], ["foot_r", "ball_r"]),
    ] {
        let was = down(&source, of_source[0], of_source[1]);
        let is = down(&moved, of_target[0], of_target[1]);
        assert!(was > 50.0 && (is - was).abs() < 15.0, "{of_source:?}: {was}, {is}");
    }
}

#[test]
fn a_limb_that_never_bends_has_the_hinge_of_the_other_side() {
    let source = motion("skeletons/vicon_sword_attack.bvh");
    let figure = Figure::new(&source);
    let expected = figure.t_pose(&source).unwrap();
    let mut stiff = source.clone();
    for bone in [Bone::RightLowerArm, Bone::LeftLowerLeg] {
        let joint = expected.bones[&bone].joint;
        let mut channels = stiff.animations[0].channels.iter_mut();
        let channel = channels.find(|channel| channel.node == Some(joint)).unwrap();
        channel.rotation_keys = Keys::constant(Quat::IDENTITY);
    }
    let figure = Figure::new(&stiff);
    let t_pose = figure.t_pose(&stiff).unwrap();
    for bone in [Bone::RightUpperArm, Bone::LeftUpperLeg] {
        let found = &t_pose.bones[&bone];
        assert_eq!(found.reason, TPoseReason::OtherSide, "{}", bone.as_str());
        let rotation = |pose: &Pose| {
            pose.node_to_world[found.joint.index()]
                .to_scale_rotation_translation()
                .1
        };
        let off = rotation(&t_pose.pose)
            .angle_between(rotation(&expected.pose))
            .to_degrees();
        assert!(off < 1.0, "{}: {off} degrees", bone.as_str());
    }
}

#[test]
fn limbs_bend_on_a_character_where_they_bend_in_the_motion() {
    let target = character("human_game_engine");
    for file in COLLAPSED {
        let source = motion(file);
        let mut retargeter = PoseRetargeter::new(&source, &target, &PoseRetargetOptions::default()).unwrap();
        let (_, report) = retargeter.clip(&source, 0, &target, false).unwrap();
        let of = |aspect: Aspect| report.seen.iter().filter(move |seen| seen.aspect == aspect);
        assert!(of(Aspect::Roll).count() >= 2, "{file}: {:?}", report.seen);
        for seen in of(Aspect::Roll).chain(of(Aspect::Trunk)) {
            assert!(seen.mean_degrees < 10.0, "{file}: {seen:?}");
        }
        assert_ne!(report.verdict, Verdict::Poor, "{file}");
        // Forearms only count if the elbow is a single hinge. In the clip in the style of 100STYLE, the arms hang.
        let forearms = of(Aspect::Roll).filter(|seen| [Bone::LeftLowerArm, Bone::RightLowerArm].contains(&seen.bone));
        assert_eq!(
            forearms.count(),
            if file.contains("all_along_z") { 0 } else { 2 },
            "{file}"
        );
    }
}

#[test]
fn the_frames_of_joints_say_nothing_where_the_rest_pose_does_not_stand() {
    let target = character("human_game_engine");
    for file in ["skeletons/vicon_sword_attack.bvh", "skeletons/accad_run_turn.bvh"] {
        let source = motion(file);
        let other = with_other_frames(&source, 0.0);
        let [pose, turned] = [&source, &other].map(|scene| Pose::at_tick(scene, 0, 7.0).unwrap());
        let moved = std::iter::zip(&pose.node_to_world, &turned.node_to_world);
        let moved = moved.map(|(a, b)| a.transform_point3(Vec3::ZERO).distance(b.transform_point3(Vec3::ZERO)));
        assert!(moved.fold(0.0, f32::max) < 1e-3, "{file}: another motion");
        assert_alike(&limbs(&source, &target), &limbs(&other, &target), &LIMBS, file);
    }
}

/// Files of several programs. In the rest pose of some files, the figure stands; in others, it does not. One file
/// begins with CMU's T-pose. In further files, joints have a constant rotation that differs from the rest pose.
const FORMS: [&str; 7] = [
    "real/rokoko_dance.bvh",
    "real/additive_root_walk.bvh",
    "real/additive_root_pose.bvh",
    "real/cmu_short.bvh",
    "real/z_up_dab.bvh",
    "skeletons/vicon_sword_attack.bvh",
    "real/biovision_example1.bvh",
];

#[test]
fn a_motion_retargets_alike_from_every_format_that_holds_it() {
    let target = character("human_game_engine");
    for file in FORMS {
        let mut source = motion(file);
        // The part is long enough to show the hinges.
        source.trim(0.0, 200.0);
        let expected = limbs(&source, &target);
        for format in [Format::Gltf, Format::Mclip, Format::Vrma, Format::Fbx] {
            // A glTF without a mesh has no skin, and so no bind pose.
            let written = Exporter::new().max_error(0.0005).write(&source, format).unwrap();
            let bytes = written.files[0].bytes();
            let importer = Importer::new().format(format);
            let mut read = importer.read(&bytes, "motion").unwrap();
            Conversion::new().apply(&mut read).unwrap();
            assert_alike(
                &expected,
                &limbs(&read, &target),
                &LIMBS,
                &format!("{file} as {format:?}"),
            );
        }
    }
}

/// Many programs write nodes that hold the constant tracks, and a skin that holds the rest pose.
#[test]
fn the_rest_pose_of_gltf_with_a_skin_is_its_bind_pose() {
    let importer = Importer::new().skeleton_mesh(SkeletonMesh::Skinned);
    let mut scene = importer.import("../../fixtures/real/rokoko_dance.bvh").unwrap();
    Conversion::new().apply(&mut scene).unwrap();
    let written = Exporter::new().write(&scene, Format::Gltf).unwrap();
    let bytes = written.files[0].bytes();
    let nodes = gltf::Gltf::from_slice(&bytes).unwrap();
    let rotated = nodes.nodes().filter(|node| node.transform().decomposed().1[3] < 0.99);
    assert!(
        rotated.count() >= 5,
        "all nodes stand as at rest, so that this shows nothing"
    );
    let read = Importer::new().read(&bytes, "a.glb").unwrap();
    let same = |was: &Pose, is: &Pose, what: &str| {
        for (index, node) in scene.nodes.iter().enumerate() {
            let (was, is) = (was.node_to_world[index], is.node_to_world[index]);
            assert!(was.abs_diff_eq(is, 1e-4), "{what}: {} is at {is}, not {was}", node.name);
        }
    };
    same(&Pose::rest(&scene), &Pose::rest(&read), "at rest");
    let middle = |scene: &Scene| Pose::at_tick(scene, 0, 500.0).unwrap();
    same(&middle(&scene), &middle(&read), "in motion");
}

#[test]
fn a_t_pose_says_why_a_limb_is_rolled_as_it_is() {
    let scene = mocap::import("../../fixtures/real/rokoko_dance.bvh").unwrap();
    let figure = Figure::new(&scene);
    let t_pose = figure.t_pose(&scene).unwrap();
    for bone in [
        Bone::LeftUpperArm,
        Bone::RightUpperArm,
        Bone::LeftUpperLeg,
        Bone::RightUpperLeg,
    ] {
        assert_eq!(t_pose.bones[&bone].reason, TPoseReason::Hinge, "{}", bone.as_str());
    }
    assert_eq!(t_pose.bones[&Bone::LeftHand].reason, TPoseReason::Knuckles);
}
