//! The persons of each frame in the arrays of a file. Persons are stacked along axes, or stored in dictionaries within
//! lists.

use std::collections::HashMap;

use glam::{DMat3, DQuat, DVec3, Vec3};
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::limits::limit_exceeded;
use mocap_scene::math::median::median;

use super::{CAMERA, Kind, ROTATIONS, Sample, TO_Y_UP};
use crate::Failure;
use crate::array_files::read::layouts::Reader;
use crate::array_files::read::ndarray::NdArray;

/// The persons of a frame, with the number of the frame.
pub(super) type Frame = (u64, Vec<Sample>);

/// If the median distance of consecutive samples is at least this, in metres, the samples are different persons.
/// Samples of one person in a take are nearer, even if the distance from the camera varies by 5 percent.
const APART: f64 = 0.6;

/// The largest number of persons in one list or along one axis. If there are more samples, they are frames.
const MOST_PERSONS: usize = 32;

/// The largest difference between the determinant of a rotation matrix and 1, without a unit. The determinants of
/// matrices with 16-bit numbers are nearer to 1. The rows of a person who was not found are zeros.
const NO_ROTATION: f64 = 0.2;

/// The arrays of one dictionary: frames, each with its persons.
struct Group<'n> {
    /// The lists and dictionaries that contain the arrays, outermost first.
    path: Vec<&'n str>,
    frames: Vec<Vec<Sample>>,
}

/// The frames of a file, in order. A frame without a person is kept, without samples.
pub(super) fn frames_of(reader: &Reader<'_, '_>, kind: Kind) -> Result<Vec<Frame>, Failure> {
    let entries = reader.entries;
    if entries.is_cut {
        let most = format!("at most {} arrays", entries.arrays.len());
        return Err(Box::new(
            limit_exceeded(most, "more".to_owned()).help("save the frames along the first axis, with numpy.stack"),
        ));
    }
    let named: HashMap<&str, &NdArray<'_>> = entries
        .arrays
        .iter()
        .map(|(name, array)| (name.as_str(), array))
        .collect();
    let mut groups = Vec::new();
    for (name, positions) in &entries.arrays {
        if let Some(prefix) = name.strip_suffix(kind.positions()) {
            let path = prefix.trim_end_matches('.').split('.').filter(|part| !part.is_empty());
            groups.push(Group {
                path: path.collect(),
                frames: frames_of_group(reader, &named, (prefix, kind), positions)?,
            });
        }
    }
    Ok(joined(groups))
}

/// The frames of all dictionaries.
fn joined(mut groups: Vec<Group<'_>>) -> Vec<Frame> {
    if groups.len() == 1 || groups.iter().any(|group| group.frames.len() > 1) {
        // Each dictionary has the take of one person, or one dictionary has the takes of all persons.
        return numbered(groups.into_iter().map(|group| group.frames).collect());
    }
    let list = |group: &Group<'_>| group.path.split_last().map_or(0, |(_, outer)| outer.len());
    let lists = groups.chunk_by(|a, b| a.path[..list(a)] == b.path[..list(b)]);
    let sizes: Vec<usize> = lists.clone().map(<[_]>::len).collect();
    let samples = |list: &[Group<'_>]| -> Vec<Sample> {
        let all = list.iter().flat_map(|group| group.frames.iter().flatten());
        all.cloned().collect()
    };
    let lists_of_samples: Vec<Vec<Sample>> = lists.clone().map(samples).collect();
    let are_takes = match &lists_of_samples[..] {
        [only] => !are_persons(only),
        lists => lists.iter().all(|list| list.len() > 1) && moves_within(lists),
    };
    // The number at the end of each name, if the numbers increase.
    let numbers = |names: &mut dyn Iterator<Item = Option<&str>>| -> Option<Vec<u64>> {
        let numbers: Option<Vec<u64>> = names.map(|name| trailing_number(name?)).collect();
        numbers.filter(|numbers| numbers.is_sorted_by(|a, b| a < b))
    };
    if !are_takes {
        // A list for each frame, with its persons.
        let mut outer = lists.map(|list| list[0].path.iter().rev().nth(1).copied());
        let count = lists_of_samples.len() as u64;
        let numbers = numbers(&mut outer).unwrap_or_else(|| (0..count).collect());
        return numbers.into_iter().zip(lists_of_samples).collect();
    }
    // A list for each person, with its frames.
    let mut frames: Vec<Frame> = Vec::new();
    for size in sizes {
        let rest = groups.split_off(size);
        let mut names = groups.iter().map(|group| group.path.last().copied());
        let numbers = numbers(&mut names).unwrap_or_else(|| (0..size as u64).collect());
        for (number, group) in numbers.into_iter().zip(std::mem::replace(&mut groups, rest)) {
            let samples = group.frames.into_iter().flatten();
            match frames.binary_search_by_key(&number, |(number, _)| *number) {
                Ok(at) => frames[at].1.extend(samples),
                Err(at) => frames.insert(at, (number, samples.collect())),
            }
        }
    }
    frames
}

/// Numbers frames by their order, for takes that start together.
fn numbered(takes: Vec<Vec<Vec<Sample>>>) -> Vec<Frame> {
    let mut frames: Vec<Frame> = Vec::new();
    for take in takes {
        for (index, samples) in take.into_iter().enumerate() {
            match frames.get_mut(index) {
                Some((_, all)) => all.extend(samples),
                None => frames.push((index as u64, samples)),
            }
        }
    }
    frames
}

/// The digits at the end of a name.
fn trailing_number(name: &str) -> Option<u64> {
    let digits = name.trim_end_matches(|letter: char| letter.is_ascii_digit()).len();
    name[digits..].parse().ok()
}

/// Whether consecutive samples of one list are nearer to each other than samples of neighbouring lists. Then each list
/// is the take of one person.
fn moves_within(lists: &[Vec<Sample>]) -> bool {
    let within = lists.iter().flat_map(|list| list.windows(2));
    let mut within: Vec<f64> = within.map(|pair| pair[0].distance(&pair[1])).collect();
    let nearest = |sample: &Sample, next: &[Sample]| {
        let all = next.iter().map(|other| sample.distance(other));
        all.fold(f64::INFINITY, f64::min)
    };
    let pairs = lists.windows(2);
    let mut between: Vec<f64> = pairs.map(|pair| nearest(&pair[0][0], &pair[1])).collect();
    median(&mut within) < median(&mut between)
}

/// Whether samples are different persons, not one person who moves.
fn are_persons(samples: &[Sample]) -> bool {
    if samples.len() > MOST_PERSONS {
        return false;
    }
    let mut steps: Vec<f64> = samples.windows(2).map(|pair| pair[0].distance(&pair[1])).collect();
    median(&mut steps).is_some_and(|step| step > APART)
}

/// The frames of the arrays with names that begin with `prefix`, each with its persons. Samples have no axis, or an
/// axis of frames or of persons, or both.
fn frames_of_group(
    reader: &Reader<'_, '_>,
    named: &HashMap<&str, &NdArray<'_>>,
    (prefix, kind): (&str, Kind),
    positions: &NdArray<'_>,
) -> Result<Vec<Vec<Sample>>, Failure> {
    let name = |own: &str| format!("{prefix}{own}");
    let joints = kind.joints();
    let axes = axes(reader, &name(kind.positions()), positions, &[joints, 3], None)?;
    let count: usize = axes.iter().product();
    let places = positions.numbers();
    let rotations = match ROTATIONS
        .iter()
        .find_map(|own| Some((name(own), named.get(name(own).as_str())?)))
    {
        Some((name, array)) if kind == Kind::Joints => {
            self::axes(reader, &name, array, &[joints, 3, 3], Some(&axes))?;
            array.numbers()
        }
        _ => Vec::new(),
    };
    let cameras = match named.get(name(CAMERA).as_str()) {
        Some(array) => {
            self::axes(reader, &name(CAMERA), array, &[3], Some(&axes))?;
            array.numbers()
        }
        None => vec![0.0; 3 * count],
    };
    let sample = |index: usize| {
        let own = &places[3 * joints * index..][..3 * joints];
        let rotations = rotations
            .get(9 * joints * index..9 * joints * (index + 1))
            .unwrap_or_default();
        let sample = Sample {
            positions: vectors(own).map(DVec3::as_vec3).collect(),
            rotations: rotations
                .as_chunks::<9>()
                .0
                .iter()
                .map(rotation)
                .map(DQuat::as_quat)
                .collect(),
            place: vectors(&cameras[3 * index..][..3]).next().unwrap_or_default(),
        };
        let is_there = |position: &Vec3| position.is_finite() && *position != Vec3::ZERO;
        sample.positions.iter().any(is_there).then_some(sample)
    };
    let samples: Vec<Option<Sample>> = (0..count).map(sample).collect();
    Ok(match axes[..] {
        [frames, persons] => by_frames(samples, frames, persons),
        _ => {
            let found: Vec<Sample> = samples.iter().flatten().cloned().collect();
            match found.len() == samples.len() && are_persons(&found) {
                true => vec![found],
                false => samples.into_iter().map(Vec::from_iter).collect(),
            }
        }
    })
}

/// Splits samples along two axes. The axis with less movement is the frame axis.
fn by_frames(samples: Vec<Option<Sample>>, first: usize, second: usize) -> Vec<Vec<Sample>> {
    let moved = |step: usize, length: usize| {
        let at = |index: usize| samples[index].as_ref();
        let starts = (0..samples.len()).filter(|index| index / step % length + 1 < length);
        let mut moved: Vec<f64> = starts
            .filter_map(|index| Some(at(index)?.distance(at(index + step)?)))
            .collect();
        median(&mut moved).unwrap_or(0.0)
    };
    let is_swapped = first < 2 || (second > 1 && moved(1, second) < moved(second, first));
    let frames = if is_swapped { second } else { first };
    let mut found = vec![Vec::new(); frames];
    for (index, sample) in samples.into_iter().enumerate() {
        found[if is_swapped { index % second } else { index / second }].extend(sample);
    }
    found
}

/// The axes before the axes of a sample, at most two. Axes of length 1 are dropped, unless `expected` has them.
fn axes(
    reader: &Reader<'_, '_>,
    name: &str,
    array: &NdArray<'_>,
    widths: &[usize],
    expected: Option<&[usize]>,
) -> Result<Vec<usize>, Failure> {
    let flat: usize = widths.iter().product();
    let rows = [widths[0], flat / widths[0]];
    let outer = [widths, &rows[..], &[flat][..]]
        .into_iter()
        .find_map(|suffix| array.shape.strip_suffix(suffix));
    let axes: Option<Vec<usize>> = outer.map(|outer| outer.iter().copied().filter(|axis| *axis != 1).collect());
    let axes = axes.filter(|axes| array.is_number() && axes.len() <= 2);
    match axes.filter(|axes| expected.is_none_or(|expected| expected == axes)) {
        Some(axes) => {
            reader.check_values(array)?;
            Ok(axes)
        }
        None => {
            let widths: Vec<String> = widths.iter().map(ToString::to_string).collect();
            let outer = match expected {
                None => "frames, ".to_owned(),
                Some(axes) => axes.iter().map(|axis| format!("{axis}, ")).collect(),
            };
            let message = format!("the shape of the array {name} does not match its name");
            Err(Box::new(Diagnostic::new(Code::RowLength, message).expected_found(
                format!("({outer}{})", widths.join(", ")),
                array.shape_text(),
            )))
        }
    }
}

/// Vectors in camera axes, with +Y up.
pub(super) fn vectors(numbers: &[f64]) -> impl Iterator<Item = DVec3> {
    let rows = numbers.as_chunks::<3>().0.iter();
    rows.map(|row| DVec3::from_array(*row) * TO_Y_UP)
}

/// The rotation of a row-major matrix; not finite if the matrix is no rotation.
fn rotation(row: &[f64; 9]) -> DQuat {
    let matrix = DMat3::from_cols_array(row).transpose();
    match (matrix.determinant() - 1.0).abs() < NO_ROTATION {
        true => DQuat::from_mat3(&matrix).normalize(),
        false => DQuat::from_xyzw(f64::NAN, f64::NAN, f64::NAN, f64::NAN),
    }
}
