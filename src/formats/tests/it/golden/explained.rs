//! The differences between our scenes and Assimp's scenes, with reasons.

use super::compare::Difference;
use super::truth::Flags;

/// An intended difference.
#[derive(Debug)]
pub(crate) struct IntendedDifference {
    /// Name of the BVH file.
    file: &'static str,
    /// Absent if the difference occurs with and without post-processing.
    flags: Option<Flags>,
    /// The place of the difference; `*` matches anything.
    place: &'static str,
    #[expect(dead_code, reason = "for people; printed with a row that explains nothing")]
    reason: &'static str,
}

const JOINED_ACROSS_BONES: &str = "Two links coincide. Assimp joins their vertices although they follow different bones, \
                                   so the bones can no longer be told apart; here each keeps its own.";
const ROOT_OFFSET: &str = "The root's position starts near zero while its OFFSET does not, so the two are added; \
                           Assimp takes the position alone.";
const FACE_ORDER: &str = "Assimp reorders faces that share vertices for the vertex cache; this crate leaves that out.";
const NOT_A_NUMBER: &str = "The file holds `nan`, which Assimp passes on; here the last finite value is held.";

pub(crate) const EXPLAINED: &[IntendedDifference] = &[
    processed("additive_root_pose", "meshes", JOINED_ACROSS_BONES),
    processed("additive_root_pose", "node * meshes", JOINED_ACROSS_BONES),
    processed("additive_root_pose", "mesh *", JOINED_ACROSS_BONES),
    processed("repeated_offset_lines", "meshes", JOINED_ACROSS_BONES),
    processed("repeated_offset_lines", "node * meshes", JOINED_ACROSS_BONES),
    processed("repeated_offset_lines", "mesh *", JOINED_ACROSS_BONES),
    always("additive_root_pose", "channel Hips positions", ROOT_OFFSET),
    always("additive_root_walk", "channel FK_back1_jnt positions", ROOT_OFFSET),
    always("nan_tokens", "channel Hips positions", ROOT_OFFSET),
    always("nan_tokens", "channel UpperChest rotations", NOT_A_NUMBER),
    processed("nan_tokens", "channel UpperChest rotations count", NOT_A_NUMBER),
    processed("makehuman_fly_one_frame", "mesh 16 faces", FACE_ORDER),
    processed("makehuman_fly_one_frame", "mesh 47 faces", FACE_ORDER),
    processed("makehuman_fly_one_frame", "mesh 75 faces", FACE_ORDER),
    always(
        "additive_root_walk",
        "channel head_end_jnt rotations of the other sign",
        "The same rotation with the other sign: the two largest parts of the quaternion are equal but for their last \
         digit, and it decides which one is made positive.",
    ),
];

/// Lines of the lecture's text: Assimp's line, our line, and the reason.
pub(crate) const EXPLAINED_LINES: &[(&str, &str, &str)] = &[
    (
        "rotnKey 1:  Time = 1 Value = 0.996195 0 0 0.0871558\n",
        "rotnKey 1:  Time = 1 Value = 0.996195 0 0 0.0871557\n",
        "sin 5 degrees is 0.08715574; Assimp computes it in single precision throughout",
    ),
    (
        "rotnKey 0:  Time = 0 Value = 0.996195 0 0 0.0871558\n",
        "rotnKey 0:  Time = 0 Value = 0.996195 0 0 0.0871557\n",
        "sin 5 degrees, as above",
    ),
    (
        "rotnKey 6:  Time = 6 Value = 0.819152 0 0 0.573577\n",
        "rotnKey 6:  Time = 6 Value = 0.819152 0 0 0.573576\n",
        "sin 35 degrees is 0.57357643",
    ),
];

const fn always(file: &'static str, place: &'static str, reason: &'static str) -> IntendedDifference {
    IntendedDifference {
        file,
        flags: None,
        place,
        reason,
    }
}

const fn processed(file: &'static str, place: &'static str, reason: &'static str) -> IntendedDifference {
    IntendedDifference {
        file,
        flags: Some(Flags::MaxQualityDebone),
        place,
        reason,
    }
}

pub(crate) fn is_explained_by(difference: &Difference, row: &IntendedDifference) -> bool {
    let place = match row.place.split_once('*') {
        Some((begin, end)) => difference.place.starts_with(begin) && difference.place.ends_with(end),
        None => difference.place == row.place,
    };
    place && row.file == difference.file && row.flags.is_none_or(|flags| flags == difference.flags)
}
