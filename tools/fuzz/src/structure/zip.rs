//! Changes within the entries of an archive, with correct checksums: a reader refuses an entry with a wrong checksum
//! before it reads the content.

use fastrand::Rng;
use miniz_oxide::inflate::decompress_to_vec_with_limit;

use super::{float, number};

/// The largest size of an entry after decompression, in bytes.
const LARGEST: usize = 1 << 20;
/// The compression method of an entry: stored or deflated.
const STORED: usize = 0;
const DEFLATED: usize = 8;
/// The sizes of the headers in `APPNOTE.TXT`, 4.3.7 and 4.3.12, before the name of an entry.
const LOCAL: usize = 30;
const RECORD: usize = 46;
/// The size of the text with type and shape in a NumPy header, in bytes.
const NUMPY_HEADER: usize = 128;

struct Entry {
    name: Vec<u8>,
    data: Vec<u8>,
}

/// The archive with one to three changed entries; all entries are stored without compression.
pub(super) fn mutate(bytes: &[u8], random: &mut Rng) -> Option<Vec<u8>> {
    let mut entries = entries(bytes)?;
    for _ in 0..random.usize(1..4) {
        let entry = random.usize(..entries.len());
        change(&mut entries[entry].data, random)?;
    }
    // Removes or repeats arrays.
    match random.u8(..16) {
        0 => drop(entries.swap_remove(random.usize(..entries.len()))),
        1 => {
            let (from, to) = (random.usize(..entries.len()), random.usize(..entries.len()));
            entries[to].data = entries[from].data.clone();
        }
        _ => {}
    }
    Some(archive(&entries))
}

fn change(data: &mut [u8], random: &mut Rng) -> Option<()> {
    // Numbers follow the header of an array, at multiples of their size.
    let numbers = data.len().saturating_sub(NUMPY_HEADER);
    let mut put = |at: usize, value: &[u8]| {
        let place = data.get_mut(NUMPY_HEADER + at..)?.get_mut(..value.len())?;
        place.copy_from_slice(value);
        Some(())
    };
    let single = 4 * random.usize(..(numbers / 4).max(1));
    let double = 8 * random.usize(..(numbers / 8).max(1));
    match random.u8(..6) {
        // Small numbers, which no reader refuses at once.
        0 => put(single, &(random.f32() * 4.0 - 2.0).to_le_bytes())?,
        1 => put(double, &(random.f64() * 4.0 - 2.0).to_le_bytes())?,
        2 => put(single, &float(random).to_le_bytes())?,
        3 => put(double, &f64::from(float(random)).to_le_bytes())?,
        4 => put(double, &number(double as u64, random).to_le_bytes())?,
        // A digit of the shape or of the type.
        _ => {
            let header = data.get(..data.len().min(NUMPY_HEADER))?;
            let digits: Vec<usize> = (0..header.len()).filter(|at| header[*at].is_ascii_digit()).collect();
            let digit = *digits.get(random.usize(..digits.len().max(1)))?;
            data[digit] = b'0' + random.u8(..10);
        }
    }
    Some(())
}

/// The entries of the directory; `None` if there are no entries, or if an entry cannot be read.
fn entries(bytes: &[u8]) -> Option<Vec<Entry>> {
    let short = |at: usize| Some(u16::from_le_bytes(*bytes.get(at..at + 2)?.first_chunk()?) as usize);
    let long = |at: usize| Some(u32::from_le_bytes(*bytes.get(at..at + 4)?.first_chunk()?) as usize);
    let entry = |record: usize| {
        let (method, length, local) = (short(record + 10)?, long(record + 20)?, long(record + 42)?);
        let name = bytes.get(record + RECORD..)?.get(..short(record + 28)?)?;
        let begin = local + LOCAL + short(local + 26)? + short(local + 28)?;
        let data = bytes.get(begin..begin.checked_add(length)?)?;
        let data = match method {
            STORED => data.to_vec(),
            DEFLATED => decompress_to_vec_with_limit(data, LARGEST).ok()?,
            _ => return None,
        };
        Some(Entry {
            name: name.to_vec(),
            data,
        })
    };
    let records = bytes.windows(4).enumerate().filter(|(_, mark)| *mark == b"PK\x01\x02");
    let entries: Vec<Entry> = records.map(|(record, _)| entry(record)).collect::<Option<_>>()?;
    (!entries.is_empty()).then_some(entries)
}

/// An archive of stored entries.
fn archive(entries: &[Entry]) -> Vec<u8> {
    let (mut bytes, mut directory) = (Vec::new(), Vec::new());
    for Entry { name, data } in entries {
        let (begin, length) = (bytes.len() as u32, data.len() as u32);
        // Version 2.0, no flags, stored, no time.
        let mut common = vec![20, 0, 0, 0, STORED as u8, 0, 0, 0, 0, 0];
        common.extend(check_sum(data).to_le_bytes());
        common.extend([length.to_le_bytes(), length.to_le_bytes()].concat());
        common.extend((name.len() as u16).to_le_bytes());
        common.extend([0; 2]);
        bytes.extend_from_slice(b"PK\x03\x04");
        bytes.extend_from_slice(&common);
        bytes.extend_from_slice(name);
        bytes.extend_from_slice(data);
        directory.extend_from_slice(b"PK\x01\x02\x14\0");
        directory.extend_from_slice(&common);
        directory.extend([0; 10]);
        directory.extend(begin.to_le_bytes());
        directory.extend_from_slice(name);
    }
    let begin = bytes.len() as u32;
    let count = (entries.len() as u16).to_le_bytes();
    bytes.extend_from_slice(&directory);
    bytes.extend_from_slice(b"PK\x05\x06\0\0\0\0");
    bytes.extend([count, count].concat());
    bytes.extend((directory.len() as u32).to_le_bytes());
    bytes.extend(begin.to_le_bytes());
    bytes.extend([0; 2]);
    bytes
}

/// CRC-32 of ISO 3309, the checksum of an entry.
fn check_sum(bytes: &[u8]) -> u32 {
    const POLYNOMIAL: u32 = 0xedb8_8320;
    !bytes.iter().fold(!0_u32, |sum, byte| {
        (0..8).fold(sum ^ u32::from(*byte), |sum, _| match sum & 1 {
            1 => (sum >> 1) ^ POLYNOMIAL,
            _ => sum >> 1,
        })
    })
}
