//! A dog, retargeted to animals with other proportions, other numbers of joints, and other names.

use std::f32::consts::FRAC_PI_2;
use std::sync::LazyLock;

use mocap::figure::report::QuadrupedLeg;
use mocap::figure::{Axis, Figure};
use mocap::glam::{Mat4, Quat, Vec3};
use mocap::retarget::report::Verdict;
use mocap::retarget::{RetargetOptions, Retargeter};
use mocap::scene::{NodeId, Scene};
use mocap::{Binding, Pose};

use crate::creatures::{Body, skeleton};

static DOG: LazyLock<Scene> = LazyLock::new(|| mocap::import("../../fixtures/made/dog_walk.bvh").unwrap());

/// A horse of 1.5 m whose trunk is one joint. Its feet are children of the root, at the ends of the shins.
fn horse() -> Scene {
    let mut horse = Body::default();
    let root = horse.add("Armature", None, [0.0, 0.0, 0.0]);
    let trunk = horse.add("Trunk", Some(root), [0.0, 120.0, 0.0]);
    horse.chain(
        &["Throat", "Throat1", "Skull", "Skull_end"],
        trunk,
        &[
            [0.0, 20.0, 55.0],
            [0.0, 25.0, 15.0],
            [0.0, 25.0, 15.0],
            [0.0, -10.0, 40.0],
        ],
    );
    horse.chain(
        &["Tail_a", "Tail_b", "Tail_c", "Tail_c_end"],
        trunk,
        &[
            [0.0, 10.0, -70.0],
            [0.0, -10.0, -15.0],
            [0.0, -25.0, -5.0],
            [0.0, -25.0, 0.0],
        ],
    );
    for (end, z) in [("Front", 50.0), ("Back", -55.0)] {
        for (side, x) in [("L", 18.0), ("R", -18.0)] {
            let names = ["UpLeg", "LowLeg", "LowLeg_end"].map(|part| format!("{end}{part}.{side}"));
            let bend = if end == "Front" { -6.0 } else { 8.0 };
            let offsets = [[x, -10.0, z], [0.0, -55.0, bend], [0.0, -50.0, -bend]];
            horse.chain(&names.each_ref().map(String::as_str), trunk, &offsets);
            let foot = horse.add(&format!("{end}Foot.{side}"), Some(root), [x, 5.0, z]);
            horse.add(&format!("{end}Foot.{side}_end"), Some(foot), [0.0, -5.0, 8.0]);
        }
    }
    skeleton(&horse.0)
}

/// A mouse in centimetres, whose legs have the joints of the dog's legs. Its hind feet lie on the ground.
fn mouse() -> Scene {
    let mut mouse = Body::default();
    let pelvis = mouse.add("m0", None, [0.0, 4.0, 0.0]);
    let chest = mouse.chain(
        &["m1", "m2", "m3", "m4"],
        pelvis,
        &[[0.0, 0.5, 1.2], [0.0, 0.3, 1.2], [0.0, 0.0, 1.2], [0.0, -0.3, 1.2]],
    );
    mouse.chain(
        &["m5", "m6", "m7"],
        chest,
        &[[0.0, 0.3, 0.8], [0.0, 0.4, 0.8], [0.0, -0.3, 1.5]],
    );
    let tail: Vec<String> = (10..16).map(|joint| format!("m{joint}tail")).collect();
    let tail: Vec<&str> = tail.iter().map(String::as_str).collect();
    mouse.chain(&tail, pelvis, &[[0.0, 0.0, -1.3]; 6]);
    for (first, x) in [(20, 0.7), (30, -0.7)] {
        let names: Vec<String> = (first..first + 9).map(|joint| format!("m{joint}")).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        mouse.chain(
            &names[..4],
            chest,
            &[[x, -0.6, 0.2], [0.0, -1.2, -0.4], [0.0, -1.3, 0.3], [0.0, -0.4, 0.5]],
        );
        mouse.chain(
            &names[4..],
            pelvis,
            &[
                [x, -0.4, -0.2],
                [0.0, -1.3, 0.9],
                [0.0, -1.6, -1.2],
                [0.0, -0.3, 1.3],
                [0.0, 0.0, 0.4],
            ],
        );
    }
    skeleton(&mouse.0)
}

/// The joints of a leg that both animals have: hip or shoulder, stifle or elbow, and paw.
fn anchors(leg: &QuadrupedLeg) -> [NodeId; 3] {
    [leg.upper, leg.lower, leg.paw]
}

/// The positions of some joints in each frame, in metres with +Y up.
fn places(scene: &Scene, animation: usize, joints: &[NodeId]) -> Vec<Vec<Vec3>> {
    let metres = Figure::new(scene).survey.metres_per_unit as f32;
    let motion = &scene.animations[animation];
    let binding = Binding::new(scene, motion);
    let mut pose = Pose::rest(scene);
    let frame = |frame: usize| {
        pose.sample(&binding, motion, frame as f64);
        joints.iter().map(|joint| metres * pose.position(*joint)).collect()
    };
    (0..motion.frame_count()).map(frame).collect()
}

/// The hip, the knee and the paw of each leg, for each frame of the dog and of the other animal.
fn on(target: Scene) -> (Vec<Vec<Vec3>>, Vec<Vec<Vec3>>, Retargeter) {
    let mut dog = DOG.clone();
    mocap::Conversion::new().apply(&mut dog).unwrap();
    let legs = |scene: &Scene| -> Vec<NodeId> {
        let found = Figure::new(scene).quadruped(scene).unwrap().clone();
        found.legs.iter().flat_map(anchors).collect()
    };
    let joints = [legs(&dog), legs(&target)];
    let done = Retargeter::new(DOG.clone(), target, RetargetOptions::new()).unwrap();
    let moved = done.scene();
    (places(&dog, 0, &joints[0]), places(&moved, 0, &joints[1]), done)
}

/// The mean angle in degrees between the directions from one joint to the next.
fn off(was: &[Vec<Vec3>], is: &[Vec<Vec3>], from: usize, to: usize) -> f32 {
    let angle = |(was, is): (&Vec<Vec3>, &Vec<Vec3>)| (was[to] - was[from]).angle_between(is[to] - is[from]);
    was.iter().zip(is).map(angle).sum::<f32>().to_degrees() / was.len() as f32
}

#[test]
fn a_dog_walks_on_a_horse() {
    let (was, is, done) = on(horse());
    let report = done.clips()[0].report.body().unwrap();
    assert_ne!(report.verdict, Verdict::Poor, "{report}");
    let (mut slid, mut stood) = (0.0, 0);
    for leg in 0..4 {
        let [hip, knee, paw] = [0, 1, 2].map(|joint| 3 * leg + joint);
        for (from, to, most) in [(hip, knee, 10.0), (hip, paw, 5.0)] {
            let off = off(&was, &is, from, to);
            assert!(off < most, "{leg} {from} {to}: {off}, {report}");
        }
        // The paw of the dog is on the ground in the frames in which it is low and slow.
        let low = was.iter().map(|frame| frame[paw].y).fold(f32::MAX, f32::min) + 0.02;
        let size = (is[0][hip] - is[0][paw]).length() / (was[0][hip] - was[0][paw]).length();
        for frame in 1..was.len() {
            let step = |frames: &[Vec<Vec3>]| (frames[frame][paw] - frames[frame - 1][paw]).with_y(0.0).length();
            if was[frame][paw].y < low && was[frame - 1][paw].y < low && step(&was) < 0.004 {
                slid += step(&is) / size;
                stood += 1;
            }
        }
    }
    assert!(stood > 40 && slid < 0.003 * stood as f32, "{slid} m in {stood} frames");
    // Left stays left: seen along the path, the left hips are on the left.
    let way = is[is.len() - 1][0] - is[0][0];
    for pair in [0, 6] {
        let left = is[10][pair] - is[10][pair + 3];
        assert!(Vec3::Y.cross(way).dot(left) > 0.0);
    }
}

#[test]
fn legs_show_the_up_axis() {
    for (axis, turn) in [(Axis::Y, Quat::IDENTITY), (Axis::Z, Quat::from_rotation_x(FRAC_PI_2))] {
        let mut scene = mouse();
        scene.metadata.up = None;
        scene.nodes[0].transform = Mat4::from_quat(turn) * scene.nodes[0].transform;
        assert_eq!(Figure::new(&scene).up.value, axis);
    }
}

/// The tail of the mouse bends like the tail of the dog, so its tip moves.
#[test]
fn the_tail_follows() {
    let target = mouse();
    let joints: Vec<NodeId> = ["m0", "m4", "m15tail"]
        .iter()
        .map(|name| NodeId::new(target.nodes.iter().position(|node| node.name == **name).unwrap()))
        .collect();
    let done = Retargeter::new(DOG.clone(), target, RetargetOptions::new()).unwrap();
    let frames = places(&done.scene(), 0, &joints);
    let bend = |frame: &Vec<Vec3>| (frame[2] - frame[0]).angle_between(frame[1] - frame[0]);
    let bends: Vec<f32> = frames.iter().map(bend).collect();
    let range = bends.iter().fold(f32::MIN, |most, bend| most.max(*bend))
        - bends.iter().fold(f32::MAX, |least, bend| least.min(*bend));
    assert!(range > 0.02, "{range}");
}
