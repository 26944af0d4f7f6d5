//! The motion of a robot: the position of its base and of its joints, in the layouts that `mocap robot` writes. The
//! body option names the robot.

use glam::{DQuat, DVec3};
use mocap_figure::robot_bones::moving::scene_of_clips;
use mocap_figure::robot_clip;
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::scene::robot::{JointKind, Placement, Robot};
use mocap_scene::scene::{Format, Scene};

use super::plausible::check_radians;
use super::{Reader, TABLE, refused};
use crate::array_files::read::body::Body;
use crate::array_files::read::motion::Motion;
use crate::array_files::read::ndarray::{Entries, NdArray};
use crate::{Failure, ReadOptions};

/// The rate in Hz if the arrays state none, as in motions for Unitree's robots.
const USUAL_RATE: f64 = 30.0;

/// A layout with several arrays, which it identifies by name.
struct Layout {
    joints: &'static str,
    positions: &'static str,
    rotations: &'static str,
    /// Whether rotations are w, x, y, z.
    w_first: bool,
    /// Whether positions and rotations are given for all links, base first.
    of_links: bool,
}

/// The name of the array of base positions in files of ASAP and PBHC. These files have a dictionary for each motion,
/// under the name of the motion.
pub(super) const OFFSETS: &str = "root_trans_offset";

const LAYOUTS: &[Layout] = &[
    Layout {
        joints: "dof_pos",
        positions: "root_pos",
        rotations: "root_rot",
        w_first: false,
        of_links: false,
    },
    // HoloMotion.
    Layout {
        joints: "ref_dof_pos",
        positions: "ref_global_translation",
        rotations: "ref_global_rotation_quat",
        w_first: false,
        of_links: true,
    },
    // ASAP and PBHC.
    Layout {
        joints: "dof",
        positions: OFFSETS,
        rotations: "root_rot",
        w_first: false,
        of_links: false,
    },
    Layout {
        joints: "joint_pos",
        positions: "body_pos_w",
        rotations: "body_quat_w",
        w_first: true,
        of_links: true,
    },
    Layout {
        joints: "dof_positions",
        positions: "body_positions",
        rotations: "body_rotations",
        w_first: true,
        of_links: true,
    },
    Layout {
        joints: "joint_angles",
        positions: "base_frame_pos",
        rotations: "base_frame_wxyz",
        w_first: true,
        of_links: false,
    },
];

/// The count of numbers for the base: a position and a quaternion.
pub(in super::super) const BASE: usize = 7;

/// A layout with a single array, whose rows have the base numbers before the joint numbers.
struct Rows {
    name: &'static str,
    /// The count of numbers for the base in a row: position and rotation.
    base: usize,
    /// Converts the base numbers of a row to the position of the base, and to its rotation as x, y, z and w.
    read: fn(&[f64]) -> [f64; BASE],
}

const ROWS: &[Rows] = &[
    // MuJoCo.
    Rows {
        name: "qpos",
        base: BASE,
        read: |row| [row[0], row[1], row[2], row[4], row[5], row[6], row[3]],
    },
    // A table without a header, as for Unitree's robots.
    Rows {
        name: TABLE,
        base: BASE,
        read: |row| std::array::from_fn(|column| row[column]),
    },
    // MimicKit: the rotation is axis times angle.
    Rows {
        name: "frames",
        base: 6,
        read: |row| {
            let turn = DQuat::from_scaled_axis(DVec3::new(row[3], row[4], row[5]));
            [row[0], row[1], row[2], turn.x, turn.y, turn.z, turn.w]
        },
    },
];

/// Whether the arrays are a robot motion.
pub(super) fn is_motion(entries: &Entries<'_>) -> bool {
    let has = |name: &str| entries.get(name).is_some();
    let has_numbers = |name: &str| {
        entries
            .get(name)
            .is_some_and(|array| array.is_number() && array.shape.len() == 2)
    };
    ROWS.iter().any(|rows| has_numbers(rows.name)) || LAYOUTS.iter().any(|layout| has(layout.joints))
}

/// The scene of the robot that the body option states, with these motions, each with its name.
pub(super) fn scene(motions: &[(&str, Entries<'_>)], options: &ReadOptions, format: Format) -> Result<Scene, Failure> {
    let Some(Body::Robot(robot, _)) = options.body.as_deref() else {
        let message = "the arrays are a robot motion, but do not state which robot";
        return Err(Box::new(
            refused(message, &motions[0].1).help("name the robot, a .urdf or an MJCF .xml: {body} robot.urdf"),
        ));
    };
    let mut clips = Vec::with_capacity(motions.len());
    let mut assumptions = Vec::new();
    for (name, entries) in motions {
        let reader = Reader { entries, options };
        let mut motion = Motion::default();
        let read = reader
            .frame_rate(USUAL_RATE, &mut motion)
            .and_then(|()| positions(&reader, robot));
        let (root, positions) = read.map_err(|mut failure| {
            if motions.len() > 1 {
                failure.message = format!("{}, in the motion {name}", failure.message);
            }
            failure
        })?;
        clips.push(robot_clip(robot, name, motion.frame_rate, &root, &positions));
        assumptions = motion.assumptions;
    }
    let mut scene = scene_of_clips(robot, clips);
    scene.metadata.format = Some(format);
    scene.metadata.assumptions = assumptions;
    Ok(scene)
}

/// The placement of the base in each frame, and the joint positions in the robot's order.
fn positions(reader: &Reader<'_, '_>, robot: &Robot) -> Result<(Vec<Placement>, Vec<f64>), Failure> {
    let entries = reader.entries;
    let own = robot.dof_names();
    let stated = entries.first(&["dof_names", "joint_names"]).map(NdArray::texts);
    let names = stated.as_deref().unwrap_or(&own);
    let count = names.len();
    let layout = LAYOUTS.iter().find(|layout| entries.get(layout.joints).is_some());
    let (rows, joints, joints_name) = match layout {
        Some(layout) => {
            let (frames, joints) = reader.numbers(layout.joints, None, &[count])?;
            (base(reader, layout, frames)?, joints, layout.joints)
        }
        None => {
            let found = ROWS.iter().find(|rows| entries.get(rows.name).is_some());
            let Rows { name, base, read } = found.unwrap_or(&ROWS[0]);
            let (_, all) = reader.numbers(name, None, &[base + count])?;
            let rows = all.chunks_exact(base + count);
            (
                rows.clone().map(read).collect(),
                rows.flat_map(|row| row[*base..].to_vec()).collect(),
                *name,
            )
        }
    };
    if rows.is_empty() {
        return Err(Box::new(Diagnostic::new(
            Code::NoMotion,
            "the motion of the robot has no frames",
        )));
    }
    let columns = own.iter().map(|name| {
        let found = names.iter().position(|other| other == name);
        found.ok_or_else(|| no_joint(name, names))
    });
    let columns: Vec<usize> = columns.collect::<Result<_, _>>()?;
    if let Some(other) = names.iter().find(|name| !own.contains(name)) {
        return Err(no_joint(other, &own));
    }
    let root = rows.iter().enumerate().map(|(frame, row)| placement(frame, row));
    let root = root.collect::<Result<Vec<_>, _>>()?;
    let ordered = joints
        .chunks_exact(count.max(1))
        .flat_map(|row| columns.iter().map(|column| row[*column]));
    let ordered: Vec<f64> = ordered.collect();
    if let Some(at) = ordered.iter().position(|position| !position.is_finite()) {
        let (frame, name) = (at / own.len(), &own[at % own.len()]);
        let message = format!("the position of a joint is not finite in frame {frame} of {joints_name}");
        let diagnostic = Diagnostic::new(Code::NonFiniteValue, message).in_joint(name.as_str());
        return Err(Box::new(diagnostic.expected_found("a number", ordered[at].to_string())));
    }
    // A hinge without limits may keep turning.
    let hinges = robot.moving_joints().into_iter().enumerate().filter(|(_, link)| {
        let joint = &robot.links[*link].joint;
        joint.kind == JointKind::Hinge && (joint.limits.upper - joint.limits.lower).is_finite()
    });
    let means = hinges.map(|(column, _)| {
        let positions = ordered.iter().skip(column).step_by(own.len());
        positions.map(|position| position.abs()).sum::<f64>() / rows.len().max(1) as f64
    });
    check_radians(joints_name, means)?;
    Ok((root, ordered))
}

/// The placement of the base in each frame: x, y, z, then its rotation as x, y, z, w.
fn base(reader: &Reader<'_, '_>, layout: &Layout, frames: usize) -> Result<Vec<[f64; BASE]>, Failure> {
    let links = match reader.entries.get(layout.positions).filter(|_| layout.of_links) {
        Some(array) => array.shape.get(1).copied().unwrap_or(1).max(1),
        None => 1,
    };
    let widths = |last: usize| match layout.of_links {
        true => vec![links, last],
        false => vec![last],
    };
    let (_, positions) = reader.numbers(layout.positions, Some(frames), &widths(3))?;
    let (_, rotations) = reader.numbers(layout.rotations, Some(frames), &widths(4))?;
    let rows = positions.chunks_exact(3 * links).zip(rotations.chunks_exact(4 * links));
    Ok(rows
        .map(|(position, rotation)| {
            let [i, j, k, w] = match layout.w_first {
                true => [rotation[1], rotation[2], rotation[3], rotation[0]],
                false => [rotation[0], rotation[1], rotation[2], rotation[3]],
            };
            [position[0], position[1], position[2], i, j, k, w]
        })
        .collect())
}

fn placement(frame: usize, row: &[f64; BASE]) -> Result<Placement, Failure> {
    /// The accepted lengths of a quaternion. A quaternion with another length is no rotation, or its columns are in
    /// another order.
    const LENGTH: std::ops::Range<f64> = 0.9..1.1;
    let [x, y, z, i, j, k, w] = *row;
    let (translation, rotation) = (DVec3::new(x, y, z), DQuat::from_xyzw(i, j, k, w));
    if !translation.is_finite() || !LENGTH.contains(&rotation.length()) {
        let message = format!("the base has no valid position in frame {frame}");
        let found = format!("{x} {y} {z} and {i} {j} {k} {w}");
        return Err(Box::new(
            Diagnostic::new(Code::NonFiniteValue, message)
                .expected_found("a finite position and a rotation of length 1", found),
        ));
    }
    Ok(Placement {
        rotation: rotation.normalize(),
        translation,
    })
}

fn no_joint(name: &str, names: &[String]) -> Failure {
    /// The largest number of joints in an error.
    const NAMED: usize = 6;
    let message = "the joints of the arrays differ from the joints of the robot: name the robot of this motion";
    let first: Vec<&str> = names.iter().take(NAMED).map(String::as_str).collect();
    Box::new(
        Diagnostic::new(Code::InvalidRobot, message)
            .in_joint(name)
            .expected_found(format!("{name:?} in both"), format!("{} ...", first.join(", "))),
    )
}
