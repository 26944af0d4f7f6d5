//! Reads the lines of a joint's block: OFFSET and CHANNELS.

use glam::Vec3;
use mocap_scene::error::{Code, Diagnostic, nearest};
use mocap_scene::limits::FARTHEST;
use mocap_scene::math::rotation::Axis;

use super::super::Failure;
use super::super::channel::ChannelKind;
use super::{Reader, is_structure};
use crate::text::{Word, decode_name, number, quote};

impl Reader<'_, '_> {
    /// Reads `"OFFSET" x y z`. The last OFFSET wins.
    pub(super) fn read_offset(&mut self, keyword: Word<'_>) -> Result<(), Failure> {
        let open = self.open.last_mut().expect("OFFSET stands in a block");
        open.offsets += 1;
        let (joint, repeated) = (open.joint, open.offsets > 1);
        let mut offset = Vec3::ZERO;
        for (axis, letter) in ['X', 'Y', 'Z'].into_iter().enumerate() {
            let what = format!("the {letter} value of OFFSET");
            let Some(word) = self.cursor.next_word() else {
                return Err(self.cut_off("OFFSET", &what));
            };
            let Some(number) = number::parse(word.bytes).filter(|number| number.length == word.bytes.len()) else {
                return Err(self.invalid_number(word, what));
            };
            if number.value.is_nan() || number.value.abs() > FARTHEST {
                return Err(self.in_open_joint(
                    Diagnostic::new(Code::NonFiniteOffset, "OFFSET must be finite and below 1e18")
                        .at(self.cursor.locate(word))
                        .expected_found(what, quote(word.bytes)),
                ));
            }
            self.decimals.note(word, number, joint);
            offset[axis] = number.value as f32;
        }
        self.skip_more_of_offset();
        self.joints[joint].offset = offset;
        self.joints[joint].source.offset = Some(keyword.offset);
        if repeated {
            self.warn(
                Code::RepeatedOffset,
                keyword,
                "the joint has a second OFFSET; the last one was used",
            );
        }
        Ok(())
    }

    /// Skips a rotation after the offset, which some programs write and no reader uses.
    fn skip_more_of_offset(&mut self) {
        let is_number =
            |word: &Word<'_>| number::parse(word.bytes).is_some_and(|found| found.length == word.bytes.len());
        let Some(first) = self.cursor.peek_word().filter(is_number) else {
            return;
        };
        while self.cursor.peek_word().is_some_and(|word| is_number(&word)) {
            self.cursor.next_word();
        }
        let message = "OFFSET has more than three numbers; the first three were used";
        self.warn(Code::LongOffset, first, message);
    }

    /// Reads `"CHANNELS" n name{n}`. A second line continues the first.
    pub(super) fn read_channels(&mut self, keyword: Word<'_>) -> Result<(), Failure> {
        let Some(word) = self.cursor.next_word() else {
            return Err(self.cut_off("CHANNELS", "a number of channels"));
        };
        let count = std::str::from_utf8(word.bytes)
            .ok()
            .and_then(|digits| digits.parse::<u64>().ok());
        let Some(count) = count else {
            return Err(self.invalid_number(word, "the number of CHANNELS".to_owned()));
        };
        let joint = self.open.last().expect("CHANNELS stands in a block").joint;
        let mut channels = Vec::new();
        // A set, so that a long list is not searched for every name.
        let mut seen = [false; ChannelKind::COUNT];
        while let Some(name) = self.cursor.peek_word() {
            let Some(kind) = ChannelKind::from_name(name.bytes) else {
                if (channels.len() as u64) < count && !is_structure(name) {
                    return Err(self.unknown_channel(name));
                }
                break;
            };
            if std::mem::replace(&mut seen[kind.index()], true) {
                self.warn(
                    Code::RepeatedChannel,
                    name,
                    &format!("{} is named twice in the joint", kind.name()),
                );
            }
            channels.push(kind);
            self.cursor.next_word();
        }
        let listed = channels.len();
        if (listed as u64) < count && self.cursor.peek_word().is_none() {
            return Err(self.cut_off("CHANNELS", "a channel name"));
        }
        if listed as u64 != count {
            return Err(self.in_open_joint(
                Diagnostic::new(
                    Code::ChannelCount,
                    "the number after CHANNELS differs from the number of names",
                )
                .at(self.cursor.locate(word))
                .expected_found(format!("{count} channel names"), format!("{listed}"))
                .help(format!("write CHANNELS {listed}, or complete the list")),
            ));
        }
        self.add_channels(keyword, joint, channels)
    }

    /// Adds channels. Ignores a second CHANNELS line that equals the first. A second CHANNELS line with other channels
    /// continues the first.
    fn add_channels(&mut self, keyword: Word<'_>, joint: usize, mut channels: Vec<ChannelKind>) -> Result<(), Failure> {
        if !self.joints[joint].channels.is_empty() {
            self.warn(Code::RepeatedChannels, keyword, "the joint has a second CHANNELS line");
            if self.joints[joint].channels == channels {
                return Ok(());
            }
            if self.joints.len() - 1 != joint {
                // Otherwise the columns of the joint would not be adjacent, and readers disagree about their order.
                return Err(self.unexpected(keyword, "all CHANNELS of a joint before its children"));
            }
        } else {
            self.joints[joint].source.channels = Some(keyword.offset);
            self.joints[joint].first_column = self.channel_count;
        }
        self.channel_count += channels.len();
        self.joints[joint].channels.append(&mut channels);
        Ok(())
    }

    fn unknown_channel(&self, word: Word<'_>) -> Failure {
        let help = match nearest(&decode_name(word.bytes), ChannelKind::names()) {
            Some(name) => format!("did you mean {name}?"),
            None => format!(
                "the channels are {}",
                [Axis::X, Axis::Y, Axis::Z]
                    .map(|axis| format!(
                        "{}, {}",
                        ChannelKind::Position(axis).name(),
                        ChannelKind::Rotation(axis).name()
                    ))
                    .join(", ")
            ),
        };
        self.in_open_joint(
            Diagnostic::new(Code::UnknownChannel, format!("{} is not a channel", quote(word.bytes)))
                .at(self.cursor.locate(word))
                .expected_found("a channel name", quote(word.bytes))
                .help(help),
        )
    }
}
