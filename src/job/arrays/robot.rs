//! The motion of a robot as files of other programs: pickled arrays, and rows of numbers.

use std::fmt::Write;

use mocap_retarget::robot::{Robot, RobotMotion};

use super::pickle::Pickle;

/// The number of decimals of a value in a row. The last decimal is a micrometre or a microradian.
const DECIMALS: usize = 6;

/// The step of the last decimal. Rounding moves a value by one step to keep it within its limit.
const LAST_DECIMAL: f64 = 1e-6;

/// The motion of a robot as CSV without a header, as in the LAFAN1 dataset for Unitree's robots. Each frame is a row:
/// the position of the base, its rotation as x, y, z and w, the joints. Rounding keeps every joint within its limit.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::Importer;
/// use mocap::arrays::robot_csv;
/// use mocap::retarget::robot::{RobotOptions, RobotRetargeter};
///
/// let robot = Importer::new().import_robot("fixtures/robots/h1.urdf")?;
/// let walk = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
/// let (motion, _) = RobotRetargeter::new(&walk, &robot, &RobotOptions::default())?.clip(&walk, 0)?;
/// let text = robot_csv(&motion, &robot);
/// assert_eq!(text.lines().next().unwrap().split(',').count(), 7 + 19);
/// # Ok::<(), mocap::Error>(())
/// ```
pub fn robot_csv(motion: &RobotMotion, robot: &Robot) -> String {
    let limits: Vec<_> = robot
        .moving_joints()
        .into_iter()
        .map(|link| robot.links[link].joint.limits)
        .collect();
    let mut text = String::new();
    for (frame, root) in motion.root.iter().enumerate() {
        let mut row: Vec<f64> = root.translation.to_array().to_vec();
        row.extend(root.rotation.to_array());
        let joints = std::iter::zip(motion.dof_of(frame), &limits);
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

/// The motion of a robot as a pickle, as GMR writes it. `pickle.load` reads it if NumPy is installed. The pickle is a
/// dictionary:
///
/// - `fps`
/// - `root_pos` (frames x 3, metres), `root_rot` (frames x 4, x y z w)
/// - `dof_pos` (frames x joints), `dof_names`
/// - `local_body_pos` and `link_body_list`, which are `None`
///
/// The pickle has protocol 4.
pub fn robot_pickle(motion: &RobotMotion) -> Vec<u8> {
    Pickle::dictionary(|pickle| {
        pickle_base(motion, pickle);
        for absent in ["local_body_pos", "link_body_list"] {
            pickle.text(absent);
            pickle.none();
        }
    })
}

/// Adds the entries that every pickle of a robot's motion has.
pub(super) fn pickle_base(motion: &RobotMotion, pickle: &mut Pickle) {
    let frames = motion.frames();
    pickle.text("fps");
    pickle.number(motion.fps);
    pickle.text("root_pos");
    pickle.array(&motion.root_pos(), &[frames, 3]);
    pickle.text("root_rot");
    pickle.array(&motion.root_rot(), &[frames, 4]);
    pickle.text("dof_pos");
    pickle.array(&motion.dof_pos, &[frames, motion.dof_names.len()]);
    pickle.text("dof_names");
    pickle.texts(&motion.dof_names);
}

/// Rounds to six decimals. The result, read back from its decimals, is within the limits.
pub fn rounded_within(value: f64, lower: f64, upper: f64) -> f64 {
    let read = |value: f64| -> f64 { format!("{value:.DECIMALS$}").parse().unwrap_or(value) };
    let rounded = read(value);
    match rounded {
        _ if rounded > upper => read(rounded - LAST_DECIMAL),
        _ if rounded < lower => read(rounded + LAST_DECIMAL),
        _ => rounded,
    }
}
