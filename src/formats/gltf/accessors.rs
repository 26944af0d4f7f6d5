//! Reads the numbers of a file. Every count, offset and stride is checked against the available bytes, and against a
//! budget before anything is allocated.

use std::borrow::Cow;
use std::cell::Cell;
use std::collections::HashMap;

use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::limits::Limits;

use super::invalid::{invalid, missing};
use super::json::{Accessor, Root, SparsePart};
use crate::Failure;

/// The bytes that animations need, and the budget for their values.
pub(super) struct Bytes<'a> {
    /// The file's buffers; `None` for buffers that no animation needs.
    pub(super) buffers: Vec<Option<Cow<'a, [u8]>>>,
    /// The contents of the compressed views, by index.
    pub(super) views: HashMap<usize, Vec<u8>>,
    pub(super) budget: Budget,
}

/// The number of values that may still be read. Accessors may share bytes, and an accessor without bytes has zeros. So
/// the size of a file alone does not bound the values.
pub(super) struct Budget {
    most: u64,
    left: Cell<u64>,
}

impl Budget {
    /// The budget for a file of `bytes` bytes, of which `streams` bytes are compressed.
    pub(super) fn new(limits: &Limits, bytes: u64, streams: u64) -> Self {
        const ANY_FILE: u64 = 4 << 20;
        /// The values allowed per byte. Each track of sixty joints may share its bytes with a few others, and a value
        /// may take one byte.
        const PER_BYTE: u64 = 16;
        /// The values allowed per byte of a stream. A stream of static values has hardly any bytes.
        const PER_STREAM_BYTE: u64 = 256;
        let grown = PER_BYTE
            .saturating_mul(bytes)
            .saturating_add(PER_STREAM_BYTE.saturating_mul(streams));
        let most = limits.max_values.min(ANY_FILE.saturating_add(grown));
        Self {
            most,
            left: Cell::new(most),
        }
    }

    /// Takes `values` from the budget.
    pub(super) fn take(&self, values: u64, pointer: &str) -> Result<(), Failure> {
        let Some(left) = self.left.get().checked_sub(values) else {
            let message = "the animations have more values than the limits allow";
            return Err(Diagnostic::new(Code::LimitExceeded, message)
                .at_pointer(pointer)
                .expected_found(
                    format!("at most {} values in a file of this size", self.most),
                    format!("{values} more than {}", self.most - self.left.get()),
                )
                .into());
        };
        self.left.set(left);
        Ok(())
    }
}

/// A component type of an accessor, glTF's `componentType`.
#[derive(Clone, Copy)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn of(code: u32, pointer: &str) -> Result<Self, Failure> {
        Ok(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => {
                return Err(
                    invalid(format!("{pointer}/componentType"), "glTF has no such component type")
                        .expected_found("5120 to 5123, 5125 or 5126", format!("{code}"))
                        .into(),
                );
            }
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// The number in the bytes of one component.
    fn number(self, b: &[u8], normalized: bool) -> f32 {
        // Normalized integers follow the equations of the specification.
        let integer = |value: f32, most: f32| if normalized { (value / most).max(-1.0) } else { value };
        match self {
            Self::I8 => integer(f32::from(b[0] as i8), 127.0),
            Self::U8 => integer(f32::from(b[0]), 255.0),
            Self::I16 => integer(f32::from(i16::from_le_bytes([b[0], b[1]])), 32767.0),
            Self::U16 => integer(f32::from(u16::from_le_bytes([b[0], b[1]])), 65535.0),
            Self::U32 => u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as f32,
            Self::F32 => f32::from_le_bytes([b[0], b[1], b[2], b[3]]),
        }
    }

    fn index(self, b: &[u8]) -> Option<usize> {
        match self {
            Self::U8 => Some(usize::from(b[0])),
            Self::U16 => Some(usize::from(u16::from_le_bytes([b[0], b[1]]))),
            Self::U32 => Some(u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize),
            _ => None,
        }
    }
}

/// The numbers of an accessor with `columns` components. `pointer` is the JSON pointer to the index of the accessor.
pub(super) fn numbers(
    root: &Root,
    bytes: &Bytes<'_>,
    index: usize,
    columns: usize,
    pointer: &str,
) -> Result<Vec<f32>, Failure> {
    let accessor = root
        .accessors
        .get(index)
        .ok_or_else(|| missing(pointer, "accessor", index, root.accessors.len()))?;
    let pointer = format!("/accessors/{index}");
    let wanted = match columns {
        1 => "SCALAR",
        2 => "VEC2",
        3 => "VEC3",
        16 => "MAT4",
        _ => "VEC4",
    };
    if accessor.shape != wanted {
        return Err(
            invalid(format!("{pointer}/type"), "an animation needs a different type here")
                .expected_found(wanted, format!("\"{}\"", accessor.shape))
                .into(),
        );
    }
    let component = Component::of(accessor.component_type, &pointer)?;
    bytes.budget.take(
        (accessor.count as u64).saturating_mul(columns as u64),
        &format!("{pointer}/count"),
    )?;
    let size = columns * component.size();
    let mut numbers = match accessor.buffer_view {
        None => vec![0.0; accessor.count * columns],
        Some(view) => {
            let rows = rows(root, bytes, view, accessor.byte_offset, accessor.count, size, &pointer)?;
            rows.flat_map(|row| {
                row.chunks_exact(component.size())
                    .map(|b| component.number(b, accessor.normalized))
            })
            .collect()
        }
    };
    if let Some(sparse) = &accessor.sparse {
        let pointer = format!("{pointer}/sparse");
        if sparse.count > accessor.count {
            return Err(invalid(
                format!("{pointer}/count"),
                "a sparse accessor replaces more values than the accessor has",
            )
            .expected_found(format!("at most {}", accessor.count), format!("{}", sparse.count))
            .into());
        }
        replace(root, bytes, accessor, columns, component, &pointer, &mut numbers)?;
    }
    Ok(numbers)
}

/// The indices of a scalar accessor: the corners of faces.
pub(super) fn indices(root: &Root, bytes: &Bytes<'_>, index: usize, pointer: &str) -> Result<Vec<u32>, Failure> {
    let accessor = root
        .accessors
        .get(index)
        .ok_or_else(|| missing(pointer, "accessor", index, root.accessors.len()))?;
    let pointer = format!("/accessors/{index}");
    let component = Component::of(accessor.component_type, &pointer)?;
    let view = accessor.buffer_view.filter(|_| accessor.sparse.is_none());
    let Some(view) = view.filter(|_| accessor.shape == "SCALAR" && component.index(&[0; 4]).is_some()) else {
        return Err(invalid(pointer, "indices must be unsigned integers in a buffer view").into());
    };
    bytes.budget.take(accessor.count as u64, &format!("{pointer}/count"))?;
    let rows = rows(
        root,
        bytes,
        view,
        accessor.byte_offset,
        accessor.count,
        component.size(),
        &pointer,
    )?;
    Ok(rows
        .map(|row| component.index(row).unwrap_or_default() as u32)
        .collect())
}

/// Replaces values of an accessor by the values that its sparse part states.
fn replace(
    root: &Root,
    bytes: &Bytes<'_>,
    accessor: &Accessor,
    columns: usize,
    component: Component,
    pointer: &str,
    numbers: &mut [f32],
) -> Result<(), Failure> {
    let Some(sparse) = &accessor.sparse else { return Ok(()) };
    let part = |name: &str, part: &SparsePart, size: usize| {
        let pointer = format!("{pointer}/{name}");
        rows(
            root,
            bytes,
            part.buffer_view,
            part.byte_offset,
            sparse.count,
            size,
            &pointer,
        )
        .map(|rows| rows.map(<[u8]>::to_vec).collect::<Vec<_>>())
    };
    let at = format!("{pointer}/indices/componentType");
    let kind = Component::of(
        sparse.indices.component_type.unwrap_or_default(),
        &format!("{pointer}/indices"),
    )?;
    let indices = part("indices", &sparse.indices, kind.size())?;
    let values = part("values", &sparse.values, columns * component.size())?;
    for (index, value) in std::iter::zip(indices, values) {
        let index = kind
            .index(&index)
            .ok_or_else(|| invalid(&*at, "indices must be unsigned integers"))?;
        let row = numbers
            .chunks_exact_mut(columns)
            .nth(index)
            .ok_or_else(|| missing(format!("{pointer}/indices"), "value", index, accessor.count))?;
        for (number, b) in std::iter::zip(row, value.chunks_exact(component.size())) {
            *number = component.number(b, accessor.normalized);
        }
    }
    Ok(())
}

/// The `count` elements of `size` bytes of a view, starting at `offset`.
fn rows<'a>(
    root: &Root,
    bytes: &'a Bytes<'_>,
    index: usize,
    offset: usize,
    count: usize,
    size: usize,
    pointer: &str,
) -> Result<impl Iterator<Item = &'a [u8]> + use<'a>, Failure> {
    let view = root.buffer_views.get(index).ok_or_else(|| {
        missing(
            format!("{pointer}/bufferView"),
            "buffer view",
            index,
            root.buffer_views.len(),
        )
    })?;
    let contents = match bytes.views.get(&index) {
        Some(decoded) => decoded.as_slice(),
        None => {
            let buffer = bytes.buffers.get(view.buffer).and_then(|buffer| buffer.as_deref());
            let buffer = buffer.ok_or_else(|| {
                missing(
                    format!("/bufferViews/{index}/buffer"),
                    "buffer",
                    view.buffer,
                    root.buffers.len(),
                )
            })?;
            view.byte_offset
                .checked_add(view.byte_length)
                .and_then(|end| buffer.get(view.byte_offset..end))
                .ok_or_else(|| {
                    invalid(format!("/bufferViews/{index}"), "the view reaches beyond its buffer").expected_found(
                        format!("at most {} bytes", buffer.len()),
                        format!("{} bytes from byte {}", view.byte_length, view.byte_offset),
                    )
                })?
        }
    };
    let stride = view.byte_stride.unwrap_or(size);
    if stride < size {
        return Err(invalid(
            format!("/bufferViews/{index}/byteStride"),
            format!("the stride is shorter than the elements that {pointer} reads with it"),
        )
        .expected_found(format!("at least {size}"), format!("{stride}"))
        .into());
    }
    let length = match count.checked_sub(1) {
        Some(rows) => rows.checked_mul(stride).and_then(|length| length.checked_add(size)),
        None => Some(0),
    };
    let wanted = length
        .and_then(|length| length.checked_add(offset))
        .and_then(|end| contents.get(offset..end))
        .ok_or_else(|| {
            invalid(pointer, "the elements reach beyond their view").expected_found(
                format!("at most {} bytes", contents.len()),
                format!("{count} elements of {size} bytes, {stride} apart, from byte {offset}"),
            )
        })?;
    Ok(wanted.chunks(stride).map(move |row| &row[..size]))
}
