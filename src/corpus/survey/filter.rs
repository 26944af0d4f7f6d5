//! Filter expressions on rows, such as `skate < 1 and not twin`.
//!
//! An expression has `or`, `and`, `not`, parentheses and comparisons. A comparison is `<`, `<=`, `>`, `>=`, `=` or `!=`
//! between a column and a number, a word or a quoted text. A boolean column needs no comparison. A comparison with an
//! absent value is false, so `skate < 1` keeps no clip without a measured skate.

use mocap_scene::error::{Code, Diagnostic, Error, Result};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::row::{Cell, CellType, ClipRow};

/// A parsed expression on rows.
///
/// ```
/// use mocap::survey::Condition;
/// use mocap::survey::report::ClipRow;
///
/// let condition: Condition = "frames >= 10 and not (verdict = bad or twin)".parse()?;
/// let mut row = ClipRow::default();
/// assert!(!condition.holds(&row));
/// row.frames = 10;
/// assert!(condition.holds(&row));
/// assert!("skat < 1".parse::<Condition>().unwrap_err().to_string().contains("skate"));
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Condition {
    text: String,
    tree: Tree,
}

#[derive(Clone, Debug, PartialEq)]
enum Tree {
    Or(Box<Tree>, Box<Tree>),
    And(Box<Tree>, Box<Tree>),
    Not(Box<Tree>),
    Flag(String),
    Compare(String, Comparison, Cell),
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Comparison {
    Less,
    AtMost,
    More,
    AtLeast,
    Equal,
    NotEqual,
}

/// The deepest nesting of parentheses and `not`.
const DEEPEST: usize = 64;

impl Condition {
    /// Whether the expression is true for a row.
    pub fn holds(&self, row: &ClipRow) -> bool {
        self.tree.holds(row)
    }
}

impl std::str::FromStr for Condition {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let mut parser = Parser {
            text,
            words: words(text)?,
            next: 0,
            depth: 0,
        };
        let tree = parser.either()?;
        match parser.words.get(parser.next) {
            None => Ok(Self {
                text: text.to_owned(),
                tree,
            }),
            Some(word) => Err(parser.refused("and, or, or the end", word)),
        }
    }
}

/// Serializes the text of the expression.
impl Serialize for Condition {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.text)
    }
}

impl<'de> Deserialize<'de> for Condition {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        String::deserialize(deserializer)?
            .parse()
            .map_err(serde::de::Error::custom)
    }
}

impl Tree {
    fn holds(&self, row: &ClipRow) -> bool {
        match self {
            Self::Or(a, b) => a.holds(row) || b.holds(row),
            Self::And(a, b) => a.holds(row) && b.holds(row),
            Self::Not(a) => !a.holds(row),
            Self::Flag(column) => row.cell(column) == Some(Cell::Flag(true)),
            Self::Compare(column, comparison, with) => match (row.cell(column), with) {
                (Some(Cell::Number(value)), Cell::Number(with)) => comparison.holds(value.partial_cmp(with)),
                (Some(Cell::Text(value)), Cell::Text(with)) => comparison.holds(Some(value.cmp(with))),
                _ => false,
            },
        }
    }
}

impl Comparison {
    const ALL: [(&str, Self); 6] = [
        ("<=", Self::AtMost),
        (">=", Self::AtLeast),
        ("!=", Self::NotEqual),
        ("<", Self::Less),
        (">", Self::More),
        ("=", Self::Equal),
    ];

    fn holds(self, order: Option<std::cmp::Ordering>) -> bool {
        order.is_some_and(|order| match self {
            Self::Less => order.is_lt(),
            Self::AtMost => order.is_le(),
            Self::More => order.is_gt(),
            Self::AtLeast => order.is_ge(),
            Self::Equal => order.is_eq(),
            Self::NotEqual => order.is_ne(),
        })
    }
}

/// A word of an expression, and the column in which it begins, from 1.
struct Word {
    text: String,
    column: usize,
    is_quoted: bool,
}

fn words(text: &str) -> Result<Vec<Word>> {
    let mut words = Vec::new();
    let mut rest = text;
    loop {
        rest = rest.trim_start();
        let column = text[..text.len() - rest.len()].chars().count() + 1;
        let Some(first) = rest.chars().next() else {
            return Ok(words);
        };
        let mut is_quoted = false;
        let (word, after) = if let '\'' | '"' = first {
            is_quoted = true;
            let end = rest[1..].find(first).ok_or_else(|| {
                Diagnostic::new(
                    Code::InvalidValue,
                    format!("{{where}}: the text of column {column} has no end"),
                )
                .help(format!("close it with {first}"))
            })?;
            (&rest[1..=end], &rest[end + 2..])
        } else if let Some((sign, _)) = Comparison::ALL.iter().find(|(sign, _)| rest.starts_with(sign)) {
            // Also accept `==`, which programmers write.
            let length = if rest.starts_with("==") { 2 } else { sign.len() };
            (*sign, &rest[length..])
        } else if let '(' | ')' = first {
            rest.split_at(1)
        } else {
            let end = rest.find(|c: char| c.is_whitespace() || "()<>=!'\"".contains(c));
            // An unknown sign becomes a word of its own, which the parser rejects.
            let end = end.filter(|end| *end > 0).unwrap_or(match end {
                None => rest.len(),
                Some(_) => first.len_utf8(),
            });
            rest.split_at(end)
        };
        words.push(Word {
            text: word.to_owned(),
            column,
            is_quoted,
        });
        rest = after;
    }
}

struct Parser<'a> {
    text: &'a str,
    words: Vec<Word>,
    next: usize,
    depth: usize,
}

impl Parser<'_> {
    /// The expression with `and`, `or` and `not` in place of the signs of programming languages, for the help of an
    /// error. `None` if the result is not a valid expression.
    fn respelled(&self) -> Option<String> {
        let mut text = self.text.replace("!=", "\0").replace("==", "=").replace('!', " not ");
        for (signs, word) in [(["&&", "&"], " and "), (["||", "|"], " or ")] {
            text = signs.iter().fold(text, |text, sign| text.replace(sign, word));
        }
        let text = text
            .replace('\0', "!=")
            .split_whitespace()
            .collect::<Vec<_>>()
            .join(" ");
        let is_valid = |text: &String| text.parse::<Condition>().is_ok();
        (text != self.text).then_some(text).filter(is_valid)
    }

    fn refused(&self, expected: &str, found: &Word) -> Error {
        let message = format!(
            "{{where}} \"{}\": unexpected word at column {}",
            self.text, found.column
        );
        let error = Diagnostic::new(Code::InvalidValue, message);
        let error = error.expected_found(expected, format!("\"{}\"", found.text));
        match self.respelled() {
            Some(text) => error.help(format!("did you mean \"{text}\"?")).into(),
            None => error.into(),
        }
    }

    fn ended(&self, expected: &str) -> Error {
        let message = format!("{{where}} \"{}\" ends too early", self.text);
        let error = Diagnostic::new(Code::InvalidValue, message);
        error.expected_found(expected, "the end").into()
    }

    fn takes(&mut self, word: &str) -> bool {
        let next = self.words.get(self.next);
        let is_next = next.is_some_and(|next| !next.is_quoted && next.text == word);
        self.next += usize::from(is_next);
        is_next
    }

    fn either(&mut self) -> Result<Tree> {
        let mut tree = self.both()?;
        while self.takes("or") {
            tree = Tree::Or(Box::new(tree), Box::new(self.both()?));
        }
        Ok(tree)
    }

    fn both(&mut self) -> Result<Tree> {
        let mut tree = self.single()?;
        while self.takes("and") {
            tree = Tree::And(Box::new(tree), Box::new(self.single()?));
        }
        Ok(tree)
    }

    fn single(&mut self) -> Result<Tree> {
        self.depth += 1;
        if self.depth > DEEPEST {
            let message = format!("{{where}} nests deeper than {DEEPEST}");
            return Err(Diagnostic::new(Code::InvalidValue, message).into());
        }
        let tree = if self.takes("not") {
            Ok(Tree::Not(Box::new(self.single()?)))
        } else if self.takes("(") {
            let tree = self.either()?;
            match self.takes(")") {
                true => Ok(tree),
                false => Err(self
                    .words
                    .get(self.next)
                    .map_or_else(|| self.ended(")"), |word| self.refused(")", word))),
            }
        } else {
            self.comparison()
        };
        self.depth -= 1;
        tree
    }

    fn comparison(&mut self) -> Result<Tree> {
        let Some(word) = self.words.get(self.next) else {
            return Err(self.ended("a column"));
        };
        let columns = ClipRow::columns();
        let Some((column, kind)) = columns.iter().find(|(name, _)| *name == word.text && !word.is_quoted) else {
            let nearest = mocap_scene::error::nearest(&word.text, columns.iter().map(|(name, _)| *name));
            let message = format!("{{where}}: \"{}\" is not a column", word.text);
            let help = match nearest {
                Some(name) => format!("did you mean {name}?"),
                None => match self.respelled() {
                    Some(text) => format!("did you mean \"{text}\"?"),
                    None => "docs/survey-columns.md lists the columns".to_owned(),
                },
            };
            return Err(Diagnostic::new(Code::InvalidValue, message).help(help).into());
        };
        self.next += 1;
        if *kind == CellType::Flag {
            return Ok(Tree::Flag((*column).to_owned()));
        }
        let sign = "<, <=, >, >=, = or !=";
        let Some(word) = self.words.get(self.next) else {
            return Err(self.ended(sign));
        };
        let found = Comparison::ALL
            .iter()
            .find(|(text, _)| *text == word.text && !word.is_quoted);
        let (_, comparison) = found.ok_or_else(|| self.refused(sign, word))?;
        self.next += 1;
        let Some(word) = self.words.get(self.next) else {
            return Err(self.ended("a value"));
        };
        let with = match kind {
            CellType::Number => match word.text.parse::<f64>() {
                Ok(number) if !number.is_nan() => Cell::Number(number),
                _ => return Err(self.refused("a number", word)),
            },
            _ => Cell::Text(word.text.clone()),
        };
        self.next += 1;
        Ok(Tree::Compare((*column).to_owned(), *comparison, with))
    }
}
