//! Wildcards in the names of a path: `*`, `?`, `[a-z]`, `[!a-z]`, and `**` for any number of folders.

use std::path::{Component, Path, PathBuf};

use crate::Failure;

/// The part of a path that starts with its first wildcard. Without a name it matches every path.
#[derive(Debug, Default)]
pub struct Pattern(Vec<Part>);

/// One name of a pattern, between two separators.
#[derive(Debug)]
enum Part {
    /// `**`: any number of folders.
    Folders,
    Name(Vec<Token>),
}

#[derive(Debug)]
enum Token {
    Is(char),
    Any,
    Several,
    OneOf {
        ranges: Vec<(char, char)>,
        is_excluded: bool,
    },
}

/// The relation of a path to a pattern.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fit {
    /// Neither the path nor anything inside it matches.
    No,
    /// The path does not match, but paths inside it may match.
    Above,
    /// The path or one of its parent folders matches.
    Whole,
}

impl Pattern {
    /// Splits a path into the folder before its first wildcard, and the pattern.
    pub fn of(path: &Path) -> Result<(PathBuf, Self), Failure> {
        let refuse = |problem: &str| Err(Failure::Usage(format!("{}: {problem}", path.display())));
        let mut parts = path.components().peekable();
        let mut base = PathBuf::new();
        while let Some(part) = parts.next_if(|part| !has_wildcard(Path::new(part))) {
            base.push(part);
        }
        let mut pattern = Vec::new();
        for part in parts {
            match part {
                Component::Normal(name) => match name.to_str().map(Part::of) {
                    Some(Ok(Part::Folders)) if matches!(pattern.last(), Some(Part::Folders)) => {}
                    Some(Ok(part)) => pattern.push(part),
                    Some(Err(problem)) => return refuse(problem),
                    None => return refuse("a name with wildcards must be UTF-8"),
                },
                _ => return refuse("after a wildcard a path must not have .."),
            }
        }
        Ok((base, Self(pattern)))
    }

    /// Matches a path, relative to the folder of the pattern, against the pattern.
    pub fn fit<'a>(&self, names: impl IntoIterator<Item = &'a str>) -> Fit {
        // Whether each part may match the next name. The last entry is true if the names so far match the whole
        // pattern.
        let mut next = vec![false; self.0.len() + 1];
        self.reach(0, &mut next);
        for name in names {
            if next[self.0.len()] {
                return Fit::Whole;
            }
            let mut after = vec![false; next.len()];
            for (at, part) in self.0.iter().enumerate().filter(|(at, _)| next[*at]) {
                match part {
                    Part::Folders => self.reach(at, &mut after),
                    Part::Name(tokens) if is_match(tokens, name) => self.reach(at + 1, &mut after),
                    Part::Name(_) => {}
                }
            }
            next = after;
        }
        match (next[self.0.len()], next.contains(&true)) {
            (true, _) => Fit::Whole,
            (false, true) => Fit::Above,
            (false, false) => Fit::No,
        }
    }

    /// Marks a part. After `**`, which may match no folder, marks the following part too.
    fn reach(&self, mut at: usize, next: &mut [bool]) {
        next[at] = true;
        while let Some(Part::Folders) = self.0.get(at) {
            at += 1;
            next[at] = true;
        }
    }
}

pub(super) fn has_wildcard(path: &Path) -> bool {
    path.to_string_lossy().contains(['*', '?', '['])
}

impl Part {
    fn of(name: &str) -> Result<Self, &'static str> {
        if name == "**" {
            return Ok(Self::Folders);
        }
        if name.contains("**") {
            return Err("** matches any number of folders; write it as a name of its own, as in **/*.bvh");
        }
        let mut rest = name.chars();
        let mut tokens = Vec::new();
        while let Some(c) = rest.next() {
            tokens.push(match c {
                '?' => Token::Any,
                '*' => Token::Several,
                '[' => {
                    let (token, after) = one_of(rest.as_str()).ok_or("the [ of a wildcard lacks its ]")?;
                    rest = after.chars();
                    token
                }
                c => Token::Is(c),
            });
        }
        Ok(Self::Name(tokens))
    }
}

/// The characters between `[` and `]`, and the text after `]`. A `]` directly after `[` is one of the characters.
fn one_of(text: &str) -> Option<(Token, &str)> {
    let (is_excluded, text) = text.strip_prefix('!').map_or((false, text), |text| (true, text));
    let first = text.chars().next()?.len_utf8();
    let (set, after) = text.split_at(first + text[first..].find(']')?);
    let mut ranges = Vec::new();
    let mut set = set.chars();
    while let Some(low) = set.next() {
        ranges.push(
            match set.as_str().strip_prefix('-').and_then(|rest| rest.chars().next()) {
                Some(high) => {
                    set.nth(1);
                    (low, high)
                }
                None => (low, low),
            },
        );
    }
    Some((Token::OneOf { ranges, is_excluded }, &after[1..]))
}

/// Whether the tokens match the whole name. If a match fails, the last `*` takes one more character.
fn is_match(tokens: &[Token], name: &str) -> bool {
    let (mut at, mut rest) = (0, name.chars());
    let mut again = None;
    loop {
        let before = rest.clone();
        match (tokens.get(at), rest.next()) {
            (Some(Token::Several), _) => {
                again = Some((at + 1, before.clone()));
                (at, rest) = (at + 1, before);
                continue;
            }
            (Some(token), Some(c)) if token.takes(c) => {
                at += 1;
                continue;
            }
            (None, None) => return true,
            _ => {}
        }
        let Some((after, mut longer)) = again.take() else {
            return false;
        };
        if longer.next().is_none() {
            return false;
        }
        (at, rest) = (after, longer.clone());
        again = Some((after, longer));
    }
}

impl Token {
    fn takes(&self, c: char) -> bool {
        match self {
            Self::Is(own) => *own == c,
            Self::Any | Self::Several => true,
            Self::OneOf { ranges, is_excluded } => {
                ranges.iter().any(|(low, high)| (*low..=*high).contains(&c)) != *is_excluded
            }
        }
    }
}
