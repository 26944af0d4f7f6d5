//! Wildcards in the names of a path: `*`, `?`, `[a-z]`, `[!a-z]`, and `**` for any number of folders.

use std::path::{Component, Path, PathBuf};

use crate::Failure;

/// The part of a path from its first wildcard on. Without a name it matches every path.
#[derive(Debug, Default)]
pub(super) struct Pattern(Vec<Part>);

/// A name of a pattern.
#[derive(Debug)]
enum Part {
    /// `**`
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

/// How a path fits a pattern.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fit {
    No,
    /// Paths below it may match.
    Above,
    /// It matches, or a folder above it does.
    Whole,
}

impl Pattern {
    /// The folder before the first wildcard of a path, and the pattern below it.
    pub(super) fn of(path: &Path) -> Result<(PathBuf, Self), Failure> {
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

    /// How the path of these names below the folder of the pattern fits.
    pub(super) fn fit<'a>(&self, names: impl IntoIterator<Item = &'a str>) -> Fit {
        // Which parts may match the next name; one place more for the end of the pattern.
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

    /// Marks a part, and those behind it that follow where it is `**` for no folder.
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
            return Err("** stands for folders and must be a whole name of the path, as in **/*.bvh");
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

/// The characters between `[` and `]`, and what follows. A `]` that comes first is one of them.
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

/// Whether the tokens match the whole name. Where a match fails, the last `*` takes one character more.
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

#[cfg(test)]
mod tests {
    use super::*;

    fn fit(pattern: &str, path: &str) -> Fit {
        let (base, pattern) = Pattern::of(Path::new(pattern)).map_err(Failure::into_words).unwrap();
        assert_eq!(base, Path::new(""));
        pattern.fit(path.split('/').filter(|name| !name.is_empty()))
    }

    /// The expected values are those of Bash with `globstar` and `dotglob`, but that a folder that matches has all that
    /// is below it.
    #[test]
    fn paths_fit_as_in_a_shell() {
        for (pattern, whole, above, no) in [
            ("*.bvh", "a.bvh .bvh ä.bvh a.bvh/b", "", "a.bvh2 a/b.bvh a.BVH"),
            ("a?c", "abc aäc abc/d", "", "ac abbc"),
            ("*a*b*", "ab xaxbx aab", "", "ba b a"),
            ("[a-cx]1", "a1 b1 x1", "", "d1 -1 a"),
            ("[!a-c]1", "d1 é1", "", "a1 11x"),
            ("[]]x[-]", "]x-", "", "x ]xx"),
            ("[[]1[]]", "[1]", "", "1"),
            ("*/walk/*.bvh", "a/walk/b.bvh", "a a/walk", "a/run walk.bvh/x/y"),
            ("**/*.bvh", "a.bvh a/b.bvh a/b/c.bvh", "a a/b", ""),
            ("[a]/**/b", "a/b a/x/b a/b/c", "a a/x/y", "b x/b"),
            ("**", "a a/b", "", ""),
        ] {
            for (paths, expected) in [(whole, Fit::Whole), (above, Fit::Above), (no, Fit::No)] {
                for path in paths.split_whitespace() {
                    assert_eq!(fit(pattern, path), expected, "{pattern} {path}");
                }
            }
        }
        assert_eq!(Pattern::default().fit(["a", "b"]), Fit::Whole);
    }

    #[test]
    fn the_folder_before_a_wildcard_is_no_part_of_the_pattern() {
        for (path, folder, below) in [("/a/b*/c", "/a", "b1/c"), ("../*", "..", "x"), ("a/./[b]", "a", "b")] {
            let (base, pattern) = Pattern::of(Path::new(path)).map_err(Failure::into_words).unwrap();
            assert_eq!(
                (base.as_path(), pattern.fit(below.split('/'))),
                (Path::new(folder), Fit::Whole)
            );
        }
        for path in ["a*/../b", "[a", "[!]", "a**", "**.bvh"] {
            assert!(Pattern::of(Path::new(path)).is_err(), "{path}");
        }
    }

    #[test]
    fn many_wildcards_take_no_longer_than_the_name_allows() {
        let name = "a".repeat(250);
        assert_eq!(fit(&"*a".repeat(100_000), &name), Fit::No);
        assert_eq!(fit(&(["*a".repeat(200), "*b".to_owned()].concat()), &name), Fit::No);
        assert_eq!(fit(&"**/".repeat(20_000), &"a/".repeat(100)), Fit::Whole);
    }
}
