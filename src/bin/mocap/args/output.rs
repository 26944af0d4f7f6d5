//! The options of every command that writes.

/// What an output may replace.
#[derive(Clone, Copy, Debug, clap::Args)]
pub(crate) struct ForceArgs {
    /// Replace a file that may be a source: a BVH, ASF, AMC, C3D, FBX, glTF, VRM or .bin file that is not known as an
    /// output of this program. Known are glTF and FBX files that say so, unchanged outputs in the manifest of a folder,
    /// and files with the same bytes as the output; a BVH file does not say who wrote it. An input is never replaced
    #[arg(long)]
    pub(crate) force: bool,
}
