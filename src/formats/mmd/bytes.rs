//! Reads consecutive little-endian numbers and strings of a file.

use glam::{DQuat, DVec3};
use mocap_scene::error::{Code, Diagnostic};

use super::EXPORT_AGAIN;
use crate::Failure;

/// The unread bytes.
pub(super) struct Cursor<'a> {
    bytes: &'a [u8],
    offset: usize,
}

/// The error for a file whose contents contradict its first bytes.
pub(super) fn invalid(message: impl Into<String>) -> Failure {
    Diagnostic::new(Code::InvalidMmd, message.into())
        .help(EXPORT_AGAIN)
        .into()
}

impl<'a> Cursor<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, offset: 0 }
    }

    pub(super) fn offset(&self) -> usize {
        self.offset
    }

    pub(super) fn rest(&self) -> usize {
        self.bytes.len() - self.offset
    }

    pub(super) fn is_at_end(&self) -> bool {
        self.rest() == 0
    }

    pub(super) fn take(&mut self, length: usize) -> Result<&'a [u8], Failure> {
        let end = self.offset.saturating_add(length);
        let Some(taken) = self.bytes.get(self.offset..end) else {
            let expected = format!("{length} more bytes at byte {}", self.offset);
            return Err(Diagnostic::new(Code::UnexpectedEnd, "the file is cut off")
                .expected_found(expected, self.rest().to_string())
                .help(EXPORT_AGAIN)
                .into());
        };
        self.offset = end;
        Ok(taken)
    }

    pub(super) fn array<const N: usize>(&mut self) -> Result<[u8; N], Failure> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(N)?);
        Ok(array)
    }

    pub(super) fn byte(&mut self) -> Result<u8, Failure> {
        Ok(self.array::<1>()?[0])
    }

    pub(super) fn short(&mut self) -> Result<u16, Failure> {
        self.array().map(u16::from_le_bytes)
    }

    pub(super) fn long(&mut self) -> Result<u32, Failure> {
        self.array().map(u32::from_le_bytes)
    }

    pub(super) fn int(&mut self) -> Result<i32, Failure> {
        self.array().map(i32::from_le_bytes)
    }

    pub(super) fn real(&mut self) -> Result<f64, Failure> {
        self.array().map(f32::from_le_bytes).map(f64::from)
    }

    /// The number of the following items, which `what` names. Each item has at least `each` bytes. The count is checked
    /// against the remaining bytes.
    pub(super) fn count(&mut self, what: &str, each: usize) -> Result<usize, Failure> {
        let at = self.offset;
        let count = self.long()?;
        let most = self.rest() / each;
        match usize::try_from(count) {
            Ok(count) if count <= most => Ok(count),
            _ => Err(Diagnostic::new(
                Code::UnexpectedEnd,
                format!("the file has fewer {what} than it states at byte {at}"),
            )
            .expected_found(count.to_string(), format!("room for {most}"))
            .help(EXPORT_AGAIN)
            .into()),
        }
    }

    /// Three numbers, without conversion to right-handed axes.
    pub(super) fn numbers(&mut self) -> Result<DVec3, Failure> {
        Ok(DVec3::new(self.real()?, self.real()?, self.real()?))
    }

    /// A position, converted to right-handed axes.
    pub(super) fn position(&mut self) -> Result<DVec3, Failure> {
        Ok(self.numbers()? * DVec3::new(1.0, 1.0, -1.0))
    }

    /// A rotation, converted to right-handed axes.
    pub(super) fn rotation(&mut self) -> Result<DQuat, Failure> {
        let [x, y, z, w] = [self.real()?, self.real()?, self.real()?, self.real()?];
        Ok(DQuat::from_xyzw(-x, -y, z, w))
    }
}
