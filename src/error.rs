//! What is wrong with a file, and where.
//!
//! A [`Diagnostic`] is one thing to say about a file. An [`Error`] is the diagnostic that stopped the import; the
//! warnings of a [`Scene`](crate::scene::Scene) are diagnostics that did not. Both carry a [`Code`], a stable name
//! whose cause and remedy stand in one table.

mod code;

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use serde::Serialize;

pub use self::code::Code;

/// The result of everything in this crate that can fail.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// A place in a text file, and what stands there.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Location {
    /// Line, from 1. CR, LF and CRLF each end one line.
    pub line: usize,
    /// Column, from 1, in characters. A tab is one character.
    pub column: usize,
    /// Characters that the diagnostic is about, from `column` on; at least 1.
    pub length: usize,
    /// The line, or the part of a long one around `column`.
    pub text: String,
    /// The column of the first character of `text`; 1 where that is the whole line.
    pub text_column: usize,
}

/// One thing to say about a file.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Diagnostic {
    /// Its stable name.
    pub code: Code,
    /// What is the case, as one sentence without its place and without a full stop.
    pub message: String,
    /// Where it was met, the first time if `count` is above 1. Absent where no single place is to blame.
    pub location: Option<Location>,
    /// The joint it belongs to.
    pub joint: Option<String>,
    /// What should have stood there.
    pub expected: Option<String>,
    /// What stood there.
    pub found: Option<String>,
    /// How to mend it.
    pub help: Option<String>,
    /// How often it was met.
    pub count: u64,
}

impl Diagnostic {
    /// A diagnostic that was met once, without a place.
    pub fn new(code: Code, message: impl Into<String>) -> Self {
        Self {
            code,
            message: message.into(),
            location: None,
            joint: None,
            expected: None,
            found: None,
            help: None,
            count: 1,
        }
    }

    /// Says where.
    #[must_use]
    pub fn at(mut self, location: Location) -> Self {
        self.location = Some(location);
        self
    }

    /// Says in which joint.
    #[must_use]
    pub fn in_joint(mut self, joint: impl Into<String>) -> Self {
        self.joint = Some(joint.into());
        self
    }

    /// Says what should have stood there, and what did.
    #[must_use]
    pub fn expected_found(mut self, expected: impl Into<String>, found: impl Into<String>) -> Self {
        self.expected = Some(expected.into());
        self.found = Some(found.into());
        self
    }

    /// Says how to mend it.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// Says how often it was met.
    #[must_use]
    pub fn times(mut self, count: u64) -> Self {
        self.count = count;
        self
    }
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)?;
        if self.count > 1 {
            write!(f, " ({} times)", self.count)?;
        }
        if let Some(joint) = &self.joint {
            write!(f, "; joint \"{joint}\"")?;
        }
        if let Some(expected) = &self.expected {
            write!(f, "; expected {expected}")?;
        }
        if let Some(found) = &self.found {
            write!(f, "; found {found}")?;
        }
        if let Some(help) = &self.help {
            write!(f, "; help: {help}")?;
        }
        Ok(())
    }
}

/// Why a file could not be read or written: one [`Diagnostic`], the file it is about, and what was noticed before.
///
/// It prints as one line that begins as compilers begin theirs:
///
/// ```
/// let error = mocap::Importer::new().read(b"HIERARCHY\nROOT a {\n  OFFSET 0 zero 0\n}\n", "a.bvh").unwrap_err();
/// assert_eq!(
///     error.to_string(),
///     "a.bvh:3:12: error[invalid-number]: \"zero\" is not a number; joint \"a\"; \
///      expected the Y value of OFFSET; found \"zero\""
/// );
/// ```
#[derive(Debug)]
pub struct Error(Box<Inner>);

#[derive(Debug)]
struct Inner {
    diagnostic: Diagnostic,
    path: Option<PathBuf>,
    source: Option<io::Error>,
    warnings: Vec<Diagnostic>,
}

impl Error {
    /// The operating system refused to read or write `path`.
    pub(crate) fn io(path: &Path, source: io::Error) -> Self {
        let mut error = Self::from(Diagnostic::new(Code::Io, source.to_string()));
        error.0.path = Some(path.to_owned());
        error.0.source = Some(source);
        error
    }

    /// Names the file, unless it is named already.
    #[must_use]
    pub fn with_path(mut self, path: &Path) -> Self {
        self.0.path.get_or_insert_with(|| path.to_owned());
        self
    }

    /// Adds what the reader had noticed before it stopped.
    pub(crate) fn with_warnings(mut self, warnings: Vec<Diagnostic>) -> Self {
        self.0.warnings = warnings;
        self
    }

    /// The stable name of what went wrong.
    pub fn code(&self) -> Code {
        self.0.diagnostic.code
    }

    /// Everything that is known about it.
    pub fn diagnostic(&self) -> &Diagnostic {
        &self.0.diagnostic
    }

    /// The file, where there is one.
    pub fn path(&self) -> Option<&Path> {
        self.0.path.as_deref()
    }

    /// The place in the file, where there is one.
    pub fn location(&self) -> Option<&Location> {
        self.0.diagnostic.location.as_ref()
    }

    /// The joint it belongs to, where there is one.
    pub fn joint(&self) -> Option<&str> {
        self.0.diagnostic.joint.as_deref()
    }

    /// What the reader had noticed before it stopped, in the order of the file.
    pub fn warnings(&self) -> &[Diagnostic] {
        &self.0.warnings
    }
}

impl From<Box<Diagnostic>> for Error {
    fn from(diagnostic: Box<Diagnostic>) -> Self {
        Self(Box::new(Inner {
            diagnostic: *diagnostic,
            path: None,
            source: None,
            warnings: Vec::new(),
        }))
    }
}

impl From<Diagnostic> for Error {
    fn from(diagnostic: Diagnostic) -> Self {
        Box::new(diagnostic).into()
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(path) = &self.0.path {
            write!(f, "{}:", path.display())?;
        }
        if let Some(Location { line, column, .. }) = self.location() {
            write!(f, "{line}:{column}:")?;
        }
        if self.0.path.is_some() || self.location().is_some() {
            f.write_str(" ")?;
        }
        write!(f, "error[{}]: {}", self.code(), self.0.diagnostic)
    }
}

impl std::error::Error for Error {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        self.0.source.as_ref().map(|source| source as _)
    }
}
