//! Motion as comma-separated values.

use std::fmt::Write;

use mocap_scene::files::csv_field;

use crate::arrays::Arrays;

impl Arrays {
    /// Comma-separated values: one row for each frame and joint.
    ///
    /// The first line is a comment, `# ` and the [`Header`](crate::arrays::Header) as JSON. The second names the
    /// columns:
    ///
    /// - `frame`, `time` in seconds, `joint`
    /// - the position as `x`, `y`, `z`
    /// - the rotation by [`Rotation::columns`](crate::arrays::Rotation::columns)
    /// - if requested, the velocity as `vx`, `vy`, `vz`, and `contact` as 0 or 1
    ///
    /// `pandas.read_csv(path, skiprows=1)` reads the file. Each number has the fewest digits that read back as the same
    /// 32-bit value. A spreadsheet reads a name such as `=1+1` as a formula;
    /// [`to_csv_for_spreadsheet`](Self::to_csv_for_spreadsheet) prevents this.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::arrays::{ArrayOptions, Arrays};
    ///
    /// let motion = Arrays::of(&mocap::import("fixtures/real/lecture_Test.bvh")?, &ArrayOptions::default())?;
    /// let text = motion.to_csv();
    /// let mut lines = text.lines().skip(1);
    /// assert_eq!(lines.next(), Some("frame,time,joint,x,y,z,qx,qy,qz,qw"));
    /// assert!(lines.next().is_some_and(|line| line.starts_with("0,0,Shoulder,0.1,0,0,")));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    pub fn to_csv(&self) -> String {
        text(self, false)
    }

    /// As [`to_csv`](Self::to_csv), but a spreadsheet reads no cell as a formula: see [`csv_field`]. The first line is
    /// one cell, in quotes.
    pub fn to_csv_for_spreadsheet(&self) -> String {
        text(self, true)
    }
}

fn text(arrays: &Arrays, for_spreadsheet: bool) -> String {
    let mut text = String::with_capacity(100 * arrays.rows());
    let header = format!("# {}", arrays.header.to_json());
    // Without quotes, each comma in the header would begin a new cell.
    text += &if for_spreadsheet {
        csv_field(&header, true)
    } else {
        header
    };
    text += "\nframe,time,joint,x,y,z";
    for column in arrays.header.rotation.columns() {
        text += ",";
        text += column;
    }
    text += if arrays.velocities.is_some() { ",vx,vy,vz" } else { "" };
    text += if arrays.contacts.is_some() { ",contact\n" } else { "\n" };

    let names: Vec<String> = arrays
        .joints()
        .iter()
        .map(|joint| csv_field(&joint.name, for_spreadsheet))
        .collect();
    let width = arrays.header.rotation.width();
    for row in 0..arrays.rows() {
        let (frame, joint) = (row / names.len(), row % names.len());
        let time = frame as f64 / arrays.frame_rate();
        let position = &arrays.positions[3 * row..][..3];
        let rotation = &arrays.rotations[width * row..][..width];
        let velocity = arrays
            .velocities
            .as_ref()
            .map_or(&[][..], |values| &values[3 * row..][..3]);
        // Writing to a string cannot fail.
        let _ = write!(text, "{frame},{time},{}", names[joint]);
        for value in position.iter().chain(rotation).chain(velocity) {
            let _ = write!(text, ",{value}");
        }
        if let Some(contacts) = &arrays.contacts {
            text += if contacts[row] { ",1" } else { ",0" };
        }
        text += "\n";
    }
    text
}
