//! Names of bones and morphs: their Shift-JIS bytes, and their meaning.

use encoding_rs::SHIFT_JIS;

use mocap_scene::scene::{Face, HumanoidBone as Bone, Side};

/// The size in bytes of a bone or morph name in a motion.
pub const NAME_BYTES: usize = 15;
/// The size in bytes of the model name and of an IK name.
pub(super) const LONG_NAME_BYTES: usize = 20;

/// The bytes before the first NUL.
pub fn until_nul(bytes: &[u8]) -> &[u8] {
    let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
    &bytes[..end]
}

pub fn decode(bytes: &[u8]) -> String {
    let (name, _) = SHIFT_JIS.decode_without_bom_handling(bytes);
    // A cut name may end with half of a character.
    name.trim_end_matches(char::REPLACEMENT_CHARACTER).to_owned()
}

/// The bytes of a name; `None` if Shift-JIS lacks a character.
pub fn encode(name: &str) -> Option<Vec<u8>> {
    let (bytes, _, is_lossy) = SHIFT_JIS.encode(name);
    (!is_lossy).then(|| bytes.into_owned())
}

/// The name of a bone or morph in a motion. Long names are cut.
pub fn key(name: &str) -> Option<Vec<u8>> {
    let mut bytes = encode(name)?;
    bytes.truncate(NAME_BYTES);
    Some(bytes)
}

/// Bones by the names that nearly all models have, without the side. For each bone, the first name that a model has
/// counts.
#[rustfmt::skip]
pub(super) const BONES: &[(&str, Bone)] = &[
    ("上半身", Bone::Spine), ("上半身2", Bone::Chest), ("上半身3", Bone::UpperChest),
    ("首", Bone::Neck), ("頭", Bone::Head), ("あご", Bone::Jaw), ("目", Bone::LeftEye),
    ("肩", Bone::LeftShoulder), ("腕", Bone::LeftUpperArm), ("ひじ", Bone::LeftLowerArm), ("手首", Bone::LeftHand),
    ("親指0", Bone::LeftThumbMetacarpal), ("親指1", Bone::LeftThumbProximal), ("親指2", Bone::LeftThumbDistal),
    ("人指1", Bone::LeftIndexProximal), ("人指2", Bone::LeftIndexIntermediate), ("人指3", Bone::LeftIndexDistal),
    ("人差指1", Bone::LeftIndexProximal), ("人差指2", Bone::LeftIndexIntermediate),
    ("人差指3", Bone::LeftIndexDistal),
    ("中指1", Bone::LeftMiddleProximal), ("中指2", Bone::LeftMiddleIntermediate), ("中指3", Bone::LeftMiddleDistal),
    ("薬指1", Bone::LeftRingProximal), ("薬指2", Bone::LeftRingIntermediate), ("薬指3", Bone::LeftRingDistal),
    ("小指1", Bone::LeftLittleProximal), ("小指2", Bone::LeftLittleIntermediate), ("小指3", Bone::LeftLittleDistal),
    ("足", Bone::LeftUpperLeg), ("ひざ", Bone::LeftLowerLeg), ("足首", Bone::LeftFoot), ("つま先", Bone::LeftToes),
];

pub(super) const LEFT: char = '左';
pub(super) const RIGHT: char = '右';

/// The humanoid bone of a joint with this name. The hips follow from the other bones, because no name means the common
/// parent of legs and trunk.
pub fn bone(name: &str) -> Option<Bone> {
    let name = in_ascii(name);
    let (side, rest) = match name.chars().next()? {
        LEFT => (Some(Side::Left), &name[LEFT.len_utf8()..]),
        RIGHT => (Some(Side::Right), &name[RIGHT.len_utf8()..]),
        _ => (None, &name[..]),
    };
    let (_, bone) = BONES.iter().find(|(own, _)| *own == rest)?;
    match (side, bone.side()) {
        (None, None) => Some(*bone),
        (Some(side), Some(_)) => Some(bone.on(side)),
        _ => None,
    }
}

/// A name with full-width digits and letters converted to ASCII. Models use both kinds of characters.
pub fn in_ascii(name: &str) -> String {
    /// The code point distance from a full-width character to its ASCII character.
    const WIDE: u32 = '！' as u32 - '!' as u32;
    let narrow = |letter: char| match letter {
        '！'..='～' => char::from_u32(letter as u32 - WIDE).unwrap_or(letter),
        _ => letter,
    };
    name.chars().map(narrow).collect()
}

/// VRM expressions by the morph names that nearly all models have. The writer uses the first name of an expression.
#[rustfmt::skip]
const EXPRESSIONS: &[(&str, &str)] = &[
    ("あ", "aa"), ("い", "ih"), ("う", "ou"), ("え", "ee"), ("お", "oh"),
    ("まばたき", "blink"), ("ウィンク２", "blinkLeft"), ("ｳｨﾝｸ２右", "blinkRight"),
    ("笑い", "happy"), ("怒り", "angry"), ("困る", "sad"), ("なごみ", "relaxed"), ("びっくり", "surprised"),
];

/// The morph name of a VRM expression.
pub(super) fn morph(preset: &str) -> Option<&'static str> {
    let found = EXPRESSIONS.iter().find(|(_, own)| *own == preset);
    found.map(|(name, _)| *name)
}

/// The face role of a morph.
pub(super) fn face(morph: &str) -> Face {
    match EXPRESSIONS.iter().find(|(name, _)| *name == morph) {
        Some((_, preset)) => Face::Preset((*preset).to_owned()),
        None => Face::Custom(morph.to_owned()),
    }
}
