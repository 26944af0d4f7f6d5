//! An array of any program: its shape, its element type, and its bytes, which are decoded on demand.

use std::ops::Deref;
use std::rc::Rc;

use mocap_scene::error::{Code, Diagnostic};

use crate::Failure;

/// The type of an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Bool,
    /// Signed integers with this number of bytes.
    Int(usize),
    Uint(usize),
    /// IEEE numbers of 2, 4 or 8 bytes.
    Float(usize),
    /// The upper half of a 32-bit float.
    Bfloat16,
    /// NumPy text with this number of characters of 4 bytes.
    Text(usize),
    /// Text of one byte per character, with this number of characters.
    Bytes(usize),
}

impl Kind {
    /// The number of bytes of an element.
    pub(super) fn size(self) -> usize {
        match self {
            Self::Bool => 1,
            Self::Int(size) | Self::Uint(size) | Self::Float(size) | Self::Bytes(size) => size,
            Self::Bfloat16 => 2,
            Self::Text(characters) => 4 * characters,
        }
    }

    /// The type for NumPy's letter and size, such as `f4`.
    pub(super) fn of_numpy(letters: &str) -> Option<Self> {
        let (letter, size) = letters.split_at_checked(1)?;
        let size: usize = size.parse().ok().filter(|size| *size <= 1 << 16)?;
        match (letter, size) {
            ("b", 1) => Some(Self::Bool),
            ("i", 1 | 2 | 4 | 8) => Some(Self::Int(size)),
            ("u", 1 | 2 | 4 | 8) => Some(Self::Uint(size)),
            ("f", 2 | 4 | 8) => Some(Self::Float(size)),
            ("U", _) => Some(Self::Text(size)),
            ("S", _) => Some(Self::Bytes(size)),
            _ => None,
        }
    }
}

/// The bytes of an array: from the file, or shared with other arrays.
#[derive(Clone, Debug)]
pub enum Bytes<'a> {
    File(&'a [u8]),
    /// Bytes that several arrays may share. The bytes of this array start at the given index.
    Made(Rc<Vec<u8>>, usize),
}

impl Bytes<'_> {
    pub(super) fn made(bytes: Vec<u8>) -> Self {
        Self::Made(Rc::new(bytes), 0)
    }

    /// The bytes after the first `begin` bytes.
    pub(super) fn after(&self, begin: usize) -> Self {
        match self {
            Self::File(bytes) => Self::File(bytes.get(begin..).unwrap_or_default()),
            Self::Made(bytes, first) => Self::Made(Rc::clone(bytes), first.saturating_add(begin).min(bytes.len())),
        }
    }
}

impl Deref for Bytes<'_> {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        match self {
            Self::File(bytes) => bytes,
            Self::Made(bytes, first) => &bytes[*first..],
        }
    }
}

/// The number of elements that any array may have, however few bytes it has.
const MOST_EXPANDED: usize = 1 << 18;

/// The number of elements allowed for each stored byte of an array, because an expanded PyTorch tensor has few bytes
/// and many elements. A decoded element takes 8 bytes. So the memory is at most 32 times the stored bytes, plus the
/// memory of `MOST_EXPANDED` elements.
const EXPANDED_PER_BYTE: usize = 4;

/// An array: the bytes of its elements, and their type and arrangement.
#[derive(Clone, Debug)]
pub struct NdArray<'a> {
    pub(super) shape: Vec<usize>,
    pub(super) kind: Kind,
    pub(super) big_endian: bool,
    /// The number of elements from one index of an axis to the next.
    pub(super) strides: Vec<usize>,
    pub(super) bytes: Bytes<'a>,
}

impl<'a> NdArray<'a> {
    /// An array with contiguous elements, in C order (last axis first) or in Fortran order (first axis first).
    ///
    /// # Errors
    /// [`Code::UnexpectedEnd`] if there are fewer bytes than the shape needs. `entry` names the source of the bytes.
    pub fn new(
        entry: &str,
        (kind, big_endian): (Kind, bool),
        shape: Vec<usize>,
        is_fortran: bool,
        bytes: Bytes<'a>,
    ) -> Result<Self, Failure> {
        let mut strides = vec![1; shape.len()];
        let mut next = 1_usize;
        let mut set = |axis: usize| {
            strides[axis] = next;
            next = next.saturating_mul(shape[axis].max(1));
        };
        if is_fortran {
            (0..shape.len()).for_each(&mut set);
        } else {
            (0..shape.len()).rev().for_each(&mut set);
        }
        let array = Self {
            shape,
            kind,
            big_endian,
            strides,
            bytes,
        };
        array.check(entry)?;
        Ok(array)
    }

    /// Refuses an array whose last element is beyond its bytes.
    pub(super) fn check(&self, entry: &str) -> Result<(), Failure> {
        if self.shape.contains(&0) {
            return Ok(());
        }
        let axes = std::iter::zip(&self.shape, &self.strides);
        let last = axes.fold(0_usize, |last, (length, stride)| {
            last.saturating_add((length - 1).saturating_mul(*stride))
        });
        let needed = last.saturating_add(1).saturating_mul(self.kind.size());
        let most = MOST_EXPANDED.saturating_add(self.bytes.len().saturating_mul(EXPANDED_PER_BYTE));
        if needed <= self.bytes.len() && self.count() <= most {
            return Ok(());
        }
        Err(Box::new(
            Diagnostic::new(
                Code::UnexpectedEnd,
                format!("the array {entry} has fewer bytes than its shape needs"),
            )
            .expected_found(
                format!("{needed} bytes for the shape {}", self.shape_text()),
                format!("{}", self.bytes.len()),
            )
            .help("the file is cut off: export or download it again"),
        ))
    }

    /// The number of elements.
    pub(super) fn count(&self) -> usize {
        self.shape
            .iter()
            .fold(1, |count: usize, length| count.saturating_mul(*length))
    }

    pub(super) fn is_number(&self) -> bool {
        !matches!(self.kind, Kind::Text(_) | Kind::Bytes(_))
    }

    /// The shape as NumPy prints it.
    pub(super) fn shape_text(&self) -> String {
        let axes: Vec<String> = self.shape.iter().map(ToString::to_string).collect();
        match axes.as_slice() {
            [one] => format!("({one},)"),
            axes => format!("({})", axes.join(", ")),
        }
    }

    /// The elements as numbers, in C order. Empty for text.
    pub fn numbers(&self) -> Vec<f64> {
        let mut numbers = Vec::with_capacity(self.count());
        if self.is_number() {
            self.each(|bytes| numbers.push(number(self.kind, self.big_endian, bytes)));
        }
        numbers
    }

    /// The elements as strings. Empty for numbers.
    pub(super) fn texts(&self) -> Vec<String> {
        let mut texts = Vec::new();
        match self.kind {
            Kind::Text(_) => self.each(|bytes| {
                let (characters, _) = bytes.as_chunks::<4>();
                let codes = characters.iter().map(|code| match self.big_endian {
                    true => u32::from_be_bytes(*code),
                    false => u32::from_le_bytes(*code),
                });
                let letters = codes.map(|code| char::from_u32(code).unwrap_or(char::REPLACEMENT_CHARACTER));
                let text: String = letters.collect();
                texts.push(text.trim_end_matches('\0').to_owned());
            }),
            Kind::Bytes(_) => self.each(|bytes| {
                let text = String::from_utf8_lossy(bytes);
                texts.push(text.trim_end_matches('\0').to_owned());
            }),
            _ => {}
        }
        texts
    }

    /// Calls `see` with the bytes of each element, in C order.
    fn each(&self, mut see: impl FnMut(&[u8])) {
        let size = self.kind.size();
        let count = self.count();
        let mut index = vec![0_usize; self.shape.len()];
        let mut at = 0_usize;
        for _ in 0..count {
            let begin = at.wrapping_mul(size);
            see(self.bytes.get(begin..begin.wrapping_add(size)).unwrap_or_default());
            for axis in (0..index.len()).rev() {
                index[axis] += 1;
                at = at.wrapping_add(self.strides[axis]);
                if index[axis] < self.shape[axis] {
                    break;
                }
                at = at.wrapping_sub(self.strides[axis].wrapping_mul(self.shape[axis]));
                index[axis] = 0;
            }
        }
    }

    /// The only element of an array; `None` if the array has more or fewer elements.
    pub(super) fn scalar(&self) -> Option<f64> {
        (self.count() == 1).then(|| self.numbers().first().copied()).flatten()
    }
}

/// A number of `kind` from its bytes; 0 if there are too few bytes, which [`NdArray::check`] has excluded.
fn number(kind: Kind, big_endian: bool, bytes: &[u8]) -> f64 {
    let mut eight = [0_u8; 8];
    let size = bytes.len().min(8);
    eight[..size].copy_from_slice(&bytes[..size]);
    if big_endian {
        eight[..size].reverse();
    }
    let bits = u64::from_le_bytes(eight);
    match kind {
        Kind::Bool => f64::from(u8::from(bits != 0)),
        Kind::Uint(_) => bits as f64,
        Kind::Int(size) => {
            let unused = 64 - 8 * size as u32;
            ((bits << unused).cast_signed() >> unused) as f64
        }
        Kind::Float(2) => half(bits as u16),
        Kind::Float(4) => f64::from(f32::from_bits(bits as u32)),
        Kind::Float(_) => f64::from_bits(bits),
        Kind::Bfloat16 => f64::from(f32::from_bits((bits as u32) << 16)),
        Kind::Text(_) | Kind::Bytes(_) => 0.0,
    }
}

/// A 16-bit IEEE 754 float.
pub fn half(bits: u16) -> f64 {
    let (exponent, fraction) = (i32::from(bits >> 10 & 0x1f), f64::from(bits & 0x3ff));
    let size = match exponent {
        0 => fraction * 2_f64.powi(-24),
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        _ => (1024.0 + fraction) * 2_f64.powi(exponent - 25),
    };
    if bits >> 15 == 1 { -size } else { size }
}

/// The arrays of a file, with their names. The array of an `.npy` has no name.
#[derive(Clone, Debug, Default)]
pub(super) struct Entries<'a> {
    pub(super) arrays: Vec<(String, NdArray<'a>)>,
    /// Whether there are more arrays than listed.
    pub(super) is_cut: bool,
}

impl<'a> Entries<'a> {
    pub(super) fn get(&self, name: &str) -> Option<&NdArray<'a>> {
        self.arrays.iter().find(|(own, _)| own == name).map(|(_, array)| array)
    }

    /// The array with the first of these names that exists.
    pub(super) fn first(&self, names: &[&str]) -> Option<&NdArray<'a>> {
        names.iter().find_map(|name| self.get(name))
    }

    /// The arrays of each dictionary that has the array `inner`, with the name of the dictionary.
    pub(super) fn of_each(&self, inner: &str) -> Vec<(&str, Self)> {
        let names = self.arrays.iter().map(|(name, _)| name.as_str());
        let prefixes = names.filter_map(|name| name.strip_suffix(inner));
        let mut rest = &self.arrays[..];
        let mut of_dictionary = |prefix: &str| {
            let is_own = |(name, _): &&(String, NdArray<'a>)| name.starts_with(prefix);
            rest = rest
                .iter()
                .position(|array| is_own(&array))
                .map_or(&[], |begin| &rest[begin..]);
            let (own, after) = rest.split_at(rest.iter().take_while(is_own).count());
            rest = after;
            let arrays = own
                .iter()
                .map(|(name, array)| (name[prefix.len()..].to_owned(), array.clone()));
            Self {
                arrays: arrays.collect(),
                is_cut: self.is_cut,
            }
        };
        let dictionaries = prefixes.filter_map(|prefix| Some((prefix.strip_suffix('.')?, prefix)));
        dictionaries
            .map(|(name, prefix)| (name, of_dictionary(prefix)))
            .collect()
    }

    /// The names and the shapes of the arrays, for errors.
    pub(super) fn describe(&self) -> String {
        /// The largest number of arrays in an error.
        const NAMED: usize = 12;
        let named = self.arrays.iter().take(NAMED);
        let mut words: Vec<String> = named
            .map(|(name, array)| format!("{name} {}", array.shape_text()))
            .collect();
        if self.arrays.len() > NAMED {
            words.push(format!("and {} more", self.arrays.len() - NAMED));
        }
        match words.is_empty() {
            true => "no array".to_owned(),
            false => words.join(", ").trim_start().to_owned(),
        }
    }
}
