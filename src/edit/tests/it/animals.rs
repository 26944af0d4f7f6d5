//! Tests of steps on an animal on four legs.

use mocap::edit::{FootLockOptions, Mirror, Step, StepInput, foot_lock};
use mocap::glam::Vec3;
use mocap::scene::{NodeId, Scene};
use mocap::{Binding, Pose};

/// The front and hind paws of the dog, left before right.
const PAWS: [&str; 4] = ["b__LeftFinger", "b_RightFinger", "b_LeftAnkle", "b_RightAnkle"];

/// The shoulders and hips, left before right.
const HIPS: [&str; 4] = ["b_LeftArm", "b_RightArm", "b_LeftLegUpper", "b_RightLegUpper"];

fn dog() -> Scene {
    mocap::import("../../fixtures/made/dog_walk.bvh").unwrap()
}

/// The places of some joints in each frame, in centimetres with +Y up.
fn places(scene: &Scene, names: [&str; 4]) -> Vec<[Vec3; 4]> {
    let node = |name: &str| NodeId::new(scene.nodes.iter().position(|node| node.name == name).unwrap());
    let nodes = names.map(node);
    let motion = &scene.animations[0];
    let binding = Binding::new(scene, motion);
    let mut pose = Pose::rest(scene);
    let frame = |frame: usize| {
        pose.sample(&binding, motion, frame as f64);
        nodes.map(|node| pose.position(node))
    };
    (0..motion.frame_count()).map(frame).collect()
}

/// The positions of the paws relative to the midpoint of hips and shoulders: left, up and forward, in each frame.
fn paws_of_trunk(scene: &Scene) -> Vec<[Vec3; 4]> {
    let frames = places(scene, HIPS).into_iter().zip(places(scene, PAWS));
    let of_frame = |(hips, paws): ([Vec3; 4], [Vec3; 4])| {
        let forward = (hips[0] + hips[1] - hips[2] - hips[3]).with_y(0.0).normalize();
        let left = Vec3::Y.cross(forward);
        let middle = 0.25 * hips.into_iter().sum::<Vec3>();
        paws.map(|paw| {
            let from = paw - middle;
            Vec3::new(from.dot(left), from.y, from.dot(forward))
        })
    };
    frames.map(of_frame).collect()
}

#[test]
fn a_mirrored_dog_steps_with_the_other_paws() {
    let dog = dog();
    let mut mirrored = dog.clone();
    let report = Mirror::new().apply(&mut mirrored, &StepInput::new()).unwrap();
    assert!(report.pairs >= 12, "{report}");
    for (was, is) in paws_of_trunk(&dog).into_iter().zip(paws_of_trunk(&mirrored)) {
        for (paw, other) in [(0, 1), (1, 0), (2, 3), (3, 2)] {
            let expected = was[paw] * Vec3::new(-1.0, 1.0, 1.0);
            assert!(is[other].distance(expected) < 0.1, "{} cm and {expected}", is[other]);
        }
    }
    Mirror::new().apply(&mut mirrored, &StepInput::new()).unwrap();
    for (was, is) in places(&dog, PAWS).into_iter().zip(places(&mirrored, PAWS)) {
        assert!((0..4).all(|paw| was[paw].distance(is[paw]) < 0.01));
    }
}

#[test]
fn paws_of_a_dog_stand_still() {
    let dog = dog();
    let mut locked = dog.clone();
    let report = foot_lock(&mut locked, 0, &FootLockOptions::default()).unwrap();
    assert!(
        report.contacts >= 4 && report.slide_after < 0.1 * report.slide_before,
        "{report}"
    );
    // The paws that hardly move before the lock move less after it.
    let (before, after) = (places(&dog, PAWS), places(&locked, PAWS));
    let step = |frames: &[[Vec3; 4]], frame: usize, paw: usize| {
        (frames[frame][paw] - frames[frame - 1][paw]).with_y(0.0).length()
    };
    let (mut was, mut is) = (0.0, 0.0);
    for paw in 0..4 {
        for frame in (1..before.len()).filter(|frame| step(&before, *frame, paw) < 0.6) {
            was += step(&before, frame, paw);
            is += step(&after, frame, paw);
        }
    }
    assert!(is < 0.3 * was, "{is} and {was} cm");
}
