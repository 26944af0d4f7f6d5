//! The options of `mocap convert` that change a motion.

use mocap::Conversion;
use mocap::convert::RootMotion;
use mocap::job::{OutSpace, SourceFrames};

/// Changes of the motion.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Changing")]
pub(crate) struct ChangeArgs {
    #[command(flatten)]
    pub(crate) out: OutSpace,
    #[command(flatten)]
    pub(crate) frames: SourceFrames,
    /// Keep the figure in place over the ground
    #[arg(long, conflicts_with = "root_motion")]
    pub(crate) in_place: bool,
    /// Move the translation over the ground and the heading to a new joint `Root`
    #[arg(long)]
    pub(crate) root_motion: bool,
}

impl ChangeArgs {
    /// What the library is to do.
    pub(crate) fn conversion(&self) -> Conversion {
        let mut conversion = self.frames.conversion().root(match (self.in_place, self.root_motion) {
            (true, _) => RootMotion::InPlace,
            (false, true) => RootMotion::Extract,
            (false, false) => RootMotion::Keep,
        });
        if let Some(metres) = self.out.metres_per_unit() {
            conversion = conversion.out_metres_per_unit(metres);
        }
        if let Some(up) = self.out.up() {
            conversion = conversion.out_up(up);
        }
        conversion
    }
}
