//! FBX in a build without the feature `fbx`: the file is known, and the error names the feature.

use crate::{ReadOptions, Source};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::scene::Scene;

pub(super) const DESCRIPTION: &str = "Autodesk FBX: this build cannot read it";

pub(super) fn read(_: &Source<'_>, _: &ReadOptions) -> Result<Scene> {
    Err(Diagnostic::new(Code::MissingFeature, "this build cannot read FBX")
        .help("build it with `--features fbx`, which needs a C compiler")
        .into())
}
