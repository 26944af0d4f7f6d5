//! Comma-separated values: one row for each frame and joint.
//!
//! The first line is a comment, `# ` and the [`Header`](crate::arrays::Header) as JSON; the second names the columns.
//! `pandas.read_csv(path, skiprows=1)` reads it. Numbers have as many digits as are needed to read the same 32-bit
//! number back.

use std::fmt::Write;

use crate::arrays::Arrays;

/// The text of the file: `frame`, `time` in seconds, `joint`, the position as `x`, `y`, `z`, the rotation by
/// [`Rotation::columns`](crate::arrays::Rotation::columns), then, if asked for, the velocity as `vx`, `vy`, `vz`, and
/// `contact` as 0 or 1.
///
/// ```
/// use mocap::arrays::{ArrayOptions, arrays, csv};
///
/// let motion = arrays(&mocap::import("fixtures/real/lecture_Test.bvh")?, &ArrayOptions::default())?;
/// let text = csv::write(&motion);
/// let mut lines = text.lines().skip(1);
/// assert_eq!(lines.next(), Some("frame,time,joint,x,y,z,qx,qy,qz,qw"));
/// assert!(lines.next().is_some_and(|line| line.starts_with("0,0,Shoulder,0.1,0,0,")));
/// # Ok::<(), mocap::Error>(())
/// ```
pub fn write(arrays: &Arrays) -> String {
    let mut text = String::with_capacity(100 * arrays.rows());
    text += &format!("# {}\nframe,time,joint,x,y,z", arrays.header.to_json());
    for column in arrays.header.rotation.columns() {
        text += ",";
        text += column;
    }
    text += if arrays.velocities.is_some() { ",vx,vy,vz" } else { "" };
    text += if arrays.contacts.is_some() { ",contact\n" } else { "\n" };

    let names: Vec<String> = arrays.joints().iter().map(|joint| field(&joint.name)).collect();
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

/// RFC 4180: a field with a comma, a quote or a line end is quoted, and its quotes doubled.
fn field(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}
