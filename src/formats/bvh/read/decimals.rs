//! Decimal points and decimal commas.

use memchr::memchr;
use mocap_scene::error::{Code, Diagnostic};

use super::Failure;
use crate::text::number::Number;
use crate::text::{Cursor, Word, quote};
use crate::warnings::Warnings;

/// The decimal separator in the hierarchy.
#[derive(Debug, Default)]
pub(super) struct Decimals {
    /// The start and end of the first number with a comma, and its joint.
    comma: Option<(usize, usize, usize)>,
    has_points: bool,
}

impl Decimals {
    /// Records the decimal separator of a number of `joint`.
    pub(super) fn note(&mut self, word: Word<'_>, number: Number, joint: usize) {
        if number.comma {
            let end = word.offset + word.bytes.len();
            self.comma.get_or_insert((word.offset, end, joint));
        }
        self.has_points |= word.bytes.contains(&b'.');
    }
}

/// Accepts the commas of the hierarchy itself, as [`accept_comma`] does. The cursor is after the hierarchy. `name`
/// returns the name of a joint.
pub(super) fn accept_commas_of_hierarchy<'a>(
    cursor: &Cursor<'_>,
    decimals: &Decimals,
    name: impl Fn(usize) -> &'a str,
    warnings: &mut Warnings,
) -> Result<(), Failure> {
    let Some((offset, end, joint)) = decimals.comma else {
        return Ok(());
    };
    let bytes = &cursor.text()[offset..end];
    accept_comma(cursor, decimals, cursor.offset(), Word { bytes, offset }, warnings)
        .map_err(|failure| Box::new(failure.in_joint(name(joint))))
}

/// Reads commas as decimal separators if no number of the file has a point: then commas have no other meaning.
pub(super) fn accept_comma(
    cursor: &Cursor<'_>,
    decimals: &Decimals,
    motion_start: usize,
    word: Word<'_>,
    warnings: &mut Warnings,
) -> Result<(), Failure> {
    let mut refused = false;
    warnings.tally(Code::DecimalComma, || {
        refused = decimals.has_points || memchr(b'.', &cursor.text()[motion_start..]).is_some();
        Diagnostic::new(
            Code::DecimalComma,
            "numbers have decimal commas, which were read as decimal points",
        )
        .at(cursor.locate(word))
    });
    if !refused {
        return Ok(());
    }
    warnings.forget(Code::DecimalComma);
    Err(Box::new(
        Diagnostic::new(Code::InvalidNumber, format!("{} is not a number", quote(word.bytes)))
            .at(cursor.locate(word))
            .expected_found("decimal points, as elsewhere in the file", quote(word.bytes))
            .help("separate values by spaces, and write decimals with a point"),
    ))
}
