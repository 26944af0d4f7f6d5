//! The face of a VRM animation: nodes that are weights of expressions, and one that is the gaze.

use glam::Vec3;
use serde::{Deserialize, Serialize};

/// What a node of a VRM animation is on a face. Such a node is no part of the body: its transform says nothing else.
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
    /// An expression that VRM 1.0 names, such as `happy`: X of the node's translation is its weight, from 0 to 1, in
    /// any unit of length.
    Preset(String),
    /// An expression of the author's own; its weight is stated as that of a preset.
    Custom(String),
    /// The gaze: the node's rotation is that of the eyes' direction, which is +Z at rest.
    LookAt {
        /// Where the eyes look from, as an offset from the head in metres.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[cfg_attr(feature = "schema", schemars(with = "Option<[f32; 3]>"))]
        offset_from_head: Option<Vec3>,
    },
}

impl Face {
    /// The expressions that VRM 1.0 names, but for the four directions of a look, which are the gaze.
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

    /// VRM 0's names of the expressions of VRM 1.0, except for looks and `surprised`, which it lacks.
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

    /// Whether both are one expression, or the gaze.
    #[doc(hidden)]
    pub fn is_part(&self, other: &Self) -> bool {
        let is_gaze = |face: &Self| matches!(face, Self::LookAt { .. });
        self == other || (is_gaze(self) && is_gaze(other))
    }

    /// What it is in a mirror.
    #[doc(hidden)]
    pub fn mirrored(&self) -> Self {
        match self {
            Self::Preset(name) if name == "blinkLeft" => Self::Preset("blinkRight".to_owned()),
            Self::Preset(name) if name == "blinkRight" => Self::Preset("blinkLeft".to_owned()),
            other => other.clone(),
        }
    }
}
