//! The options of `mocap convert` that change a motion.

use mocap::job::SourceFrames;

/// Changes of the motion.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Changing")]
pub(crate) struct ChangeArgs {
    #[command(flatten)]
    pub(crate) frames: SourceFrames,
    /// Keep the figure in place over the ground
    #[arg(long, conflicts_with = "root_motion")]
    pub(crate) in_place: bool,
    /// Move the translation over the ground and the heading to a new joint `Root`
    #[arg(long)]
    pub(crate) root_motion: bool,
}
