//! The explained cases where one of the two programs refuses a file that the other reads. Each rule has the words of
//! the message, and checks on the file that its reason applies.

use crate::source::{Channel, Source};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Program {
    Assimp,
    Mocap,
}

/// The reason why one program refuses a file and the other does not.
pub(crate) struct Refusal {
    /// The row of `README.md` that gives the reason.
    pub id: &'static str,
    pub by: Program,
    /// The message contains one of these texts.
    words: &'static [&'static str],
    holds: fn(&Source) -> bool,
}

impl Refusal {
    pub(crate) fn applies(&self, by: Program, message: &str, source: &Source) -> bool {
        self.by == by && self.words.iter().any(|words| message.contains(words)) && (self.holds)(source)
    }
}

pub(crate) const REFUSALS: &[Refusal] = &[
    Refusal {
        id: "duplicate-names",
        by: Program::Assimp,
        words: &["has the same name as"],
        holds: duplicate_names,
    },
    Refusal {
        id: "letter-case",
        by: Program::Assimp,
        words: &["Expected ", "Invalid channel specifier", "Unknown keyword"],
        holds: letter_case,
    },
    Refusal {
        id: "end-site-name",
        by: Program::Assimp,
        words: &["Expected opening brace", "Expected \"End Site\""],
        holds: end_site_name,
    },
    Refusal {
        id: "nested-end-site",
        by: Program::Assimp,
        words: &["Unknown keyword \"End\""],
        holds: nested_end_site,
    },
    Refusal {
        id: "name-with-space",
        by: Program::Assimp,
        words: &["Expected opening brace"],
        holds: name_with_space,
    },
    Refusal {
        id: "text-before-hierarchy",
        by: Program::Assimp,
        words: &["Expected header string \"HIERARCHY\""],
        holds: text_before_hierarchy,
    },
    Refusal {
        id: "no-motion",
        by: Program::Assimp,
        words: &["Expected beginning of motion data \"MOTION\""],
        holds: |source| words(source).all(|word| word != "MOTION"),
    },
    Refusal {
        id: "unbalanced-hierarchy",
        by: Program::Assimp,
        words: &[
            "Expected beginning of motion data \"MOTION\"",
            "Unknown keyword \"MOTION\"",
        ],
        holds: unbalanced_hierarchy,
    },
    Refusal {
        id: "frame-lines",
        by: Program::Assimp,
        words: &[
            "Expected frame count \"Frames:\"",
            "Expected frame duration \"Frame Time:\"",
        ],
        holds: frame_lines,
    },
    Refusal {
        id: "short-motion",
        by: Program::Assimp,
        words: &["Unexpected end of file while trying to read a float"],
        holds: |source| {
            source
                .motion
                .as_ref()
                .is_some_and(|motion| (motion.values.len() as f64) < motion.frames * motion.columns() as f64)
        },
    },
    Refusal {
        id: "numbers-run-together",
        by: Program::Assimp,
        words: &["Expected a floating point number"],
        holds: numbers_run_together,
    },
    Refusal {
        id: "incomplete-position",
        by: Program::Assimp,
        words: &["Missing position channel in node"],
        holds: incomplete_position,
    },
    Refusal {
        id: "scale-channels",
        by: Program::Assimp,
        words: &["Invalid channel specifier"],
        holds: |source| words(source).any(|word| matches!(word, "Xscale" | "Yscale" | "Zscale")),
    },
    Refusal {
        id: "no-size",
        by: Program::Assimp,
        words: &["No meshes remaining"],
        holds: |source| {
            source
                .motion
                .as_ref()
                .is_some_and(|motion| motion.nodes.iter().skip(1).all(|node| node.offset == [0.0; 3]))
        },
    },
    Refusal {
        id: "row-length",
        by: Program::Mocap,
        words: &["[row-length]"],
        holds: row_length,
    },
    Refusal {
        id: "comma-and-point",
        by: Program::Mocap,
        words: &["[invalid-number]"],
        holds: comma_and_point,
    },
    Refusal {
        id: "frame-time",
        by: Program::Mocap,
        words: &["[frame-time]"],
        holds: |source| {
            source
                .motion
                .as_ref()
                .is_some_and(|motion| !(motion.frame_time > 0.0 && motion.frame_time.is_finite()))
        },
    },
    Refusal {
        id: "offset-not-finite",
        by: Program::Mocap,
        words: &["[non-finite-offset]"],
        holds: |source| {
            let is_out_of_reach = |part: &f64| part.is_nan() || part.abs() > 1e18;
            source
                .motion
                .as_ref()
                .is_some_and(|motion| motion.nodes.iter().any(|node| node.offset.iter().any(is_out_of_reach)))
        },
    },
];

/// Words that Assimp compares case-sensitively.
const SPELLINGS: &[&str] = &[
    "HIERARCHY",
    "ROOT",
    "JOINT",
    "OFFSET",
    "CHANNELS",
    "End",
    "Site",
    "MOTION",
    "Frames:",
    "Frame",
    "Time:",
    "Xposition",
    "Yposition",
    "Zposition",
    "Xrotation",
    "Yrotation",
    "Zrotation",
];

fn words(source: &Source) -> impl Iterator<Item = &str> {
    source.text.split_whitespace()
}

fn lines(source: &Source) -> impl Iterator<Item = &str> {
    source.text.split(['\n', '\r'])
}

/// The words of a line without the braces at its end.
fn words_of_line(line: &str) -> Vec<&str> {
    line.split_whitespace().filter(|word| *word != "{").collect()
}

fn duplicate_names(source: &Source) -> bool {
    let Some(motion) = &source.motion else { return false };
    let mut names: Vec<&str> = motion.nodes.iter().map(|node| node.name.as_str()).collect();
    names.sort_unstable();
    names.windows(2).any(|pair| pair[0] == pair[1])
}

fn letter_case(source: &Source) -> bool {
    words(source).any(|word| {
        SPELLINGS
            .iter()
            .any(|right| word != *right && word.eq_ignore_ascii_case(right))
    })
}

fn end_site_name(source: &Source) -> bool {
    lines(source).any(|line| match *words_of_line(line) {
        ["End", "Site"] => false,
        ["End", _, ..] => true,
        _ => false,
    })
}

/// An End Site that begins before the last End Site is closed.
fn nested_end_site(source: &Source) -> bool {
    let mut is_open = false;
    words(source).any(|word| {
        let nests = word == "End" && is_open;
        is_open = word == "End" || (is_open && word != "}");
        nests
    })
}

fn name_with_space(source: &Source) -> bool {
    lines(source).any(|line| matches!(*words_of_line(line), ["ROOT" | "JOINT", _, _, ..]))
}

/// UTF-16 shows as ASCII with zero bytes between.
fn text_before_hierarchy(source: &Source) -> bool {
    words(source).next() != Some("HIERARCHY") && source.text.replace('\0', "").contains("HIERARCHY")
}

/// Whether a word is a number that is directly followed by another number with a sign.
fn numbers_run_together(source: &Source) -> bool {
    words(source).any(|word| {
        let sign = word
            .rfind(['-', '+'])
            .filter(|&at| at > 0 && word.as_bytes()[at - 1].is_ascii_digit());
        sign.is_some_and(|at| is_number(&word[..at]) && is_number(&word[at..]))
    })
}

fn is_number(word: &str) -> bool {
    word.parse::<f64>().is_ok()
}

fn comma_and_point(source: &Source) -> bool {
    let has_comma = words(source).any(|word| word.contains(',') && is_number(&word.replace(',', ".")));
    has_comma && words(source).any(|word| word.contains('.') && is_number(word))
}

/// Whether the outermost brace is not closed before MOTION, or is followed by other text.
fn unbalanced_hierarchy(source: &Source) -> bool {
    let mut depth = 0;
    let mut closed = false;
    for word in words(source) {
        match word {
            "MOTION" => return depth != 0,
            _ if closed => return true,
            "{" => depth += 1,
            "}" => {
                depth -= 1;
                closed = depth == 0;
            }
            _ => {}
        }
    }
    false
}

fn frame_lines(source: &Source) -> bool {
    let after_motion: Vec<&str> = words(source).skip_while(|word| *word != "MOTION").take(6).collect();
    !matches!(*after_motion, ["MOTION", "Frames:", _, "Frame", "Time:", ..])
}

fn incomplete_position(source: &Source) -> bool {
    source.motion.as_ref().is_some_and(|motion| {
        motion.joints.iter().any(|joint| {
            let has = |axis| joint.channels.contains(&Channel::Position(axis));
            joint.channels.len() == 6 && !(has(0) && has(1) && has(2))
        })
    })
}

/// Whether most rows of the motion, one per line, have another number of values than the hierarchy has channels.
fn row_length(source: &Source) -> bool {
    let Some(motion) = &source.motion else { return false };
    let wrong = motion
        .line_lengths
        .iter()
        .filter(|&&length| length != motion.columns())
        .count();
    2 * wrong > motion.line_lengths.len()
}
