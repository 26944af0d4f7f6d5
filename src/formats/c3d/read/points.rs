//! Reads the data: one record per frame.

use glam::DVec3;
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::limits::{FARTHEST, is_plausible, limit_exceeded};

use super::bytes::Processor;
use super::{BLOCK, Failure, Header};
use crate::warnings::{Warnings, missing_frames};

/// The positions of the points.
#[derive(Debug)]
pub(super) struct Points {
    /// The number of complete frames in the file.
    pub(super) frames: usize,
    /// One track per point.
    pub(super) tracks: Vec<Track>,
}

/// The positions of one point, in the frames in which it was seen.
#[derive(Clone, Debug, Default)]
pub(super) struct Track {
    pub(super) ticks: Vec<f64>,
    pub(super) positions: Vec<DVec3>,
    /// Whether a residual shows that cameras measured a point at the origin. In this case zeros are a position.
    pub(super) is_measured_at_zero: bool,
}

/// Reads the points. If not even one record is complete, the number of labels limits the number of points.
pub(super) fn read(
    bytes: &[u8],
    processor: Processor,
    header: &Header,
    labels: usize,
    max_values: u64,
    warnings: &mut Warnings,
) -> Result<Points, Failure> {
    let point_size = 4 * header.number_size();
    let record_size = header.record_size(header.samples);
    let data = bytes.get(header.data..header.data_end).unwrap_or_default();
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
    let wanted = usize::try_from(header.frames).unwrap_or(usize::MAX);
    let more = records_beyond(data, record_size, wanted, bytes.len());
    let held = wanted.saturating_add(more);
    check_values(held.min(data.len() / record_size), count, max_values)?;
    for record in data.chunks_exact(record_size).take(held) {
        let tick = points.frames as f64;
        for (track, point) in std::iter::zip(&mut points.tracks, record.chunks_exact(point_size)) {
            let Some((position, residual)) = read_point(point, processor, header.scale) else {
                continue;
            };
            // Kinematics cannot compute with these numbers, so the point counts as not seen.
            if let Some(number) = position.to_array().into_iter().find(|number| !is_plausible(*number)) {
                warnings.tally(Code::NonFiniteValue, || {
                    let message = format!(
                        "a coordinate in frame {} is not finite, or beyond {FARTHEST:e}",
                        points.frames
                    );
                    let offset = point.as_ptr().addr() - bytes.as_ptr().addr();
                    Diagnostic::new(Code::NonFiniteValue, message)
                        .expected_found(format!("a coordinate at byte {offset}"), format!("{number:e}"))
                        .help("the marker counts as not seen in such frames")
                });
                continue;
            }
            track.is_measured_at_zero |= position == DVec3::ZERO && residual > 0.0;
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
    if more > 0 {
        warnings.push(Code::FrameCount, || {
            Diagnostic::new(Code::FrameCount, "the file has more frames than it states")
                .expected_found(format!("{wanted} frames"), format!("{} frames", points.frames))
                .help("all frames were read")
        });
    }
    Ok(points)
}

/// The number of records after the stated ones. Padding at the end does not count. Zeros are padding. In a file of
/// whole blocks, any bytes that are fewer than a block are padding too.
fn records_beyond(data: &[u8], record_size: usize, stated: usize, file_size: usize) -> usize {
    let beyond = data.get(stated.saturating_mul(record_size)..).unwrap_or_default();
    let used = beyond.iter().rposition(|byte| *byte != 0).map_or(0, |last| last + 1);
    let is_filling = file_size.is_multiple_of(BLOCK) && beyond.len() < BLOCK;
    if is_filling || record_size == 0 || stated == 0 {
        return 0;
    }
    used.div_ceil(record_size).min(beyond.len() / record_size)
}

/// Refuses more values than the limit allows.
fn check_values(frames: usize, points: usize, most: u64) -> Result<(), Failure> {
    match (frames as u64).saturating_mul(3 * points as u64) > most {
        true => Err(Box::new(limit_exceeded(
            format!("at most {most} values"),
            format!("{frames} frames of {points} points"),
        ))),
        false => Ok(()),
    }
}

/// The position and its residual; `None` if the point was not seen.
fn read_point(bytes: &[u8], processor: Processor, scale: Option<f64>) -> Option<(DVec3, f64)> {
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
    (residual >= 0.0).then_some((numbers, residual))
}
