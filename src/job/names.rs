//! The names of an output's joints.

use std::path::PathBuf;

use mocap_figure::name_joints;
use mocap_figure::report::NamingReport;
use mocap_figure::{BoneNames, Humanoid, HumanoidMap};
use mocap_formats::Export;
use mocap_formats::report::NodeRename;
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::scene::Scene;
use serde::{Deserialize, Serialize};

use super::source::BoneMap;

/// The names of a humanoid's joints in the output.
///
/// A file holds `{"bones": {"hips": "NAME", ...}}`, or the output of `mocap skeleton --json` for a skeleton with the
/// wanted names. If the file omits a bone or has `null` for it, the joint keeps its name.
///
/// ```
/// use mocap::job::JointNames;
///
/// let names: JointNames = serde_json::from_str("\"unreal\"").unwrap();
/// assert_eq!(names.names()?[&mocap::figure::HumanoidBone::Hips].as_deref(), Some("pelvis"));
/// let own: JointNames = serde_json::from_str(r#"{"hips": "Root"}"#).unwrap();
/// assert_eq!(own.names()?.len(), 1);
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(
    untagged,
    expecting = "vrm, mixamo, unreal, cmu, godot, unity, mhr, soma, the name of a file, or an object with the name of each bone"
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub enum JointNames {
    /// The names of a program or of a dataset.
    Known(BoneNames),
    /// The names in a JSON file.
    File(PathBuf),
    /// The name of each bone; `null` if the joint keeps its name.
    Bones(
        #[cfg_attr(
            feature = "schema",
            schemars(with = "std::collections::BTreeMap<String, Option<String>>")
        )]
        HumanoidMap,
    ),
}

impl JointNames {
    /// The name of each bone.
    ///
    /// # Errors
    /// [`Code::Io`] if the file cannot be read, and [`Code::InvalidValue`] if the file has no names.
    pub fn names(&self) -> Result<HumanoidMap> {
        match self {
            Self::Known(names) => Ok(names.names()),
            Self::Bones(names) => Ok(names.clone()),
            Self::File(path) => BoneMap::File(path.clone()).bones(),
        }
    }

    /// Parses the name of a known set, or the path of a file. The file is read at once, so that a bad file is refused
    /// before the work begins.
    ///
    /// # Errors
    /// As [`names`](Self::names); also [`Code::InvalidValue`] if `text` is neither a known set nor a file.
    pub fn parse(text: &str) -> Result<Self> {
        if let Some(names) = BoneNames::named(text) {
            return Ok(Self::Known(names));
        }
        let path = PathBuf::from(text);
        if !path.exists() {
            let known = BoneNames::ALL.map(BoneNames::as_str).join(", ");
            let message = format!("neither {known} nor a file");
            return Err(Diagnostic::new(Code::InvalidValue, message).into());
        }
        Self::File(path).names().map(Self::Bones)
    }
}

/// Renames the joints of a scene before it is written.
pub(super) fn name(
    scene: &mut Scene,
    names: Option<&HumanoidMap>,
    humanoid: &Humanoid,
) -> Result<Option<NamingReport>> {
    let named = names.map(|names| name_joints(scene, humanoid, names));
    named.transpose()
}

/// Adds the original names of the joints to the report of a written file.
pub(super) fn tell(naming: &NamingReport, scene: &Scene, written: &mut Export) {
    written.notes.push(naming.to_string());
    let mut all: Vec<NodeRename> = naming
        .renamed
        .iter()
        .map(|(node, from)| NodeRename {
            node: node.index(),
            from: from.clone(),
            to: scene.nodes[node.index()].name.clone(),
            is_asked_for: true,
        })
        .collect();
    // The format may have changed a new name further.
    all.append(&mut written.renamed);
    written.renamed = all;
}
