//! What a motion for a model of MikuMikuDance must know of the model.

use serde::{Deserialize, Serialize};

/// The model that a scene is on.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct MmdModel {
    /// Its name.
    pub(crate) name: String,
    /// What bones inherit of others.
    pub(crate) inherits: Vec<MmdInherits>,
    /// The bones that are goals of IK.
    pub(crate) ik: Vec<String>,
    /// The bone that hangs on the hips in the scene, and beside them in the model; empty where there is none.
    pub(crate) trunk: String,
}

/// What a bone has of the rotation and the position of another, by their names.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct MmdInherits {
    pub(crate) bone: String,
    pub(crate) source: String,
    pub(crate) ratio: f64,
    pub(crate) rotation: bool,
    pub(crate) position: bool,
}
