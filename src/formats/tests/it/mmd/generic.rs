//! Tests the model that is used for a motion of MikuMikuDance without a model.

use mocap::scene::HumanoidBone as B;
use mocap_formats::internals::mmd::{ARMS, bone as bone_named, model};

#[test]
fn its_bones_are_those_of_a_body() {
    let model = model();
    let bones: Vec<B> = model.bones.iter().filter_map(|bone| bone_named(&bone.name)).collect();
    // The hips are the parent of legs and trunk.
    assert!(B::REQUIRED.iter().all(|bone| *bone == B::Hips || bones.contains(bone)));
    let hand = &model.bones[model.find("左手首").unwrap()];
    let shoulder = &model.bones[model.find("左腕").unwrap()];
    let arm = hand.position - shoulder.position;
    assert!((arm.y.atan2(arm.x).to_degrees() + ARMS).abs() < 1e-4, "{arm}");
    assert!(model.bones.iter().enumerate().all(|(index, bone)| {
        bone.parent.is_none_or(|parent| parent < index) && bone.parent.is_some() == (index > 0)
    }));
}
