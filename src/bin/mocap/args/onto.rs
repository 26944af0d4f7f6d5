//! The options of commands that put motions on another body.

use std::path::Path;

use mocap::figure::HumanoidMap;
use mocap::job::{BoneMap, Feet, OntoBody, SourceMap, SourceSpace, StepLength};

use super::{InputArgs, PrintJobArgs, SpreadArgs, WriteArgs};

#[derive(Debug, clap::Args)]
pub(crate) struct OntoArgs {
    /// Length of the steps: auto, in the proportion of the legs; none, as those of the source; or a factor
    #[arg(long, value_name = "auto|none|FACTOR", default_value = "auto")]
    scale: StepLength,
    /// Hold feet still while those of the source stand; free leaves them as they come. A foot of a character is held
    /// only where it would slide more
    #[arg(long, value_name = "lock|free", default_value = "lock")]
    feet: Feet,
    /// Print the report of one output as JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Skip motions that were made with the same options, according to the manifest, and are unchanged
    #[arg(long)]
    pub(crate) resume: bool,
    /// Replace a file that may be a source; an input is never replaced
    #[arg(long)]
    pub(crate) force: bool,
    #[command(flatten)]
    pub(crate) write: WriteArgs,
    #[command(flatten)]
    pub(crate) source: SourceSpace,
    #[command(flatten)]
    pub(crate) map: SourceMap,
    #[command(flatten)]
    pub(crate) inputs: InputArgs,
    #[command(flatten)]
    pub(crate) spread: SpreadArgs,
    #[command(flatten)]
    pub(crate) print: PrintJobArgs,
}

impl OntoArgs {
    /// The body of a file, some of whose bones are known.
    pub(super) fn body(&self, file: &Path, map: Option<&HumanoidMap>) -> OntoBody {
        let mut body = OntoBody::new(file);
        body.map = map.cloned().map(BoneMap::Bones);
        body.scale = self.scale;
        body.feet = self.feet;
        body
    }
}
