//! Writes columns over time as text: OpenSim's motion and storage files, and comma-separated values.

use std::fmt::Write;

use mocap_scene::files::ANGLES_MARK;

use super::{JointAngles, TimeSeries};

impl JointAngles {
    /// An OpenSim motion file, `.mot`: a header, the column names, and a row for each frame, separated by tabs. Angles
    /// are in degrees, as the header says, and lengths in metres.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// # use mocap::biomechanics::JointAngles;
    /// let angles = JointAngles::of(&mocap::import("fixtures/real/cmu_short.bvh")?)?;
    /// let text = angles.to_mot();
    /// assert!(text.contains("\ninDegrees=yes\n") && text.contains("\ntime\tpelvis_tilt\t"));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    pub fn to_mot(&self) -> String {
        self.rows().of_opensim(ANGLES_MARK, "yes")
    }

    /// Comma-separated values: `time` in seconds, then the columns.
    pub fn to_csv(&self) -> String {
        self.rows().of_csv()
    }

    fn rows(&self) -> Rows<'_> {
        Rows {
            frame_rate: self.frame_rate,
            columns: &self.columns,
            values: &self.values,
            is_measured: false,
        }
    }
}

impl TimeSeries {
    /// An OpenSim motion or storage file, `.mot` or `.sto`: a header, the column names, and a row for each sample,
    /// separated by tabs.
    pub fn to_mot(&self) -> String {
        let in_degrees = if self.is_measured() { "no" } else { "yes" };
        self.rows().of_opensim(self.title, in_degrees)
    }

    /// Comma-separated values: `time` in seconds, then the columns.
    pub fn to_csv(&self) -> String {
        self.rows().of_csv()
    }

    fn rows(&self) -> Rows<'_> {
        Rows {
            frame_rate: self.frame_rate,
            columns: &self.columns,
            values: &self.values,
            is_measured: self.is_measured(),
        }
    }

    fn is_measured(&self) -> bool {
        self.title != ANGLES_MARK
    }
}

/// The common view of [`JointAngles`] and [`TimeSeries`].
struct Rows<'a> {
    frame_rate: f64,
    columns: &'a [String],
    values: &'a [f64],
    /// Whether the values were measured. Measured values have any unit, and are printed in single precision. Angles and
    /// lengths are printed with six decimals.
    is_measured: bool,
}

impl Rows<'_> {
    fn of_opensim(&self, title: &str, in_degrees: &str) -> String {
        let mut text = format!(
            "{title}\nversion=1\nnRows={}\nnColumns={}\ninDegrees={in_degrees}\nendheader\n",
            self.values.len() / self.columns.len().max(1),
            self.columns.len() + 1
        );
        self.write(&mut text, '\t');
        text
    }

    fn of_csv(&self) -> String {
        let mut text = String::new();
        self.write(&mut text, ',');
        text
    }

    fn write(&self, text: &mut String, separator: char) {
        text.push_str("time");
        for column in self.columns {
            text.push(separator);
            text.push_str(column);
        }
        text.push('\n');
        for (frame, row) in self.values.chunks(self.columns.len().max(1)).enumerate() {
            // Writing to a string cannot fail. Six decimals are a millionth of a degree, or a micrometre.
            let _ = write!(text, "{:.6}", frame as f64 / self.frame_rate);
            for value in row {
                // Adding zero turns the -0 of a small negative number into 0.
                let _ = match self.is_measured {
                    true => write!(text, "{separator}{}", *value as f32 + 0.0),
                    false => write!(text, "{separator}{:.6}", (value * 1e6).round() / 1e6 + 0.0),
                };
            }
            text.push('\n');
        }
    }
}
