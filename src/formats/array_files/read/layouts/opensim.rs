//! Joint angles of OpenSim's models, by their coordinate names: `hip_flexion_r`, `knee_angle_l`, ...
//!
//! The names come from OpenSim's gait models and from *Rajagopal 2016*. Files of these models do not state bone
//! lengths, so the angles are applied to the body that the caller names, or to a body of generic proportions. Joint
//! axes differ slightly between models, and the angles do not show the model.

use glam::{DQuat, DVec3};
use mocap_figure::joint_angles::{is_angle, rotations_of};
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::scene::joint_tables;
use mocap_scene::scene::{Confidence, HumanoidBone as Bone, Topic};

use crate::array_files::read::mot::Columns;
use crate::array_files::read::motion::Motion;
use crate::array_files::read::proportions;
use crate::warnings::Warnings;
use crate::{Failure, ReadOptions};

/// The number of joints of an SMPL body. In its T-pose no joint is rotated.
const JOINTS: usize = 22;

/// The angles that every body motion must have.
const NEEDED: [&str; 4] = ["hip_flexion_r", "hip_flexion_l", "knee_angle_r", "knee_angle_l"];

/// Column names of other models, each with the name that mocap uses.
const ALIASES: [(&str, &str); 5] = [
    ("ankle_inversion", "subtalar_angle"),
    ("wrist_deviation", "wrist_dev"),
    ("lumbar_extension", "lumbar_pitch"),
    ("lumbar_bending", "lumbar_roll"),
    ("lumbar_rotation", "lumbar_yaw"),
];

/// The motion in the columns of a file.
pub(in crate::array_files::read) fn motion(
    columns: &Columns,
    options: &ReadOptions,
    warnings: &mut Warnings,
) -> Result<Motion, Failure> {
    if let Some(missing) = NEEDED.iter().find(|name| columns.column(name).is_none()) {
        let found: Vec<&str> = columns.names.iter().map(String::as_str).take(12).collect();
        return Err(Box::new(
            Diagnostic::new(
                Code::MissingKeyword,
                format!("the file has no column {missing}: it is not a body motion"),
            )
            .expected_found("joint angles of OpenSim's gait models", found.join(", "))
            .help("forces, activations and marker errors are not a motion; name the file with the joint angles"),
        ));
    }
    let joints = joint_tables::smpl(JOINTS).unwrap_or_default();
    let frames = columns.times.len();
    let mut motion = Motion {
        rest: match &options.body {
            Some(body) => body.rest(&joints, &[]),
            None => proportions::rest(&joints),
        },
        rotations: vec![Vec::with_capacity(frames); joints.len()],
        joints,
        ..Motion::default()
    };
    let knees = knee_sign(columns);
    for frame in 0..frames {
        let angle = |name: &str| angle(columns, name, frame, knees);
        let rotations = rotations_of(&angle);
        let of = |bone: Bone| {
            rotations
                .iter()
                .find(|(own, _)| *own == bone)
                .map(|(_, rotation)| *rotation)
        };
        for (joint, track) in motion.joints.iter().zip(&mut motion.rotations) {
            track.push(
                joint
                    .bone
                    .and_then(|bone| own_rotation(bone, &of))
                    .unwrap_or(DQuat::IDENTITY),
            );
        }
        let position = |name: &str| columns.column(name).map_or(0.0, |values| values[frame]);
        let root = DVec3::new(-position("pelvis_tz"), position("pelvis_ty"), position("pelvis_tx"));
        motion.root.push(root);
    }
    motion.frame_rate = frame_rate(columns, options, warnings)?;
    say(columns, options, knees, &mut motion, warnings);
    Ok(motion)
}

/// The frame rate in frames per second, from the times of the rows unless the caller states it.
fn frame_rate(columns: &Columns, options: &ReadOptions, warnings: &mut Warnings) -> Result<f64, Failure> {
    if options.retime.is_some() {
        return options.frame_rate_or(f64::NAN);
    }
    let rate = options.frame_rate_or(columns.rate()?)?;
    if let Some(row) = columns.uneven_row(rate) {
        warnings.push(Code::FrameTime, || {
            let message = format!("the time steps of the rows vary, first at frame {row}: the motion is uneven there");
            Diagnostic::new(Code::FrameTime, message)
                .expected_found(
                    format!("{} s from row to row, which is the mean", 1.0 / rate),
                    format!("{} s", columns.times[row] - columns.times[row - 1]),
                )
                .help("write the file with even time steps: mocap read the rows as evenly spaced")
        });
    }
    Ok(rate)
}

/// The rotation of a joint. Spine and neck share the rotation that is stated for the whole trunk and the head.
fn own_rotation(bone: Bone, of: &dyn Fn(Bone) -> Option<DQuat>) -> Option<DQuat> {
    let part = |whole: Bone, count: f64| Some(DQuat::IDENTITY.slerp(of(whole)?, 1.0 / count));
    match bone {
        Bone::Spine | Bone::Chest | Bone::UpperChest => part(Bone::UpperChest, 3.0),
        Bone::Neck | Bone::Head => part(Bone::Head, 2.0),
        _ => of(bone),
    }
}

/// The value of the column with OpenSim's usual `name` in a frame, in degrees.
fn angle(columns: &Columns, name: &str, frame: usize, knees: f64) -> Option<f64> {
    let of = |name: &str| Some(columns.column(name)?[frame]);
    let alias = || {
        let (base, side) = name
            .rsplit_once('_')
            .filter(|(_, side)| ["l", "r"].contains(side))
            .unwrap_or((name, ""));
        let (_, other) = ALIASES.iter().find(|(own, _)| *own == base)?;
        of(&if side.is_empty() {
            (*other).to_owned()
        } else {
            format!("{other}_{side}")
        })
    };
    let value = of(name).or_else(alias)?;
    let sign = if name.starts_with("knee_angle") { knees } else { 1.0 };
    Some(sign * if columns.in_degrees { value } else { value.to_degrees() })
}

/// -1 if bent knees have negative angles, as in OpenSim's older models; otherwise 1. Knees bend in one direction only.
fn knee_sign(columns: &Columns) -> f64 {
    let knees = ["knee_angle_r", "knee_angle_l"]
        .into_iter()
        .filter_map(|name| columns.column(name));
    let sum: f64 = knees.flatten().filter(|angle| angle.is_finite()).sum();
    if sum < 0.0 { -1.0 } else { 1.0 }
}

fn say(columns: &Columns, options: &ReadOptions, knees: f64, motion: &mut Motion, warnings: &mut Warnings) {
    if options.body.is_none() {
        let choice = format!("generic proportions, {} m tall", proportions::HEIGHT);
        let reason = "joint angles do not state bone lengths; name a body for its lengths";
        motion.assume(Topic::Body, choice, reason, Confidence::Unsure);
    }
    if knees < 0.0 {
        let reason = "knees bend to one side, and the mean of their angles is below 0";
        motion.assume(
            Topic::Layout,
            "bent knees have negative angles",
            reason,
            Confidence::Sure,
        );
    }
    let is_known = |name: &str| {
        let base = name.trim_end_matches("_r").trim_end_matches("_l").to_ascii_lowercase();
        base.starts_with("pelvis_")
            || base == "filled_joints"
            || is_angle(&base)
            || ALIASES.iter().any(|(_, other)| *other == base)
    };
    let unknown: Vec<&str> = columns
        .names
        .iter()
        .map(String::as_str)
        .filter(|name| !is_known(name))
        .collect();
    if !unknown.is_empty() {
        warnings.push(Code::UnknownChannel, || {
            let message = format!("{} columns are not known angles, and were skipped", unknown.len());
            Diagnostic::new(Code::UnknownChannel, message)
                .expected_found("angles of OpenSim's models", unknown.join(", "))
        });
    }
}
