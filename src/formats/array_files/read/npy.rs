//! NumPy's `.npy`: `numpy.lib.format`, versions 1 to 3. The file has a magic text, the length of the header, a Python
//! literal, and then the elements.

use mocap_scene::error::{Code, Diagnostic};

use super::ndarray::{Bytes, Kind, NdArray};
use crate::Failure;
use crate::array_files::NPY_HEAD;

/// The largest number of axes, as in NumPy.
const MOST_AXES: usize = 64;

/// The contents of an `.npy` file.
pub(super) enum Npy<'a> {
    Array(NdArray<'a>),
    /// Python objects: a pickle, starting at this byte.
    Objects(usize),
}

/// The array of an `.npy`. `entry` is the name of the array in errors.
pub(super) fn read<'a>(bytes: &Bytes<'a>, entry: &str) -> Result<Npy<'a>, Failure> {
    let refused = |expected: &str, found: String| -> Failure {
        Box::new(
            Diagnostic::new(
                Code::UnexpectedToken,
                format!("the header of the array {entry} is not NumPy's"),
            )
            .expected_found(expected, found)
            .help("write it with numpy.save or numpy.savez"),
        )
    };
    let (Some(&version), true) = (bytes.get(NPY_HEAD.len()), bytes.starts_with(NPY_HEAD)) else {
        return Err(refused(
            "the bytes \\x93NUMPY",
            format!("{} bytes with another beginning", bytes.len()),
        ));
    };
    let at = NPY_HEAD.len() + 2;
    let (length, begin) = match (version, bytes.get(at..at + 2), bytes.get(at..at + 4)) {
        (1, Some(&[a, b]), _) => (usize::from(u16::from_le_bytes([a, b])), at + 2),
        (2 | 3, _, Some(&[a, b, c, d])) => (u32::from_le_bytes([a, b, c, d]) as usize, at + 4),
        _ => return Err(refused("version 1, 2 or 3", format!("version {version}"))),
    };
    let header = bytes.get(begin..begin.saturating_add(length));
    let header = header.and_then(|header| std::str::from_utf8(header).ok());
    let Some(header) = header else {
        return Err(refused("a header of text", format!("{length} bytes that are not text")));
    };
    let shown = || header.trim_end().chars().take(100).collect::<String>();
    let Some((descr, is_fortran, shape)) = parse(header) else {
        return Err(refused("{'descr': ..., 'fortran_order': ..., 'shape': (...)}", shown()));
    };
    let (order, letters) = descr.split_at_checked(1).unwrap_or_default();
    if letters == "O" {
        return Ok(Npy::Objects(begin + length));
    }
    let Some(kind) = Kind::of_numpy(letters) else {
        return Err(refused(
            "numbers, truth values or strings",
            format!("the type '{descr}'"),
        ));
    };
    NdArray::new(
        entry,
        (kind, order == ">"),
        shape,
        is_fortran,
        bytes.after(begin + length),
    )
    .map(Npy::Array)
}

/// The element type, whether the order is Fortran's, and the shape, from the text of a header.
fn parse(header: &str) -> Option<(&str, bool, Vec<usize>)> {
    let value = |key: &str| {
        let (_, rest) = header.split_once(&format!("'{key}':"))?;
        Some(rest.trim_start())
    };
    let descr = value("descr")?;
    let quote = descr.chars().next().filter(|quote| matches!(quote, '\'' | '"'))?;
    let descr = descr[1..].split(quote).next()?;
    let is_fortran = value("fortran_order")?.starts_with("True");
    let shape = value("shape")?.strip_prefix('(')?;
    let (shape, _) = shape.split_once(')')?;
    let axes = shape.split(',').map(str::trim).filter(|axis| !axis.is_empty());
    let shape: Vec<usize> = axes
        .map(|axis| axis.trim_end_matches('L').parse().ok())
        .collect::<Option<_>>()?;
    (shape.len() <= MOST_AXES).then_some((descr, is_fortran, shape))
}
