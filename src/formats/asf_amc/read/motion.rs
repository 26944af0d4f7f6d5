//! Reads the `.amc` file: numbered frames with a line of values for each bone.

use std::collections::HashMap;

use mocap_scene::error::{Code, Diagnostic, nearest};
use mocap_scene::limits::limit_exceeded;

use super::line::Lines;
use super::skeleton::{ChannelKind, Skeleton};
use crate::Failure;
use crate::ReadOptions;
use crate::asf_amc::HEADER;
use crate::text::{Word, decode_name, number, quote};
use crate::warnings::Warnings;

/// The contents of the file.
#[derive(Debug)]
pub(super) struct Motion {
    pub(super) frames: usize,
    /// One track for each bone, in the order of the skeleton.
    pub(super) tracks: Vec<Track>,
    /// Whether angles are in degrees.
    pub(super) degrees: bool,
}

/// The motion of one bone.
#[derive(Clone, Debug, Default)]
pub(super) struct Track {
    /// The indices of the frames that have values for the bone.
    pub(super) ticks: Vec<f64>,
    /// The values of each frame in `ticks`, one for each channel of the bone.
    #[doc(hidden)]
    pub values: Vec<f64>,
}

/// Reads an `.amc` text. `skeleton_file` is the name of the skeleton's file in messages.
pub(super) fn read(
    text: &[u8],
    skeleton: &Skeleton,
    skeleton_file: &str,
    options: &ReadOptions,
    warnings: &mut Warnings,
) -> Result<Motion, Failure> {
    let names = skeleton.bones.iter().enumerate();
    let mut reader = Reader {
        lines: Lines::new(text),
        skeleton,
        skeleton_file,
        max_values: options.limits.max_values,
        warnings,
        bone_of: names.map(|(index, bone)| (bone.name.as_str(), index)).collect(),
        motion: Motion {
            frames: 0,
            tracks: vec![Track::default(); skeleton.bones.len()],
            degrees: skeleton.degrees,
        },
        last_number: None,
        bones_in_frame: 0,
        bones_in_first_frame: None,
        values: 0,
    };
    reader.read_frames()?;
    reader.report_the_rest();
    Ok(reader.motion)
}

struct Reader<'a, 'c> {
    lines: Lines<'a>,
    skeleton: &'c Skeleton,
    /// The name of the skeleton's file in messages.
    skeleton_file: &'c str,
    max_values: u64,
    warnings: &'c mut Warnings,
    bone_of: HashMap<&'c str, usize>,
    motion: Motion,
    /// The number of the last frame header.
    last_number: Option<u64>,
    bones_in_frame: usize,
    /// The number of bones in the first frame; `None` while the first frame is read.
    bones_in_first_frame: Option<usize>,
    /// The number of values read so far.
    values: u64,
}

impl<'a> Reader<'a, '_> {
    fn read_frames(&mut self) -> Result<(), Failure> {
        let mut line = Vec::new();
        while self.lines.read_line(&mut line) {
            let first = line[0];
            if first.bytes.starts_with(b":") {
                self.read_header(first)?;
            } else if line.len() == 1 && first.bytes.iter().all(u8::is_ascii_digit) {
                self.begin_frame(first)?;
            } else if let Err(failure) = self.read_bone(&line) {
                let is_cut_off = line.last().is_some_and(|word| self.lines.end_with(*word));
                if !is_cut_off || self.bones_in_first_frame.is_none() {
                    return Err(failure);
                }
                // The file ends inside a word, so its last frame is dropped.
                for (track, bone) in std::iter::zip(&mut self.motion.tracks, &self.skeleton.bones) {
                    track.values.truncate(track.ticks.len() * bone.channels.len());
                }
            }
        }
        if self
            .bones_in_first_frame
            .is_some_and(|first| self.bones_in_frame < first)
        {
            self.drop_last_frame();
        }
        Ok(())
    }

    fn read_header(&mut self, word: Word<'_>) -> Result<(), Failure> {
        if word.is(":DEGREES") {
            self.motion.degrees = true;
        } else if word.is(":RADIANS") {
            self.motion.degrees = false;
        } else if !word.is(":FULLY-SPECIFIED") {
            return Err(self.lines.unexpected(word, HEADER.join(", ")));
        }
        Ok(())
    }

    fn begin_frame(&mut self, word: Word<'_>) -> Result<(), Failure> {
        let number = std::str::from_utf8(word.bytes)
            .ok()
            .and_then(|digits| digits.parse::<u64>().ok());
        let Some(number) = number else {
            let message = format!("{} is too large for a frame number", quote(word.bytes));
            let next = self.last_number.map_or(1, |last| last.saturating_add(1));
            let diagnostic = self.lines.at(word, Code::InvalidNumber, message);
            return Err(Box::new(diagnostic.expected_found(
                format!("{next}, or another whole number below 2^64"),
                quote(word.bytes),
            )));
        };
        if let Some(last) = self.last_number {
            self.bones_in_first_frame.get_or_insert(self.bones_in_frame);
            let next = last.saturating_add(1);
            if number != next {
                self.warnings.tally(Code::FrameNumber, || {
                    let message = "frame numbers are not consecutive; the frames were read in the order of the file";
                    self.lines
                        .at(word, Code::FrameNumber, message)
                        .expected_found(format!("{next}"), format!("{number}"))
                });
            }
        }
        self.last_number = Some(number);
        self.bones_in_frame = 0;
        self.motion.frames += 1;
        Ok(())
    }

    /// Reads the name of a bone, and a value for each of its channels.
    fn read_bone(&mut self, line: &[Word<'a>]) -> Result<(), Failure> {
        let name = line[0];
        if self.last_number.is_none() {
            return Err(self.lines.unexpected(name, "the number of the first frame"));
        }
        let Some(&index) = self.bone_of.get(decode_name(name.bytes).as_str()) else {
            return Err(self.unknown_bone(name));
        };
        let bone = &self.skeleton.bones[index];
        let tick = (self.motion.frames - 1) as f64;
        if self.motion.tracks[index].ticks.last() == Some(&tick) {
            let message = "the bone occurs twice in this frame";
            let diagnostic = self.lines.at(name, Code::UnexpectedToken, message).in_joint(&bone.name);
            return Err(Box::new(
                diagnostic.help("put the number of the next frame before the bone"),
            ));
        }
        if line.len() - 1 != bone.channels.len() {
            return self.wrong_length(line, index);
        }
        self.values += bone.channels.len() as u64;
        if self.values > self.max_values {
            let limit = self.max_values;
            let diagnostic = limit_exceeded(format!("at most {limit} values"), format!("more than {limit}"));
            return Err(Box::new(diagnostic.in_joint(&bone.name)));
        }
        for &word in &line[1..] {
            let value = self.read_value(word, index)?;
            self.motion.tracks[index].values.push(value);
        }
        self.motion.tracks[index].ticks.push(tick);
        self.bones_in_frame += 1;
        Ok(())
    }

    fn unknown_bone(&self, word: Word<'_>) -> Failure {
        let message = format!("no bone is called {}", quote(word.bytes));
        let diagnostic = self.lines.at(word, Code::UnexpectedToken, message).expected_found(
            "the number of a frame, or the name of a bone of the skeleton",
            quote(word.bytes),
        );
        let names = self.skeleton.bones.iter().map(|bone| bone.name.as_str());
        let near = nearest(&decode_name(word.bytes), names);
        let question = near.map_or(String::new(), |near| format!("did you mean {near}? If not, "));
        Box::new(diagnostic.help(question + &self.check_skeleton()))
    }

    /// The help for a motion that does not match the skeleton.
    fn check_skeleton(&self) -> String {
        format!("check that {} is the skeleton of the same person", self.skeleton_file)
    }

    /// A line cut off by the end of the file drops its frame. Any other short line is an error.
    fn wrong_length(&mut self, line: &[Word<'a>], index: usize) -> Result<(), Failure> {
        let bone = &self.skeleton.bones[index];
        let is_cut_off = self.lines.peek_word().is_none() && line.len() <= bone.channels.len();
        if is_cut_off && self.bones_in_first_frame.is_some() {
            return Ok(());
        }
        let expected = match bone.channels.len() {
            1 => "1 value, as the skeleton states".to_owned(),
            count => format!("{count} values, as the skeleton states"),
        };
        Err(Box::new(
            self.lines
                .at(line[0], Code::RowLength, "the line has the wrong number of values")
                .in_joint(&bone.name)
                .expected_found(expected, format!("{}", line.len() - 1))
                .help(self.check_skeleton()),
        ))
    }

    fn read_value(&mut self, word: Word<'_>, index: usize) -> Result<f64, Failure> {
        let bone = &self.skeleton.bones[index];
        let number = number::parse(word.bytes).filter(|number| number.length == word.bytes.len());
        let Some(number) = number else {
            let failure = self.lines.invalid_number(word, "a value of the bone");
            return Err(Box::new(failure.in_joint(&bone.name)));
        };
        if number.comma {
            self.warnings.tally(Code::DecimalComma, || {
                let message = "numbers have decimal commas, which were read as decimal points";
                self.lines.at(word, Code::DecimalComma, message)
            });
        }
        if number.value.is_finite() {
            return Ok(number.value);
        }
        self.warnings.tally(Code::NonFiniteValue, || {
            let message = "the value is not finite; the last finite value was used";
            let diagnostic = self.lines.at(word, Code::NonFiniteValue, message).in_joint(&bone.name);
            diagnostic.expected_found("a finite number", quote(word.bytes))
        });
        let values = &self.motion.tracks[index].values;
        let before = values.len().checked_sub(bone.channels.len());
        Ok(before.map_or(0.0, |before| values[before]))
    }

    fn drop_last_frame(&mut self) {
        self.motion.frames -= 1;
        let tick = self.motion.frames as f64;
        for (track, bone) in std::iter::zip(&mut self.motion.tracks, &self.skeleton.bones) {
            if track.ticks.last() == Some(&tick) {
                track.ticks.pop();
                track.values.truncate(track.values.len() - bone.channels.len());
            }
        }
        self.warnings.push(Code::RowLength, || {
            let message = "the file ends inside its last frame, which was dropped";
            let expected = self.bones_in_first_frame.unwrap_or_default();
            self.lines
                .at_end(Code::RowLength, message)
                .expected_found(format!("{expected} bones"), format!("{}", self.bones_in_frame))
                .help("the file is cut off: export or download it again")
        });
    }

    /// Warns about missing values and unused values.
    fn report_the_rest(&mut self) {
        if self.motion.frames == 0 {
            self.warnings.push(Code::NoMotion, || {
                Diagnostic::new(
                    Code::NoMotion,
                    "the file has no frames: the scene has a skeleton and no animation",
                )
            });
        }
        for (track, bone) in std::iter::zip(&self.motion.tracks, &self.skeleton.bones) {
            let missing = self.motion.frames - track.ticks.len();
            if missing > 0 && !bone.channels.is_empty() {
                self.warnings.push(Code::Gap, || {
                    Diagnostic::new(
                        Code::Gap,
                        format!("{missing} of {} frames have no value for the bone", self.motion.frames),
                    )
                    .in_joint(&bone.name)
                });
            }
            let is_root = bone.parent.is_none();
            let in_vain = |kind: &ChannelKind| match kind {
                ChannelKind::Rotation(_) => false,
                ChannelKind::Translation(_) => !is_root,
                ChannelKind::Length => true,
            };
            if bone.channels.iter().any(in_vain) {
                self.warnings.push(Code::IgnoredChannel, || {
                    let message = "only the rotation of a bone is read; its translations and lengths are skipped";
                    Diagnostic::new(Code::IgnoredChannel, message).in_joint(&bone.name)
                });
            }
        }
    }
}
