//! Reads the HIERARCHY section: the joints in the order of the file.

mod items;

use glam::Vec3;
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::limits::{Limits, limit_exceeded};
use mocap_scene::scene::report::SourceLines;

use super::Failure;
use super::channel::ChannelKind;
use super::decimals::Decimals;
use crate::text::{Cursor, LineIndex, Word, decode_name, is_binary, quote};
use crate::warnings::Warnings;

/// A ROOT, a JOINT or an End Site.
#[derive(Debug)]
pub(super) struct Joint {
    #[doc(hidden)]
    pub name: String,
    #[doc(hidden)]
    pub parent: Option<usize>,
    pub(super) is_end_site: bool,
    pub(super) offset: Vec3,
    /// The channels of the joint's columns, in the order of the file.
    pub(super) channels: Vec<ChannelKind>,
    /// The index of the joint's first column in a row.
    pub(super) first_column: usize,
    pub(super) source: SourceLines,
}

/// The joints in depth-first order, parents before children.
#[derive(Debug)]
pub(super) struct Hierarchy {
    pub(super) joints: Vec<Joint>,
    /// The number of values in a row.
    pub(super) channel_count: usize,
    /// The decimal separator of the numbers in the hierarchy.
    pub(super) decimals: Decimals,
}

impl Hierarchy {
    /// The joint and the channel of a column.
    pub(super) fn column(&self, column: usize) -> (&Joint, ChannelKind) {
        let joint = self
            .joints
            .iter()
            .find(|joint| (joint.first_column..joint.first_column + joint.channels.len()).contains(&column))
            .expect("every column belongs to a joint");
        (joint, joint.channels[column - joint.first_column])
    }
}

/// Reads `HIERARCHY`, after comment lines.
pub(super) fn read_header(cursor: &mut Cursor<'_>) -> Result<(), Failure> {
    crate::bvh::pass_comments(cursor);
    let start = cursor.clone();
    match cursor.next_word() {
        Some(word) if word.is("HIERARCHY") => Ok(()),
        _ => Err(Box::new(not_a_bvh(&start))),
    }
}

fn not_a_bvh(cursor: &Cursor<'_>) -> Diagnostic {
    if is_binary(cursor.text()) {
        return Diagnostic::new(Code::BinaryFile, "the file is binary, not BVH text");
    }
    let word = cursor.peek_word().unwrap_or(Word {
        bytes: b"",
        offset: cursor.offset(),
    });
    Diagnostic::new(Code::MissingKeyword, "a BVH file begins with HIERARCHY")
        .at(cursor.locate(word))
        .expected_found("HIERARCHY", quote(word.bytes))
        .help("check that the extension matches the contents of the file; exporters write HIERARCHY as the first word")
}

/// Reads everything from the first ROOT to MOTION or the end of the text.
pub(super) fn read(cursor: &mut Cursor<'_>, limits: &Limits, warnings: &mut Warnings) -> Result<Hierarchy, Failure> {
    let mut reader = Reader {
        cursor,
        limits,
        warnings,
        joints: Vec::new(),
        open: Vec::new(),
        channel_count: 0,
        decimals: Decimals::default(),
    };
    reader.read_roots()?;
    reader.count_lines();
    Ok(Hierarchy {
        joints: reader.joints,
        channel_count: reader.channel_count,
        decimals: reader.decimals,
    })
}

/// An open block. Open blocks are in an explicit list, so that no file can overflow the call stack.
struct Open<'a> {
    joint: usize,
    keyword: Word<'a>,
    offsets: usize,
}

struct Reader<'a, 'c> {
    cursor: &'c mut Cursor<'a>,
    limits: &'c Limits,
    warnings: &'c mut Warnings,
    joints: Vec<Joint>,
    open: Vec<Open<'a>>,
    channel_count: usize,
    decimals: Decimals,
}

impl<'a> Reader<'a, '_> {
    /// Reads `root+`. Text between roots is tolerated with a warning.
    fn read_roots(&mut self) -> Result<(), Failure> {
        let mut last_root = None;
        while let Some(word) = self.cursor.peek_word() {
            if word.is("ROOT") {
                if last_root.is_some() {
                    self.warn(Code::SeveralRoots, word, "the hierarchy has more than one ROOT");
                }
                last_root = Some(self.joints.len());
                self.read_tree(None)?;
            } else if let (true, Some(root)) = (word.is("JOINT"), last_root) {
                self.warn(
                    Code::JointOutsideRoot,
                    word,
                    "this JOINT follows the closing brace of its ROOT",
                );
                self.read_tree(Some(root))?;
            } else if let (true, Some(_)) = (word.is("}"), last_root) {
                self.warn(Code::ExtraBrace, word, "this closing brace has no opening brace");
                self.cursor.next_word();
            } else if begins_motion(word) && last_root.is_some() {
                break;
            } else {
                let expected = if last_root.is_some() { "MOTION" } else { "ROOT" };
                return Err(self.missing_keyword(expected, word));
            }
        }
        if last_root.is_none() {
            return Err(Box::new(
                Diagnostic::new(Code::UnexpectedEnd, "the file ends before its ROOT")
                    .at(self.cursor.locate_end())
                    .expected_found("ROOT", "the end of the file"),
            ));
        }
        Ok(())
    }

    /// Replaces the byte offsets of the joints' source locations by line numbers.
    fn count_lines(&mut self) {
        let lines = LineIndex::new(&self.cursor.text()[..self.cursor.offset()]);
        for SourceLines { name, offset, channels } in self.joints.iter_mut().map(|joint| &mut joint.source) {
            *name = lines.line(*name);
            *offset = offset.map(|offset| lines.line(offset));
            *channels = channels.map(|channels| lines.line(channels));
        }
    }

    fn missing_keyword(&self, expected: &str, found: Word<'_>) -> Failure {
        Box::new(
            Diagnostic::new(Code::MissingKeyword, format!("{expected} is missing here"))
                .at(self.cursor.locate(found))
                .expected_found(expected, quote(found.bytes)),
        )
    }

    /// Reads one ROOT or JOINT and its descendants.
    fn read_tree(&mut self, parent: Option<usize>) -> Result<(), Failure> {
        let keyword = self.cursor.next_word().expect("the caller has seen the keyword");
        let name = self.cursor.next_name();
        self.open_block(keyword, decode_name(name.bytes), parent, false)?;
        while let Some(open) = self.open.last() {
            let joint = open.joint;
            let Some(word) = self.cursor.next_word() else {
                return Err(Box::new(self.unclosed()));
            };
            let is_end_site = self.joints[joint].is_end_site;
            if word.is("OFFSET") {
                self.read_offset(word)?;
            } else if is_end_site && (word.is("CHANNELS") || word.is("JOINT")) {
                return Err(self.unexpected(word, "OFFSET or }"));
            } else if word.is("CHANNELS") {
                self.read_channels(word)?;
            } else if word.is("JOINT") {
                let name = self.cursor.next_name();
                self.open_block(word, decode_name(name.bytes), Some(joint), false)?;
            } else if let Some(name) = self.end_site(word) {
                let name = name.unwrap_or_else(|| format!("EndSite_{}", self.joints[joint].name));
                if is_end_site {
                    self.warn(
                        Code::NestedEndSite,
                        word,
                        "this End Site stands within an End Site; it was read as its child",
                    );
                }
                self.open_block(word, name, Some(joint), true)?;
            } else if word.is("}") {
                self.open.pop();
            } else if begins_motion(word) {
                let keyword = if word.is("MOTION") { "MOTION" } else { "Frames:" };
                self.warnings.push(Code::MissingBrace, || {
                    Diagnostic::new(
                        Code::MissingBrace,
                        format!("{keyword} begins before all joints are closed"),
                    )
                    .at(self.cursor.locate(word))
                    .in_joint(&self.joints[joint].name)
                    .expected_found(format!("{} more closing braces", self.open.len()), keyword)
                });
                self.open.clear();
                self.cursor.set_offset(word.offset);
            } else if is_end_site {
                return Err(self.unexpected(word, "OFFSET or }"));
            } else {
                return Err(self.unexpected(word, "OFFSET, CHANNELS, JOINT, End Site or }"));
            }
        }
        Ok(())
    }

    /// Reads `End Site`, `End site NAME`, `End Site4`, `End Site #name: NAME` or `End NAME`. Returns the name, if there
    /// is one.
    fn end_site(&mut self, word: Word<'a>) -> Option<Option<String>> {
        let glued = word.strip_prefix("EndSite");
        if !word.is("End") && glued.is_none() {
            return None;
        }
        if glued.is_none() {
            let before = self.cursor.offset();
            let site = self.cursor.next_word();
            if site.and_then(|site| site.strip_prefix("Site")).is_none() {
                self.cursor.set_offset(before);
            }
        }
        let name = self.cursor.next_name().bytes;
        let name = match name {
            [b'#', comment @ ..] => comment.strip_prefix(b"name:").unwrap_or(comment).trim_ascii(),
            name => name,
        };
        Some((!name.is_empty()).then(|| decode_name(name)))
    }

    fn open_block(
        &mut self,
        keyword: Word<'a>,
        name: String,
        parent: Option<usize>,
        is_end_site: bool,
    ) -> Result<(), Failure> {
        let Limits {
            max_nodes,
            max_depth,
            max_name_bytes,
            ..
        } = *self.limits;
        let within =
            |limit: usize, what: &str| limit_exceeded(format!("at most {limit} {what}"), format!("more than {limit}"));
        let exceeded = if self.joints.len() >= max_nodes {
            Some(within(max_nodes, "nodes"))
        } else if self.open.len() >= max_depth {
            Some(within(max_depth, "nested joints"))
        } else if name.len() > max_name_bytes {
            Some(within(max_name_bytes, "bytes in a name"))
        } else {
            None
        };
        if let Some(diagnostic) = exceeded {
            return Err(self.in_open_joint(diagnostic.at(self.cursor.locate(keyword))));
        }
        self.open.push(Open {
            joint: self.joints.len(),
            keyword,
            offsets: 0,
        });
        self.joints.push(Joint {
            name,
            parent,
            is_end_site,
            offset: Vec3::ZERO,
            channels: Vec::new(),
            first_column: self.channel_count,
            // Byte offsets for now. Lines are counted once, at the end.
            source: SourceLines {
                name: keyword.offset,
                ..SourceLines::default()
            },
        });
        match self.cursor.next_word() {
            Some(brace) if brace.is("{") => Ok(()),
            Some(word) => Err(self.unexpected(word, "{")),
            None => Err(Box::new(self.unclosed())),
        }
    }

    fn invalid_number(&self, word: Word<'_>, expected: String) -> Failure {
        self.in_open_joint(
            Diagnostic::new(Code::InvalidNumber, format!("{} is not a number", quote(word.bytes)))
                .at(self.cursor.locate(word))
                .expected_found(expected, quote(word.bytes)),
        )
    }

    fn unexpected(&self, word: Word<'_>, expected: &str) -> Failure {
        self.in_open_joint(
            Diagnostic::new(
                Code::UnexpectedToken,
                format!("{} is not allowed here", quote(word.bytes)),
            )
            .at(self.cursor.locate(word))
            .expected_found(expected, quote(word.bytes)),
        )
    }

    /// The error for a file that ends inside the construction of `keyword`, before `expected`.
    fn cut_off(&self, keyword: &str, expected: &str) -> Failure {
        self.in_open_joint(
            Diagnostic::new(Code::UnexpectedEnd, format!("the file ends inside {keyword}"))
                .at(self.cursor.locate_end())
                .expected_found(expected, "the end of the file"),
        )
    }

    fn unclosed(&self) -> Diagnostic {
        let diagnostic = Diagnostic::new(Code::UnexpectedEnd, "the file ends inside the hierarchy")
            .at(self.cursor.locate_end())
            .expected_found("}", "the end of the file");
        match self.open.last() {
            Some(open) => {
                let line = self.cursor.locate(open.keyword).line;
                diagnostic.in_joint(&self.joints[open.joint].name).help(format!(
                    "the joint that begins in line {line} is not closed; the file is cut off or closing braces are missing"
                ))
            }
            None => diagnostic,
        }
    }

    fn warn(&mut self, code: Code, word: Word<'_>, message: &str) {
        self.warnings.push(code, || {
            let mut warning = Diagnostic::new(code, message).at(self.cursor.locate(word));
            warning.joint = self.open.last().map(|open| self.joints[open.joint].name.clone());
            warning
        });
    }

    fn in_open_joint(&self, diagnostic: Diagnostic) -> Failure {
        Box::new(match self.open.last() {
            Some(open) => diagnostic.in_joint(&self.joints[open.joint].name),
            None => diagnostic,
        })
    }
}

/// Whether a word is `MOTION`, or the start of the line `Frames:` if MOTION is missing.
pub(super) fn begins_motion(word: Word<'_>) -> bool {
    let frames = word.strip_prefix("Frames");
    word.is("MOTION") || frames.is_some_and(|rest| rest.bytes.is_empty() || rest.bytes.starts_with(b":"))
}

/// A word that ends a list of channel names.
fn is_structure(word: Word<'_>) -> bool {
    let keywords = ["{", "}", "OFFSET", "CHANNELS", "JOINT", "ROOT", "End"];
    keywords.iter().any(|keyword| word.is(keyword)) || begins_motion(word)
}
