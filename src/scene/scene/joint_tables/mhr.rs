//! The joints of the Momentum Human Rig (Apache-2.0), in the order of the arrays of SAM 3D Body.

use super::super::{HumanoidBone as Bone, Side};
use super::Joint;

/// The name of a joint (with `*` for the side), the name of its parent, and its bone on the left side. A digit instead
/// of a name stands for twist helpers of the parent: all numbers from this digit to [`LAST_TWIST`].
type Row = (&'static str, &'static str, Option<Bone>);

const ROOT: [Row; 2] = [("body_world", "", None), ("root", "body_world", Some(Bone::Hips))];

const LEG: [Row; 9] = [
    ("*_upleg", "root", Some(Bone::LeftUpperLeg)),
    ("*_lowleg", "*_upleg", Some(Bone::LeftLowerLeg)),
    ("*_foot", "*_lowleg", Some(Bone::LeftFoot)),
    ("*_talocrural", "*_foot", None),
    ("*_subtalar", "*_talocrural", None),
    ("*_transversetarsal", "*_subtalar", None),
    ("*_ball", "*_transversetarsal", Some(Bone::LeftToes)),
    ("1", "*_lowleg", None),
    ("0", "*_upleg", None),
];

const SPINE: [Row; 4] = [
    ("c_spine0", "root", Some(Bone::Spine)),
    ("c_spine1", "c_spine0", None),
    ("c_spine2", "c_spine1", Some(Bone::Chest)),
    ("c_spine3", "c_spine2", Some(Bone::UpperChest)),
];

const ARM: [Row; 29] = [
    ("*_clavicle", "c_spine3", Some(Bone::LeftShoulder)),
    ("*_uparm", "*_clavicle", Some(Bone::LeftUpperArm)),
    ("*_lowarm", "*_uparm", Some(Bone::LeftLowerArm)),
    ("*_wrist_twist", "*_lowarm", None),
    ("*_wrist", "*_wrist_twist", Some(Bone::LeftHand)),
    ("*_pinky0", "*_wrist", None),
    ("*_pinky1", "*_pinky0", Some(Bone::LeftLittleProximal)),
    ("*_pinky2", "*_pinky1", Some(Bone::LeftLittleIntermediate)),
    ("*_pinky3", "*_pinky2", Some(Bone::LeftLittleDistal)),
    ("*_pinky_null", "*_pinky3", None),
    ("*_ring1", "*_wrist", Some(Bone::LeftRingProximal)),
    ("*_ring2", "*_ring1", Some(Bone::LeftRingIntermediate)),
    ("*_ring3", "*_ring2", Some(Bone::LeftRingDistal)),
    ("*_ring_null", "*_ring3", None),
    ("*_middle1", "*_wrist", Some(Bone::LeftMiddleProximal)),
    ("*_middle2", "*_middle1", Some(Bone::LeftMiddleIntermediate)),
    ("*_middle3", "*_middle2", Some(Bone::LeftMiddleDistal)),
    ("*_middle_null", "*_middle3", None),
    ("*_index1", "*_wrist", Some(Bone::LeftIndexProximal)),
    ("*_index2", "*_index1", Some(Bone::LeftIndexIntermediate)),
    ("*_index3", "*_index2", Some(Bone::LeftIndexDistal)),
    ("*_index_null", "*_index3", None),
    // The bone of the thumb's first joint belongs to the wrist. The metacarpal begins at the second joint.
    ("*_thumb0", "*_wrist", None),
    ("*_thumb1", "*_thumb0", Some(Bone::LeftThumbMetacarpal)),
    ("*_thumb2", "*_thumb1", Some(Bone::LeftThumbProximal)),
    ("*_thumb3", "*_thumb2", Some(Bone::LeftThumbDistal)),
    ("*_thumb_null", "*_thumb3", None),
    ("1", "*_lowarm", None),
    ("0", "*_uparm", None),
];

const HEAD: [Row; 17] = [
    ("c_neck", "c_spine3", Some(Bone::Neck)),
    ("c_neck_twist1_proc", "c_neck", None),
    ("c_neck_twist0_proc", "c_neck", None),
    ("c_head", "c_neck", Some(Bone::Head)),
    ("c_jaw", "c_head", Some(Bone::Jaw)),
    ("c_teeth", "c_jaw", None),
    ("c_jaw_null", "c_jaw", None),
    ("c_tongue0", "c_jaw", None),
    ("c_tongue1", "c_tongue0", None),
    ("c_tongue2", "c_tongue1", None),
    ("c_tongue3", "c_tongue2", None),
    ("c_tongue4", "c_tongue3", None),
    ("r_eye", "c_head", Some(Bone::RightEye)),
    ("r_eye_null", "r_eye", None),
    ("l_eye", "c_head", Some(Bone::LeftEye)),
    ("l_eye_null", "l_eye", None),
    ("c_head_null", "c_head", None),
];

/// The number of the last twist helper of a limb.
const LAST_TWIST: usize = 4;

/// The 127 joints of the Momentum Human Rig. Joints with a name that ends in `_proc` share the twist of their limb.
pub fn mhr() -> Vec<Joint> {
    let mut joints: Vec<Joint> = Vec::new();
    let mut add = |rows: &[Row], side: Option<Side>| {
        let letter = if side == Some(Side::Right) { "r" } else { "l" };
        for (name, parent, bone) in rows {
            let parent = parent.replace('*', letter);
            let above = joints.iter().position(|joint| joint.name == parent);
            let names = match name.parse::<usize>() {
                Err(_) => vec![name.replace('*', letter)],
                Ok(first) => {
                    let helpers = first..=LAST_TWIST;
                    helpers.map(|index| format!("{parent}_twist{index}_proc")).collect()
                }
            };
            joints.extend(names.into_iter().map(|name| Joint {
                name,
                parent: above,
                bone: bone.map(|bone| side.map_or(bone, |side| bone.on(side))),
            }));
        }
    };
    add(&ROOT, None);
    add(&LEG, Some(Side::Left));
    add(&LEG, Some(Side::Right));
    add(&SPINE, None);
    add(&ARM, Some(Side::Right));
    add(&ARM, Some(Side::Left));
    add(&HEAD, None);
    joints
}

/// The body and head keypoints of SAM 3D Body, with the positions of the hand keypoints.
const KEYPOINTS: &str = "nose left_eye right_eye left_ear right_ear left_shoulder right_shoulder left_elbow right_elbow \
     left_hip right_hip left_knee right_knee left_ankle right_ankle left_big_toe left_small_toe left_heel right_big_toe \
     right_small_toe right_heel right_hand right_wrist left_hand left_wrist left_olecranon right_olecranon \
     left_cubital_fossa right_cubital_fossa left_acromion right_acromion neck";

/// The names of the 70 keypoints of SAM 3D Body. The keypoints of a hand go from the thumb to the little finger, and
/// from tip to knuckle.
pub fn mhr70() -> Vec<String> {
    let of_hand = |side: &str| -> Vec<String> {
        let fingers = ["thumb", "index", "middle", "ring", "pinky"].into_iter();
        let points = fingers.flat_map(|finger| ["tip", "1", "2", "3"].map(|part| format!("{side}_{finger}_{part}")));
        points.collect()
    };
    let points = KEYPOINTS
        .split_whitespace()
        .flat_map(|point| match point.strip_suffix("_hand") {
            Some(side) => of_hand(side),
            None => vec![point.to_owned()],
        });
    points.collect()
}
