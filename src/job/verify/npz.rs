//! Reads the `.npz` files of `fk`, without code of the writer. They are uncompressed zip archives of `.npy` files, in
//! versions 1.0 to 3.0 of `numpy.lib.format`.

use std::io::{Cursor, Read};

use mocap_scene::error::{Code, Diagnostic, Error, Result};
use zip::ZipArchive;

use super::arrays::{ArrayFile, HELP, Header, invalid};
use crate::arrays::Rotation;

/// One array: its dtype, its shape, and its bytes.
struct Array {
    name: &'static str,
    dtype: String,
    shape: Vec<usize>,
    bytes: Vec<u8>,
}

/// Whether the file is a zip archive.
pub(super) fn sniff(bytes: &[u8]) -> bool {
    bytes.starts_with(b"PK\x03\x04")
}

/// The arrays of a file.
///
/// # Errors
/// [`Code::InvalidArrays`].
pub(super) fn read(bytes: &[u8]) -> Result<ArrayFile> {
    let mut archive =
        ZipArchive::new(Cursor::new(bytes)).map_err(|error| invalid(format!("the archive is broken: {error}")))?;
    let names: Vec<String> = archive.file_names().flatten().map(Into::into).collect();
    let mut array = |name: &'static str| Array::read(&mut archive, name, bytes.len());
    let header = array("header")?.strings()?.swap_remove(0);
    let header = Header::from_json(&header)?;
    let count = header.joints.len();
    let joints = || header.joints.iter();
    let as_header = |is_same: bool, name: &str| match is_same {
        true => Ok(()),
        false => Err(invalid(format!("`{name}` differs from the header"))),
    };
    as_header(
        array("names")?.strings()?.iter().eq(joints().map(|joint| &joint.name)),
        "names",
    )?;
    let parents = array("parents")?.integers(count)?;
    let expected = joints().map(|joint| joint.parent.map_or(Ok(-1), i32::try_from));
    as_header(parents.into_iter().map(Ok).eq(expected), "parents")?;
    let end_sites = array("end_sites")?.bools(count)?;
    as_header(
        end_sites.into_iter().eq(joints().map(|joint| joint.end_site)),
        "end_sites",
    )?;
    let orders = array("rotation_orders")?.strings()?;
    let expected = joints().map(|joint| joint.rotation_order.as_deref().unwrap_or_default());
    as_header(orders.iter().map(String::as_str).eq(expected), "rotation_orders")?;
    let offsets = array("offsets")?.floats(&[count, 3])?;
    as_header(
        offsets.into_iter().eq(joints().flat_map(|joint| joint.offset)),
        "offsets",
    )?;
    // The header's decimal digits may be parsed as a neighbouring number.
    let rate = array("frame_rate")?.number()?;
    as_header((rate - header.frame_rate).abs() <= 1e-12 * rate.abs(), "frame_rate")?;
    let positions = array("positions")?;
    let frames = positions.shape.first().copied().unwrap_or_default();
    let positions = positions.floats(&[frames, count, 3])?;
    let rotations = array("rotations")?;
    let rotations = match header.rotation {
        Rotation::Matrix => rotations.floats(&[frames, count, 3, 3])?,
        other => rotations.floats(&[frames, count, other.width()])?,
    };
    let has = |name: &str| names.iter().any(|own| own == name);
    let velocities = match has("velocities.npy") {
        true => Some(array("velocities")?.floats(&[frames, count, 3])?),
        false => None,
    };
    if has("contacts.npy") {
        array("contacts")?.values::<1>("|b1", &[frames, count])?;
    }
    Ok(ArrayFile {
        header,
        frames,
        positions,
        rotations,
        velocities,
    })
}

impl Array {
    /// `most_bytes` is the length of the archive, which is not compressed.
    fn read(archive: &mut ZipArchive<Cursor<&[u8]>>, name: &'static str, most_bytes: usize) -> Result<Self> {
        let file = archive
            .by_name(&format!("{name}.npy"))
            .map_err(|error| invalid(format!("there is no array `{name}`: {error}")))?;
        let mut bytes = Vec::new();
        // A length in the archive may be wrong.
        let read = file.take(most_bytes as u64).read_to_end(&mut bytes);
        read.map_err(|error| invalid(format!("the array `{name}` cannot be read: {error}")))?;
        let broken = || invalid(format!("the array `{name}` has no NumPy header"));
        let rest = bytes.strip_prefix(b"\x93NUMPY").ok_or_else(broken)?;
        // A version in two bytes, then the length of the header: two bytes in version 1, four bytes from version 2.
        let (length, start) = match *rest {
            [1, 0, a, b, ..] => (usize::from(u16::from_le_bytes([a, b])), 4),
            [2 | 3, 0, a, b, c, d, ..] => (u32::from_le_bytes([a, b, c, d]) as usize, 6),
            _ => return Err(broken()),
        };
        let literal = rest
            .get(start..)
            .and_then(|rest| rest.get(..length))
            .ok_or_else(broken)?;
        let literal = std::str::from_utf8(literal).map_err(|_| broken())?;
        let dtype = between(literal, "'descr':", "'", "'").ok_or_else(broken)?.to_owned();
        let is_in_c_order = literal
            .split("'fortran_order':")
            .nth(1)
            .map(|rest| rest.trim_start().starts_with("False"));
        if is_in_c_order != Some(true) {
            return Err(invalid(format!("the array `{name}` is not in C order")));
        }
        let shape = between(literal, "'shape':", "(", ")").ok_or_else(broken)?;
        let axes = shape.split(',').map(str::trim).filter(|axis| !axis.is_empty());
        let shape = axes
            .map(str::parse)
            .collect::<Result<Vec<usize>, _>>()
            .map_err(|_| broken())?;
        let bytes = rest[start + length..].to_vec();
        Ok(Self {
            name,
            dtype,
            shape,
            bytes,
        })
    }

    fn wrong(&self, expected: &str) -> Error {
        let found = format!("{} of shape {:?}, {} bytes", self.dtype, self.shape, self.bytes.len());
        let message = format!("the array `{}` has an unexpected type or shape", self.name);
        let diagnostic = Diagnostic::new(Code::InvalidArrays, message).expected_found(expected, found);
        diagnostic.help(HELP).into()
    }

    /// The values, `N` bytes each, of this type and shape.
    fn values<const N: usize>(&self, dtype: &str, shape: &[usize]) -> Result<&[[u8; N]]> {
        let expected = || self.wrong(&format!("{dtype} of shape {shape:?}"));
        let (values, rest) = self.bytes.as_chunks::<N>();
        let count = shape.iter().try_fold(1_usize, |count, axis| count.checked_mul(*axis));
        let fits = self.dtype == dtype && self.shape == shape && rest.is_empty() && count == Some(values.len());
        if fits { Ok(values) } else { Err(expected()) }
    }

    fn floats(&self, shape: &[usize]) -> Result<Vec<f32>> {
        let values = self.values("<f4", shape)?;
        Ok(values.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect())
    }

    fn integers(&self, count: usize) -> Result<Vec<i32>> {
        let values = self.values("<i4", &[count])?;
        Ok(values.iter().map(|bytes| i32::from_le_bytes(*bytes)).collect())
    }

    fn bools(&self, count: usize) -> Result<Vec<bool>> {
        let values = self.values("|b1", &[count])?;
        Ok(values.iter().map(|[byte]| *byte != 0).collect())
    }

    fn number(&self) -> Result<f64> {
        let values = self.values("<f8", &[])?;
        values
            .first()
            .map(|bytes| f64::from_le_bytes(*bytes))
            .ok_or_else(|| self.wrong("a number"))
    }

    /// Strings of the dtype `<U` with a length: four bytes per character, padded with zeros. Never empty for a scalar.
    fn strings(&self) -> Result<Vec<String>> {
        let wrong = || self.wrong("strings");
        let length: usize = self
            .dtype
            .strip_prefix("<U")
            .and_then(|length| length.parse().ok())
            .ok_or_else(wrong)?;
        let count = match *self.shape {
            [] => 1,
            [count] => count,
            _ => return Err(wrong()),
        };
        let text_bytes = length.checked_mul(4).filter(|bytes| *bytes > 0).ok_or_else(wrong)?;
        if text_bytes.checked_mul(count) != Some(self.bytes.len()) {
            return Err(wrong());
        }
        let text = |bytes: &[u8]| {
            let (characters, _) = bytes.as_chunks::<4>();
            let characters = characters.iter().map(|bytes| u32::from_le_bytes(*bytes));
            let characters = characters.map(|code| char::from_u32(code).unwrap_or(char::REPLACEMENT_CHARACTER));
            let text: String = characters.collect();
            text.trim_end_matches('\0').to_owned()
        };
        Ok(self.bytes.chunks(text_bytes).map(text).collect())
    }
}

/// The text between `open` and `close` after `key`.
fn between<'a>(text: &'a str, key: &str, open: &str, close: &str) -> Option<&'a str> {
    let (_, rest) = text.split_once(key)?;
    let (_, rest) = rest.split_once(open)?;
    Some(rest.split_once(close)?.0)
}
