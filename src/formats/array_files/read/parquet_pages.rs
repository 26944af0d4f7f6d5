//! Checks the claims of a Parquet file's pages against the file before any page is decoded. The Parquet library
//! allocates as much memory as a page header claims, up to 2 GiB.
//!
//! Headers are structs of Thrift's compact protocol, before each page of a column.

use mocap_scene::error::{Code, Diagnostic};
use parquet::basic::{Compression, Type};
use parquet::file::metadata::{ColumnChunkMetaData, ParquetMetaData, RowGroupMetaData};

use crate::Failure;

/// The largest expansion of one byte by Snappy: a copy of three bytes stands for 64.
const MOST_INFLATED: u64 = 22;

/// The number of bytes that any page may have, however few compressed bytes it has.
const ANY: u64 = 64;

/// Encodings with dictionary indices: PLAIN_DICTIONARY and RLE_DICTIONARY.
const BY_DICTIONARY: [i64; 2] = [2, 8];

/// The largest nesting depth of structs in a header.
const MOST_DEEP: usize = 8;

fn damaged(column: &ColumnChunkMetaData, what: &str) -> Failure {
    let message = format!("the column {} of the Parquet file {what}", column.column_path());
    Box::new(
        Diagnostic::new(Code::UnexpectedEnd, message)
            .help("the file is cut off or damaged: write or download it again"),
    )
}

/// Refuses columns whose pages are beyond the file, are longer than their bytes can be, or have more than `most_values`
/// values in total. Returns the bytes of the longest text dictionary, because any number of rows can have its longest
/// text.
pub(super) fn check(bytes: &[u8], metadata: &ParquetMetaData, most_values: u64) -> Result<u64, Failure> {
    let (mut values, mut longest) = (0_u64, 0);
    for column in metadata.row_groups().iter().flat_map(RowGroupMetaData::columns) {
        let (of_column, dictionary) = check_column(bytes, column)?;
        values = values.saturating_add(of_column);
        if column.column_type() == Type::BYTE_ARRAY {
            longest = longest.max(dictionary);
        }
        if values > most_values {
            return Err(Box::new(mocap_scene::limits::limit_exceeded(
                format!("at most {most_values} values"),
                format!("{values} or more"),
            )));
        }
    }
    Ok(longest)
}

/// The number of values that the pages of a column claim, and the bytes of its dictionary.
fn check_column(bytes: &[u8], column: &ColumnChunkMetaData) -> Result<(u64, u64), Failure> {
    let is_snappy = match column.compression() {
        Compression::UNCOMPRESSED => false,
        Compression::SNAPPY => true,
        other => {
            let message = format!("the column {} is compressed by {other}", column.column_path());
            return Err(Box::new(
                Diagnostic::new(Code::UnreadableFormat, message)
                    .expected_found("SNAPPY, or no compression", other.to_string())
                    .help("write it with compression=\"snappy\""),
            ));
        }
    };
    let first = column
        .dictionary_page_offset()
        .unwrap_or(i64::MAX)
        .min(column.data_page_offset());
    let range = usize::try_from(first)
        .ok()
        .zip(usize::try_from(column.compressed_size()).ok())
        .and_then(|(first, length)| bytes.get(first..first.checked_add(length)?));
    let mut rest = range.ok_or_else(|| damaged(column, "ends beyond it"))?;
    let (mut values, mut dictionary, mut has_dictionary) = (0_u64, 0, false);
    while !rest.is_empty() {
        let mut thrift = Thrift { bytes: rest };
        let header = thrift
            .page()
            .ok_or_else(|| damaged(column, "has a page without a header"))?;
        let (compressed, inflated) = (header.compressed, header.inflated);
        let page = usize::try_from(compressed)
            .ok()
            .and_then(|length| thrift.bytes.split_at_checked(length));
        let (page, after) = page.ok_or_else(|| damaged(column, "has a page that ends beyond it"))?;
        let most = match is_snappy {
            true => (page.len() as u64).saturating_mul(MOST_INFLATED).saturating_add(ANY),
            false => page.len() as u64,
        };
        if inflated.is_none_or(|inflated| inflated > most) {
            return Err(damaged(
                column,
                "has a page that states more bytes than it can decompress to",
            ));
        }
        // A dictionary has each value once.
        if header.is_dictionary && header.values > most {
            return Err(damaged(column, "has a dictionary with more values than bytes"));
        }
        if header.is_dictionary {
            dictionary = inflated.unwrap_or_default().max(dictionary);
        }
        has_dictionary |= header.is_dictionary;
        if BY_DICTIONARY.contains(&header.encoding) && !header.is_dictionary && !has_dictionary {
            return Err(damaged(column, "has values that refer to a missing dictionary"));
        }
        values = values.saturating_add(header.values);
        rest = after;
    }
    Ok((values, dictionary))
}

/// The fields of a page header that are needed.
#[derive(Default)]
struct PageHeader {
    inflated: Option<u64>,
    compressed: i64,
    values: u64,
    is_dictionary: bool,
    encoding: i64,
}

/// The remaining bytes of Thrift's compact protocol.
struct Thrift<'a> {
    bytes: &'a [u8],
}

impl<'a> Thrift<'a> {
    fn page(&mut self) -> Option<PageHeader> {
        let mut header = PageHeader::default();
        let mut field = 0;
        while let Some((id, kind)) = self.field(&mut field)? {
            match (id, kind) {
                (2, INT32) => header.inflated = u64::try_from(self.signed()?).ok(),
                (3, INT32) => header.compressed = self.signed()?,
                // The fields with the headers of a data page, of a dictionary page, and of a data page version 2.
                (5 | 7 | 8, STRUCT) => {
                    header.is_dictionary |= id == 7;
                    // The field of the encoding in each of these headers.
                    let encoding = if id == 8 { 4 } else { 2 };
                    let mut inner = 0;
                    while let Some((id, kind)) = self.field(&mut inner)? {
                        match (id, kind) {
                            (1, INT32) => header.values = u64::try_from(self.signed()?).ok()?,
                            (id, INT32) if id == encoding => header.encoding = self.signed()?,
                            _ => self.skip(kind, MOST_DEEP)?,
                        }
                    }
                }
                _ => self.skip(kind, MOST_DEEP)?,
            }
        }
        Some(header)
    }

    /// The number and the type of the next field; no field at the end of a struct.
    fn field(&mut self, last: &mut i64) -> Option<Option<(i64, u8)>> {
        let byte = self.byte()?;
        if byte == 0 {
            return Some(None);
        }
        *last = match byte >> 4 {
            0 => self.signed()?,
            delta => *last + i64::from(delta),
        };
        Some(Some((*last, byte & 15)))
    }

    fn byte(&mut self) -> Option<u8> {
        let (byte, rest) = self.bytes.split_first()?;
        self.bytes = rest;
        Some(*byte)
    }

    fn unsigned(&mut self) -> Option<u64> {
        let mut value = 0_u64;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            value |= u64::from(byte & 127) << shift;
            if byte < 128 {
                return Some(value);
            }
        }
        None
    }

    /// A zigzag-encoded number: the last bit is the sign.
    fn signed(&mut self) -> Option<i64> {
        let value = self.unsigned()?;
        Some((value >> 1) as i64 ^ -((value & 1) as i64))
    }

    fn take(&mut self, length: u64) -> Option<()> {
        self.bytes = self.bytes.get(usize::try_from(length).ok()?..)?;
        Some(())
    }

    /// Skips a value. No list has more elements than remaining bytes.
    fn skip(&mut self, kind: u8, deep: usize) -> Option<()> {
        let deep = deep.checked_sub(1)?;
        match kind {
            TRUE | FALSE => Some(()),
            BYTE => self.take(1),
            INT16 | INT32 | INT64 => self.unsigned().map(drop),
            DOUBLE => self.take(8),
            BINARY => {
                let length = self.unsigned()?;
                self.take(length)
            }
            LIST | SET => {
                let byte = self.byte()?;
                let count = match byte >> 4 {
                    15 => self.unsigned()?,
                    count => u64::from(count),
                };
                // A boolean in a list is a byte.
                let element = if matches!(byte & 15, TRUE | FALSE) {
                    BYTE
                } else {
                    byte & 15
                };
                (count <= self.bytes.len() as u64).then_some(())?;
                (0..count).try_for_each(|_| self.skip(element, deep))
            }
            STRUCT => {
                let mut field = 0;
                while let Some((_, kind)) = self.field(&mut field)? {
                    self.skip(kind, deep)?;
                }
                Some(())
            }
            _ => None,
        }
    }
}

const TRUE: u8 = 1;
const FALSE: u8 = 2;
const BYTE: u8 = 3;
const INT16: u8 = 4;
const INT32: u8 = 5;
const INT64: u8 = 6;
const DOUBLE: u8 = 7;
const BINARY: u8 = 8;
const LIST: u8 = 9;
const SET: u8 = 10;
const STRUCT: u8 = 12;
