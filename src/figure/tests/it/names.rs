//! Tests the meanings of joint names.

use mocap::scene::Side;
use mocap_figure::names::Name;
use mocap_figure::names::words::{FingerKind, Meaning, Part};

fn read(name: &str) -> (Option<Side>, Option<Part>) {
    let name = Name::read(name);
    (
        name.side,
        name.meaning.first().map(|(part, _)| *part).filter(|_| !name.is_helper),
    )
}

#[test]
fn names_of_many_families() {
    let (left, right) = (Some(Side::Left), Some(Side::Right));
    let names = [
        ("mixamorig:Hips", None, Part::Hips),
        ("mixamorig_LeftUpLeg", left, Part::UpperLeg),
        ("Bip01 R Calf", right, Part::LowerLeg),
        ("Bip01 L Toe0", left, Part::Toes),
        ("ValveBiped.Bip01_L_UpperArm", left, Part::UpperArm),
        ("lhumerus", left, Part::UpperArm),
        ("rclavicle", right, Part::Shoulder),
        ("lShldr", left, Part::UpperArm),
        ("rShin", right, Part::LowerLeg),
        ("LHipJoint", left, Part::UpperLeg),
        ("LeftHip", left, Part::UpperLeg),
        ("HipLeft", left, Part::UpperLeg),
        ("LinkerOberarm", left, Part::UpperArm),
        ("rechter Unterarm", right, Part::LowerArm),
        ("Hip", None, Part::Hips),
        ("upperarm_l", left, Part::UpperArm),
        ("thigh.R", right, Part::UpperLeg),
        ("upper_arm.L", left, Part::UpperArm),
        ("spine.001", None, Part::Spine),
        ("L_upLeg_jnt", left, Part::UpperLeg),
        ("FK_back2_jnt", None, Part::Spine),
        ("mShoulderLeft", left, Part::Shoulder),
        ("Left-Ankle", left, Part::Foot),
        ("J_Bip_L_UpperArm", left, Part::UpperArm),
        ("CC_Base_L_Forearm", left, Part::LowerArm),
        ("左ひじ", left, Part::LowerArm),
        ("右足首", right, Part::Foot),
        ("左足", left, Part::UpperLeg),
        ("上半身2", None, Part::Spine),
        ("L5", None, Part::Spine),
        ("T12", None, Part::Spine),
        ("Quadril", None, Part::Hips),
        ("Pescoço", None, Part::Neck),
        ("ToSpine", None, Part::Spine),
        ("LeftFootThumb1", left, Part::Toes),
        ("LeftHandRingPinky1", left, Part::Finger),
        ("左親指０", left, Part::Finger),
        ("f_index.01.L", left, Part::Finger),
        ("lThumb1", left, Part::Finger),
        ("lthumb", left, Part::Finger),
        ("Spine_Mid", None, Part::Spine),
        ("Lefthand", left, Part::Hand),
    ];
    for (name, side, part) in names {
        assert_eq!(read(name), (side, Some(part)), "{name}");
    }
}

#[test]
fn helpers_and_names_without_a_meaning() {
    for helper in [
        "LeftForeArmTwist",
        "HeadTop_End",
        "Hips_end",
        "UpLegLBox",
        "左足IK",
        "左足D",
        "__Clavicle_L",
        "LeftHandEnd",
        "Sleeve_L",
    ] {
        assert!(Name::read(helper).is_helper, "{helper}");
    }
    for nothing in ["J0", "joint12", "bone_003", "Character1_Reference", "", "17", "Bip01"] {
        let name = Name::read(nothing);
        assert_eq!(
            (name.meaning, name.side, name.is_helper),
            (&[] as Meaning, None, false),
            "{nothing}"
        );
    }
}

#[test]
fn a_controller_is_no_twist_joint() {
    for twist in [
        "LeftForeArmTwist",
        "lForearmRoll",
        "LeftUpLegRoll",
        "upperarm_twist_01_l",
        "RightArmRoll_1",
        "lforearmroll",
        "thighTwist01_R",
    ] {
        assert!(Name::read(twist).is_twist, "{twist}");
    }
    for other in [
        "FootController",
        "LeftHandControl",
        "foot_scroll_l",
        "Controller",
        "LeftArm",
        "Trolley",
    ] {
        assert!(!Name::read(other).is_twist, "{other}");
    }
}

#[test]
fn fingers_have_a_kind() {
    for (name, finger) in [
        ("LeftHandRingPinky1", FingerKind::Little),
        ("LeftHandRing1", FingerKind::Ring),
        ("lMid1", FingerKind::Middle),
        ("middle_01_l", FingerKind::Middle),
        ("右人指２", FingerKind::Index),
        ("LeftInHandIndex", FingerKind::Index),
    ] {
        assert_eq!(Name::read(name).finger, Some(finger), "{name}");
    }
    assert_eq!(Name::read("LeftForeArm").finger, None);
    assert_eq!(Name::read("finger1-2.L").numbers, ["1", "2"]);
}

#[test]
fn a_mirrored_name_differs_in_the_side_alone() {
    assert!(Name::read("LeftArm").mirrors(&Name::read("RightArm")));
    assert!(!Name::read("LeftArm").mirrors(&Name::read("RightForeArm")));
    assert!(!Name::read("lIndex1").mirrors(&Name::read("rIndex2")));
    assert!(!Name::read("J1").mirrors(&Name::read("J1")));
}

/// The names are those of ARKit, of Character Creator, of VRoid Studio, of VRM and of MikuMikuDance.
#[test]
fn names_of_shapes_are_paired_by_their_side() {
    for (left, right) in [
        ("eyeBlinkLeft", "eyeBlinkRight"),
        ("mouthSmile_L", "mouthSmile_R"),
        ("Fcl_EYE_Close_L", "Fcl_EYE_Close_R"),
        ("blinkLeft", "blinkRight"),
        ("Head.browDownLeft", "Head.browDownRight"),
        ("まばたき左", "まばたき右"),
        ("ウィンク", "ウィンク右"),
        ("ウィンク２", "ｳｨﾝｸ２右"),
        ("左眉上", "右眉上"),
    ] {
        assert_eq!(
            Name::pairs(&[left, "jawOpen", right]),
            [Some(2), None, Some(0)],
            "{left}"
        );
    }
    // A shape of both eyes is no partner, and each name has one partner.
    assert_eq!(
        Name::pairs(&["blink", "blinkRight", "mouthFunnel", "L", "R"]),
        [None; 5]
    );
    let names = ["ウィンク", "ウィンク左", "ウィンク右", "ウィンク２"];
    assert_eq!(Name::pairs(&names), [None, Some(2), Some(1), None]);
}
