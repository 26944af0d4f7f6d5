//! Joint angles as text: OpenSim's motion files, and comma-separated values.

use std::fmt::Write;

use super::JointAngles;
use crate::files::ANGLES_MARK;

impl JointAngles {
    /// A motion file of OpenSim, `.mot`: a header, the names of the columns, and a row for each frame, separated by
    /// tabs. Angles are in degrees, which its header says, lengths in metres.
    ///
    /// ```
    /// # use mocap::biomechanics::JointAngles;
    /// let angles = JointAngles::of(&mocap::import("fixtures/real/cmu_short.bvh")?)?;
    /// let text = angles.to_mot();
    /// assert!(text.contains("\ninDegrees=yes\n") && text.contains("\ntime\tpelvis_tilt\t"));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    pub fn to_mot(&self) -> String {
        let mut text = format!(
            "{ANGLES_MARK}\nversion=1\nnRows={}\nnColumns={}\ninDegrees=yes\nendheader\n",
            self.frames(),
            self.columns.len() + 1
        );
        self.rows(&mut text, '\t');
        text
    }

    /// Comma-separated values: `time` in seconds, then the columns.
    pub fn to_csv(&self) -> String {
        let mut text = String::new();
        self.rows(&mut text, ',');
        text
    }

    fn rows(&self, text: &mut String, separator: char) {
        text.push_str("time");
        for column in &self.columns {
            text.push(separator);
            text.push_str(column);
        }
        text.push('\n');
        for (frame, row) in self.values.chunks(self.columns.len().max(1)).enumerate() {
            // Writing to a string cannot fail. Six decimals are a millionth of a degree, or a micrometre.
            let _ = write!(text, "{:.6}", frame as f64 / self.frame_rate);
            for value in row {
                // Adding zero turns the -0 of a small negative number into 0.
                let _ = write!(text, "{separator}{:.6}", (value * 1e6).round() / 1e6 + 0.0);
            }
            text.push('\n');
        }
    }
}
