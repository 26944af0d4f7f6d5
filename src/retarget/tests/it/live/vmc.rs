//! Tests the bones and the axes of the VMC protocol.

use mocap::glam::{Mat3, Quat, Vec3};
use mocap::scene::HumanoidBone as Bone;
use mocap_retarget::internals::vmc::{BonePose, bone, mirrored, unity_name};

#[test]
fn bones_have_the_names_of_unity() {
    // UnityEngine.HumanBodyBones, in Unity's scripting reference.
    for (unity, vrm) in [
        ("Hips", Bone::Hips),
        ("UpperChest", Bone::UpperChest),
        ("LeftThumbProximal", Bone::LeftThumbMetacarpal),
        ("LeftThumbIntermediate", Bone::LeftThumbProximal),
        ("RightThumbDistal", Bone::RightThumbDistal),
        ("RightLittleIntermediate", Bone::RightLittleIntermediate),
    ] {
        assert_eq!((bone(unity), unity_name(vrm).as_str()), (Some(vrm), unity));
    }
    assert_eq!(bone("LastBone"), None);
}

#[test]
fn a_turn_in_unity_is_the_other_way_round_here() {
    // In Unity, a positive rotation about +Y moves +Z to +X, which is the figure's right. In a scene, right is -X.
    let half = std::f32::consts::FRAC_PI_4;
    let unity = BonePose {
        position: Vec3::new(1.0, 2.0, 3.0),
        rotation: Quat::from_xyzw(0.0, half.sin(), 0.0, half.cos()),
    };
    let found = mirrored(unity);
    assert_eq!(found.position, Vec3::new(-1.0, 2.0, 3.0));
    assert!((found.rotation * Vec3::Z).distance(Vec3::NEG_X) < 1e-6);
    // A matrix gives the same result: S R S.
    let mirror = Mat3::from_diagonal(Vec3::new(-1.0, 1.0, 1.0));
    let rotation = Quat::from_xyzw(0.1, -0.5, 0.3, 0.8).normalize();
    let expected = mirror * Mat3::from_quat(rotation) * mirror;
    let found = mirrored(BonePose { rotation, ..unity }).rotation;
    assert!(Mat3::from_quat(found).abs_diff_eq(expected, 1e-6));
}
