//! Assigns samples to persons, and finds the frames that lack a person.

use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::report::counted;

use super::samples::Frame;
use super::{Kind, Sample};
use crate::warnings::Warnings;
use crate::{Failure, ReadOptions};

/// The largest mean displacement of a person's joints from one frame to the next, in metres. A sample that is farther
/// away belongs to another person.
const FARTHEST: f64 = 1.0;

/// The largest ratio of two distances at which two persons count as crossing: the distance for the exchanged assignment
/// over the distance for the chosen one.
const CROSSING: f64 = 1.5;

/// The largest number of persons in a message.
const NAMED: usize = 5;

/// The frames of a person, with their positions in the take.
pub(super) struct Person {
    pub(super) frames: Vec<(usize, Sample)>,
    /// The name of the person; `None` if the take has no other person.
    pub(super) name: Option<String>,
}

/// The frames of the requested person, or of the person with the most frames. Samples of consecutive frames are
/// assigned to persons so that joints move as little as possible.
pub(super) fn only_person(
    frames: Vec<(usize, Vec<Sample>)>,
    options: &ReadOptions,
    warnings: &mut Warnings,
) -> Result<Person, Failure> {
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
                format!("persons come so close to each other that they may be confused, first in frame {first}");
            Diagnostic::new(Code::SeveralRoots, message).help("save each person in a separate file")
        });
    }
    chosen(persons, options, warnings)
}

fn chosen(
    mut persons: Vec<Vec<(usize, Sample)>>,
    options: &ReadOptions,
    warnings: &mut Warnings,
) -> Result<Person, Failure> {
    let name = |person: usize| format!("person_{person}");
    if persons.len() < 2 {
        return Ok(Person {
            frames: persons.pop().unwrap_or_default(),
            name: options.person.clone().filter(|own| *own == name(0)),
        });
    }
    let longest = persons.iter().map(Vec::len).max().unwrap_or(0);
    // On a tie, the first person is chosen.
    let usual = persons.iter().position(|person| person.len() == longest).unwrap_or(0);
    let own = (options.person.as_ref()).and_then(|own| (0..persons.len()).find(|person| name(*person) == *own));
    let own = own.unwrap_or(usual);
    let mut others: Vec<usize> = (0..persons.len()).filter(|person| *person != own).collect();
    let count = others.len();
    others.sort_by_key(|person| std::cmp::Reverse(persons[*person].len()));
    let of_frames = |person: &usize| format!("{} ({})", name(*person), counted(persons[*person].len(), "frame"));
    let named: Vec<String> = others.iter().take(NAMED).map(of_frames).collect();
    let more = if count > NAMED { ", ..." } else { "" };
    warnings.push(Code::NotCarriedOver, || {
        let left_out = match count {
            1 => "1 other person is".to_owned(),
            count => format!("{count} other persons are"),
        };
        let message = format!(
            "{} is read, and {left_out} left out: {}{more}",
            of_frames(&own),
            named.join(", ")
        );
        Diagnostic::new(Code::NotCarriedOver, message)
            .help(format!("choose another person: {{clip}} {}", name(others[0])))
    });
    Ok(Person {
        frames: persons.swap_remove(own),
        name: Some(name(own)),
    })
}

/// The position of each frame in the take, from the number of the frame. The number of a frame is larger by `step` than
/// the number of the frame before.
pub(super) fn places(frames: Vec<Frame>, step: u64) -> Vec<(usize, Vec<Sample>)> {
    let first = frames.first().map_or(0, |(number, _)| *number);
    let at = |number: u64| usize::try_from((number - first) / step).unwrap_or(usize::MAX);
    frames
        .into_iter()
        .map(|(number, samples)| (at(number), samples))
        .collect()
}

/// A sample for each frame. Frames that lack the person, or have numbers that are not finite, are interpolated.
pub(super) fn fill(
    person: Vec<(usize, Sample)>,
    (kind, all): (Kind, usize),
    warnings: &mut Warnings,
) -> Result<Vec<Sample>, Failure> {
    let first = person.first().map_or(0, |(frame, _)| *frame);
    let frames = person.last().map_or(0, |(frame, _)| frame + 1 - first);
    let whole: Vec<(usize, Sample)> = (person.into_iter())
        .filter(|(_, sample)| sample.is_whole())
        .map(|(frame, sample)| (frame - first, sample))
        .collect();
    let Some((_, last)) = whole.last() else {
        if frames == 0 {
            let message = format!("{} has no frames with a person", kind.positions());
            return Err(Box::new(Diagnostic::new(Code::NoMotion, message)));
        }
        let message = format!(
            "no frame of {} has only finite numbers and valid rotations",
            kind.positions()
        );
        return Err(Box::new(Diagnostic::new(Code::NonFiniteValue, message)));
    };
    let last = last.clone();
    let missing = frames - whole.len();
    if missing > 0 {
        warnings.push(Code::Gap, || {
            let message = format!("the person is missing, or not finite, in {missing} of {frames} frames");
            Diagnostic::new(Code::Gap, message).help("mocap interpolated the missing frames")
        });
    }
    if frames < all {
        warnings.push(Code::MissingFrames, || {
            let message = format!(
                "the take is limited to the frames with the person: {first} to {} of {all}",
                first + frames - 1
            );
            Diagnostic::new(Code::MissingFrames, message)
        });
    }
    let mut filled: Vec<Sample> = Vec::with_capacity(frames);
    for (frame, sample) in whole {
        let before = filled.len();
        let gap = frame + 1 - before;
        if gap > 1 {
            let from = filled.last().unwrap_or(&sample).clone();
            filled.extend((1..gap).map(|step| between(&from, &sample, step as f32 / gap as f32)));
        }
        filled.push(sample);
    }
    filled.resize(frames, last);
    Ok(filled)
}

fn between(from: &Sample, to: &Sample, share: f32) -> Sample {
    let positions = std::iter::zip(&from.positions, &to.positions);
    let rotations = std::iter::zip(&from.rotations, &to.rotations);
    Sample {
        positions: positions.map(|(from, to)| from.lerp(*to, share)).collect(),
        rotations: rotations.map(|(from, to)| from.slerp(*to, share)).collect(),
        place: from.place.lerp(to.place, f64::from(share)),
    }
}
