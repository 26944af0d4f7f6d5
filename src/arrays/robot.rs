//! The motion of a robot as files of other programs: pickled arrays, and rows of numbers.

use std::fmt::Write;

use super::pickle::Pickle;
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
        Pickle::dictionary(|pickle| {
            self.pickle_base(pickle);
            for absent in ["local_body_pos", "link_body_list"] {
                pickle.text(absent);
                pickle.none();
            }
        })
    }

    /// What every pickle of a robot's motion has.
    pub(super) fn pickle_base(&self, pickle: &mut Pickle) {
        let frames = self.frames();
        pickle.text("fps");
        pickle.number(self.fps);
        pickle.text("root_pos");
        pickle.array(&self.root_pos(), &[frames, 3]);
        pickle.text("root_rot");
        pickle.array(&self.root_rot(), &[frames, 4]);
        pickle.text("dof_pos");
        pickle.array(&self.dof_pos, &[frames, self.dof_names.len()]);
        pickle.text("dof_names");
        pickle.texts(&self.dof_names);
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
