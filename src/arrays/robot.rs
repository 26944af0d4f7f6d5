//! The motion of a robot as files of other programs: pickled arrays, and rows of numbers.

use std::fmt::Write;

use crate::files::ARRAY_MARK;
use crate::robot::{Robot, RobotMotion};

/// Decimals of a row.
const DECIMALS: usize = 6;
const LAST_DECIMAL: f64 = 1e-6;

impl RobotMotion {
    /// A row of numbers for each frame, without a header, as in the LAFAN1 set for Unitree's robots: the position of
    /// the base, its rotation as x, y, z and w, the joints. No rounding brings a joint beyond its limit.
    ///
    /// ```
    /// use mocap::Importer;
    /// use mocap::robot::{RobotOptions, RobotRetargeter};
    ///
    /// let robot = Importer::new().import_robot("fixtures/robots/h1.urdf")?;
    /// let walk = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
    /// let (motion, _) = RobotRetargeter::new(&walk, &robot, &RobotOptions::default())?.clip(&walk, 0)?;
    /// let text = motion.to_csv(&robot);
    /// assert_eq!(text.lines().next().unwrap().split(',').count(), 7 + 19);
    /// # Ok::<(), mocap::Error>(())
    /// ```
    pub fn to_csv(&self, robot: &Robot) -> String {
        let limits: Vec<_> = robot
            .moving_joints()
            .into_iter()
            .map(|link| robot.links[link].joint.limits)
            .collect();
        let mut text = String::new();
        for (frame, root) in self.root.iter().enumerate() {
            let mut row: Vec<f64> = root.translation.to_array().to_vec();
            row.extend(root.rotation.to_array());
            let joints = std::iter::zip(self.dof_of(frame), &limits);
            row.extend(joints.map(|(position, limits)| rounded_within(*position, limits.lower, limits.upper)));
            for (column, value) in row.into_iter().enumerate() {
                if column > 0 {
                    text.push(',');
                }
                let _ = write!(text, "{value:.DECIMALS$}");
            }
            text.push('\n');
        }
        text
    }

    /// The bytes of a pickle as GMR writes it, which `pickle.load` reads where NumPy is installed: a dictionary with
    /// `fps`, `root_pos` (frames x 3, metres), `root_rot` (frames x 4, x y z w), `dof_pos` (frames x joints) and
    /// `dof_names`; `local_body_pos` and `link_body_list` are `None`. Protocol 4.
    pub fn to_pickle(&self) -> Vec<u8> {
        let frames = self.frames();
        let mut out = Pickle(vec![0x80, 4]);
        // A text that is forgotten at once: the file says who wrote it.
        out.text(ARRAY_MARK);
        out.0.push(b'0');
        out.0.extend(b"}(");
        out.text("fps");
        out.0.push(b'G');
        out.0.extend(self.fps.to_be_bytes());
        out.text("root_pos");
        out.array(&self.root_pos(), frames, 3);
        out.text("root_rot");
        out.array(&self.root_rot(), frames, 4);
        out.text("dof_pos");
        out.array(&self.dof_pos, frames, self.dof_names.len());
        out.text("dof_names");
        out.0.extend(b"](");
        self.dof_names.iter().for_each(|name| out.text(name));
        out.0.push(b'e');
        for absent in ["local_body_pos", "link_body_list"] {
            out.text(absent);
            out.0.push(b'N');
        }
        out.0.extend(b"u.");
        out.0
    }
}

/// A number of six decimals that is within the limits, as its decimals are read again.
fn rounded_within(value: f64, lower: f64, upper: f64) -> f64 {
    let read = |value: f64| -> f64 { format!("{value:.DECIMALS$}").parse().unwrap_or(value) };
    let rounded = read(value);
    match rounded {
        _ if rounded > upper => read(rounded - LAST_DECIMAL),
        _ if rounded < lower => read(rounded + LAST_DECIMAL),
        _ => rounded,
    }
}

/// The instructions of a pickle.
struct Pickle(Vec<u8>);

impl Pickle {
    fn text(&mut self, text: &str) {
        self.0.push(b'X');
        self.0.extend((text.len() as u32).to_le_bytes());
        self.0.extend(text.as_bytes());
    }

    fn function(&mut self, name: &str) {
        self.0.extend(format!("cnumpy\n{name}\n").as_bytes());
    }

    /// `numpy.reshape(numpy.array(numpy.frombuffer(bytes, "<f8")), (rows, columns))`: names that every version has. The
    /// copy can be written to.
    fn array(&mut self, values: &[f64], rows: usize, columns: usize) {
        self.function("reshape");
        self.function("array");
        self.function("frombuffer");
        self.0.push(0x8e);
        self.0.extend((8 * values.len() as u64).to_le_bytes());
        values.iter().for_each(|value| self.0.extend(value.to_le_bytes()));
        self.text("<f8");
        // A tuple of two, call; a tuple of one, call.
        self.0.extend([0x86, b'R', 0x85, b'R']);
        for length in [rows, columns] {
            self.0.push(b'J');
            self.0.extend((length as i32).to_le_bytes());
        }
        self.0.extend([0x86, 0x86, b'R']);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_stays_within_the_limits() {
        for (value, lower, upper) in [
            (0.087_266_46, -0.1, 0.087_266_46),
            (-0.087_266_56, -0.087_266_56, 1.0),
            (1.0, -1.0, 1.0),
            (0.123_456_49, -1.0, 1.0),
        ] {
            let kept = rounded_within(value, lower, upper);
            assert!((lower..=upper).contains(&kept), "{value} {kept}");
            assert!((kept - value).abs() <= 1.01e-6, "{value} {kept}");
        }
    }
}
