//! Left and right exchanged.

use mocap::edit::mirror;
use mocap::process::validate;
use mocap::skeleton::{HumanoidBone, humanoid};

use super::*;

/// Skeletons with other names, rest poses and offsets on both sides.
const CLIPS: [&str; 8] = [
    "cmu_12_01_walk.bvh",
    "motionbuilder_vicon_walk.bvh",
    "cmu_salsa_poser_names.bvh",
    "mocopi_jump_six_channels.bvh",
    "rokoko_dance.bvh",
    "perception_neuron_moving_positions.bvh",
    "kinect_openni.bvh",
    "run.fbx",
];

fn largest_distance(a: &[Vec<Vec3>], b: &[Vec<Vec3>]) -> f32 {
    let of_frame = |(a, b): (&Vec<Vec3>, &Vec<Vec3>)| a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
    a.iter().zip(b).map(of_frame).fold(0.0, f32::max)
}

#[test]
fn twice_is_the_identity_and_once_keeps_the_bones() {
    for file in CLIPS {
        if cfg!(not(feature = "fbx")) && file.ends_with("fbx") {
            continue;
        }
        let before = import(file);
        let mut scene = before.clone();
        let report = mirror(&mut scene, 0, None).unwrap();
        assert_bones_keep_their_lengths(&before, &scene);
        assert_eq!(validate(&scene), [], "{file}");
        assert!(
            report.pairs >= 8 && report.without_partner.is_empty(),
            "{file}: {report:?}"
        );
        mirror(&mut scene, 0, None).unwrap();
        let off = largest_distance(&positions(&before), &positions(&scene));
        // A micrometre, and what 32 bits hold of positions of some metres.
        assert!(off < 3e-6, "{file}: {off}");
    }
}

/// The distances between joints of both sides say it without a plane; and a heap of four joints turns inside out.
#[test]
fn each_side_does_what_the_other_did() {
    use HumanoidBone::*;
    let scene = import("cmu_12_01_walk.bvh");
    let mut other = scene.clone();
    mirror(&mut other, 0, None).unwrap();
    let found = humanoid(&scene);
    let node = |bone: HumanoidBone| found.joint(bone).unwrap().index();
    let (before, after) = (positions(&scene), positions(&other));
    for (old, new) in before.iter().zip(&after) {
        for (a, b) in [
            (LeftHand, RightFoot),
            (LeftHand, RightHand),
            (LeftFoot, RightFoot),
            (LeftHand, Head),
            (LeftLowerLeg, RightLowerArm),
        ] {
            let was = old[node(a)].distance(old[node(b)]);
            let is = new[node(a.mirrored())].distance(new[node(b.mirrored())]);
            assert!((was - is).abs() < 0.02, "{a:?} {b:?}: {was} {is}");
        }
        let volume = |at: &[Vec3], mirrored: bool| {
            let [a, b, c, d] =
                [Hips, Head, LeftHand, LeftFoot].map(|bone| at[node(if mirrored { bone.mirrored() } else { bone })]);
            (b - a).cross(c - a).dot(d - a)
        };
        assert!((volume(old, false) + volume(new, true)).abs() < 0.01);
    }
    // It walks on the same way: the hips of the first frame are where they were, and the path begins forward.
    let hips = node(Hips);
    assert!(before[0][hips].distance(after[0][hips]) < 1e-6);
    let way = |at: &[Vec<Vec3>]| (at[200][hips] - at[0][hips]).normalize();
    assert!(way(&before).dot(way(&after)) > 0.95, "{} {}", way(&before), way(&after));
}
