//! What is asked of one file twice is answered alike, whatever is asked: bones, T-pose, ground and contacts.

use mocap::Conversion;
use mocap::Scene;
use mocap::arrays::{ArrayOptions, Contacts, arrays};
use mocap::edit::{ContactOptions, contacts};
use mocap::figure::{Figure, HumanoidBone as Bone};
use mocap::glam::Vec3;
use mocap::retarget::vrm_humanoid;
use mocap::scene::{NodeId, UpAxis};

/// Rest poses of every kind, several units and up axes, feet with and without toes.
const FILES: [&str; 8] = [
    "real/cmu_12_01_walk.bvh",
    "real/rokoko_dance.bvh",
    "real/motionbuilder_vicon_walk.bvh",
    "real/mocopi_jump_six_channels.bvh",
    "real/biovision_example1.bvh",
    "real/z_up_dab.bvh",
    "skeletons/accad_run_turn.bvh",
    "real/cmu_02_01.amc",
];

fn import(file: &str) -> Scene {
    mocap::import(format!("fixtures/{file}")).unwrap()
}

/// The contacts of `edit` and those of the arrays, of the same joints in the same frames; and one rest height.
#[test]
fn a_foot_is_on_the_ground_or_is_not() {
    let mut seen = 0;
    for file in FILES {
        let scene = import(file);
        let of_edit = contacts(&scene, 0, None, &ContactOptions::default()).unwrap();
        let options = ArrayOptions::new().contacts(Contacts::new());
        let of_arrays = arrays(&scene, &options).unwrap();
        let columns = of_arrays.contacts.as_ref().unwrap();
        let (frames, joints) = (of_arrays.frames, of_arrays.joints().len());
        assert_eq!(frames, of_edit.frames, "{file}");
        let mut in_contact = 0;
        for point in &of_edit.points {
            let joint = of_arrays
                .joints()
                .iter()
                .position(|joint| joint.name == point.name)
                .unwrap();
            let column: Vec<bool> = columns.iter().skip(joint).step_by(joints).copied().collect();
            assert_eq!(column, point.at_rest, "{file}: {}", point.name);
            in_contact += point.at_rest.iter().filter(|rests| **rests).count();
        }
        assert_eq!(columns.iter().filter(|rests| **rests).count(), in_contact, "{file}");
        seen += in_contact;
    }
    assert!(seen > 1000, "{seen}");
}

/// The bones and the T-pose of the figure, and those of the VRM animation that is made of it.
#[test]
fn bones_and_t_pose_are_those_of_the_vrm_animation() {
    for file in FILES {
        let mut scene = import(file);
        Conversion::new().apply(&mut scene).unwrap();
        assert_eq!(
            (scene.metadata.metres_per_unit, scene.metadata.up),
            (Some(1.0), Some(UpAxis::Y))
        );
        let figure = Figure::new(&scene);
        let t_pose = figure.t_pose(&scene).unwrap();
        let made = vrm_humanoid(&scene, None).unwrap();
        let world = mocap::Pose::rest(&made);
        let node = |bone: Bone| made.nodes.iter().position(|node| node.humanoid_bone == Some(bone));
        let at = |bone: Bone| node(bone).map(|node| world.position(NodeId::new(node)));
        let left = at(Bone::LeftUpperArm).unwrap() - at(Bone::RightUpperArm).unwrap();
        assert!(left.x > 0.1, "{file}: {left}");
        let shoulders = |bone: Bone| t_pose.pose.position(t_pose.bones[&bone].joint);
        let across = shoulders(Bone::LeftUpperArm) - shoulders(Bone::RightUpperArm);
        // From where the figure looks in its file to +Z.
        let turn = mocap::glam::Quat::from_rotation_y((across.z).atan2(across.x) - left.z.atan2(left.x));
        for (bone, found) in &t_pose.bones {
            let Some(index) = node(*bone) else { continue };
            assert_eq!(
                made.nodes[index].name,
                scene.nodes[found.joint.index()].name,
                "{file}: {bone:?}"
            );
            if *bone == Bone::Hips {
                continue;
            }
            let hips = t_pose.bones[&Bone::Hips].joint;
            let here: Vec3 = turn * (t_pose.pose.position(found.joint) - t_pose.pose.position(hips));
            let there = at(*bone).unwrap() - at(Bone::Hips).unwrap();
            assert!(
                here.distance(there) < 2e-3,
                "{file}: {bone:?} is at {here} and at {there}"
            );
        }
    }
}
