//! The options of every command that writes.

/// What an output may replace.
#[derive(Clone, Copy, Debug, clap::Args)]
pub(crate) struct ForceArgs {
    /// Replace a file that may be a source: a BVH, ASF, AMC, C3D, FBX, glTF, VRM or .bin file that is not known as an
    /// output of this program. An output is known in three cases. It is glTF or FBX, which names the program that wrote
    /// it. It stands unchanged in the manifest of a folder. Or it has the bytes of the new output. BVH names no
    /// program. An input is never replaced
    #[arg(long)]
    pub(crate) force: bool,
}
