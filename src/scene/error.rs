//! Diagnostics: problems of a file, with their locations.
//!
//! A [`Diagnostic`] describes one problem of a file. An [`Error`] is the diagnostic that stopped the import. The
//! warnings of a [`Scene`](crate::scene::Scene) are diagnostics that did not stop the import. Each diagnostic has a
//! [`Code`]: a stable name with a cause and a remedy.

mod code;
pub(crate) mod nearest;
mod pointer;
mod spelling;
mod visible;

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

pub use self::code::Code;
#[doc(hidden)]
pub use self::nearest::nearest;
#[doc(hidden)]
pub use self::pointer::{pointer, wrong_value};
#[doc(hidden)]
pub use self::spelling::{spell_options, spelled};
pub use self::visible::visible;
#[doc(hidden)]
pub use self::visible::visible_json;

/// The result of every fallible function of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// A position in a text file, and the text at that position.
///
/// [`Error`] has an example.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Location {
    /// The line, from 1. CR, LF and CRLF each end one line.
    pub line: usize,
    /// The column in characters, from 1. A tab is one character.
    pub column: usize,
    /// The number of affected characters, starting at `column`; at least 1.
    pub length: usize,
    /// The text of the line. Of a long line, only the piece around `column`.
    pub text: String,
    /// The column of the first character of `text`; 1 if `text` is the whole line.
    pub text_column: usize,
}

/// One problem of a file.
///
/// [`Error`] has an example.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Diagnostic {
    /// The stable name of the problem.
    pub code: Code,
    /// The problem in one sentence, without location and full stop.
    pub message: String,
    /// The location, or the location of the first occurrence if `count` is above 1. Absent if the problem has no single
    /// location.
    pub location: Option<Location>,
    /// The location in a JSON file, as a JSON pointer: `/accessors/3/count`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pointer: Option<String>,
    /// The affected joint.
    pub joint: Option<String>,
    /// What the format expects at the location.
    pub expected: Option<String>,
    /// What the file has at the location.
    pub found: Option<String>,
    /// The remedy.
    pub help: Option<String>,
    /// The number of occurrences.
    pub count: u64,
}

impl Diagnostic {
    /// A diagnostic with one occurrence and without a location.
    pub fn new(code: Code, message: impl Into<String>) -> Self {
        Self {
            code,
            message: spelled(&message.into()).into_owned(),
            location: None,
            pointer: None,
            joint: None,
            expected: None,
            found: None,
            help: None,
            count: 1,
        }
    }

    /// Sets the location.
    #[must_use]
    pub fn at(mut self, location: Location) -> Self {
        self.location = Some(location);
        self
    }

    /// Sets the location in a JSON file, as a JSON pointer.
    #[must_use]
    pub fn at_pointer(mut self, pointer: impl Into<String>) -> Self {
        self.pointer = Some(pointer.into());
        self
    }

    /// Sets the joint.
    #[must_use]
    pub fn in_joint(mut self, joint: impl Into<String>) -> Self {
        self.joint = Some(joint.into());
        self
    }

    /// Sets what the format expects and what the file has.
    #[must_use]
    pub fn expected_found(mut self, expected: impl Into<String>, found: impl Into<String>) -> Self {
        self.expected = Some(expected.into());
        self.found = Some(found.into());
        self
    }

    /// Sets the remedy.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(spelled(&help.into()).into_owned());
        self
    }

    /// Sets the number of occurrences.
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
        if let Some(pointer) = &self.pointer {
            write!(f, "; at {pointer}")?;
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

/// The reason why a file could not be read or written: one [`Diagnostic`], the path of the file, and the warnings
/// before the error.
///
/// An error prints as one line that begins with the location, like a compiler message:
///
/// ```
/// let error = mocap::Importer::new().read(b"HIERARCHY\nROOT a {\n  OFFSET 0 zero 0\n}\n", "a.bvh").unwrap_err();
/// assert_eq!(
///     error.to_string(),
///     "a.bvh:3:12: error[invalid-number]: \"zero\" is not a number; joint \"a\"; \
///      expected the Y value of OFFSET; found \"zero\""
/// );
/// ```
pub struct Error(Box<Inner>);

#[derive(Debug)]
struct Inner {
    diagnostic: Diagnostic,
    path: Option<PathBuf>,
    source: Option<io::Error>,
    warnings: Vec<Diagnostic>,
}

impl Error {
    /// An error for `path` from the operating system.
    #[doc(hidden)]
    pub fn io(path: &Path, source: io::Error) -> Self {
        let is_named = !path.as_os_str().is_empty();
        let is_missing = source.kind() == io::ErrorKind::NotFound && source.get_ref().is_none();
        let message = match source.kind() {
            _ if !is_named => "the name of the file is empty".to_owned(),
            _ if is_missing => "the file or folder does not exist".to_owned(),
            io::ErrorKind::IsADirectory => "it is a folder, not a file".to_owned(),
            io::ErrorKind::NotADirectory => "a part of the path is a file, not a folder".to_owned(),
            _ => source.to_string(),
        };
        let help = match source.kind() {
            io::ErrorKind::NotFound if is_named => "check the name of the file and of its folder",
            io::ErrorKind::PermissionDenied => "check who may read and write the file and its folder",
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => "free some space, or write to another disk",
            io::ErrorKind::IsADirectory => "name a file instead of a folder",
            io::ErrorKind::NotADirectory => "name a folder instead of a file",
            _ => "",
        };
        let mut diagnostic = Diagnostic::new(Code::Io, message);
        if !help.is_empty() {
            diagnostic = diagnostic.help(help);
        }
        let mut error = Self::from(diagnostic);
        error.0.path = is_named.then(|| path.to_owned());
        error.0.source = Some(source);
        error
    }

    /// Sets the path, unless the error has one.
    #[must_use]
    pub fn with_path(mut self, path: &Path) -> Self {
        self.0.path.get_or_insert_with(|| path.to_owned());
        self
    }

    /// Names the clip that the error concerns.
    #[doc(hidden)]
    pub fn in_clip(mut self, index: usize, name: &str) -> Self {
        let message = &mut self.0.diagnostic.message;
        message.insert_str(0, &format!("clip {index} \"{name}\": "));
        self
    }

    /// Adds the warnings that precede the error.
    #[doc(hidden)]
    pub fn with_warnings(mut self, warnings: Vec<Diagnostic>) -> Self {
        self.0.warnings = warnings;
        self
    }

    /// The stable name of the error.
    pub fn code(&self) -> Code {
        self.0.diagnostic.code
    }

    /// The whole diagnostic.
    pub fn diagnostic(&self) -> &Diagnostic {
        &self.0.diagnostic
    }

    /// The file, if there is one.
    pub fn path(&self) -> Option<&Path> {
        self.0.path.as_deref()
    }

    /// The location in the file, if there is one.
    pub fn location(&self) -> Option<&Location> {
        self.0.diagnostic.location.as_ref()
    }

    /// The affected joint, if there is one.
    pub fn joint(&self) -> Option<&str> {
        self.0.diagnostic.joint.as_deref()
    }

    /// The warnings that precede the error, in the order of the file.
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

/// Prints the same text as [`fmt::Display`], because a `main` that returns an error prints its `Debug` text.
impl fmt::Debug for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl std::error::Error for Error {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        self.0.source.as_ref().map(|source| source as _)
    }
}
