//! Names of bones in other programs.

use mocap::figure::{BoneNames, HumanoidBone};

#[test]
fn every_bone_has_a_row_and_no_name_is_given_twice() {
    // Mixamo's skeletons have every bone but the jaw.
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
