//! Tests the names of bones in MikuMikuDance (MMD).

use mocap::scene::HumanoidBone as Bone;
use mocap_formats::internals::mmd::{NAME_BYTES, bone, decode, encode, in_ascii, key, until_nul};

#[test]
fn names_mean_bones_with_wide_letters_too() {
    assert_eq!(bone("左ひじ"), Some(Bone::LeftLowerArm));
    assert_eq!(bone("右人指３"), Some(Bone::RightIndexDistal));
    assert_eq!(bone("上半身２"), bone("上半身2"));
    assert_eq!(bone("左足ＩＫ"), None);
    assert_eq!(bone("足"), None);
    assert_eq!(bone("左頭"), None);
    assert_eq!(in_ascii("左足ＩＫ"), "左足IK");
}

/// The expected bytes come from Python: `"左足ＩＫ".encode("cp932")`.
#[test]
fn names_are_shift_jis() {
    let bytes = [0x8D, 0xB6, 0x91, 0xAB, 0x82, 0x68, 0x82, 0x6A];
    assert_eq!(encode("左足ＩＫ").unwrap(), bytes);
    assert_eq!(decode(&bytes), "左足ＩＫ");
    assert_eq!(decode(until_nul(&[0x8D, 0xB6, 0, 0xFD])), "左");
    assert_eq!(encode("é"), None);
    assert_eq!(key("左足左足左足左足").unwrap().len(), NAME_BYTES);
}
