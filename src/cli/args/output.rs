//! The options of every command that writes.

/// What an output may replace.
#[derive(Clone, Copy, Debug, clap::Args)]
pub(crate) struct ForceArgs {
    /// Replace a file that may be a source: a BVH, ASF, AMC, C3D, FBX, glTF, VRM or .bin file that is not a known
    /// output of this program. An output is known if it is glTF, FBX or USD and names this program, if the record of
    /// outputs or a folder's manifest lists it unchanged, or if its bytes equal the new output. BVH names no program. An
    /// input is never replaced
    #[arg(long)]
    pub(crate) force: bool,
}
