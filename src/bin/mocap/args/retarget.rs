//! The options of `mocap retarget`.

use std::path::PathBuf;

use mocap::figure::HumanoidMap;
use mocap::job::{Angle, BoneMap, Feet, SourceMap, SourceSpace, StepLength};

use super::batch::is_folder;
use super::{FbxOutArgs, FrameRateArgs, InputArgs, PrintJobArgs, SpreadArgs};

#[derive(Debug, clap::Args)]
pub(crate) struct RetargetArgs {
    /// The motion files, and after them the character, unless --character or --to-skeleton names it: a .glb, .gltf or
    /// .vrm file, or any file with the skeleton of a humanoid
    #[arg(required = true, value_name = "PATH")]
    pub(crate) paths: Vec<PathBuf>,
    /// The file to write. A glTF or VRM character keeps its format, and everything in it; the motions are added. An
    /// .fbx has any character with its skin, colours and textures, and the motions. Another skeleton is written as
    /// .glb, .gltf or .bvh. A .vrma has the motions alone, as the character makes them. - is standard output. A folder,
    /// which is there or ends in /, gets an output of each motion, with the character in each, and a manifest; then
    /// motions may be folders and wildcards too
    #[arg(short, long, value_name = "OUT")]
    pub(crate) output: PathBuf,
    /// Format of standard output, or of the outputs in a folder [default: that of a glTF or VRM character, or else glb]
    #[arg(long, value_name = "FORMAT", value_parser = ["glb", "gltf", "bvh", "fbx", "vrma"])]
    pub(crate) to: Option<String>,
    /// The character; every PATH is a motion then
    #[arg(long, value_name = "FILE", conflicts_with = "to_skeleton")]
    pub(crate) character: Option<PathBuf>,
    /// Move the motions onto the skeleton of this file alone, without what else is in it; every PATH is a motion then
    #[arg(long, value_name = "FILE")]
    pub(crate) to_skeleton: Option<PathBuf>,
    /// Length of the steps: auto, in the proportion of the legs; none, as those of the source; or a factor
    #[arg(long, value_name = "auto|none|FACTOR", default_value = "auto")]
    pub(crate) scale: StepLength,
    /// Hold feet still while those of the source stand, where they would slide more; free leaves them as they come
    #[arg(long, value_name = "lock|free", default_value = "lock")]
    pub(crate) feet: Feet,
    /// Leave out the animations that the character has; by default they stay
    #[arg(long)]
    pub(crate) replace_animations: bool,
    /// Largest allowed angle in degrees; above it the exit code is 1. It is the worst of all: between a limb of the
    /// motion and that of the character in any frame, and in the mean a roll of a limb, a line of the trunk, a palm
    #[arg(long, value_name = "DEGREES")]
    pub(crate) max_angle: Option<Angle>,
    /// Print the report of one output as JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Skip motions that were retargeted with the same options, according to the manifest, and are unchanged
    #[arg(long)]
    pub(crate) resume: bool,
    /// Take the bones of the character from this JSON file, of the shape that `mocap skeleton --json` prints
    #[arg(long, value_name = "FILE", value_parser = BoneMap::parse_file)]
    pub(crate) character_map: Option<HumanoidMap>,
    /// Replace a file that may be a source; an input is never replaced
    #[arg(long)]
    pub(crate) force: bool,
    #[command(flatten)]
    pub(crate) fbx: FbxOutArgs,
    #[command(flatten)]
    pub(crate) source: SourceSpace,
    #[command(flatten)]
    pub(crate) map: SourceMap,
    #[command(flatten)]
    pub(crate) read: FrameRateArgs,
    #[command(flatten)]
    pub(crate) inputs: InputArgs,
    #[command(flatten)]
    pub(crate) spread: SpreadArgs,
    #[command(flatten)]
    pub(crate) print: PrintJobArgs,
}

impl RetargetArgs {
    /// Whether the output is a folder, with an output of each motion.
    pub(crate) fn is_many(&self) -> bool {
        is_folder(&self.output)
    }
}
