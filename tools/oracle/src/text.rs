//! Compares the lines about the same part of the scene that Assimp and mocap print in the format of the course.
//!
//! A line may differ if that part of the scenes differs for an accepted reason. The text alone has two more accepted
//! differences: a minus sign before zero, and numbers that are equal to six digits.

use std::collections::HashMap;
use std::fmt;

use crate::difference::{BONE_COUNT, Place, close};
use crate::scene::Track;

/// The part of the scene that a group of lines prints.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Subject {
    /// The n-th heading.
    Heading(usize),
    Scene,
    Mesh(usize),
    Node(usize),
    Bone(usize, usize),
    Animation,
    Channel(usize),
    Key(usize, bool, usize),
}

impl fmt::Display for Subject {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Heading(index) => write!(f, "heading {index}"),
            Self::Scene => f.write_str("scene"),
            Self::Mesh(mesh) => write!(f, "mesh {mesh}"),
            Self::Node(node) => write!(f, "node {node}"),
            Self::Bone(mesh, bone) => write!(f, "mesh {mesh} bone {bone}"),
            Self::Animation => f.write_str("animation"),
            Self::Channel(channel) => write!(f, "channel {channel}"),
            Self::Key(channel, true, key) => write!(f, "channel {channel} posKey {key}"),
            Self::Key(channel, false, key) => write!(f, "channel {channel} rotnKey {key}"),
        }
    }
}

/// Lines that differ; empty if one text has no such lines.
#[derive(Debug)]
pub(crate) struct TextDifference {
    pub subject: Subject,
    pub assimp: String,
    pub ours: String,
}

impl TextDifference {
    /// Whether a difference of the scenes at the place appears in these lines.
    pub(crate) fn shows(&self, place: Place) -> bool {
        self.prints(place) || (self.only_one_text_has_it() && self.is_counted(place))
    }

    fn only_one_text_has_it(&self) -> bool {
        self.assimp.is_empty() || self.ours.is_empty()
    }

    /// Whether these lines print the value at the place.
    fn prints(&self, place: Place) -> bool {
        match (place, self.subject) {
            (Place::Count(_), Subject::Scene) | (Place::Animation(_), Subject::Animation) => true,
            (Place::Node(node, _), Subject::Node(at)) => node == at,
            (Place::Mesh(mesh, _), Subject::Mesh(at)) => mesh == at,
            (Place::Bone(mesh, bone, _), Subject::Bone(at_mesh, at_bone)) => (mesh, bone) == (at_mesh, at_bone),
            (Place::Channel(channel) | Place::KeyCount(channel, _), Subject::Channel(at)) => channel == at,
            (Place::Key(channel, track, key), Subject::Key(at, is_position, at_key)) => {
                (channel, key) == (at, at_key) && is_position == (track == Track::Position)
            }
            _ => false,
        }
    }

    /// Whether the place is the count of the items that these lines print.
    fn is_counted(&self, place: Place) -> bool {
        match (place, self.subject) {
            (Place::Count("animations"), subject) => subject.is_in_animation(),
            (Place::Count("meshes"), Subject::Mesh(_) | Subject::Bone(..)) => true,
            (Place::Mesh(mesh, BONE_COUNT), Subject::Bone(at, _)) => mesh == at,
            (Place::KeyCount(channel, track), Subject::Key(at, is_position, _)) => {
                channel == at && is_position == (track == Track::Position)
            }
            _ => false,
        }
    }
}

/// The lines of an output in groups, in the order of the output.
struct Groups<'a> {
    order: Vec<Subject>,
    lines: HashMap<Subject, Vec<&'a str>>,
}

impl<'a> Groups<'a> {
    fn of(text: &'a str) -> Self {
        let mut groups = Self {
            order: Vec::new(),
            lines: HashMap::new(),
        };
        let mut subject = Subject::Scene;
        let (mut headings, mut nodes) = (0, 0);
        // Keeps each line break, so that a missing line break at the end of the text is a difference.
        for line in text.split_inclusive('\n') {
            let words: Vec<&str> = line.split_whitespace().collect();
            subject = match *words {
                ["Success!"] => Subject::Scene,
                [first, ..] if first.starts_with("-----") || first.starts_with("=====") => {
                    headings += 1;
                    Subject::Heading(headings)
                }
                ["Number", ..] | ["Material:", ..] => Subject::Scene,
                ["Mesh", "index", index, ..] | ["Mesh", index, ..] if number_before_colon(index).is_some() => {
                    Subject::Mesh(number_before_colon(index).unwrap_or_default())
                }
                ["Node", "Name:", ..] => {
                    nodes += 1;
                    Subject::Node(nodes - 1)
                }
                ["---", "Anim", ..] => Subject::Animation,
                ["Channel", index, ..] if subject.is_in_animation() => {
                    Subject::Channel(number_before_colon(index).unwrap_or_default())
                }
                [key @ ("posKey" | "rotnKey"), index, ..] => {
                    let index = number_before_colon(index).unwrap_or_default();
                    Subject::Key(subject.channel(), key == "posKey", index)
                }
                // The layout of 2017 lists the bones under their mesh. The later layouts name the mesh in the bone's
                // line.
                ["---", "Bone", "Name:", ..] => subject.next_bone(None),
                ["Bone", "Name:", ..] => subject.next_bone(mesh_of_bone_line(line)),
                _ => subject,
            };
            let lines = groups.lines.entry(subject).or_default();
            if lines.is_empty() {
                groups.order.push(subject);
            }
            lines.push(line);
        }
        groups
    }

    fn text(&self, subject: Subject) -> String {
        self.lines.get(&subject).map(|lines| lines.concat()).unwrap_or_default()
    }
}

impl Subject {
    fn channel(self) -> usize {
        match self {
            Self::Channel(channel) | Self::Key(channel, ..) => channel,
            _ => 0,
        }
    }

    fn next_bone(self, mesh: Option<usize>) -> Self {
        match self {
            Self::Bone(last, bone) if mesh.is_none_or(|mesh| mesh == last) => Self::Bone(last, bone + 1),
            Self::Mesh(last) => Self::Bone(mesh.unwrap_or(last), 0),
            _ => Self::Bone(mesh.unwrap_or_default(), 0),
        }
    }

    fn is_in_animation(self) -> bool {
        matches!(self, Self::Animation | Self::Channel(_) | Self::Key(..))
    }
}

fn number_before_colon(word: &str) -> Option<usize> {
    word.strip_suffix(':')?.parse().ok()
}

fn mesh_of_bone_line(line: &str) -> Option<usize> {
    line.rsplit_once("   Mesh: ")?.1.split_whitespace().next()?.parse().ok()
}

/// The number of equal lines in the two outputs, and the places of differences.
pub(crate) fn compare(assimp: &str, ours: &str) -> (usize, Vec<TextDifference>) {
    if assimp == ours {
        return (assimp.lines().count(), Vec::new());
    }
    let (assimp, ours) = (Groups::of(assimp), Groups::of(ours));
    let mut equal = 0;
    let mut differences = Vec::new();
    let only_ours = ours.order.iter().filter(|subject| !assimp.lines.contains_key(subject));
    for &subject in assimp.order.iter().chain(only_ours) {
        if assimp.lines.get(&subject) == ours.lines.get(&subject) {
            equal += assimp.lines[&subject].len();
        } else {
            differences.push(TextDifference {
                subject,
                assimp: assimp.text(subject),
                ours: ours.text(subject),
            });
        }
    }
    if differences.is_empty() {
        // The same lines in another order.
        let (assimp, ours) = (format!("{:?}", assimp.order), format!("{:?}", ours.order));
        differences.push(TextDifference {
            subject: Subject::Scene,
            assimp,
            ours,
        });
    }
    (equal, differences)
}

/// The explanations that only concern the text, as rows of `README.md`.
pub(crate) const MINUS_ZERO: &str = "minus-zero";
pub(crate) const SIXTH_DIGIT: &str = "sixth-digit";

/// The row of `README.md` that explains a difference of the outputs of equal scenes.
pub(crate) fn explain(difference: &TextDifference) -> Option<&'static str> {
    let TextDifference { subject, assimp, ours } = difference;
    let unsigned_zeros = |text: &str| match subject {
        Subject::Bone(..) => text.replace(" -0 ", " 0 ").replace(" -0 ", " 0 "),
        _ => text.to_owned(),
    };
    let (assimp, ours) = (unsigned_zeros(assimp), unsigned_zeros(ours));
    if assimp == ours {
        Some(MINUS_ZERO)
    } else if differ_in_sixth_digit(&assimp, &ours) {
        Some(SIXTH_DIGIT)
    } else {
        None
    }
}

/// Whether the outputs are equal except for the last of six digits of some numbers.
fn differ_in_sixth_digit(assimp: &str, ours: &str) -> bool {
    let (assimp, ours): (Vec<&str>, Vec<&str>) = (assimp.split(' ').collect(), ours.split(' ').collect());
    assimp.len() == ours.len()
        && assimp.iter().zip(ours).all(|(a, b)| {
            let (a_number, b_number) = (a.trim_end().parse::<f64>(), b.trim_end().parse::<f64>());
            let near = || matches!((a_number, b_number), (Ok(a), Ok(b)) if close(a, b) || is_one_unit(a, b));
            let is_value = a.contains('.') || b.contains('.') || a.contains('e') || b.contains('e');
            *a == b || (is_value && near())
        })
}

/// Whether the numbers are one unit of the sixth digit apart.
fn is_one_unit(a: f64, b: f64) -> bool {
    let unit = 10f64.powf(a.abs().max(b.abs()).log10().floor() - 5.0);
    (a - b).abs() < 1.5 * unit
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one(assimp: &str, ours: &str) -> TextDifference {
        let (_, mut differences) = compare(assimp, ours);
        assert_eq!(differences.len(), 1, "{differences:?}");
        differences.remove(0)
    }

    const BONE: &str =
        "Mesh index 0: nverts = 12\nBone Name: a   Mesh: 0  nweights = 12\n     Offset matrix: 1 -0 -0 -2 ";

    #[test]
    fn a_minus_before_zero_is_explained_in_offset_matrices_alone() {
        let difference = one(BONE, &BONE.replace("-0 -0", "0 0"));
        assert_eq!(difference.subject, Subject::Bone(0, 0));
        assert_eq!(explain(&difference), Some("minus-zero"));
        assert_eq!(explain(&one(BONE, &BONE.replace("-0 -0 -2", "0 0 2"))), None);
        let node = "Node Name: a\nTransformation:  1 -0 0 ";
        assert_eq!(explain(&one(node, &node.replace("-0", "0"))), None);
    }

    #[test]
    fn the_sixth_digit_may_differ_and_no_other() {
        let key = "     Channel 3: nodeName = a\n        posKey 7:  Time = 7 Value = 12.3456 0.5 100 \n";
        let key = format!(" --- Anim 0:  Name = Motion\n{key}");
        let difference = one(&key, &key.replace("12.3456", "12.3457"));
        assert_eq!(difference.subject, Subject::Key(3, true, 7));
        assert_eq!(explain(&difference), Some("sixth-digit"));
        for wrong in ["12.3466", "12.3458", "-12.3456", "nan"] {
            assert_eq!(explain(&one(&key, &key.replace("12.3456", wrong))), None, "{wrong}");
        }
        assert_eq!(explain(&one(&key, &key.replace("Time = 7", "Time = 8"))), None);
    }

    #[test]
    fn lines_that_only_one_text_has_are_differences() {
        let text = " --- Anim 0:  Name = Motion\n     Channel 0: nodeName = a\n        posKey 0:  Time = 0\n";
        let short = &text[..text.len() - "        posKey 0:  Time = 0\n".len()];
        assert_eq!(one(text, short).ours, "");
        assert_eq!(one(short, text).assimp, "");
        assert_eq!(one(text, text.trim_end()).subject, Subject::Key(0, true, 0));
    }
}
