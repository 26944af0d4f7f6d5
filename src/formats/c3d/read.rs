//! Reads the header, the parameters and the data of a file.

#[doc(hidden)]
pub(crate) mod bytes;
mod parameters;
mod points;
pub(crate) mod recorded;
mod rotations;
mod scene;

use std::ops::Range;

use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::limits::{FARTHEST, SMALLEST_SCALE, is_degenerate_scale, is_plausible, limit_exceeded};
use mocap_scene::scene::Scene;

use self::bytes::{Bytes, Processor};
use self::parameters::Parameters;
use super::{BLOCK, KEY};
use crate::warnings::Warnings;
use crate::{Failure, ReadOptions, Source};

/// The byte of the header with the block number of the data.
const DATA_BLOCK: usize = 16;

/// The help for a file that is too short.
const CUT_OFF: &str = "the file is cut off: export or download it again";

pub(super) fn read(source: &Source<'_>, options: &ReadOptions) -> Result<Scene> {
    let mut warnings = Warnings::default();
    let read = read_bytes(source.bytes, options, &mut warnings);
    warnings.attach_to(read)
}

fn read_bytes(bytes: &[u8], options: &ReadOptions, warnings: &mut Warnings) -> Result<Scene, Failure> {
    let (processor, section) = processor(bytes)?;
    let section_start = section.start - 4;
    let parameters = read_parameters(bytes, section, processor, warnings)?;
    let mut header = Header::read(bytes, processor, &parameters, options, warnings)?;
    if section_start > header.data {
        header.data_end = section_start.min(bytes.len());
    }
    if let Some((start, _)) = rotations::layout(&parameters).filter(|(start, _)| *start > header.data) {
        header.data_end = header.data_end.min(start);
    }
    let (labels, most) = (parameters.labels().len(), options.limits.max_values);
    let points = points::read(bytes, processor, &header, labels, most, warnings)?;
    let recorded = recorded::read(bytes, processor, &header, &parameters, points.frames, warnings);
    let segments = rotations::read(bytes, processor, &header, &parameters, most, warnings);
    Ok(scene::build(
        &parameters,
        &header,
        (points, segments),
        recorded,
        warnings,
    ))
}

/// Reads the parameters of a section of stated length. If the parameters go on beyond this length but end before the
/// data, the stated length is too small.
fn read_parameters(
    bytes: &[u8],
    section: Range<usize>,
    processor: Processor,
    warnings: &mut Warnings,
) -> Result<Parameters, Failure> {
    let stated = parameters::read(bytes, section.clone(), processor);
    if stated.as_ref().is_ok_and(|stated| stated.is_ended) {
        return stated;
    }
    let mut header = Bytes::new(bytes, processor);
    header.set_offset(DATA_BLOCK);
    let data_block = header.word().map_or(0, usize::from);
    let data = data_block.saturating_sub(1).saturating_mul(BLOCK).min(bytes.len());
    if data <= section.end {
        return stated;
    }
    match parameters::read(bytes, section.start..data, processor) {
        Ok(all) if all.is_ended => {
            if stated.as_ref().map_or(true, |stated| *stated != all) {
                warnings.push(Code::HeaderCount, || {
                    let message =
                        "the parameter section is longer than stated; all parameters before the data were read";
                    Diagnostic::new(Code::HeaderCount, message)
                        .expected_found(format!("{} bytes", data - section.start), format!("{}", section.len()))
                });
            }
            Ok(all)
        }
        _ => stated,
    }
}

/// The processor type of the file's numbers, and the byte range of its parameters.
fn processor(bytes: &[u8]) -> Result<(Processor, Range<usize>), Failure> {
    if bytes.is_empty() {
        return Err(Box::new(Diagnostic::new(Code::EmptyFile, "the file is empty")));
    }
    let &[first, key, ..] = bytes else {
        return Err(not_a_c3d("a file of one byte".to_owned()));
    };
    if key != KEY || first == 0 {
        return Err(not_a_c3d(format!("the bytes {first:#04x} {key:#04x}")));
    }
    let start = (usize::from(first) - 1) * BLOCK;
    let Some(&[_, _, blocks, code]) = bytes.get(start..start + 4) else {
        return Err(Box::new(
            Diagnostic::new(Code::UnexpectedEnd, "the file ends before its parameters")
                .expected_found(format!("parameters at byte {start}"), format!("{} bytes", bytes.len()))
                .help(CUT_OFF),
        ));
    };
    let processor =
        Processor::from_code(code).ok_or_else(|| not_a_c3d(format!("the processor {code}, at byte {}", start + 3)))?;
    // Some writers leave the number of blocks 0. Each parameter states its own length.
    let end = match blocks {
        0 => bytes.len(),
        blocks => bytes.len().min(start + usize::from(blocks) * BLOCK),
    };
    Ok((processor, start + 4..end))
}

fn not_a_c3d(found: String) -> Failure {
    Box::new(
        Diagnostic::new(Code::BinaryFile, "the file is not C3D")
            .expected_found(
                "a block number, the byte 0x50, and processor 84, 85 or 86 in that block",
                found,
            )
            .help("check that the extension matches the contents of the file, and that the file is not compressed"),
    )
}

/// The values of the header. A value of the parameters replaces the header's value, because parameters can hold larger
/// numbers. In valid files both values agree.
#[derive(Debug)]
struct Header {
    points: usize,
    /// The number of analog samples in a record.
    samples: usize,
    /// The number of records that the file states.
    frames: u64,
    /// The byte at which the first record begins.
    data: usize,
    /// The last byte at which the data may end.
    data_end: usize,
    /// The scale factor of integers; `None` if coordinates are 32-bit floats.
    scale: Option<f64>,
    frame_rate: f64,
    /// The frame rate that the file states.
    stated_rate: f64,
    /// The number of the first frame, counted from 1.
    first: u64,
}

impl Header {
    fn read(
        bytes: &[u8],
        processor: Processor,
        parameters: &Parameters,
        options: &ReadOptions,
        warnings: &mut Warnings,
    ) -> Result<Self, Failure> {
        let mut header = Bytes::new(bytes, processor);
        header.skip(2);
        let (points, samples) = (header.word()?, header.word()?);
        let (first, last) = (header.word()?, header.word()?);
        header.skip(2);
        let scale = header.real()?;
        let data_block = header.word()?;
        header.skip(2);
        let rate = header.real()?;

        // Some writers leave parameters zero and set only the header.
        let number = |name: &str| {
            parameters
                .number("POINT", name)
                .filter(|value| value.is_finite() && *value != 0.0)
        };
        // These words are unsigned.
        let used = |used: f64| if used < 0.0 { used + 65_536.0 } else { used };
        let points = number("USED").map_or(usize::from(points), |points| used(points) as usize);
        let scale = number("SCALE").unwrap_or(scale);
        check_scale(scale)?;
        let data_block = number("DATA_START").unwrap_or(f64::from(data_block));
        let limit = options.limits.max_nodes;
        if points >= limit {
            return Err(Box::new(limit_exceeded(
                format!("at most {limit} nodes"),
                format!("{points} points and their group"),
            )));
        }
        let frames = match parameters.frames() {
            Some(frames) => frames,
            None => u64::from(last).saturating_sub(u64::from(first)) + 1,
        };
        let limit = options.limits.max_values;
        if frames.saturating_mul(3 * points as u64) > limit {
            return Err(Box::new(limit_exceeded(
                format!("at most {limit} values"),
                format!("{frames} frames of {points} points"),
            )));
        }
        if data_block.is_nan() || data_block < 1.0 {
            return Err(Box::new(
                Diagnostic::new(Code::MissingKeyword, "the file does not state where its data begins")
                    .expected_found(
                        "a block number, 1 or more, in POINT:DATA_START",
                        format!("{data_block}"),
                    )
                    .help("export the file again"),
            ));
        }
        let rate = number("RATE").unwrap_or(rate);
        let mut header = Self {
            points,
            samples: usize::from(samples),
            frames,
            data: (data_block as usize - 1).saturating_mul(BLOCK),
            data_end: bytes.len(),
            scale: (scale >= 0.0).then_some(scale),
            frame_rate: options.frame_rate_or(rate)?,
            stated_rate: rate,
            first: parameters.first_frame().unwrap_or_else(|| u64::from(first)),
        };
        if let Some(samples) = parameters.analog_samples(rate) {
            header.choose_samples(samples, bytes.len(), warnings);
        }
        Ok(header)
    }

    /// Converts a time that counts from frame 1 to the seconds after the first frame, at the rate at which the motion
    /// is read.
    fn since_first(&self, time: f64) -> f64 {
        let before = self.first.saturating_sub(1) as f64;
        let scale = if self.stated_rate > 0.0 {
            self.stated_rate
        } else {
            self.frame_rate
        };
        (time * scale - before) / self.frame_rate
    }

    /// The size of a number in the data, in bytes.
    fn number_size(&self) -> usize {
        if self.scale.is_some() { 2 } else { 4 }
    }

    /// The size of a record in bytes: four numbers for each point, and the analog samples.
    fn record_size(&self, samples: usize) -> usize {
        (4 * self.points + samples) * self.number_size()
    }

    /// Takes the sample count of the parameters if it matches the length of the file and the header's count does not
    /// match. With the header's count, every record would be read at a wrong offset.
    fn choose_samples(&mut self, samples: usize, length: usize, warnings: &mut Warnings) {
        let data = length.saturating_sub(self.data) as u64;
        // The rest of the last block is padded or omitted.
        let rest = |samples: usize| {
            let rest = data.checked_sub(self.frames.saturating_mul(self.record_size(samples) as u64));
            rest.filter(|rest| *rest < BLOCK as u64)
        };
        match (rest(self.samples), rest(samples)) {
            (None, Some(_)) | (Some(1..), Some(0)) => {}
            _ => return,
        }
        let stated = std::mem::replace(&mut self.samples, samples);
        warnings.push(Code::HeaderCount, || {
            let message = "the number of analog samples in the header does not match the data; the number in the \
                parameters was used";
            Diagnostic::new(Code::HeaderCount, message).expected_found(
                format!("{samples} per frame, as ANALOG:USED and ANALOG:RATE state"),
                format!("{stated}"),
            )
        });
    }
}

/// Refuses a scale factor that integers cannot be multiplied by. Only the sign of a negative factor matters.
fn check_scale(scale: f64) -> Result<(), Failure> {
    if is_plausible(scale) && (scale < 0.0 || !is_degenerate_scale(scale)) {
        return Ok(());
    }
    Err(Box::new(
        Diagnostic::new(
            Code::NumberRange,
            "the scale factor is too large or too small to compute with",
        )
        .expected_found(
            format!("0, or {SMALLEST_SCALE:e} to {FARTHEST:e}, in POINT:SCALE or at byte 12"),
            format!("{scale:e}"),
        )
        .help("export the file again"),
    ))
}
