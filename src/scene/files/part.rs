//! A part of a file in memory. Long texts of numbers are packed, because they take most of the memory of a writer.

use std::borrow::Cow;

/// The characters of a packed text. The last entry only fills up a byte and is not a character.
const CHARACTERS: [u8; 16] = *b"0123456789-. \n\0\0";

/// The code of a byte that is not in [`CHARACTERS`].
const UNKNOWN: u8 = 16;

/// The code of each byte: its index in [`CHARACTERS`].
const CODES: [u8; 256] = {
    let mut codes = [UNKNOWN; 256];
    let mut code = 0;
    while CHARACTERS[code] != 0 {
        codes[CHARACTERS[code] as usize] = code as u8;
        code += 1;
    }
    codes
};

/// The two characters of each packed byte.
const PAIRS: [[u8; 2]; 256] = {
    let mut pairs = [[0; 2]; 256];
    let mut byte = 0;
    while byte < 256 {
        pairs[byte] = [CHARACTERS[byte >> 4], CHARACTERS[byte & 15]];
        byte += 1;
    }
    pairs
};

/// A part of a file: bytes, or a text of numbers in half the memory.
#[doc(hidden)]
#[derive(Clone, Debug, PartialEq)]
pub struct FilePart<'a> {
    stored: Cow<'a, [u8]>,
    /// The number of characters of a packed text, which has two in each byte; `None` for bytes.
    characters: Option<usize>,
}

impl<'a> From<&'a [u8]> for FilePart<'a> {
    fn from(bytes: &'a [u8]) -> Self {
        Cow::Borrowed(bytes).into()
    }
}

impl From<Vec<u8>> for FilePart<'_> {
    fn from(bytes: Vec<u8>) -> Self {
        Cow::<[u8]>::Owned(bytes).into()
    }
}

impl<'a> From<Cow<'a, [u8]>> for FilePart<'a> {
    fn from(stored: Cow<'a, [u8]>) -> Self {
        Self {
            stored,
            characters: None,
        }
    }
}

impl FilePart<'_> {
    /// Packs a text of decimal numbers, spaces and line feeds. A text with other characters is copied.
    pub fn numbers(text: &[u8]) -> FilePart<'static> {
        let mut packed = Vec::with_capacity(text.len().div_ceil(2));
        let mut all = 0;
        let (pairs, last) = text.as_chunks::<2>();
        packed.extend(pairs.iter().map(|pair| {
            let [first, second] = pair.map(|byte| CODES[usize::from(byte)]);
            all |= first | second;
            (first << 4) | (second & 15)
        }));
        packed.extend(last.iter().map(|byte| {
            let code = CODES[usize::from(*byte)];
            all |= code;
            (code << 4) | 15
        }));
        match all & UNKNOWN {
            0 => FilePart {
                stored: Cow::Owned(packed),
                characters: Some(text.len()),
            },
            _ => text.to_vec().into(),
        }
    }

    /// The number of bytes in the file.
    pub fn len(&self) -> usize {
        self.characters.unwrap_or(self.stored.len())
    }

    /// Whether the part has no bytes.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The bytes in the file.
    pub fn bytes(&self) -> Cow<'_, [u8]> {
        let Some(characters) = self.characters else {
            return Cow::Borrowed(&self.stored);
        };
        let mut text = vec![0; 2 * self.stored.len()];
        for (pair, byte) in text.as_chunks_mut::<2>().0.iter_mut().zip(&*self.stored) {
            *pair = PAIRS[usize::from(*byte)];
        }
        text.truncate(characters);
        Cow::Owned(text)
    }

    /// The bytes in the file.
    pub fn into_bytes(self) -> Vec<u8> {
        match self.characters {
            None => self.stored.into_owned(),
            Some(_) => self.bytes().into_owned(),
        }
    }

    /// A part with the same bytes that refers to the memory of this part.
    pub fn borrowed(&self) -> FilePart<'_> {
        FilePart {
            stored: Cow::Borrowed(&self.stored),
            characters: self.characters,
        }
    }
}
