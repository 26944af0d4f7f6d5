//! The motion of a robot as files for training code. `docs/robots.md` lists the keys, shapes and orders of each file,
//! and their sources.

use glam::DVec3;
use mocap_figure::robot_bones::links_of_four_legs;
use mocap_retarget::robot::{InverseDynamics, LinkMotion, LinkOrder, Robot, RobotMotion};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::math::quaternion::rotation_vector;
use mocap_scene::scene::robot::{JointKind, Placement};

use crate::arrays::pickle::Pickle;
use crate::arrays::robot::pickle_base;

/// An array with a name.
pub(crate) struct Named {
    pub(super) name: &'static str,
    pub(super) shape: Vec<usize>,
    pub(super) values: Values,
}

/// The values of an array.
pub(crate) enum Values {
    Int(i64),
    Floats(Vec<f64>),
    Doubles(Vec<f64>),
    Texts(Vec<String>),
}

impl Named {
    fn floats(name: &'static str, shape: &[usize], values: Vec<f64>) -> Self {
        Self {
            name,
            shape: shape.to_vec(),
            values: Values::Floats(values),
        }
    }

    fn doubles(name: &'static str, shape: &[usize], values: Vec<f64>) -> Self {
        Self {
            name,
            shape: shape.to_vec(),
            values: Values::Doubles(values),
        }
    }

    fn texts(name: &'static str, texts: &[String]) -> Self {
        Self {
            name,
            shape: vec![texts.len()],
            values: Values::Texts(texts.to_vec()),
        }
    }

    fn text(name: &'static str, text: &str) -> Self {
        Self {
            name,
            shape: Vec::new(),
            values: Values::Texts(vec![text.to_owned()]),
        }
    }

    /// A frame rate: an int if the rate is whole.
    fn rate(fps: f64, shape: &[usize]) -> Self {
        let whole = fps.round() as i64;
        Self {
            name: "fps",
            shape: shape.to_vec(),
            values: match fps == whole as f64 {
                true => Values::Int(whole),
                false => Values::Floats(vec![fps]),
            },
        }
    }
}

fn flat(vectors: &[DVec3]) -> Vec<f64> {
    vectors.iter().flat_map(DVec3::to_array).collect()
}

/// Rotations as w, x, y and z.
fn wxyz<'a>(links: impl IntoIterator<Item = &'a Placement>) -> Vec<f64> {
    let rotations = links.into_iter().map(|transform| transform.rotation);
    rotations.flat_map(|turn| [turn.w, turn.x, turn.y, turn.z]).collect()
}

fn positions<'a>(links: impl IntoIterator<Item = &'a Placement>) -> Vec<f64> {
    links
        .into_iter()
        .flat_map(|transform| transform.translation.to_array())
        .collect()
}

/// The training data of mjlab and BeyondMimic: positions and velocities of joints and bodies. The order is depth-first
/// for mjlab, as in MuJoCo, and breadth-first for BeyondMimic, as in Isaac Lab.
pub(crate) fn for_tracking(motion: &RobotMotion, robot: &Robot, order: LinkOrder, metadata: &str) -> Vec<Named> {
    let links = LinkMotion::new(robot, motion, order);
    let (frames, count, joints) = (motion.frames(), links.names.len(), motion.dof_names.len());
    vec![
        Named::rate(motion.fps, &[1]),
        Named::floats("joint_pos", &[frames, joints], links.ordered(&motion.dof_pos)),
        Named::floats("joint_vel", &[frames, joints], links.ordered(&motion.dof_velocities())),
        Named::floats("body_pos_w", &[frames, count, 3], positions(&links.transforms)),
        Named::floats("body_quat_w", &[frames, count, 4], wxyz(&links.transforms)),
        Named::floats("body_lin_vel_w", &[frames, count, 3], flat(&links.velocities)),
        Named::floats("body_ang_vel_w", &[frames, count, 3], flat(&links.angular_velocities)),
        Named::texts("joint_names", &links.joint_names(motion)),
        Named::texts("body_names", &links.names),
        Named::text("metadata", metadata),
    ]
}

/// The training data of Isaac Lab's AMP tasks: joints and bodies breadth-first, as in PhysX.
pub(crate) fn for_isaac_lab(motion: &RobotMotion, robot: &Robot, metadata: &str) -> Vec<Named> {
    let links = LinkMotion::new(robot, motion, LinkOrder::BreadthFirst);
    let (frames, count, joints) = (motion.frames(), links.names.len(), motion.dof_names.len());
    let velocities = links.ordered(&motion.dof_velocities());
    vec![
        Named::rate(motion.fps, &[]),
        Named::texts("dof_names", &links.joint_names(motion)),
        Named::texts("body_names", &links.names),
        Named::floats("dof_positions", &[frames, joints], links.ordered(&motion.dof_pos)),
        Named::floats("dof_velocities", &[frames, joints], velocities),
        Named::floats("body_positions", &[frames, count, 3], positions(&links.transforms)),
        Named::floats("body_rotations", &[frames, count, 4], wxyz(&links.transforms)),
        Named::floats("body_linear_velocities", &[frames, count, 3], flat(&links.velocities)),
        Named::floats(
            "body_angular_velocities",
            &[frames, count, 3],
            flat(&links.angular_velocities),
        ),
        Named::text("metadata", metadata),
    ]
}

/// The inverse dynamics with MuJoCo's names: `qpos`, `qvel`, `qacc` and `qfrc_inverse`.
pub(crate) fn for_dynamics(motion: &RobotMotion, robot: &Robot, metadata: &str) -> Vec<Named> {
    let found = InverseDynamics::new(robot, motion);
    let (frames, joints) = (motion.frames(), motion.dof_names.len());
    let of_velocities = [found.velocities.len() / (6 + joints), 6 + joints];
    vec![
        Named::rate(motion.fps, &[]),
        Named::texts("dof_names", &motion.dof_names),
        Named::doubles("qpos", &[frames, 7 + joints], motion.qpos()),
        Named::doubles("qvel", &of_velocities, found.velocities),
        Named::doubles("qacc", &of_velocities, found.accelerations),
        Named::doubles("qfrc_inverse", &of_velocities, found.forces),
        Named::text("metadata", metadata),
    ]
}

/// The input of ProtoMotions, in the layout that PyRoki writes.
pub(crate) fn for_proto_motions(motion: &RobotMotion, metadata: &str) -> Vec<Named> {
    let (frames, joints) = (motion.frames(), motion.dof_names.len());
    vec![
        Named::floats("base_frame_pos", &[frames, 3], motion.root_pos()),
        Named::floats("base_frame_wxyz", &[frames, 4], wxyz(&motion.root)),
        Named::floats("joint_angles", &[frames, joints], motion.dof_pos.clone()),
        Named::texts("joint_names", &motion.dof_names),
        Named::rate(motion.fps, &[]),
        Named::text("metadata", metadata),
    ]
}

/// The motion of a robot with four legs as JSON, as Tencent's lifelike-agility-and-play has it for the robot MAX. Each
/// frame has the position of the base, its rotation as x, y, z and w, and the joints of each leg from the trunk
/// outwards.
///
/// # Errors
/// [`Code::Unrepresentable`] if the robot does not have four legs with all of its joints.
pub(crate) fn for_max(motion: &RobotMotion, robot: &Robot) -> Result<String> {
    let Some(legs) = links_of_four_legs(robot) else {
        let message = "the layout max stores only the joints of four legs, but the robot has other joints or legs";
        return Err(Diagnostic::new(Code::Unrepresentable, message)
            .help("choose another format, such as npz")
            .into());
    };
    let links = robot.moving_joints();
    let [front_left, front_right, hind_left, hind_right] = legs;
    let joints = [front_right, front_left, hind_right, hind_left].into_iter().flatten();
    let columns = joints.filter_map(|link| links.iter().position(|other| *other == link));
    let columns: Vec<usize> = columns.collect();
    let frames = motion.root.iter().enumerate().map(|(frame, root)| {
        let dof = motion.dof_of(frame);
        let base = root.translation.to_array().into_iter().chain(root.rotation.to_array());
        let row = base.chain(columns.iter().map(|column| dof[*column]));
        let row: Vec<String> = row.map(|value| value.to_string()).collect();
        format!("[{}]", row.join(", "))
    });
    let frames: Vec<String> = frames.collect();
    Ok(format!(
        "{{\"FrameDuration\": {}, \"LegOrder\": [\"FR\", \"FL\", \"HR\", \"HL\"], \"Frames\": [{}]}}\n",
        motion.fps.recip(),
        frames.join(", ")
    ))
}

/// The input of TWIST's motion library: a GMR pickle with the positions of the links in the coordinate frame of the
/// base.
pub(crate) fn for_twist(motion: &RobotMotion, robot: &Robot, metadata: &str) -> Vec<u8> {
    let links = LinkMotion::new(robot, motion, LinkOrder::DepthFirst);
    Pickle::dictionary(|pickle| {
        pickle_base(motion, pickle);
        pickle.text("local_body_pos");
        pickle.floats(&links.within_base(), &[motion.frames(), links.names.len(), 3]);
        pickle.text("link_body_list");
        pickle.texts(&links.names);
        pickle.text("metadata");
        pickle.text(metadata);
    })
}

/// The input of the motion libraries of ASAP and PBHC: a dictionary from the motion's name to the motion. `pose_aa` has
/// the rotation vectors of the base, of each joint, and of the points that the libraries add to a robot. These points
/// do not rotate.
///
/// # Errors
/// [`Code::Unrepresentable`] if a joint slides.
pub(crate) fn for_asap(motion: &RobotMotion, robot: &Robot, metadata: &str) -> Result<Vec<u8>> {
    /// The number of points that the libraries add to a robot: both hands and the head. A library that adds fewer
    /// points ignores the remaining rows.
    const ADDED: usize = 3;
    let joints: Vec<_> = robot
        .moving_joints()
        .into_iter()
        .map(|link| &robot.links[link].joint)
        .collect();
    if let Some(slide) = joints.iter().find(|joint| joint.kind == JointKind::Slide) {
        let message = "the layout asap stores only rotations of joints, but a joint of the robot slides";
        return Err(Diagnostic::new(Code::Unrepresentable, message)
            .in_joint(slide.name.as_str())
            .help("choose another format, such as npz")
            .into());
    }
    let (frames, count) = (motion.frames(), joints.len());
    let mut vectors = Vec::with_capacity(frames * 3 * (1 + count + ADDED));
    for (frame, root) in motion.root.iter().enumerate() {
        vectors.extend(rotation_vector(root.rotation).to_array());
        for (joint, position) in joints.iter().zip(motion.dof_of(frame)) {
            vectors.extend((*position * joint.axis).to_array());
        }
        vectors.extend([0.0; 3 * ADDED]);
    }
    let (feet, contacts) = motion.contacts_of_feet();
    let contacts: Vec<f64> = contacts.into_iter().map(f64::from).collect();
    Ok(Pickle::dictionary(|pickle| {
        pickle.text(&motion.name);
        pickle.entries(|pickle| {
            pickle.text("fps");
            pickle.number(motion.fps);
            pickle.text("root_trans_offset");
            pickle.floats(&motion.root_pos(), &[frames, 3]);
            pickle.text("root_rot");
            pickle.floats(&motion.root_rot(), &[frames, 4]);
            pickle.text("dof");
            pickle.floats(&motion.dof_pos, &[frames, count]);
            pickle.text("pose_aa");
            pickle.floats(&vectors, &[frames, 1 + count + ADDED, 3]);
            pickle.text("contact_mask");
            pickle.floats(&contacts, &[frames, feet]);
            pickle.text("dof_names");
            pickle.texts(&motion.dof_names);
            pickle.text("metadata");
            pickle.text(metadata);
        });
    }))
}

/// The input of MimicKit: rows with the position of the base, its rotation as an axis-angle vector, and the joints. The
/// motion does not loop: `loop_mode` is 0, clamp.
pub(crate) fn for_mimic_kit(motion: &RobotMotion, metadata: &str) -> Vec<u8> {
    let mut rows = Vec::with_capacity(motion.frames() * (6 + motion.dof_names.len()));
    for (frame, root) in motion.root.iter().enumerate() {
        rows.extend(root.translation.to_array());
        rows.extend(rotation_vector(root.rotation).to_array());
        rows.extend(motion.dof_of(frame));
    }
    Pickle::dictionary(|pickle| {
        pickle.text("loop_mode");
        pickle.number(0.0);
        pickle.text("fps");
        pickle.number(motion.fps);
        pickle.text("frames");
        pickle.array(&rows, &[motion.frames(), 6 + motion.dof_names.len()]);
        pickle.text("metadata");
        pickle.text(metadata);
    })
}
