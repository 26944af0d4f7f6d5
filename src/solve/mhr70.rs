//! The joints of the 70 keypoints of SAM 3D Body.

/// The points of a set in their order; then its joints as `name parent bone points`; then roll marks as `joint from
/// to`.
pub(super) type Table = (&'static str, &'static [&'static str], &'static [[&'static str; 3]]);

/// The name `left_hand` means all finger joints of the left hand. The name `right_hand` means all finger joints of the
/// right hand. The points come from [`joint_tables::mhr70`](mocap_scene::scene::joint_tables::mhr70).
pub(super) const MHR70: Table = (
    "",
    &[
        "hips - hips left_hip+right_hip",
        "left_hip hips leftUpperLeg left_hip",
        "left_knee left_hip leftLowerLeg left_knee",
        "left_ankle left_knee leftFoot left_ankle",
        "left_toes left_ankle leftToes left_big_toe+left_small_toe",
        "right_hip hips rightUpperLeg right_hip",
        "right_knee right_hip rightLowerLeg right_knee",
        "right_ankle right_knee rightFoot right_ankle",
        "right_toes right_ankle rightToes right_big_toe+right_small_toe",
        "chest hips chest neck",
        "neck chest neck neck",
        "head neck head left_ear+right_ear",
        "left_shoulder chest leftUpperArm left_shoulder",
        "left_elbow left_shoulder leftLowerArm left_elbow",
        "left_wrist left_elbow leftHand left_wrist",
        "left_hand",
        "right_shoulder chest rightUpperArm right_shoulder",
        "right_elbow right_shoulder rightLowerArm right_elbow",
        "right_wrist right_elbow rightHand right_wrist",
        "right_hand",
    ],
    &[
        ["head", "right_ear", "left_ear"],
        ["left_wrist", "left_pinky_3", "left_index_3"],
        ["right_wrist", "right_pinky_3", "right_index_3"],
        ["left_ankle", "left_big_toe", "left_small_toe"],
        ["right_ankle", "right_small_toe", "right_big_toe"],
    ],
);

/// The fingers of a hand of [`MHR70`], with their bones.
const FINGERS: [(&str, [&str; 3]); 5] = [
    ("thumb", ["ThumbMetacarpal", "ThumbProximal", "ThumbDistal"]),
    ("index", ["IndexProximal", "IndexIntermediate", "IndexDistal"]),
    ("middle", ["MiddleProximal", "MiddleIntermediate", "MiddleDistal"]),
    ("ring", ["RingProximal", "RingIntermediate", "RingDistal"]),
    ("pinky", ["LittleProximal", "LittleIntermediate", "LittleDistal"]),
];

/// The joints of a hand, as rows of a table.
pub(super) fn hand_rows(side: &str) -> Vec<String> {
    let mut rows = Vec::new();
    for (finger, bones) in FINGERS {
        let mut above = format!("{side}_wrist");
        for (part, bone) in [("3", bones[0]), ("2", bones[1]), ("1", bones[2]), ("tip", "")] {
            let name = format!("{side}_{finger}_{part}");
            let bone = if bone.is_empty() {
                "-".to_owned()
            } else {
                format!("{side}{bone}")
            };
            rows.push(format!("{name} {above} {bone} {name}"));
            above = name;
        }
    }
    rows
}
