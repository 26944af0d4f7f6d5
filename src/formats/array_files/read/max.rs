//! Motions of a robot with four legs as JSON, as Tencent's lifelike-agility-and-play has them for the robot MAX.
//!
//! ```text
//! {"FrameDuration": 0.00833, "LegOrder": ["FR", "FL", "HR", "HL"], "Frames": [[x, y, z, i, j, k, w, ...], ...]}
//! ```
//!
//! A row has the position of the base, and its rotation as x, y, z and w. The joints of each leg follow, from the trunk
//! outwards.

use mocap_figure::robot_bones::links_of_four_legs;
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::scene::robot::Robot;
use serde::Deserialize;

use super::Body;
use super::layouts::{BASE_OF_ROBOT, TABLE};
use super::ndarray::{Bytes, Entries, Kind, NdArray};
use crate::{Failure, ReadOptions};

#[derive(Deserialize)]
#[serde(rename_all = "PascalCase")]
struct Motion {
    /// In seconds.
    frame_duration: f64,
    leg_order: Vec<String>,
    frames: Vec<Vec<f64>>,
}

/// The arrays of a file, with the joints in the order of the robot that the body option states.
pub(super) fn entries(bytes: &[u8], options: &ReadOptions) -> Result<Entries<'static>, Failure> {
    let text = crate::text::decode(bytes)?;
    let motion: Motion = serde_json::from_slice(&text).map_err(|error| {
        let message = match error.is_eof() {
            true => "the file ends inside its JSON".to_owned(),
            false => format!(
                "line {}, column {}: the value has another type",
                error.line(),
                error.column()
            ),
        };
        let expected = "FrameDuration: a number, LegOrder: four names, Frames: rows of numbers";
        let error = Diagnostic::new(Code::UnexpectedToken, message).expected_found(expected, "other JSON");
        Box::new(error.help("export or download the file again"))
    })?;
    let columns = match options.body.as_deref() {
        Some(Body::Robot(robot, _)) => columns(robot, &motion.leg_order)?,
        // The layout of a robot's motion refuses arrays without a robot.
        _ => Vec::new(),
    };
    let width = BASE_OF_ROBOT + columns.len();
    let mut rows = Vec::with_capacity(8 * width * motion.frames.len());
    for (frame, row) in motion.frames.iter().enumerate() {
        if row.len() != width && !columns.is_empty() {
            let message = format!("frame {frame} does not match the joints of the robot");
            let error = Diagnostic::new(Code::RowLength, message);
            return Err(Box::new(
                error.expected_found(format!("{width} numbers"), row.len().to_string()),
            ));
        }
        let (base, joints) = row.split_at(row.len().min(BASE_OF_ROBOT));
        let ordered = columns.iter().map(|column| &joints[*column]);
        rows.extend(base.iter().chain(ordered).flat_map(|value| value.to_le_bytes()));
    }
    let mut entries = Entries::default();
    for (name, shape, bytes) in [
        (TABLE, vec![motion.frames.len(), width], rows),
        ("fps", vec![], motion.frame_duration.recip().to_le_bytes().to_vec()),
    ] {
        let array = NdArray::new(name, (Kind::Float(8), false), shape, false, Bytes::made(bytes))?;
        entries.arrays.push((name.to_owned(), array));
    }
    Ok(entries)
}

/// For each joint in the robot's order, its column after the columns of the base.
fn columns(robot: &Robot, leg_order: &[String]) -> Result<Vec<usize>, Failure> {
    let Some(legs) = links_of_four_legs(robot) else {
        let message = "the motion has the joints of four legs, but the robot has other joints or legs";
        let help = "name the robot of this motion: {body} robot.urdf";
        return Err(Box::new(Diagnostic::new(Code::InvalidRobot, message).help(help)));
    };
    let leg = |name: &String| match name.as_str() {
        "FL" => Some(0),
        "FR" => Some(1),
        "HL" | "RL" => Some(2),
        "HR" | "RR" => Some(3),
        _ => None,
    };
    let order: Option<Vec<usize>> = leg_order.iter().map(leg).collect();
    let order = order.filter(|order| (0..4).all(|leg| order.contains(&leg)) && order.len() == 4);
    let order = order.ok_or_else(|| {
        let error = Diagnostic::new(Code::InvalidValue, "LegOrder does not name each of the four legs once");
        Box::new(error.expected_found("FR, FL, HR and HL", leg_order.join(", ")))
    })?;
    let links: Vec<usize> = order.iter().flat_map(|leg| &legs[*leg]).copied().collect();
    let moving = robot.moving_joints();
    let column = |link: &usize| links.iter().position(|other| other == link);
    Ok(moving.iter().filter_map(column).collect())
}
