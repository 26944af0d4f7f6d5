//! The `.asf` file: bones as the file has them, then in the order of the hierarchy.

use std::collections::HashMap;

use glam::{DQuat, DVec3};

use super::Failure;
use super::line::Lines;
use crate::error::{Code, Diagnostic};
use crate::format::text::{Word, decode_name, quote};
use crate::limits::{Limits, limit_exceeded};

/// What one value of a motion drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ChannelKind {
    Translation(usize),
    Rotation(usize),
    /// The length of the bone. No two programs agree on what it does, so it does nothing here.
    Length,
}

/// The root or a bone.
#[derive(Clone, Debug)]
pub(super) struct Bone {
    pub(super) name: String,
    /// Index of the bone that it hangs on; absent on the root alone.
    pub(super) parent: Option<usize>,
    /// From the near end to the far end, in the world.
    pub(super) link: DVec3,
    /// The rotation of its axes in the world.
    pub(super) axes: DQuat,
    /// What the values of the motion drive, in the order written.
    pub(super) channels: Vec<ChannelKind>,
    /// Whether nothing hangs on it.
    pub(super) is_leaf: bool,
}

/// The whole file.
#[derive(Debug)]
pub(super) struct Skeleton {
    /// Depth-first, the root first.
    pub(super) bones: Vec<Bone>,
    /// Where the root stands at rest.
    pub(super) position: DVec3,
    /// Whether angles are in degrees.
    pub(super) degrees: bool,
    /// `:units length`.
    pub(super) length_unit: Option<f64>,
}

/// Reads an `.asf` text.
pub(super) fn read(text: &[u8], limits: &Limits) -> Result<Skeleton, Failure> {
    let mut reader = Reader {
        lines: Lines::new(text),
        limits,
        bones: vec![Bone::new("root".to_owned())],
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

/// The rotation by `angles` about the axes in `order`, the first first: `R = R3 R2 R1`.
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
    /// In the order of the file, the root first.
    bones: Vec<Bone>,
    /// Of each bone, in the order of the hierarchy.
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
                        .at(section, Code::MissingKeyword, "an .asf file is made of sections")
                        .expected_found("a section, as :units", quote(section.bytes)),
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

    /// The next line, unless a section begins there.
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
            let bone = self.read_bone(line[0])?;
            self.index_of.insert(bone.name.clone(), self.bones.len());
            self.bones.push(bone);
            self.children.push(Vec::new());
        }
        Ok(())
    }

    fn located(&self, diagnostic: Diagnostic, word: Word<'_>) -> Failure {
        let location = self.lines.at(word, diagnostic.code, "").location;
        Box::new(Diagnostic { location, ..diagnostic })
    }

    /// From behind `begin` to `end`.
    fn read_bone(&mut self, begin: Word<'_>) -> Result<Bone, Failure> {
        let mut bone = Bone::new(String::new());
        let (mut direction, mut length) = (DVec3::ZERO, 0.0);
        loop {
            let Some(line) = self.next_in_section() else {
                return Err(self.unclosed(begin, "end of the bone"));
            };
            let keyword = line[0];
            let in_bone = |failure: Failure| -> Failure {
                let joint = (!bone.name.is_empty()).then(|| bone.name.clone());
                Box::new(Diagnostic { joint, ..*failure })
            };
            if keyword.is("end") {
                break;
            } else if keyword.is("name") {
                bone.name = self.read_name(&line)?;
            } else if keyword.is("direction") {
                direction = self.lines.vector(&line).map_err(in_bone)?;
            } else if keyword.is("length") {
                length = self.lines.number(&line, 1, "the length of the bone").map_err(in_bone)?;
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
        if bone.name.is_empty() {
            return Err(Box::new(
                self.lines
                    .at(begin, Code::MissingKeyword, "this bone has no name")
                    .expected_found("name, and the name of the bone", "end"),
            ));
        }
        bone.link = direction * length;
        Ok(bone)
    }

    fn unclosed(&self, begin: Word<'_>, expected: &str) -> Failure {
        Box::new(
            self.lines
                .at(begin, Code::UnexpectedEnd, "this begin has no end")
                .expected_found(expected, "the end of its section"),
        )
    }

    fn read_name(&self, line: &[Word<'_>]) -> Result<String, Failure> {
        let Some(word) = line.get(1) else {
            return Err(self.lines.unexpected(line[0], "a name behind it"));
        };
        let name = decode_name(word.bytes);
        if self.index_of.contains_key(&name) {
            let message = format!("a second bone is called {}", quote(word.bytes));
            let diagnostic = self.lines.at(*word, Code::UnexpectedToken, message);
            return Err(Box::new(diagnostic.help(
                "give each bone a name of its own: the hierarchy and the motion find it by that",
            )));
        }
        Ok(name)
    }

    /// `dof rx ry rz`, `order TX TY TZ RX RY RZ`.
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

    /// `XYZ`, in any case and any order.
    fn read_order(&self, line: &[Word<'_>], index: usize) -> Result<[usize; 3], Failure> {
        let Some(word) = line.get(index) else {
            return Err(self
                .lines
                .unexpected(line[line.len() - 1], "an order of axes behind it, as XYZ"));
        };
        let axis = |letter: u8| b"XYZ".iter().position(|name| letter.eq_ignore_ascii_case(name));
        let axes: Option<Vec<usize>> = word.bytes.iter().map(|&letter| axis(letter)).collect();
        match axes.as_deref() {
            Some(&[a, b, c]) if a != b && b != c && a != c => Ok([a, b, c]),
            _ => Err(self.lines.unexpected(*word, "an order of axes, as XYZ")),
        }
    }

    fn rotation(&self, order: [usize; 3], angles: DVec3) -> DQuat {
        let radians = if self.degrees {
            angles.map(f64::to_radians)
        } else {
            angles
        };
        // The numbers stand in the order of the axes' names, not of x, y, z.
        turn(std::iter::zip(order, radians.to_array()))
    }

    fn read_hierarchy(&mut self) -> Result<(), Failure> {
        let begin = match self.next_in_section() {
            Some(line) if line[0].is("begin") => line[0],
            Some(line) => return Err(self.lines.unexpected(line[0], "begin")),
            None => return Err(self.lines.ended("the hierarchy is empty", "begin")),
        };
        loop {
            match self.next_in_section() {
                None => return Err(self.unclosed(begin, "end of the hierarchy")),
                Some(line) if line[0].is("end") => return Ok(()),
                Some(line) => self.read_family(&line)?,
            }
        }
    }

    /// A bone, and those that hang on its far end.
    fn read_family(&mut self, line: &[Word<'_>]) -> Result<(), Failure> {
        let parent = self.find(line[0])?;
        for &word in &line[1..] {
            let child = self.find(word)?;
            if child == 0 || self.bones[child].parent.is_some() {
                let message = format!("{} hangs somewhere already", quote(word.bytes));
                return Err(Box::new(self.lines.at(word, Code::UnexpectedToken, message).help(
                    "name each bone once behind the bone that it hangs on, and the root never",
                )));
            }
            self.bones[child].parent = Some(parent);
            self.bones[parent].is_leaf = false;
            self.children[parent].push(child);
        }
        Ok(())
    }

    fn find(&self, word: Word<'_>) -> Result<usize, Failure> {
        let index = self.index_of.get(&decode_name(word.bytes)).copied();
        index.ok_or_else(|| {
            let message = format!("no bone is called {}", quote(word.bytes));
            Box::new(
                self.lines
                    .at(word, Code::UnexpectedToken, message)
                    .expected_found("the name of a bone in :bonedata, or root", quote(word.bytes)),
            )
        })
    }

    /// The bones as a scene has its nodes: each right behind its parent or behind a whole subtree of its siblings.
    fn depth_first(&self) -> Result<Vec<Bone>, Failure> {
        let Limits {
            max_nodes, max_depth, ..
        } = *self.limits;
        let mut ordered: Vec<Bone> = Vec::with_capacity(self.bones.len());
        let mut nodes = 0;
        // Bone, its parent's place in the new order, its depth. A list, so that no file can overflow the call stack.
        let mut open = vec![(0, None, 1)];
        while let Some((index, parent, depth)) = open.pop() {
            let bone = &self.bones[index];
            nodes += if bone.is_leaf { 2 } else { 1 };
            let exceeded = if nodes > max_nodes {
                Some((max_nodes, "nodes"))
            } else if depth > max_depth {
                Some((max_depth, "nested bones"))
            } else {
                None
            };
            if let Some((limit, what)) = exceeded {
                let diagnostic = limit_exceeded(format!("at most {limit} {what}"), format!("more than {limit}"));
                return Err(Box::new(diagnostic.in_joint(&bone.name)));
            }
            let place = Some(ordered.len());
            ordered.push(Bone { parent, ..bone.clone() });
            let children = self.children[index].iter().rev();
            open.extend(children.map(|&child| (child, place, depth + 1)));
        }
        if ordered.len() == self.bones.len() {
            return Ok(ordered);
        }
        Err(Box::new(self.unreached()))
    }

    /// Says which bones the hierarchy does not reach from the root.
    fn unreached(&self) -> Diagnostic {
        let loose = self.bones.iter().skip(1).find(|bone| bone.parent.is_none());
        match loose {
            Some(bone) => Diagnostic::new(Code::MissingKeyword, "a bone is not in the hierarchy")
                .in_joint(&bone.name)
                .help("name it in :hierarchy behind the bone that it hangs on"),
            None => Diagnostic::new(Code::UnexpectedToken, "the hierarchy goes round in a circle")
                .help("every chain of bones must lead back to the root"),
        }
    }
}

/// Lines of a bone that say nothing about where it is.
fn is_passed_over(keyword: Word<'_>) -> bool {
    let keywords = ["id", "limits", "bodymass", "cofmass"];
    // Further limits stand on lines of their own.
    keywords.iter().any(|known| keyword.is(known)) || keyword.bytes.starts_with(b"(")
}
