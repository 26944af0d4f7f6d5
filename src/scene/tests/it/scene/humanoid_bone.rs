//! Tests the names and the parents of the bones of a humanoid.

use mocap::scene::HumanoidBone;

#[test]
fn every_bone_is_found_by_its_name_and_hangs_on_one_before_it() {
    assert_eq!(HumanoidBone::ALL.len(), 55);
    for &bone in HumanoidBone::ALL {
        assert_eq!(HumanoidBone::from_name(bone.as_str()), Some(bone));
        assert_eq!(bone.parent().is_none(), bone == HumanoidBone::Hips, "{bone:?}");
        assert!(bone.parent().is_none_or(|parent| parent < bone), "{bone:?}");
        assert_eq!(bone.mirrored().mirrored(), bone);
        assert_eq!(bone.mirrored() == bone, bone.side().is_none());
        let json = serde_json::to_string(&bone).unwrap();
        assert_eq!(json, format!("\"{}\"", bone.as_str()));
    }
}
