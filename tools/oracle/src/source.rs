//! Reads the BVH file itself, so that a rule can check an explanation on the file, and not only on the two answers.
//!
//! A plain, separate reader: words between white space, in the grammar that Assimp accepts. It shares no code with the
//! library under test.

use std::str::SplitWhitespace;

use crate::scene::Scene;

/// A file, its words, and its contents if it follows the plain grammar.
pub(crate) struct Source {
    /// The text; bytes that are not UTF-8 are replaced.
    pub text: String,
    /// Hierarchy and motion, if the file follows the plain grammar.
    pub motion: Option<Motion>,
}

/// Hierarchy and motion.
#[derive(Clone, Debug, Default)]
pub(crate) struct Motion {
    /// Joints and end sites in the order of the file.
    pub nodes: Vec<Node>,
    /// Joints in the order of the file, as the channels of an animation.
    pub joints: Vec<Joint>,
    /// The word after `Frames:`.
    pub frames: f64,
    /// The word after `Frame Time:`.
    pub frame_time: f64,
    /// The numbers of the motion up to the first other word.
    pub values: Vec<f64>,
    /// The number of values in each line of the motion.
    pub line_lengths: Vec<usize>,
}

#[derive(Clone, Debug)]
pub(crate) struct Node {
    /// An end site has the name that Assimp gives it.
    pub name: String,
    pub offset: [f64; 3],
}

#[derive(Clone, Debug)]
pub(crate) struct Joint {
    /// Index into [`Motion::nodes`].
    pub node: usize,
    pub channels: Vec<Channel>,
    /// The index of the node's first channel in a row of the motion.
    pub first_column: usize,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Channel {
    Position(usize),
    Rotation(usize),
}

impl Source {
    pub(crate) fn new(bytes: &[u8]) -> Self {
        let text = String::from_utf8_lossy(bytes).into_owned();
        let motion = read(&text);
        Self { text, motion }
    }
}

impl Motion {
    /// Values in a row.
    pub(crate) fn columns(&self) -> usize {
        self.joints.iter().map(|joint| joint.channels.len()).sum()
    }

    /// The motion without lines whose number of values is wrong, if there are such lines and they are few.
    pub(crate) fn without_odd_lines(&self) -> Option<Self> {
        let columns = self.columns();
        let odd = self.line_lengths.iter().filter(|&&length| length != columns).count();
        if odd == 0 || 2 * odd > self.line_lengths.len() {
            return None;
        }
        let mut kept = self.clone();
        kept.values.clear();
        let mut at = 0;
        for &length in &self.line_lengths {
            if length == columns {
                kept.values.extend(self.values.get(at..at + length)?);
            }
            at += length;
        }
        kept.line_lengths.retain(|&length| length == columns);
        kept.frames = kept.line_lengths.len() as f64;
        Some(kept)
    }

    /// The largest distance of an element of a rotation key from this motion's element. Keys of frames with a missing
    /// value do not count. `None` if the lines are not the rows, because the joints of the values are then unknown.
    pub(crate) fn rotation_error(&self, scene: &Scene) -> Option<f64> {
        if self.line_lengths.iter().any(|&length| length != self.columns()) {
            return None;
        }
        let channels = scene
            .animations
            .first()
            .map_or(&[][..], |animation| &animation.channels);
        let mut worst: f64 = 0.0;
        for (joint, channel) in self.joints.iter().zip(channels) {
            for (frame, key) in channel
                .rotations
                .iter()
                .enumerate()
                .filter(|(frame, _)| self.is_finite(joint, *frame))
            {
                let row: Vec<_> = self.row(joint, frame).collect();
                let exact = rotation(&row);
                let distance = |sign: f64| {
                    let parts = key
                        .value
                        .iter()
                        .zip(exact)
                        .map(|(part, exact)| (part - sign * exact).abs());
                    parts.fold(0.0, f64::max)
                };
                worst = worst.max(distance(1.0).min(distance(-1.0)));
            }
        }
        Some(worst)
    }

    /// The joint's channels with their values in a frame; nothing beyond the end of the motion.
    pub(crate) fn row<'a>(&'a self, joint: &'a Joint, frame: usize) -> impl Iterator<Item = (Channel, f64)> + 'a {
        let first = (frame * self.columns() + joint.first_column).min(self.values.len());
        joint.channels.iter().copied().zip(self.values[first..].iter().copied())
    }

    /// Whether every value of the joint in the frame is a finite number.
    pub(crate) fn is_finite(&self, joint: &Joint, frame: usize) -> bool {
        self.row(joint, frame).all(|(_, value)| value.is_finite())
    }

    /// The last finite values of the joint's channels up to the frame. A channel without a finite value is 0, as at
    /// rest.
    pub(crate) fn held_row(&self, joint: &Joint, frame: usize) -> Vec<(Channel, f64)> {
        let mut held: Vec<_> = joint.channels.iter().map(|&channel| (channel, 0.0)).collect();
        for (index, held) in held.iter_mut().enumerate() {
            let values = (0..=frame).rev().filter_map(|frame| self.row(joint, frame).nth(index));
            if let Some((_, value)) = values.into_iter().find(|(_, value)| value.is_finite()) {
                held.1 = value;
            }
        }
        held
    }
}

/// The rotation of a row of channels as w x y z: the product, in the order of the file, in double precision.
pub(crate) fn rotation(row: &[(Channel, f64)]) -> [f64; 4] {
    row.iter()
        .fold([1.0, 0.0, 0.0, 0.0], |[w, x, y, z], &(channel, degrees)| {
            let Channel::Rotation(axis) = channel else {
                return [w, x, y, z];
            };
            let (sin, cos) = (degrees.to_radians() / 2.0).sin_cos();
            match axis {
                0 => [
                    w * cos - x * sin,
                    x * cos + w * sin,
                    y * cos + z * sin,
                    z * cos - y * sin,
                ],
                1 => [
                    w * cos - y * sin,
                    x * cos - z * sin,
                    y * cos + w * sin,
                    z * cos + x * sin,
                ],
                _ => [
                    w * cos - z * sin,
                    x * cos + y * sin,
                    y * cos - x * sin,
                    z * cos + w * sin,
                ],
            }
        })
}

/// The position of a row of channels; on an axis without a channel it is the joint's offset.
pub(crate) fn position(row: &[(Channel, f64)], offset: [f64; 3]) -> [f64; 3] {
    row.iter().fold(offset, |mut position, &(channel, value)| {
        if let Channel::Position(axis) = channel {
            position[axis] = value;
        }
        position
    })
}

/// A number in Assimp's spelling, which allows a decimal comma.
fn number(word: &str) -> Option<f64> {
    word.replace(',', ".").parse().ok()
}

fn offset(words: &mut SplitWhitespace<'_>) -> Option<[f64; 3]> {
    let mut next = || number(words.next()?);
    Some([next()?, next()?, next()?])
}

fn channel(word: &str) -> Option<Channel> {
    let axis = ["X", "Y", "Z"].iter().position(|axis| word.starts_with(axis))?;
    match &word[1..] {
        "position" => Some(Channel::Position(axis)),
        "rotation" => Some(Channel::Rotation(axis)),
        _ => None,
    }
}

/// The words of each line after the line of the frame time, without blank lines.
fn line_lengths(text: &str) -> Vec<usize> {
    let lines = text
        .split(['\n', '\r'])
        .skip_while(|line| !line.trim_start().starts_with("Frame Time:"));
    lines
        .skip(1)
        .map(|line| line.split_whitespace().count())
        .filter(|&length| length > 0)
        .collect()
}

fn read(text: &str) -> Option<Motion> {
    // A brace at the front of a word is a separate word.
    let spaced = text.replace('{', " { ").replace('}', " } ");
    let mut words = spaced.split_whitespace();
    let mut motion = Motion::default();
    let mut open: Vec<usize> = Vec::new();
    let mut open_joint: Vec<usize> = Vec::new();
    (words.next()? == "HIERARCHY").then_some(())?;
    loop {
        match words.next()? {
            "ROOT" | "JOINT" => {
                let name = words.next()?.to_owned();
                (words.next()? == "{").then_some(())?;
                open.push(motion.nodes.len());
                open_joint.push(motion.joints.len());
                motion.joints.push(Joint {
                    node: motion.nodes.len(),
                    channels: Vec::new(),
                    first_column: 0,
                });
                motion.nodes.push(Node { name, offset: [0.0; 3] });
            }
            "End" => {
                (words.next()? == "Site" && words.next()? == "{").then_some(())?;
                let name = format!("EndSite_{}", motion.nodes[*open.last()?].name);
                open.push(motion.nodes.len());
                motion.nodes.push(Node { name, offset: [0.0; 3] });
            }
            "OFFSET" => motion.nodes[*open.last()?].offset = offset(&mut words)?,
            "CHANNELS" => {
                let count = number(words.next()?)? as usize;
                for _ in 0..count {
                    let channel = channel(words.next()?)?;
                    motion.joints[*open_joint.last()?].channels.push(channel);
                }
            }
            "}" => {
                let node = open.pop()?;
                if open_joint
                    .last()
                    .is_some_and(|&joint| motion.joints[joint].node == node)
                {
                    open_joint.pop();
                }
            }
            "MOTION" => break,
            _ => return None,
        }
    }
    let mut column = 0;
    for joint in &mut motion.joints {
        joint.first_column = column;
        column += joint.channels.len();
    }
    (words.next()? == "Frames:").then_some(())?;
    motion.frames = number(words.next()?)?;
    (words.next()? == "Frame" && words.next()? == "Time:").then_some(())?;
    motion.frame_time = number(words.next()?)?;
    motion.values = words.map_while(number).collect();
    motion.line_lengths = line_lengths(text);
    Some(motion)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TWO_JOINTS: &str = "HIERARCHY ROOT a { OFFSET 1 2 3 CHANNELS 2 Xposition Zrotation \
        JOINT b { OFFSET 0 4 0 CHANNELS 3 Zrotation Xrotation Yrotation End Site { OFFSET 0 5 0 } } } \
        MOTION Frames: 2 Frame Time: 0.5  7 90 10 nan 30  8 91 nan 21 31  TRAILER";

    fn two_joints() -> Motion {
        Source::new(TWO_JOINTS.as_bytes()).motion.expect("the plain grammar")
    }

    #[test]
    fn nodes_and_columns_stand_in_file_order() {
        let motion = two_joints();
        let names: Vec<&str> = motion.nodes.iter().map(|node| node.name.as_str()).collect();
        assert_eq!(names, ["a", "b", "EndSite_b"]);
        assert_eq!(motion.nodes[2].offset, [0.0, 5.0, 0.0]);
        assert_eq!(motion.joints[1].first_column, 2);
        assert_eq!((motion.columns(), motion.values.len()), (5, 10));
    }

    #[test]
    fn a_missing_axis_is_the_offset_and_a_hole_holds_the_last_value() {
        let motion = two_joints();
        let row: Vec<_> = motion.row(&motion.joints[0], 1).collect();
        assert_eq!(position(&row, motion.nodes[0].offset), [8.0, 2.0, 3.0]);
        let held: Vec<f64> = motion
            .held_row(&motion.joints[1], 1)
            .iter()
            .map(|held| held.1)
            .collect();
        assert_eq!(held, [10.0, 21.0, 31.0]);
        let held: Vec<f64> = motion
            .held_row(&motion.joints[1], 0)
            .iter()
            .map(|held| held.1)
            .collect();
        assert_eq!(held, [10.0, 0.0, 30.0]);
    }

    #[test]
    fn rotations_multiply_in_file_order() {
        // A quarter turn about z, then a quarter turn about the rotated x axis: the cycle x to y to z to x.
        let [w, x, y, z] = rotation(&[(Channel::Rotation(2), 90.0), (Channel::Rotation(0), 90.0)]);
        for part in [w, x, y, z] {
            assert!((part - 0.5).abs() < 1e-15, "{w} {x} {y} {z}");
        }
    }
}
