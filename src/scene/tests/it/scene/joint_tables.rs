//! Tests the layouts of joints in arrays.

use mocap_scene::scene::joint_tables::{Joint, g1, mhr, smpl, soma};

/// The parents and the order of some joints, as the publishers of the formats state them.
#[test]
fn layouts_are_the_published_ones() {
    for (joints, count) in [
        (smpl(22), 22),
        (smpl(24), 24),
        (smpl(52), 52),
        (smpl(55), 55),
        (soma(30), 30),
        (soma(77), 77),
        (Some(g1()), 34),
        (Some(mhr()), 127),
    ] {
        let joints = joints.unwrap();
        assert_eq!(joints.len(), count);
        let parents_are_before = |(index, joint): (usize, &Joint)| joint.parent.is_none_or(|parent| parent < index);
        assert!(joints.iter().enumerate().all(parents_are_before));
        assert_eq!(joints.iter().filter(|joint| joint.parent.is_none()).count(), 1);
    }
    let at = |joints: &[Joint], index: usize| (joints[index].name.clone(), joints[index].parent);
    let smplx = smpl(55).unwrap();
    assert_eq!(at(&smplx, 25), ("left_index1".to_owned(), Some(20)));
    assert_eq!(at(&smplx, 54), ("right_thumb3".to_owned(), Some(53)));
    let (soma30, soma77) = (soma(30).unwrap(), soma(77).unwrap());
    assert_eq!(at(&soma30, 14), ("LeftHandThumbEnd".to_owned(), Some(13)));
    assert_eq!(at(&soma30, 29), ("RightToeBase".to_owned(), Some(28)));
    assert_eq!(at(&soma77, 38), ("LeftHandPinkyEnd".to_owned(), Some(37)));
    assert_eq!(at(&soma77, 72), ("RightLeg".to_owned(), Some(0)));
    let mhr = mhr();
    for (index, name, parent) in [
        (17, "l_upleg_twist4_proc", 2),
        (25, "r_lowleg_twist1_proc", 19),
        (42, "r_wrist", 41),
        (73, "r_uparm_twist4_proc", 39),
        (99, "l_thumb3", 98),
        (112, "c_neck_twist0_proc", 110),
        (126, "c_head_null", 113),
    ] {
        assert_eq!(at(&mhr, index), (name.to_owned(), Some(parent)));
    }
    let g1 = g1();
    assert_eq!(at(&g1, 14), ("right_toe_base".to_owned(), Some(13)));
    assert_eq!(at(&g1, 33), ("right_hand_roll_skel".to_owned(), Some(32)));
}
