//! Reads the data: one record per frame.

use glam::DVec3;
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::limits::{FARTHEST, is_plausible};

use super::bytes::Processor;
use super::{Failure, Header};
use crate::warnings::{Warnings, missing_frames};

/// The positions of the points.
#[derive(Debug)]
pub(super) struct Points {
    /// Complete frames in the file.
    pub(super) frames: usize,
    /// One a point.
    pub(super) tracks: Vec<Track>,
}

/// The positions of one point, in the frames in which it was seen.
#[derive(Clone, Debug, Default)]
pub(super) struct Track {
    pub(super) ticks: Vec<f64>,
    pub(super) positions: Vec<DVec3>,
}

/// If not even one record is complete, the number of points is limited by the number of labels.
pub(super) fn read(
    bytes: &[u8],
    processor: Processor,
    header: &Header,
    labels: usize,
    warnings: &mut Warnings,
) -> Result<Points, Failure> {
    let point_size = 4 * header.number_size();
    let record_size = header.record_size(header.samples);
    let data = bytes.get(header.data..).unwrap_or_default();
    let count = if data.len() < record_size || header.frames == 0 {
        header.points.min(labels)
    } else {
        header.points
    };
    let mut points = Points {
        frames: 0,
        tracks: vec![Track::default(); count],
    };
    if record_size == 0 {
        return Ok(points);
    }
    // The frames that the file states, or as many as it holds.
    let wanted = usize::try_from(header.frames).unwrap_or(usize::MAX);
    for record in data.chunks_exact(record_size).take(wanted) {
        let tick = points.frames as f64;
        for (track, point) in std::iter::zip(&mut points.tracks, record.chunks_exact(point_size)) {
            let Some(position) = read_point(point, processor, header.scale) else {
                continue;
            };
            // In single precision a number that kinematics cannot compute with is infinite at once.
            if let Some(number) = position.to_array().into_iter().find(|number| !is_plausible(*number)) {
                warnings.tally(Code::NonFiniteValue, || {
                    let message = format!(
                        "a coordinate in frame {} is not finite, or beyond {FARTHEST:e}",
                        points.frames
                    );
                    let offset = point.as_ptr().addr() - bytes.as_ptr().addr();
                    Diagnostic::new(Code::NonFiniteValue, message)
                        .expected_found(format!("a coordinate at byte {offset}"), format!("{number:e}"))
                        .help("the marker was taken as not seen in such frames")
                });
                continue;
            }
            track.ticks.push(tick);
            track.positions.push(position);
        }
        points.frames += 1;
    }
    if points.frames < wanted {
        warnings.push(Code::MissingFrames, || {
            let expected = format!(
                "{} frames of {record_size} bytes from byte {} on",
                header.frames, header.data
            );
            let found = format!("{} in a file of {} bytes", points.frames, bytes.len());
            missing_frames(header.frames, points.frames as u64).expected_found(expected, found)
        });
    }
    Ok(points)
}

/// `None` where the point was not seen.
fn read_point(bytes: &[u8], processor: Processor, scale: Option<f64>) -> Option<DVec3> {
    let (numbers, residual) = match scale {
        Some(scale) => {
            let (words, _) = bytes.as_chunks::<2>();
            let number = |index: usize| f64::from(processor.word(words[index]).cast_signed());
            (DVec3::new(number(0), number(1), number(2)) * scale, number(3))
        }
        None => {
            let (words, _) = bytes.as_chunks::<4>();
            let number = |index: usize| processor.real(words[index]);
            (DVec3::new(number(0), number(1), number(2)), number(3))
        }
    };
    (residual >= 0.0).then_some(numbers)
}
