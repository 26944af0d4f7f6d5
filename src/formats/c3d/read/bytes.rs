//! Reads numbers in the formats of three processors.

use mocap_scene::error::{Code, Diagnostic};

use super::{CUT_OFF, Failure};

/// The number format of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Processor {
    /// Intel: little-endian, IEEE 754.
    Intel,
    /// DEC: little-endian integers, VAX F_floating reals.
    Dec,
    /// SGI and MIPS: big-endian, IEEE 754.
    Sgi,
}

impl Processor {
    /// The processor for the fourth byte of the parameter section.
    pub(super) fn from_code(code: u8) -> Option<Self> {
        match code {
            84 => Some(Self::Intel),
            85 => Some(Self::Dec),
            86 => Some(Self::Sgi),
            _ => None,
        }
    }

    pub fn word(self, bytes: [u8; 2]) -> u16 {
        match self {
            Self::Intel | Self::Dec => u16::from_le_bytes(bytes),
            Self::Sgi => u16::from_be_bytes(bytes),
        }
    }

    /// VAX F_floating: the two words are swapped, and the exponent is 2 larger than in IEEE 754.
    pub fn real(self, bytes: [u8; 4]) -> f64 {
        let [a, b, c, d] = bytes;
        match self {
            Self::Intel => f64::from(f32::from_le_bytes(bytes)),
            Self::Dec => f64::from(f32::from_le_bytes([c, d, a, b])) / 4.0,
            Self::Sgi => f64::from(f32::from_be_bytes(bytes)),
        }
    }
}

/// A reading position in the bytes of a file.
#[derive(Clone, Debug)]
pub(super) struct Bytes<'a> {
    bytes: &'a [u8],
    offset: usize,
    processor: Processor,
}

impl<'a> Bytes<'a> {
    pub(super) fn new(bytes: &'a [u8], processor: Processor) -> Self {
        Self {
            bytes,
            offset: 0,
            processor,
        }
    }

    pub(super) fn offset(&self) -> usize {
        self.offset
    }

    pub(super) fn set_offset(&mut self, offset: usize) {
        self.offset = offset;
    }

    pub(super) fn skip(&mut self, length: usize) {
        self.offset = self.offset.saturating_add(length);
    }

    pub(super) fn take(&mut self, length: usize) -> Result<&'a [u8], Failure> {
        let end = self.offset.saturating_add(length);
        let Some(taken) = self.bytes.get(self.offset..end) else {
            return Err(Box::new(
                Diagnostic::new(Code::UnexpectedEnd, "the file is cut off")
                    .expected_found(format!("{length} more bytes at byte {}", self.offset), self.rest())
                    .help(CUT_OFF),
            ));
        };
        self.offset = end;
        Ok(taken)
    }

    fn rest(&self) -> String {
        format!("{}", self.bytes.len().saturating_sub(self.offset))
    }

    pub(super) fn byte(&mut self) -> Result<u8, Failure> {
        Ok(self.take(1)?[0])
    }

    pub(super) fn word(&mut self) -> Result<u16, Failure> {
        let bytes = self.take(2)?;
        Ok(self.processor.word([bytes[0], bytes[1]]))
    }

    pub(super) fn real(&mut self) -> Result<f64, Failure> {
        let bytes = self.take(4)?;
        Ok(self.processor.real([bytes[0], bytes[1], bytes[2], bytes[3]]))
    }
}
