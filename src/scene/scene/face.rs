//! The face of a VRM animation: nodes for the weights of expressions, and a node for the gaze.

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::face_shape;

/// The role of a node in the face of a VRM animation. Such a node does not belong to the skeleton, and its transform
/// has no other meaning.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::scene::Face;
///
/// let scene = mocap::import("fixtures/made/face.vrma")?;
/// let blink = Face::Preset("blink".to_owned());
/// let node = scene.nodes.iter().position(|node| node.face.as_ref() == Some(&blink)).unwrap();
/// let channel = scene.animations[0].channels.iter().find(|channel| channel.node_name == scene.nodes[node].name);
/// assert_eq!(channel.unwrap().position_keys.values[1].x, 1.0); // the eyes are closed at its second key
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Face {
    /// A preset expression of VRM 1.0, such as `happy`. X of the node's translation is the weight, from 0 to 1, in any
    /// unit of length.
    Preset(String),
    /// A custom expression. Its weight is stored as for a preset.
    Custom(String),
    /// The gaze. The node's rotation is the rotation of the gaze direction, which is +Z at rest.
    LookAt {
        /// The position of the eyes, as an offset from the head in metres.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[cfg_attr(feature = "schema", schemars(with = "Option<[f32; 3]>"))]
        offset_from_head: Option<Vec3>,
    },
}

impl Face {
    /// The preset expressions of VRM 1.0, except the four look directions, which are the gaze.
    pub const PRESETS: [&'static str; 14] = [
        "happy",
        "angry",
        "sad",
        "relaxed",
        "surprised",
        "aa",
        "ih",
        "ou",
        "ee",
        "oh",
        "blink",
        "blinkLeft",
        "blinkRight",
        "neutral",
    ];

    /// VRM 0's names of the VRM 1.0 expressions. The look directions are missing, and so is `surprised`, which VRM 0
    /// lacks.
    #[doc(hidden)]
    pub const OF_VRM0: [(&'static str, &'static str); 13] = [
        ("joy", "happy"),
        ("angry", "angry"),
        ("sorrow", "sad"),
        ("fun", "relaxed"),
        ("a", "aa"),
        ("i", "ih"),
        ("u", "ou"),
        ("e", "ee"),
        ("o", "oh"),
        ("blink", "blink"),
        ("blink_l", "blinkLeft"),
        ("blink_r", "blinkRight"),
        ("neutral", "neutral"),
    ];

    /// The name of the expression, or `lookAt`.
    pub fn name(&self) -> &str {
        match self {
            Self::Preset(name) | Self::Custom(name) => name,
            Self::LookAt { .. } => "lookAt",
        }
    }

    /// Whether both are the same expression, or both are the gaze.
    #[doc(hidden)]
    pub fn is_part(&self, other: &Self) -> bool {
        let is_gaze = |face: &Self| matches!(face, Self::LookAt { .. });
        self == other || (is_gaze(self) && is_gaze(other))
    }

    /// The mirrored role.
    #[doc(hidden)]
    pub fn mirrored(&self) -> Self {
        match self {
            Self::Preset(name) if name == "blinkLeft" => Self::Preset("blinkRight".to_owned()),
            Self::Preset(name) if name == "blinkRight" => Self::Preset("blinkLeft".to_owned()),
            Self::Custom(name) if face_shape(name).is_some() => Self::Custom(other_side(name)),
            other => other.clone(),
        }
    }
}

/// The ARKit shape on the other side of the face; a shape in the middle is its own mirror image.
fn other_side(name: &str) -> String {
    let sides = [("Left", "Right"), ("Right", "Left"), ("_L", "_R"), ("_R", "_L")];
    let other = sides
        .into_iter()
        .find_map(|(side, other)| Some(name.strip_suffix(side)?.to_owned() + other));
    other.unwrap_or_else(|| name.to_owned())
}
