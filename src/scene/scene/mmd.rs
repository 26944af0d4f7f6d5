//! What a motion for a model of MikuMikuDance must know of the model.

use serde::{Deserialize, Serialize};

/// The model that a scene is on.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[doc(hidden)]
pub struct MmdModel {
    /// Its name.
    #[doc(hidden)]
    pub name: String,
    /// What bones inherit of others.
    #[doc(hidden)]
    pub inherits: Vec<MmdInherits>,
    /// The bones that are goals of IK.
    #[doc(hidden)]
    pub ik: Vec<String>,
    /// The bone that hangs on the hips in the scene, and beside them in the model; empty where there is none.
    #[doc(hidden)]
    pub trunk: String,
}

/// What a bone has of the rotation and the position of another, by their names.
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
