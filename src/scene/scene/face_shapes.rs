//! The 52 blend shapes that ARKit measures on a face. Other programs also name their morph targets after them.

/// The names of ARKit's `ARFaceAnchor.BlendShapeLocation`, in the order of Live Link Face's columns.
#[doc(hidden)]
pub const FACE_SHAPES: [&str; 52] = [
    "eyeBlinkLeft",
    "eyeLookDownLeft",
    "eyeLookInLeft",
    "eyeLookOutLeft",
    "eyeLookUpLeft",
    "eyeSquintLeft",
    "eyeWideLeft",
    "eyeBlinkRight",
    "eyeLookDownRight",
    "eyeLookInRight",
    "eyeLookOutRight",
    "eyeLookUpRight",
    "eyeSquintRight",
    "eyeWideRight",
    "jawForward",
    "jawRight",
    "jawLeft",
    "jawOpen",
    "mouthClose",
    "mouthFunnel",
    "mouthPucker",
    "mouthRight",
    "mouthLeft",
    "mouthSmileLeft",
    "mouthSmileRight",
    "mouthFrownLeft",
    "mouthFrownRight",
    "mouthDimpleLeft",
    "mouthDimpleRight",
    "mouthStretchLeft",
    "mouthStretchRight",
    "mouthRollLower",
    "mouthRollUpper",
    "mouthShrugLower",
    "mouthShrugUpper",
    "mouthPressLeft",
    "mouthPressRight",
    "mouthLowerDownLeft",
    "mouthLowerDownRight",
    "mouthUpperUpLeft",
    "mouthUpperUpRight",
    "browDownLeft",
    "browDownRight",
    "browInnerUp",
    "browOuterUpLeft",
    "browOuterUpRight",
    "cheekPuff",
    "cheekSquintLeft",
    "cheekSquintRight",
    "noseSneerLeft",
    "noseSneerRight",
    "tongueOut",
];

/// The ARKit shape that a morph target, an expression or a column names. The name may be in any case, may have `_L` for
/// `Left`, and may follow the name of a mesh (`Head.jawOpen`).
#[doc(hidden)]
pub fn face_shape(name: &str) -> Option<&'static str> {
    let last = name.rsplit([':', '|', '/', '.']).next().unwrap_or(name);
    [name, last].into_iter().find_map(|name| {
        let plain = |text: &str| text.replace(['_', '-', ' ', '.'], "").to_lowercase();
        let sided = [("l", "left"), ("r", "right")].into_iter().find_map(|(short, side)| {
            let stem = name
                .strip_suffix(short)
                .or_else(|| name.strip_suffix(&short.to_uppercase()))?;
            Some(plain(stem.strip_suffix(['_', '-', '.'])?) + side)
        });
        let wanted = sided.unwrap_or_else(|| plain(name));
        FACE_SHAPES
            .into_iter()
            .find(|shape| shape.eq_ignore_ascii_case(&wanted))
    })
}
