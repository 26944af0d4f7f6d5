//! Reads the `.asf` file: its sections, and the bones in the order of the file. `hierarchy` sorts them.

mod hierarchy;

use std::collections::HashMap;

use glam::{DQuat, DVec3};
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::limits::{FARTHEST, Limits, limit_exceeded};

use super::line::Lines;
use crate::Failure;
use crate::text::{Word, decode_name, quote};

/// The channel that one value of a motion drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ChannelKind {
    Translation(usize),
    Rotation(usize),
    /// The length of the bone. Programs disagree about the meaning of this channel, so mocap ignores its values.
    Length,
}

/// The root or a bone.
#[derive(Clone, Debug)]
pub(super) struct Bone {
    pub(super) name: String,
    /// The index of the parent; absent only for the root.
    pub(super) parent: Option<usize>,
    /// The world vector from the near end to the far end.
    pub(super) link: DVec3,
    /// The world rotation of the bone's axes.
    pub(super) axes: DQuat,
    /// The channels of the motion's values, in the order of the file.
    pub(super) channels: Vec<ChannelKind>,
    /// Whether the bone has no children.
    pub(super) is_leaf: bool,
}

/// The contents of the file.
#[derive(Debug)]
pub(super) struct Skeleton {
    /// The bones in depth-first order, the root first.
    pub(super) bones: Vec<Bone>,
    /// The rest position of the root.
    pub(super) position: DVec3,
    /// Whether angles are in degrees.
    pub(super) degrees: bool,
    /// The value of `:units length` in the file.
    pub(super) length_unit: Option<f64>,
}

/// Reads an `.asf` text.
pub(super) fn read(text: &[u8], limits: &Limits) -> Result<Skeleton, Failure> {
    let mut reader = Reader {
        lines: Lines::new(text),
        limits,
        bones: vec![Bone::new("root".to_owned())],
        named_at: vec![Word { bytes: b"", offset: 0 }],
        children: vec![Vec::new()],
        index_of: HashMap::from([("root".to_owned(), 0)]),
        position: DVec3::ZERO,
        degrees: true,
        length_unit: None,
    };
    reader.read_sections()?;
    let bones = reader.depth_first()?;
    Ok(Skeleton {
        bones,
        position: reader.position,
        degrees: reader.degrees,
        length_unit: reader.length_unit,
    })
}

/// The rotation by `angles` about the axes, in the order given: `R = R3 R2 R1`.
pub(super) fn turn(rotations: impl Iterator<Item = (usize, f64)>) -> DQuat {
    rotations.fold(DQuat::IDENTITY, |rotation, (axis, radians)| {
        DQuat::from_axis_angle(DVec3::AXES[axis], radians) * rotation
    })
}

impl Bone {
    fn new(name: String) -> Self {
        Self {
            name,
            parent: None,
            link: DVec3::ZERO,
            axes: DQuat::IDENTITY,
            channels: Vec::new(),
            is_leaf: true,
        }
    }
}

struct Reader<'a, 'c> {
    lines: Lines<'a>,
    limits: &'c Limits,
    /// The bones in the order of the file, the root first.
    bones: Vec<Bone>,
    /// The location of each bone's name.
    named_at: Vec<Word<'a>>,
    /// The children of each bone, in the order of the hierarchy.
    children: Vec<Vec<usize>>,
    index_of: HashMap<String, usize>,
    position: DVec3,
    degrees: bool,
    length_unit: Option<f64>,
}

impl<'a> Reader<'a, '_> {
    fn read_sections(&mut self) -> Result<(), Failure> {
        let (mut has_bones, mut has_hierarchy) = (false, false);
        while let Some(line) = self.lines.next_line() {
            let section = line[0];
            if section.is(":units") {
                self.read_units()?;
            } else if section.is(":root") {
                self.read_root()?;
            } else if section.is(":bonedata") {
                has_bones = true;
                self.read_bones()?;
            } else if section.is(":hierarchy") {
                has_hierarchy = true;
                self.read_hierarchy()?;
            } else if section.bytes.starts_with(b":") {
                while self.next_in_section().is_some() {}
            } else {
                return Err(Box::new(
                    self.lines
                        .at(section, Code::MissingKeyword, "a section is missing")
                        .expected_found("a section such as :units", quote(section.bytes))
                        .help("check that this file is the skeleton, an .asf file"),
                ));
            }
        }
        for (is_there, section) in [(has_bones, ":bonedata"), (has_hierarchy, ":hierarchy")] {
            if !is_there {
                return Err(self.lines.ended(format!("the file has no {section}"), section));
            }
        }
        Ok(())
    }

    /// The next line, or `None` if it begins a section.
    fn next_in_section(&mut self) -> Option<Vec<Word<'a>>> {
        match self.lines.peek_word() {
            Some(word) if !word.bytes.starts_with(b":") => self.lines.next_line(),
            _ => None,
        }
    }

    fn read_units(&mut self) -> Result<(), Failure> {
        while let Some(line) = self.next_in_section() {
            if line[0].is("length") {
                self.length_unit = Some(self.lines.number(&line, 1, "the unit of length")?);
            } else if line[0].is("angle") {
                self.degrees = match line.get(1) {
                    Some(unit) if unit.is("rad") => false,
                    Some(unit) if !unit.is("deg") => return Err(self.lines.unexpected(*unit, "deg or rad")),
                    _ => true,
                };
            }
        }
        Ok(())
    }

    fn read_root(&mut self) -> Result<(), Failure> {
        let mut order = [0, 1, 2];
        let mut orientation = DVec3::ZERO;
        while let Some(line) = self.next_in_section() {
            let keyword = line[0];
            if keyword.is("order") {
                self.bones[0].channels = self.read_channels(&line, 0)?;
            } else if keyword.is("axis") {
                order = self.read_order(&line, 1)?;
            } else if keyword.is("position") {
                self.position = self.lines.vector(&line)?;
            } else if keyword.is("orientation") {
                orientation = self.lines.vector(&line)?;
            } else {
                return Err(self.lines.unexpected(keyword, "order, axis, position or orientation"));
            }
        }
        self.bones[0].axes = self.rotation(order, orientation);
        Ok(())
    }

    fn read_bones(&mut self) -> Result<(), Failure> {
        while let Some(line) = self.next_in_section() {
            if !line[0].is("begin") {
                return Err(self.lines.unexpected(line[0], "begin, or the next section"));
            }
            let limit = self.limits.max_nodes;
            if self.bones.len() >= limit {
                let diagnostic = limit_exceeded(format!("at most {limit} nodes"), format!("more than {limit}"));
                return Err(self.located(diagnostic, line[0]));
            }
            let (bone, named_at) = self.read_bone(line[0])?;
            self.index_of.insert(bone.name.clone(), self.bones.len());
            self.bones.push(bone);
            self.named_at.push(named_at);
            self.children.push(Vec::new());
        }
        Ok(())
    }

    fn located(&self, mut diagnostic: Diagnostic, word: Word<'_>) -> Failure {
        diagnostic.location = self.lines.at(word, diagnostic.code, "").location;
        Box::new(diagnostic)
    }

    /// Reads a bone, from the word after `begin` to `end`. Also returns the location of the bone's name.
    fn read_bone(&mut self, begin: Word<'_>) -> Result<(Bone, Word<'a>), Failure> {
        let mut bone = Bone::new(String::new());
        let mut named_at = None;
        let (mut direction, mut length) = (None, None);
        loop {
            let in_bone = |mut failure: Failure| -> Failure {
                failure.joint = (!bone.name.is_empty()).then(|| bone.name.clone());
                failure
            };
            let Some(line) = self.next_in_section() else {
                return Err(in_bone(self.unclosed("bone", begin)));
            };
            let keyword = line[0];
            if keyword.is("end") {
                break;
            } else if keyword.is("name") {
                let name = self.read_name(&line)?;
                named_at = Some(name);
                bone.name = decode_name(name.bytes);
            } else if keyword.is("direction") {
                direction = Some(self.lines.vector(&line).map_err(in_bone)?);
            } else if keyword.is("length") {
                let what = "the length of the bone";
                length = Some(self.lines.number(&line, 1, what).map_err(in_bone)?);
            } else if keyword.is("axis") {
                let angles = self.lines.vector(&line).map_err(in_bone)?;
                let order = self.read_order(&line, 4).map_err(in_bone)?;
                bone.axes = self.rotation(order, angles);
            } else if keyword.is("dof") {
                let channels = self.read_channels(&line, self.bones.len()).map_err(in_bone)?;
                bone.channels = channels;
            } else if !is_passed_over(keyword) {
                let expected = "name, direction, length, axis, dof, limits or end";
                return Err(in_bone(self.lines.unexpected(keyword, expected)));
            }
        }
        let Some(named_at) = named_at else {
            return Err(self.lacks(begin, &bone, "name", "the name of the bone"));
        };
        let direction = direction.ok_or_else(|| self.lacks(begin, &bone, "direction", "its x, y and z"))?;
        let length = length.ok_or_else(|| self.lacks(begin, &bone, "length", "a number"))?;
        bone.link = direction * length;
        if bone.link.abs().max_element() > FARTHEST {
            let message = format!("the length of a bone must be below {FARTHEST:e}");
            let diagnostic = self.lines.at(named_at, Code::NonFiniteOffset, message);
            return Err(Box::new(diagnostic.in_joint(&bone.name)));
        }
        Ok((bone, named_at))
    }

    /// The error for a bone without a required line.
    fn lacks(&self, begin: Word<'_>, bone: &Bone, keyword: &str, what: &str) -> Failure {
        let message = format!("this bone has no {keyword}");
        let diagnostic = self.lines.at(begin, Code::MissingKeyword, message);
        let mut diagnostic = diagnostic.expected_found(format!("{keyword}, and {what}"), "end");
        diagnostic.joint = (!bone.name.is_empty()).then(|| bone.name.clone());
        Box::new(diagnostic)
    }

    /// The error for a missing `end`: a section begins or the file ends before the `end`.
    fn unclosed(&self, what: &str, begin: Word<'_>) -> Failure {
        let line = self.lines.line_number(begin);
        let (failure, cause) = match self.lines.peek_word() {
            Some(section) => (self.lines.unexpected(section, "end"), "lacks the word end"),
            None => {
                let message = format!("the file ends inside a {what}");
                (self.lines.ended(message, "end"), "is cut off or lacks the word end")
            }
        };
        let help = format!("the {what} that begins in line {line} has no end; the file {cause}");
        Box::new(failure.help(help))
    }

    fn read_name(&self, line: &[Word<'a>]) -> Result<Word<'a>, Failure> {
        let Some(&word) = line.get(1) else {
            return Err(self.lines.unexpected(line[0], "a name after this word"));
        };
        let limit = self.limits.max_name_bytes;
        if word.bytes.len() > limit {
            let found = format!("{}", word.bytes.len());
            let diagnostic = limit_exceeded(format!("at most {limit} bytes in a name"), found);
            return Err(self.located(diagnostic, word));
        }
        let Some(&index) = self.index_of.get(&decode_name(word.bytes)) else {
            return Ok(word);
        };
        let first = match index {
            0 => "the root always has the name root".to_owned(),
            _ => format!(
                "the first one is in line {}",
                self.lines.line_number(self.named_at[index])
            ),
        };
        let message = format!("a second bone is called {}", quote(word.bytes));
        let diagnostic = self.lines.at(word, Code::UnexpectedToken, message);
        Err(Box::new(diagnostic.help(format!(
            "give each bone a unique name, because the hierarchy and the motion refer to it; {first}"
        ))))
    }

    /// Reads `dof rx ry rz` or `order TX TY TZ RX RY RZ`.
    fn read_channels(&self, line: &[Word<'_>], bone: usize) -> Result<Vec<ChannelKind>, Failure> {
        let channel = |word: &Word<'_>| {
            let kind = match word.bytes.to_ascii_lowercase().as_slice() {
                b"tx" => ChannelKind::Translation(0),
                b"ty" => ChannelKind::Translation(1),
                b"tz" => ChannelKind::Translation(2),
                b"rx" => ChannelKind::Rotation(0),
                b"ry" => ChannelKind::Rotation(1),
                b"rz" => ChannelKind::Rotation(2),
                b"l" if bone > 0 => ChannelKind::Length,
                _ => {
                    let message = format!("{} is not a channel", quote(word.bytes));
                    return Err(Box::new(
                        self.lines
                            .at(*word, Code::UnknownChannel, message)
                            .expected_found("tx, ty, tz, rx, ry, rz or l", quote(word.bytes)),
                    ));
                }
            };
            Ok(kind)
        };
        line[1..].iter().map(channel).collect()
    }

    /// Reads an order such as `XYZ`, in any case.
    fn read_order(&self, line: &[Word<'_>], index: usize) -> Result<[usize; 3], Failure> {
        let Some(word) = line.get(index) else {
            return Err(self
                .lines
                .unexpected(line[line.len() - 1], "an order of axes after this word, such as XYZ"));
        };
        let axis = |letter: u8| b"XYZ".iter().position(|name| letter.eq_ignore_ascii_case(name));
        let axes: Option<Vec<usize>> = word.bytes.iter().map(|&letter| axis(letter)).collect();
        match axes.as_deref() {
            Some(&[a, b, c]) if a != b && b != c && a != c => Ok([a, b, c]),
            _ => Err(self.lines.unexpected(*word, "an order of axes, such as XYZ")),
        }
    }

    fn rotation(&self, order: [usize; 3], angles: DVec3) -> DQuat {
        let radians = if self.degrees {
            angles.map(f64::to_radians)
        } else {
            angles
        };
        // The numbers are in the order of the named axes, not of x, y, z.
        turn(std::iter::zip(order, radians.to_array()))
    }
}

/// Whether a line of a bone does not affect the bone's position.
fn is_passed_over(keyword: Word<'_>) -> bool {
    let keywords = ["id", "limits", "bodymass", "cofmass"];
    // Further limits are on lines of their own, which begin with a parenthesis.
    keywords.iter().any(|known| keyword.is(known)) || keyword.bytes.starts_with(b"(")
}
