//! The output of SAM 3D Body, which has the joints of the Momentum Human Rig. `pred_joint_coords` has the shape (127,
//! 3) for one frame, or (frames, 127, 3), in metres. `pred_global_rots` (.., 3, 3) has the rotations of the joints.
//! `pred_cam_t` (.., 3) has the position of the body relative to the camera.
//!
//! Positions are in camera axes: +X right, +Y down, +Z forward. Rotations are in axes with +Y up. The skeleton has the
//! median lengths of the take. In some files the rotations of one hand do not match its joint positions. mocap then
//! computes the rotations of this hand from its joint positions.

mod folder;
mod level;
mod persons;
mod rest;
mod samples;

use glam::{DQuat, DVec3, Quat, Vec3};
use mocap_scene::math::median::{median, median_vector};
use mocap_scene::scene::joint_tables::{Joint, mhr, mhr70};
use mocap_scene::scene::{Confidence, Format, Scene, Topic};

pub use self::folder::BodyFrames;
use self::persons::only_person;
pub use self::rest::frames;
use self::samples::{frames_of, vectors};
use super::Reader;
use crate::Failure;
use crate::array_files::read::motion::Motion;
use crate::array_files::read::ndarray::Entries;
use crate::points;
use crate::warnings::Warnings;

/// The names of the array of world rotations: in outputs of the estimator, and in outputs of its network.
const ROTATIONS: [&str; 2] = ["pred_global_rots", "joint_global_rots"];
const CAMERA: &str = "pred_cam_t";

/// The up direction in camera axes, if a file states it.
const UP: &str = "camera_up";

/// The height of the root above the rig's origin, in metres.
pub const MHR_ROOT_HEIGHT: f64 = 0.924;

/// The number of joints of the rig. The first joint does not move.
const JOINTS: usize = 127;

/// The number of keypoints in an output of SAM 3D Body.
const KEYPOINTS: usize = 70;

/// The index of the joint that carries the body.
const ROOT: usize = 1;

/// The factors of x, y and z that convert camera axes to the axes of the rotations.
const TO_Y_UP: DVec3 = DVec3::new(1.0, -1.0, -1.0);

/// The kind of points in a sample.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Kind {
    /// The joints of the rig, with or without rotations.
    #[default]
    Joints,
    /// The 70 keypoints of a file without joints.
    Keypoints,
}

impl Kind {
    /// The kind of the arrays of a file; `None` if the arrays are not an output of SAM 3D Body.
    fn of(entries: &Entries<'_>) -> Option<Self> {
        [Self::Joints, Self::Keypoints].into_iter().find(|kind| {
            let mut arrays = entries.arrays.iter();
            arrays.any(|(name, array)| name.ends_with(kind.positions()) && array.is_number())
        })
    }

    /// The name of the position array.
    fn positions(self) -> &'static str {
        match self {
            Self::Joints => "pred_joint_coords",
            Self::Keypoints => "pred_keypoints_3d",
        }
    }

    fn joints(self) -> usize {
        match self {
            Self::Joints => JOINTS,
            Self::Keypoints => KEYPOINTS,
        }
    }
}

/// A person in a frame, with +Y up. Unknown values are not finite.
#[derive(Clone, Debug)]
struct Sample {
    positions: Vec<Vec3>,
    /// The world rotation of each joint. Empty if the file has no rotations.
    rotations: Vec<Quat>,
    /// The body position relative to the camera.
    place: DVec3,
}

impl Sample {
    fn at(&self, joint: usize) -> DVec3 {
        self.positions[joint].as_dvec3()
    }

    fn rotation(&self, joint: usize) -> DQuat {
        self.rotations[joint].as_dquat()
    }

    fn is_whole(&self) -> bool {
        self.place.is_finite()
            && self.positions.iter().all(|position| position.is_finite())
            && self.rotations.iter().all(|rotation| rotation.is_finite())
    }

    /// The mean distance between the joints of two samples, over the joints that both have. NaN if the samples have no
    /// joint in common.
    fn distance(&self, other: &Self) -> f64 {
        let moved = (self.place - other.place).as_vec3();
        let pairs = std::iter::zip(&self.positions, &other.positions);
        let all = pairs
            .map(|(own, other)| (*own - *other + moved).length())
            .filter(|length| length.is_finite());
        let (sum, count) = all.fold((0.0, 0_u32), |(sum, count), length| {
            (sum + f64::from(length), count + 1)
        });
        sum / f64::from(count)
    }
}

/// Whether the arrays come from SAM 3D Body.
pub(super) fn is_motion(entries: &Entries<'_>) -> bool {
    Kind::of(entries).is_some()
}

/// The help for a file with rig parameters but no joints; `None` if the file has no parameters.
pub(super) fn needs_joints(entries: &Entries<'_>) -> Option<&'static str> {
    const PARAMETERS: [&str; 4] = [
        "mhr_model_params",
        "body_pose_params",
        "lbs_model_params",
        "pred_vertices",
    ];
    let mut names = entries.arrays.iter().map(|(name, _)| name);
    let has_parameters = names.any(|name| PARAMETERS.iter().any(|own| name.ends_with(own)));
    has_parameters.then_some(
        "mocap cannot compute joints from parameters or vertices of MHR: also save pred_joint_coords and pred_global_rots",
    )
}

pub(super) fn scene(reader: &Reader<'_, '_>, format: Format, warnings: &mut Warnings) -> Result<Scene, Failure> {
    let kind = Kind::of(reader.entries).unwrap_or_default();
    let frames = persons::places(frames_of(reader, kind)?, 1);
    of_frames(reader, (kind, reader.stated_rate()), frames, format, warnings)
}

/// The scene of one person.
fn of_frames(
    reader: &Reader<'_, '_>,
    (kind, stated_rate): (Kind, Option<f64>),
    frames: Vec<(usize, Vec<Sample>)>,
    format: Format,
    warnings: &mut Warnings,
) -> Result<Scene, Failure> {
    let all = frames.last().map_or(0, |(last, _)| last + 1);
    let person = only_person(frames, reader.options, warnings)?;
    let samples = persons::fill(person.frames, (kind, all), warnings)?;
    let rate = rate(reader, stated_rate, samples.len())?;
    let mut scene = match samples.iter().all(|sample| sample.rotations.len() == JOINTS) {
        true => of_person(reader, rate, samples, warnings)?.into_scene(format, warnings),
        false => of_points(kind, rate, &samples, format, warnings),
    };
    if let (Some(name), Some(clip)) = (person.name, scene.animations.first_mut()) {
        clip.name = name;
    }
    Ok(scene)
}

/// The points of a person without rotations. The importer can solve rotations from these points, because it knows their
/// names.
fn of_points(kind: Kind, rate: f64, samples: &[Sample], format: Format, warnings: &mut Warnings) -> Scene {
    let mut scene = Scene::default();
    scene.metadata.format = Some(format);
    scene.metadata.metres_per_unit = Some(1.0);
    let names = match kind {
        Kind::Joints => mhr().into_iter().map(|joint| joint.name).collect(),
        Kind::Keypoints => mhr70(),
    };
    let track = |(index, name): (usize, String)| {
        let all = samples.iter().map(|sample| (sample.at(index) + sample.place).as_vec3());
        points::Track {
            name,
            ticks: (0..samples.len()).map(|frame| frame as f64).collect(),
            positions: all.collect(),
            zeros: 0,
        }
    };
    let tracks = names.into_iter().enumerate().map(track).collect();
    points::add(
        &mut scene,
        points::Kind::POINTS,
        tracks,
        (samples.len(), rate),
        warnings,
    );
    scene
}

/// The motion of one person.
fn of_person(
    reader: &Reader<'_, '_>,
    frame_rate: f64,
    mut samples: Vec<Sample>,
    warnings: &mut Warnings,
) -> Result<Motion, Failure> {
    let joints = mhr();
    let mut motion = Motion {
        frame_rate,
        ..Motion::default()
    };
    rest::fit_hands(&joints, &mut samples, warnings);
    let lengths = remove_scale(&joints, &mut samples);
    let frames = rest::frames(&joints);
    let mut rest = vec![DVec3::ZERO; JOINTS];
    for (index, joint) in joints.iter().enumerate() {
        if let Some(parent) = joint.parent {
            rest[index] = rest[parent] + frames[parent] * lengths[index];
        }
    }
    let stated = match reader.entries.get(UP) {
        Some(_) => vectors(&reader.numbers(UP, Some(3), &[])?.1).next(),
        None => None,
    };
    let level = level::Level::of(&joints, &frames, &samples, stated);
    level.assume(&mut motion);
    let floor = level.floor(&joints, &frames, &samples);
    motion.root = (samples.iter())
        .map(|sample| level.turn * (sample.at(ROOT) + sample.place) - DVec3::Y * floor)
        .collect();
    let kept = kept(&joints, &samples);
    let balls = level::feet(&joints).map(|foot| rest[foot].y);
    let ground = balls[0].min(balls[1]) - level::BALL_HEIGHT;
    for (index, joint) in joints.iter().enumerate().filter(|(index, _)| kept[*index]) {
        let above = joint.parent.filter(|parent| kept[*parent]);
        let in_world = |sample: &Sample, joint: usize| sample.rotation(joint) * frames[joint].inverse();
        let rotations = samples.iter().map(|sample| match above {
            Some(parent) => in_world(sample, parent).inverse() * in_world(sample, index),
            None => level.turn * in_world(sample, index),
        });
        motion.rotations.push(rotations.collect());
        motion.rest.push((rest[index] - DVec3::Y * ground).as_vec3());
        motion.joints.push(Joint {
            // The kept joints keep their order, so the new index of a parent is the number of kept joints before the
            // parent.
            parent: above.map(|parent| kept[..parent].iter().filter(|kept| **kept).count()),
            ..joint.clone()
        });
    }
    if samples.len() > 1 {
        motion.assume(
            Topic::Body,
            "lengths are medians over the frames",
            "the size of the body changes from frame to frame",
            Confidence::Sure,
        );
    }
    Ok(motion)
}

/// The frame rate in frames per second, from the caller or the file. A single frame has no rate.
fn rate(reader: &Reader<'_, '_>, stated: Option<f64>, frames: usize) -> Result<f64, Failure> {
    /// The frame rate for a single frame. This choice has no effect on a pose.
    const OF_ONE: f64 = 30.0;
    let stated = stated.unwrap_or(if frames == 1 { OF_ONE } else { f64::NAN });
    reader.options.frame_rate_or(stated)
}

/// The position of a joint relative to its parent, in the parent's axes.
fn offset(joint: usize, parent: usize, sample: &Sample) -> DVec3 {
    sample.rotation(parent).inverse() * (sample.at(joint) - sample.at(parent))
}

/// Scales the body of every frame to the median size. Scales its distance from the camera too, because the estimator
/// computes the distance from the size. Returns the median joint offsets.
fn remove_scale(joints: &[Joint], samples: &mut [Sample]) -> Vec<DVec3> {
    let pairs = || {
        joints
            .iter()
            .enumerate()
            .filter_map(|(index, joint)| Some((index, joint.parent?)))
    };
    // The height of the root above the origin is the same for every body, so it says nothing about the size.
    let size = |sample: &Sample| -> f64 {
        let bones = pairs().filter(|(_, parent)| *parent >= ROOT);
        bones
            .map(|(joint, parent)| sample.at(joint).distance(sample.at(parent)))
            .sum()
    };
    let sizes: Vec<f64> = samples.iter().map(size).collect();
    let usual = median(&mut sizes.clone()).unwrap_or(0.0);
    for (sample, own) in samples.iter_mut().zip(&sizes) {
        let scale = if *own > 0.0 { usual / own } else { 1.0 };
        let root = sample.at(ROOT);
        for position in &mut sample.positions {
            *position = (root + (position.as_dvec3() - root) * scale).as_vec3();
        }
        sample.place = (sample.place + root) * scale - root;
    }
    let mut offsets = vec![DVec3::ZERO; joints.len()];
    for (joint, parent) in pairs() {
        offsets[joint] = median_vector(samples.iter().map(|sample| offset(joint, parent, sample)));
    }
    offsets
}

/// Selects the joints of the skeleton: all joints of body and hands, and the rotating joints of the face.
fn kept(joints: &[Joint], samples: &[Sample]) -> Vec<bool> {
    /// Joints that rotate by less than 0.5 degrees count as still. The number is the cosine of half of this angle.
    const TURNED: f64 = 0.999_99;
    let mut kept = vec![true; joints.len()];
    kept[0] = false;
    let head = joints.iter().position(|joint| joint.name == "c_head");
    let is_still = |joint: usize, parent: usize| {
        let local = |sample: &Sample| sample.rotation(parent).inverse() * sample.rotation(joint);
        let first = samples.first().map(local).unwrap_or_default();
        samples.iter().all(|sample| local(sample).dot(first).abs() > TURNED)
    };
    // Children follow their parents, so each child is examined before its parent.
    for index in (0..joints.len()).rev().filter(|_| samples.len() > 1) {
        let above = std::iter::successors(joints[index].parent, |above| joints[*above].parent);
        let is_of_face = above.into_iter().any(|above| Some(above) == head) && joints[index].name != "c_head_null";
        let has_children = joints
            .iter()
            .zip(&kept)
            .any(|(joint, kept)| *kept && joint.parent == Some(index));
        if let Some(parent) = joints[index].parent.filter(|_| is_of_face && !has_children) {
            kept[index] = !is_still(index, parent);
        }
    }
    kept
}
