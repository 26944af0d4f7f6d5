//! Tests of joint axes along bones.

use mocap::convert::AlongBone;
use mocap::edit::{BoneAxis, Step, StepInput};
use mocap::fbx::FbxOptions;
use mocap::glam::Mat4;
use mocap::gltf::GltfOptions;
use mocap::scene::NodeKind;

use super::*;

const CLIPS: [&str; 5] = [
    "cmu_12_01_walk.bvh",
    "rokoko_dance.bvh",
    "mocopi_jump_six_channels.bvh",
    "motionbuilder_vicon_walk.bvh",
    "makehuman_zombie_walk.bvh",
];

/// The matrices of nodes at rest to the world, as products of the nodes' own matrices.
fn at_rest(scene: &Scene) -> Vec<Mat4> {
    let mut to_world: Vec<Mat4> = Vec::new();
    for node in &scene.nodes {
        to_world.push(
            node.parent
                .map_or(node.transform, |parent| to_world[parent.index()] * node.transform),
        );
    }
    to_world
}

/// The largest angle in degrees between the axis of a joint and the line to its child, for joints with one child. Also
/// returns the number of these joints.
fn farthest_from_child(scene: &Scene, axis: AlongBone) -> (f32, usize) {
    let rest = at_rest(scene);
    let is_of_skeleton = |index: usize| scene.nodes[index].kind != NodeKind::Group;
    let (mut farthest, mut joints) = (0.0_f32, 0);
    for joint in (0..scene.nodes.len()).filter(|index| is_of_skeleton(*index)) {
        let of_joint = |index: &usize| scene.nodes[*index].parent == Some(NodeId::new(joint)) && is_of_skeleton(*index);
        let children: Vec<usize> = (0..scene.nodes.len()).filter(of_joint).collect();
        let [child] = children[..] else { continue };
        let line = (rest[child].w_axis - rest[joint].w_axis).truncate();
        if line.length() < 1e-3 {
            continue;
        }
        let along = match axis {
            AlongBone::Y => rest[joint].y_axis,
            _ => rest[joint].x_axis,
        };
        farthest = farthest.max(along.truncate().angle_between(line).to_degrees());
        joints += 1;
    }
    (farthest, joints)
}

/// The axis points to the child, in the scene and in written files. Every joint keeps its position, at rest and in
/// every frame.
#[test]
fn bones_lie_along_their_axis_and_nothing_moves() {
    for file in CLIPS {
        for axis in [AlongBone::Y, AlongBone::X] {
            let before = import(file);
            let mut scene = before.clone();
            let (was, _) = farthest_from_child(&before, axis);
            let report = BoneAxis::new().axis(axis).apply(&mut scene, &StepInput::new()).unwrap();
            assert_eq!(scene.validate(), [], "{file}");
            let (now, joints) = farthest_from_child(&scene, axis);
            assert!(
                was > 10.0 && now < 0.1 && joints > 10,
                "{file}: {was}, then {now} of {joints}"
            );
            assert!(report.largest_rotation > 10.0, "{file}: {report:?}");
            for (was, is) in at_rest(&before).iter().zip(at_rest(&scene)) {
                assert!(was.w_axis.distance(is.w_axis) < 1e-5, "{file}");
            }
            for (was, is) in exact_positions(&before)
                .iter()
                .flatten()
                .zip(exact_positions(&scene).iter().flatten())
            {
                assert!(was.distance(*is) < 1e-5, "{file}: {was} {is}");
            }
            let glb = GltfOptions::default().write_glb(&scene).unwrap();
            let fbx = FbxOptions::default().write(&scene).unwrap().0;
            for (bytes, name) in [(glb, "a.glb"), (fbx, "a.fbx")] {
                let written = mocap::Importer::new().read(&bytes, name).unwrap();
                let (now, joints) = farthest_from_child(&written, axis);
                assert!(now < 0.1 && joints > 10, "{file} in {name}: {now} of {joints}");
            }
        }
    }
}

/// Knees and elbows bend about one axis of their joint. The positions of hip, knee and ankle show the axis about which
/// the shin bends relative to the thigh. In a clip in which knees bend, this axis is the X axis of the knee's joint.
#[test]
fn hinges_bend_about_an_axis_of_the_frame() {
    use mocap::figure::{Humanoid, HumanoidBone as Bone};
    for file in [
        "cmu_12_01_walk.bvh",
        "motionbuilder_vicon_walk.bvh",
        "mocopi_jump_six_channels.bvh",
    ] {
        let mut scene = import(file);
        BoneAxis::new().apply(&mut scene, &StepInput::new()).unwrap();
        let found = Humanoid::of(&scene);
        let binding = Binding::new(&scene, &scene.animations[0]);
        let mut pose = Pose::rest(&scene);
        let (mut sum, mut count) = (0.0, 0.0);
        for frame in 0..scene.animations[0].frame_count() {
            pose.sample(&binding, &scene.animations[0], frame as f64);
            for bones in [
                [Bone::LeftUpperLeg, Bone::LeftLowerLeg, Bone::LeftFoot],
                [Bone::RightUpperLeg, Bone::RightLowerLeg, Bone::RightFoot],
            ] {
                let [hip, knee, ankle] = bones.map(|bone| found.joint(bone).unwrap());
                let thigh = (pose.position(knee) - pose.position(hip)).normalize();
                let shin = (pose.position(ankle) - pose.position(knee)).normalize();
                let bend = thigh.cross(shin);
                if bend.length() > 0.4 {
                    let x = pose.node_to_world[knee.index()].x_axis.truncate();
                    sum += x.angle_between(bend).to_degrees();
                    count += 1.0;
                }
            }
        }
        assert!(
            count > 10.0 && sum / count < 15.0,
            "{file}: {} degrees in {count} frames",
            sum / count
        );
    }
}

/// A bone may lie along the bending axis of the joint above. The joint of this bone also gets an axis along the bone.
#[test]
fn a_bone_along_the_axis_of_bending_has_a_frame_along_it() {
    let text = "HIERARCHY\nROOT hips\n{\nOFFSET 0 1 0\nCHANNELS 3 Zrotation Xrotation Yrotation\n\
                JOINT side\n{\nOFFSET 0 0 0\nCHANNELS 3 Zrotation Xrotation Yrotation\nEnd Site\n{\nOFFSET -0.1 0 0\n}\n}\n\
                JOINT up\n{\nOFFSET 0 0.2 0\nCHANNELS 3 Zrotation Xrotation Yrotation\nEnd Site\n{\nOFFSET 0 0.2 0\n}\n}\n}\n\
                MOTION\nFrames: 1\nFrame Time: 0.1\n0 0 0 0 0 0 0 0 0\n";
    let mut scene = mocap::Importer::new().read(text.as_bytes(), "a.bvh").unwrap();
    BoneAxis::new().apply(&mut scene, &StepInput::new()).unwrap();
    let (farthest, joints) = farthest_from_child(&scene, AlongBone::Y);
    assert!(farthest < 0.1 && joints == 2, "{farthest} of {joints}");
}
