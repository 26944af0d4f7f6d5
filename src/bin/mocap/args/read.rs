//! The frame rate of an input, for commands that do not resample.

use mocap::Importer;
use mocap::job::Reading;

/// The options of the reader, for commands that do not resample.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Reading")]
pub(crate) struct FrameRateArgs {
    /// Frames per second, instead of the file's own
    #[arg(long, value_name = "RATE")]
    fps: Option<f64>,
    #[command(flatten)]
    pub(crate) read: Reading,
}

impl FrameRateArgs {
    /// The options of the reader, the frame rate among them.
    pub(crate) fn reading(&self) -> Reading {
        let mut reading = self.read.clone();
        reading.frame_rate = self.fps;
        reading
    }

    /// An importer with these options.
    pub(crate) fn importer(&self) -> Importer {
        self.reading().importer()
    }
}
