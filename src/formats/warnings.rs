//! The warnings of a reader, limited in number, so that a hostile file cannot fill the memory.

use mocap_scene::error::{Code, Diagnostic, Error, Location, Result};
use mocap_scene::scene::Scene;

use crate::Failure;

/// The number of warnings per code that are kept with their locations. Further warnings are only counted.
const MOST_OF_A_CODE: usize = 32;

/// The warning for a file with fewer frames than it states.
pub(crate) fn missing_frames(stated: u64, found: u64) -> Diagnostic {
    let missing = stated.saturating_sub(found);
    let message = format!("{missing} of {stated} frames are missing: the file is cut off, or states a wrong number");
    Diagnostic::new(Code::MissingFrames, message)
        .expected_found(format!("{stated} frames"), format!("{found}"))
        .help("the available frames were read; export or download the file again")
}

/// The warning for a file that is cut off in its last row.
pub(crate) fn cut_row(row: Location) -> Diagnostic {
    Diagnostic::new(Code::RowLength, "the file ends inside its last row, which was dropped")
        .at(row)
        .help("the file is cut off: export or download it again")
}

#[derive(Debug, Default)]
pub(crate) struct Warnings {
    kept: Vec<Diagnostic>,
}

impl Warnings {
    /// Keeps a warning. The closure `warning` is called only if the warning is kept, because finding its location takes
    /// a pass over the text.
    pub(crate) fn push(&mut self, code: Code, warning: impl FnOnce() -> Diagnostic) {
        self.keep(code, MOST_OF_A_CODE, warning);
    }

    /// Keeps the first warning of a code, and counts the further warnings.
    pub(crate) fn tally(&mut self, code: Code, first: impl FnOnce() -> Diagnostic) {
        self.keep(code, 1, first);
    }

    /// Keeps a warning. If a kept warning has the same code and message, only counts the new warning. At most as many
    /// warnings of a code are kept as by [`push`](Self::push).
    pub(crate) fn distinct(&mut self, warning: Diagnostic) {
        let is_equal = |kept: &&mut Diagnostic| kept.code == warning.code && kept.message == warning.message;
        match self.kept.iter_mut().find(is_equal) {
            Some(first) => first.count += warning.count,
            None => self.push(warning.code, || warning),
        }
    }

    fn keep(&mut self, code: Code, most: usize, warning: impl FnOnce() -> Diagnostic) {
        let mut same = self.kept.iter_mut().filter(|kept| kept.code == code);
        match same.nth(most - 1) {
            Some(last) => last.count += 1,
            None => self.kept.push(warning()),
        }
    }

    /// Whether there is a warning with this code.
    pub(crate) fn has(&self, code: Code) -> bool {
        self.kept.iter().any(|kept| kept.code == code)
    }

    pub(crate) fn into_kept(self) -> Vec<Diagnostic> {
        self.kept
    }

    /// Removes a warning that turned out to be an error.
    pub(crate) fn forget(&mut self, code: Code) {
        self.kept.retain(|kept| kept.code != code);
    }

    /// The value with the warnings, or the error with the warnings.
    pub(crate) fn with<T>(self, read: Result<T, Failure>) -> Result<(T, Vec<Diagnostic>)> {
        match read {
            Ok(value) => Ok((value, self.kept)),
            Err(failure) => Err(Error::from(failure).with_warnings(self.kept)),
        }
    }

    /// Moves the warnings to the scene, or to the error.
    pub(crate) fn attach_to(self, read: Result<Scene, Failure>) -> Result<Scene> {
        match read {
            Ok(scene) => Ok(Scene {
                warnings: self.kept,
                ..scene
            }),
            Err(failure) => Err(Error::from(failure).with_warnings(self.kept)),
        }
    }
}
