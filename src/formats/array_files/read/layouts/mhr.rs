//! SAM 3D Body: `pred_joint_coords` (127, 3) of a frame or (frames, 127, 3) in metres, `pred_global_rots` (.., 3, 3)
//! and `pred_cam_t` (.., 3), of the Momentum Human Rig.
//!
//! Positions are in the frame of a camera: +X right, +Y down, +Z forward. Rotations are in a frame with +Y up. The
//! skeleton has the median lengths of the take. One hand of a file may have rotations that do not turn its joints to
//! where they are: that hand is turned as its positions say.

mod level;
mod rest;

pub use self::rest::frames;
use std::collections::BTreeMap;

use glam::{DMat3, DQuat, DVec3};
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::limits::limit_exceeded;
use mocap_scene::math::median::{median, median_vector};
use mocap_scene::scene::joint_tables::{Joint, mhr};
use mocap_scene::scene::{Confidence, Topic};

use super::Reader;
use crate::array_files::read::motion::Motion;
use crate::array_files::read::ndarray::Entries;
use crate::warnings::Warnings;
use crate::{Failure, ReadOptions};

const POSITIONS: &str = "pred_joint_coords";
const ROTATIONS: &str = "pred_global_rots";
const CAMERA: &str = "pred_cam_t";

/// The direction that is up in the frame of the camera, where a file states it.
const UP: &str = "camera_up";

/// How high the root stands above the origin of the rig, in metres.
pub const MHR_ROOT_HEIGHT: f64 = 0.924;

/// The joints of the rig, of which the first does not move.
const JOINTS: usize = 127;

/// The joint that carries the body.
const ROOT: usize = 1;

/// From the camera's axes to those of the rotations.
const TO_Y_UP: DVec3 = DVec3::new(1.0, -1.0, -1.0);

/// A person in a frame, with +Y up. Joints that are not known are not finite.
#[derive(Clone, Debug)]
struct Sample {
    positions: Vec<DVec3>,
    rotations: Vec<DQuat>,
    /// Where the camera has the body.
    place: DVec3,
}

impl Sample {
    fn is_whole(&self) -> bool {
        self.place.is_finite()
            && self.positions.iter().all(|position| position.is_finite())
            && self.rotations.iter().all(|rotation| rotation.is_finite())
    }

    /// How far the joints of another are away, on the average.
    fn distance(&self, other: &Self) -> f64 {
        let pairs = std::iter::zip(&self.positions, &other.positions);
        let moved = self.place - other.place;
        pairs.map(|(own, other)| (*own - *other + moved).length()).sum::<f64>() / JOINTS as f64
    }
}

/// Whether the arrays are those of SAM 3D Body.
pub(super) fn is_motion(entries: &Entries<'_>) -> bool {
    entries.arrays.iter().any(|(name, _)| name.ends_with(POSITIONS))
}

pub(super) fn motion(reader: &Reader<'_, '_>, warnings: &mut Warnings) -> Result<Motion, Failure> {
    let frames = frames_of(reader)?.into_iter().enumerate().collect();
    let rate = reader.stated_rate();
    of_person(reader, rate, only_person(frames, warnings), warnings)
}

/// The persons of each frame of a file. A file of one list has a frame, and one of lists of lists a frame for each.
fn frames_of(reader: &Reader<'_, '_>) -> Result<Vec<Vec<Sample>>, Failure> {
    let mut frames: Vec<Vec<Sample>> = Vec::new();
    let names = reader.entries.arrays.iter().map(|(name, _)| name.as_str());
    let mut list_of_last = None;
    for prefix in names.filter_map(|name| name.strip_suffix(POSITIONS)) {
        let (list, _) = prefix.trim_end_matches('.').rsplit_once('.').unwrap_or_default();
        let samples = samples(reader, prefix)?;
        match frames.last_mut() {
            // One more person of a list.
            Some(last) if samples.len() == 1 && list_of_last == Some(list) => last.extend(samples),
            _ => frames.extend(samples.into_iter().map(|sample| vec![sample])),
        }
        list_of_last = Some(list);
    }
    Ok(frames)
}

/// Frames for each file of a folder, at most: the others are interpolated.
const MOST_PER_FILE: usize = 64;

/// The persons of a folder with a file for each frame, or for each person in it.
#[derive(Debug, Default)]
pub struct BodyFrames {
    /// By the number of the frame.
    frames: BTreeMap<u64, Vec<Sample>>,
    rate: Option<f64>,
}

impl BodyFrames {
    /// The arrays of a file that are read.
    pub(in crate::array_files::read) fn reads(name: &str) -> bool {
        [POSITIONS, ROTATIONS, CAMERA, "fps"]
            .iter()
            .any(|own| name.ends_with(own))
    }

    pub(in crate::array_files::read) fn add(&mut self, frame: u64, entries: &Entries<'_>) -> Result<(), Failure> {
        let options = ReadOptions::default();
        let reader = Reader {
            entries,
            options: &options,
        };
        let samples = frames_of(&reader)?;
        if samples.len() != 1 {
            let message = "a file of a folder of frames has another number of frames than one";
            return Err(Box::new(
                Diagnostic::new(Code::RowLength, message)
                    .expected_found(format!("{POSITIONS} of one frame"), entries.describe())
                    .help("read the file itself, or take it from the folder"),
            ));
        }
        self.rate = self.rate.or(reader.stated_rate());
        self.frames
            .entry(frame)
            .or_default()
            .extend(samples.into_iter().flatten());
        Ok(())
    }

    pub(in crate::array_files::read) fn motion(
        self,
        options: &ReadOptions,
        warnings: &mut Warnings,
    ) -> Result<Motion, Failure> {
        let reader = Reader {
            entries: &Entries::default(),
            options,
        };
        let numbers: Vec<u64> = self.frames.keys().copied().collect();
        let first = numbers.first().copied().unwrap_or(0);
        // Every second frame of a film, say, is a take without gaps.
        let step = numbers.windows(2).map(|pair| pair[1] - pair[0]).min().unwrap_or(1);
        let at = |number: u64| usize::try_from((number - first) / step).unwrap_or(usize::MAX);
        let most = MOST_PER_FILE * numbers.len();
        if let Some(last) = numbers.last().filter(|last| at(**last) >= most) {
            return Err(Box::new(limit_exceeded(
                format!("at most {most} frames in {} files", numbers.len()),
                format!("numbers from {first} to {last}"),
            )));
        }
        let frames = self.frames.into_iter().map(|(number, samples)| (at(number), samples));
        let person = only_person(frames.collect(), warnings);
        of_person(&reader, self.rate, person, warnings)
    }
}

/// The frames of the arrays whose names begin with `prefix`.
fn samples(reader: &Reader<'_, '_>, prefix: &str) -> Result<Vec<Sample>, Failure> {
    let name = |own: &str| format!("{prefix}{own}");
    let (frames, positions) = rows(reader, &name(POSITIONS), None, &[JOINTS, 3])?;
    let (_, rotations) = rows(reader, &name(ROTATIONS), Some(frames), &[JOINTS, 3, 3])?;
    let places = match reader.entries.get(&name(CAMERA)) {
        Some(_) => rows(reader, &name(CAMERA), Some(frames), &[3])?.1,
        None => vec![0.0; 3 * frames],
    };
    let matrix = |row: &[f64; 9]| DQuat::from_mat3(&DMat3::from_cols_array(row).transpose()).normalize();
    let all = positions
        .chunks_exact(3 * JOINTS)
        .zip(rotations.chunks_exact(9 * JOINTS));
    let samples = all.zip(vectors(&places)).map(|((positions, rotations), place)| Sample {
        positions: vectors(positions),
        rotations: rotations.as_chunks::<9>().0.iter().map(matrix).collect(),
        place,
    });
    Ok(samples.collect())
}

/// Vectors in the frame of the camera, with +Y up.
fn vectors(numbers: &[f64]) -> Vec<DVec3> {
    let rows = numbers.as_chunks::<3>().0.iter();
    rows.map(|row| DVec3::from_array(*row) * TO_Y_UP).collect()
}

/// The numbers of an array of one frame or of many.
fn rows(
    reader: &Reader<'_, '_>,
    name: &str,
    frames: Option<usize>,
    widths: &[usize],
) -> Result<(usize, Vec<f64>), Failure> {
    let is_frame = |shape: &[usize]| shape == widths && frames.is_none_or(|frames| frames == 1);
    match reader.entries.get(name) {
        Some(array) if is_frame(&array.shape) && array.is_number() => Ok((1, array.numbers())),
        _ => reader.numbers(name, frames, widths),
    }
}

/// The frames of the person who is in most of them, each where the frame stands in the take. The persons of a frame
/// are joined to those of the frames before by the least movement.
fn only_person(frames: Vec<(usize, Vec<Sample>)>, warnings: &mut Warnings) -> Vec<(usize, Sample)> {
    /// Metres that joints move from one frame to the next on the average, at most; a person who is farther away is
    /// another one.
    const FARTHEST: f64 = 1.0;
    /// Two persons cross where the wrong choice is farther than the right one by less than this share.
    const CROSSING: f64 = 1.5;
    let most = frames.iter().map(|(_, persons)| persons.len()).max().unwrap_or(0);
    let mut persons: Vec<Vec<(usize, Sample)>> = Vec::new();
    let mut crossings = Vec::new();
    for (frame, samples) in frames {
        let mut pairs = Vec::new();
        for (index, sample) in samples.iter().enumerate() {
            for (person, known) in persons.iter().enumerate() {
                if let Some((_, last)) = known.last() {
                    pairs.push((sample.distance(last), index, person));
                }
            }
        }
        pairs.retain(|(distance, ..)| most == 1 || *distance <= FARTHEST);
        pairs.sort_by(|(a, ..), (b, ..)| a.total_cmp(b));
        let mut person_of = vec![None; samples.len()];
        let mut taken = vec![false; persons.len()];
        for (distance, index, person) in &pairs {
            if person_of[*index].is_some() || taken[*person] {
                continue;
            }
            let mut others = pairs.iter().filter(|(_, other, to)| other == index && to != person);
            if others.any(|(other, ..)| *other < CROSSING * distance) {
                crossings.push(frame);
            }
            person_of[*index] = Some(*person);
            taken[*person] = true;
        }
        for (sample, person) in samples.into_iter().zip(person_of) {
            match person {
                Some(person) => persons[person].push((frame, sample)),
                None => persons.push(vec![(frame, sample)]),
            }
        }
    }
    if let Some(first) = crossings.first() {
        warnings.push(Code::SeveralRoots, || {
            let message =
                format!("persons come so near to each other that they may be mistaken, first in frame {first}");
            Diagnostic::new(Code::SeveralRoots, message).help("save each person in a file of its own")
        });
    }
    if persons.len() > 1 {
        let others = persons.len() - 1;
        warnings.push(Code::NotCarriedOver, || {
            let message = format!("{others} more persons of the file are left out: the one in most frames is read");
            Diagnostic::new(Code::NotCarriedOver, message).help("save each person in a file of its own")
        });
    }
    // The first of those that are in as many frames.
    let longest = persons.iter().map(Vec::len).max().unwrap_or(0);
    let mut persons = persons.into_iter();
    persons.find(|person| person.len() == longest).unwrap_or_default()
}

/// The motion of one person.
fn of_person(
    reader: &Reader<'_, '_>,
    stated_rate: Option<f64>,
    person: Vec<(usize, Sample)>,
    warnings: &mut Warnings,
) -> Result<Motion, Failure> {
    let joints = mhr();
    let mut samples = fill(person, warnings)?;
    let mut motion = Motion {
        frame_rate: rate(reader, stated_rate, samples.len())?,
        ..Motion::default()
    };
    for sample in &mut samples {
        rest::fit_hands(&joints, sample);
    }
    let lengths = remove_scale(&joints, &mut samples);
    let frames = rest::frames(&joints);
    let mut rest = vec![DVec3::ZERO; JOINTS];
    for (index, joint) in joints.iter().enumerate() {
        if let Some(parent) = joint.parent {
            rest[index] = rest[parent] + frames[parent] * lengths[index];
        }
    }
    let stated = match reader.entries.get(UP) {
        Some(_) => vectors(&reader.numbers(UP, Some(3), &[])?.1).first().copied(),
        None => None,
    };
    let level = level::Level::of(&joints, &samples, stated);
    level.assume(&mut motion);
    let floor = level.floor(&joints, &samples);
    motion.root = (samples.iter())
        .map(|sample| level.turn * (sample.positions[ROOT] + sample.place) - DVec3::Y * floor)
        .collect();
    let kept = kept(&joints, &samples);
    let balls = level::feet(&joints).map(|foot| rest[foot].y);
    let ground = balls[0].min(balls[1]) - level::BALL_HEIGHT;
    for (index, joint) in joints.iter().enumerate().filter(|(index, _)| kept[*index]) {
        let above = joint.parent.filter(|parent| kept[*parent]);
        let in_world = |sample: &Sample, joint: usize| sample.rotations[joint] * frames[joint].inverse();
        let rotations = samples.iter().map(|sample| match above {
            Some(parent) => in_world(sample, parent).inverse() * in_world(sample, index),
            None => level.turn * in_world(sample, index),
        });
        motion.rotations.push(rotations.collect());
        motion.rest.push((rest[index] - DVec3::Y * ground).as_vec3());
        motion.joints.push(Joint {
            // Kept joints stand in their order.
            parent: above.map(|parent| kept[..parent].iter().filter(|kept| **kept).count()),
            ..joint.clone()
        });
    }
    motion.assume(
        Topic::Body,
        "lengths are medians over the frames",
        "the size of the body changes from frame to frame",
        Confidence::Sure,
    );
    Ok(motion)
}

/// Frames per second: of the caller or the file. One frame has none.
fn rate(reader: &Reader<'_, '_>, stated: Option<f64>, frames: usize) -> Result<f64, Failure> {
    /// Any rate is that of one frame.
    const OF_ONE: f64 = 30.0;
    let stated = stated.unwrap_or(if frames == 1 { OF_ONE } else { f64::NAN });
    reader.options.frame_rate_or(stated)
}

/// A sample for each frame: in those that lack the person, or have numbers that are not finite, between its neighbours.
fn fill(person: Vec<(usize, Sample)>, warnings: &mut Warnings) -> Result<Vec<Sample>, Failure> {
    let first = person.first().map_or(0, |(frame, _)| *frame);
    let frames = person.last().map_or(0, |(frame, _)| frame + 1 - first);
    let whole: Vec<(usize, Sample)> = (person.into_iter())
        .filter(|(_, sample)| sample.is_whole())
        .map(|(frame, sample)| (frame - first, sample))
        .collect();
    let Some((_, last)) = whole.last() else {
        let message = format!("no frame of {POSITIONS} and {ROTATIONS} has finite numbers alone");
        return Err(Box::new(Diagnostic::new(Code::NonFiniteValue, message)));
    };
    let missing = frames - whole.len();
    if missing > 0 {
        warnings.push(Code::Gap, || {
            let message = format!("the person is missing, or not finite, in {missing} of {frames} frames");
            Diagnostic::new(Code::Gap, message).help("the frames between were interpolated")
        });
    }
    let mut filled: Vec<Sample> = Vec::with_capacity(frames);
    for (frame, sample) in &whole {
        let before = filled.len();
        let gap = frame + 1 - before;
        let from = filled.last().unwrap_or(sample).clone();
        filled.extend((1..=gap).map(|step| match step == gap {
            true => sample.clone(),
            false => between(&from, sample, step as f64 / gap as f64),
        }));
    }
    filled.resize(frames, last.clone());
    Ok(filled)
}

fn between(from: &Sample, to: &Sample, share: f64) -> Sample {
    let positions = std::iter::zip(&from.positions, &to.positions);
    let rotations = std::iter::zip(&from.rotations, &to.rotations);
    Sample {
        positions: positions.map(|(from, to)| from.lerp(*to, share)).collect(),
        rotations: rotations.map(|(from, to)| from.slerp(*to, share)).collect(),
        place: from.place.lerp(to.place, share),
    }
}

/// Where a joint is from its parent, in the parent's axes.
fn offset(joint: usize, parent: usize, sample: &Sample) -> DVec3 {
    sample.rotations[parent].inverse() * (sample.positions[joint] - sample.positions[parent])
}

/// Brings the body of every frame to its median size, with its distance from the camera, which is guessed by the
/// size. Returns the median offsets of the joints.
fn remove_scale(joints: &[Joint], samples: &mut [Sample]) -> Vec<DVec3> {
    let pairs = || {
        joints
            .iter()
            .enumerate()
            .filter_map(|(index, joint)| Some((index, joint.parent?)))
    };
    // The root stands at one height from the origin, whatever the body.
    let size = |sample: &Sample| -> f64 {
        let bones = pairs().filter(|(_, parent)| *parent >= ROOT);
        bones
            .map(|(joint, parent)| sample.positions[joint].distance(sample.positions[parent]))
            .sum()
    };
    let sizes: Vec<f64> = samples.iter().map(size).collect();
    let usual = median(&mut sizes.clone()).unwrap_or(0.0);
    for (sample, own) in samples.iter_mut().zip(&sizes) {
        let scale = if *own > 0.0 { usual / own } else { 1.0 };
        let root = sample.positions[ROOT];
        sample
            .positions
            .iter_mut()
            .for_each(|position| *position = root + (*position - root) * scale);
        sample.place = (sample.place + root) * scale - root;
    }
    let mut offsets = vec![DVec3::ZERO; joints.len()];
    for (joint, parent) in pairs() {
        offsets[joint] = median_vector(samples.iter().map(|sample| offset(joint, parent, sample)));
    }
    offsets
}

/// Which joints the skeleton has: all of the body and of the hands, and of the face those that turn.
fn kept(joints: &[Joint], samples: &[Sample]) -> Vec<bool> {
    /// The cosine of half of 0.5 degrees, by which a joint turns at least.
    const TURNED: f64 = 0.999_99;
    let mut kept = vec![true; joints.len()];
    kept[0] = false;
    let head = joints.iter().position(|joint| joint.name == "c_head");
    let is_still = |joint: usize, parent: usize| {
        let local = |sample: &Sample| sample.rotations[parent].inverse() * sample.rotations[joint];
        let first = samples.first().map(local).unwrap_or_default();
        samples.iter().all(|sample| local(sample).dot(first).abs() > TURNED)
    };
    // Children stand after their parents.
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
