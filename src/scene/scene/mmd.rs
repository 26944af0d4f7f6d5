//! Properties of a MikuMikuDance model that affect its motions.

use serde::{Deserialize, Serialize};

/// The model of a scene's skeleton.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[doc(hidden)]
pub struct MmdModel {
    /// The name of the model.
    #[doc(hidden)]
    pub name: String,
    /// The rotations and positions that bones inherit from other bones.
    #[doc(hidden)]
    pub inherits: Vec<MmdInherits>,
    /// The bones that are IK goals.
    #[doc(hidden)]
    pub ik: Vec<String>,
    /// The bone that is a child of the hips in the scene, but a sibling of the hips in the model. Empty if there is
    /// none.
    #[doc(hidden)]
    pub trunk: String,
}

/// The share of another bone's rotation and position that a bone inherits. Bones are stated by name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[doc(hidden)]
pub struct MmdInherits {
    #[doc(hidden)]
    pub bone: String,
    #[doc(hidden)]
    pub source: String,
    #[doc(hidden)]
    pub ratio: f64,
    #[doc(hidden)]
    pub rotation: bool,
    #[doc(hidden)]
    pub position: bool,
}
