//! Hands of the target touch the parts that the source's hands touch. The tests measure the distances of wrists in the
//! poses of both motions. `tools/hands/check` measures with meshes and separate code.

use mocap::figure::HumanoidBone as Bone;
use mocap::figure::{Figure, Humanoid};
use mocap::retarget::report::{HandContact, RetargetReport, TouchedPart};
use mocap::retarget::{PoseRetargetOptions, PoseRetargeter, RetargetOptions, Retargeter};
use mocap::scene::Animation;
use mocap::{Binding, Importer, Pose, Scene};

const SALSA: &str = "../../fixtures/real/cmu_salsa_poser_names.bvh";
const CHILD: &str = "../../fixtures/characters/human_vrm0.vrm";

fn character() -> Scene {
    Importer::new().gltf_meshes(true).import(CHILD).unwrap()
}

/// A motion on a character, and its report.
fn moved(source: &str, keep: bool) -> (Animation, RetargetReport) {
    let options = RetargetOptions::new().keep_hands(keep);
    let retargeting = Retargeter::new(mocap::import(source).unwrap(), character(), options).unwrap();
    let clip = retargeting.into_clips().remove(0);
    (clip.animation, clip.report.body().unwrap().clone())
}

/// The mean distance of the wrists in a contact, in lengths of the leg.
fn wrists(scene: &Scene, animation: &Animation, [first, last]: [f64; 2]) -> f32 {
    let figure = Figure::with_bones(scene, Humanoid::of(scene));
    let joint = |bone: Bone| figure.humanoid.joint(bone).unwrap();
    let binding = Binding::new(scene, animation);
    let mut pose = Pose::rest(scene);
    let [hip, knee, foot] =
        [Bone::LeftUpperLeg, Bone::LeftLowerLeg, Bone::LeftFoot].map(|bone| pose.position(joint(bone)));
    let leg = hip.distance(knee) + knee.distance(foot);
    let frames = first as usize..=last as usize;
    let count = frames.clone().count() as f32;
    let distances = frames.map(|frame| {
        pose.sample(&binding, animation, frame as f64);
        pose.position(joint(Bone::LeftHand))
            .distance(pose.position(joint(Bone::RightHand)))
    });
    distances.sum::<f32>() / count / leg
}

#[test]
fn hands_that_meet_are_as_far_apart_as_in_the_source() {
    let (kept, report) = moved(SALSA, true);
    let (free, free_report) = moved(SALSA, false);
    assert_eq!(free_report.hands, None);
    let hands = report.hands.unwrap();
    let meets = |contact: &&HandContact| contact.with == TouchedPart::OtherHand;
    let longest = |contact: &&HandContact| (contact.last - contact.first) as usize;
    let contact = hands.contacts.iter().filter(meets).max_by_key(longest).unwrap();
    // The first frame is a rest pose, and is dropped.
    let (source, target) = (mocap::import(SALSA).unwrap(), character());
    let whole = &source.animations[0];
    let left_out = whole.duration - kept.duration;
    let frames = [contact.first, contact.last];
    let wanted = wrists(&source, whole, frames.map(|frame| frame + left_out));
    let off = |animation: &Animation| (wrists(&target, animation, frames) - wanted).abs();
    // A fiftieth of the leg is one centimetre on this child.
    assert!(off(&kept) < 0.02, "{} of a leg", off(&kept));
    assert!(off(&kept) < 0.5 * off(&free), "{} and {}", off(&kept), off(&free));
    assert!(hands.jerk_ratio < 1.2, "{}", hands.jerk_ratio);
}

#[test]
fn a_motion_whose_hands_touch_nothing_is_the_same() {
    let walk = "../../fixtures/real/cmu_12_01_walk.bvh";
    let ((kept, report), (free, _)) = (moved(walk, true), moved(walk, false));
    assert_eq!(report.hands, None);
    assert!(kept == free, "the walk differs");
}

#[test]
fn on_its_own_skeleton_hands_are_where_they_were() {
    let source = mocap::import(SALSA).unwrap();
    let mut retargeter = PoseRetargeter::new(&source, &source, &PoseRetargetOptions::default()).unwrap();
    let (_, report) = retargeter.clip(&source, 0, &source, true).unwrap();
    assert_eq!(report.hands, None);
}
