//! The options of every command that writes.

/// What an output may replace.
#[derive(Clone, Copy, Debug, clap::Args)]
pub(crate) struct ForceArgs {
    /// Replace a file that may be a source: a BVH, ASF, AMC, C3D, FBX, glTF, VRM or .bin file that is not a known
    /// output of this program. A glTF, FBX or USD file that names this program is known. So is a file that the record
    /// of outputs or a folder's manifest lists unchanged, or whose bytes equal the new output. BVH names no program.
    /// An input is never replaced
    #[arg(long)]
    pub(crate) force: bool,
}
