//! Tests the names that other programs have for bones.

use mocap::figure::{BoneNames, HumanoidBone};

#[test]
fn every_bone_has_a_row_and_no_name_is_given_twice() {
    // Mixamo's skeletons have every bone except the jaw.
    for bone in HumanoidBone::ALL {
        let has_name = BoneNames::Mixamo.name_of(*bone).is_some();
        assert_eq!(has_name, *bone != HumanoidBone::Jaw, "{bone:?}");
    }
    for names in BoneNames::ALL {
        assert_eq!(BoneNames::named(names.as_str()), Some(names));
        let all = names.names();
        let mut given: Vec<_> = all.values().flatten().collect();
        given.sort();
        given.dedup();
        assert_eq!(given.len(), all.len(), "{names:?}");
    }
}

/// The names as Unity's `HumanBodyBones` and Godot's `SkeletonProfileHumanoid` list them. They differ only in the
/// thumbs.
#[test]
fn engines_count_the_joints_of_thumbs_differently() {
    let thumb = [
        HumanoidBone::LeftThumbMetacarpal,
        HumanoidBone::LeftThumbProximal,
        HumanoidBone::LeftThumbDistal,
    ];
    let of = |names: BoneNames| thumb.map(|bone| names.name_of(bone).unwrap());
    assert_eq!(
        of(BoneNames::Unity),
        ["LeftThumbProximal", "LeftThumbIntermediate", "LeftThumbDistal"]
    );
    assert_eq!(
        of(BoneNames::Godot),
        ["LeftThumbMetacarpal", "LeftThumbProximal", "LeftThumbDistal"]
    );
    let little = HumanoidBone::RightLittleProximal;
    assert_eq!(BoneNames::Unity.name_of(little).unwrap(), "RightLittleProximal");
    assert_eq!(BoneNames::Mhr.name_of(little).unwrap(), "r_pinky1");
}
