//! The zlib streams of written FBX files, decoded by an inflate that shares nothing with the encoder.
//!
//! ufbx before 0.21, and with it the built-in importer of Blender 5.0, reads the code lengths of literals and of
//! distances as two lists. The format has one list, in which a run of equal lengths may continue from the literals to
//! the distances.

use std::fs;

use crate::fbx_out::fixtures;
use mocap::fbx::FbxOptions;

/// The bits of a stream, beginning with the lowest bit of each byte.
struct Bits<'a> {
    bytes: &'a [u8],
    next: usize,
}

/// A Huffman code: the symbols of each length, beginning with one bit.
struct Code([Vec<usize>; 15]);

impl Code {
    /// `lengths` has the number of bits of each symbol; 0 for an unused symbol.
    fn of(lengths: &[u8]) -> Self {
        let of_length =
            |length: usize| (0..lengths.len()).filter(move |&symbol| usize::from(lengths[symbol]) == length);
        Self(std::array::from_fn(|index| of_length(index + 1).collect()))
    }
}

/// RFC 1951, 3.2.5: the extra bits of lengths and of distances.
const LENGTH_BITS: [u32; 29] = [
    0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3, 4, 4, 4, 4, 5, 5, 5, 5, 0,
];
/// RFC 1951, 3.2.7: the order of the lengths of the code for code lengths.
const ORDER: [usize; 19] = [16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15];
/// The bytes before the first element of an FBX file.
const HEADER: usize = 27;
const END_OF_BLOCK: usize = 256;

impl Bits<'_> {
    fn bit(&mut self) -> usize {
        let bit = self.bytes[self.next / 8] >> (self.next % 8) & 1;
        self.next += 1;
        bit.into()
    }

    fn take(&mut self, count: u32) -> usize {
        (0..count).map(|index| self.bit() << index).sum()
    }

    /// RFC 1951, 3.2.2: codes of one length are consecutive, in the order of their symbols.
    fn symbol(&mut self, Code(symbols): &Code) -> usize {
        let (mut code, mut first) = (0, 0);
        for symbols in symbols {
            code = code << 1 | self.bit();
            first <<= 1;
            match symbols.get(code - first) {
                Some(symbol) => return *symbol,
                None => first += symbols.len(),
            }
        }
        panic!("no code of 15 bits");
    }
}

/// The reason why an inflate of ufbx before 0.21 refuses a zlib stream, otherwise the number of its blocks.
fn refused(stream: &[u8]) -> Result<usize, String> {
    let mut bits = Bits {
        bytes: &stream[2..],
        next: 0,
    };
    for block in 0.. {
        let is_last = bits.bit() == 1;
        match bits.take(2) {
            0 => {
                bits.next = bits.next.next_multiple_of(8);
                let length = bits.take(16);
                bits.next += 16 + 8 * length;
            }
            1 => {
                let literals = [(144, 8), (112, 9), (24, 7), (8, 8)];
                let literals = literals.map(|(count, length)| vec![length; count]).concat();
                pass_block(&mut bits, &Code::of(&literals), &Code::of(&[5; 30]));
            }
            2 => {
                let (literals, distances) = code_lengths(&mut bits).map_err(|why| format!("block {block}: {why}"))?;
                pass_block(&mut bits, &literals, &distances);
            }
            _ => return Err(format!("block {block} is of no kind")),
        }
        if is_last {
            return Ok(block + 1);
        }
    }
    unreachable!()
}

fn code_lengths(bits: &mut Bits<'_>) -> Result<(Code, Code), String> {
    let (literals, distances, count) = (bits.take(5) + 257, bits.take(5) + 1, bits.take(4) + 4);
    let mut of_lengths = vec![0; 19];
    for &symbol in &ORDER[..count] {
        of_lengths[symbol] = bits.take(3) as u8;
    }
    let of_lengths = Code::of(&of_lengths);
    let mut lengths: Vec<u8> = Vec::new();
    while lengths.len() < literals + distances {
        let begin = lengths.len();
        let (value, run) = match bits.symbol(&of_lengths) {
            16 => (lengths[begin - 1], 3 + bits.take(2)),
            17 => (0, 3 + bits.take(3)),
            18 => (0, 11 + bits.take(7)),
            length => (length as u8, 1),
        };
        lengths.extend(vec![value; run]);
        let repeats_before = run > 1 && value != 0 && begin == literals;
        if begin < literals && lengths.len() > literals || repeats_before {
            return Err(format!(
                "a run of code lengths from {begin} to {}, of {literals} literals",
                lengths.len()
            ));
        }
    }
    let of_distances = lengths.split_off(literals);
    Ok((Code::of(&lengths), Code::of(&of_distances)))
}

fn pass_block(bits: &mut Bits<'_>, literals: &Code, distances: &Code) {
    loop {
        match bits.symbol(literals) {
            END_OF_BLOCK => return,
            symbol if symbol > END_OF_BLOCK => {
                bits.take(LENGTH_BITS[symbol - 257]);
                let distance = bits.symbol(distances) as u32;
                bits.take((distance / 2).saturating_sub(1));
            }
            _ => {}
        }
    }
}

/// The compressed arrays of the element at a byte of a binary file, and the position of the next element.
fn streams<'a>(file: &'a [u8], mut at: usize, found: &mut Vec<&'a [u8]>) -> usize {
    let int = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap()) as usize;
    let long = |at: usize| u64::from_le_bytes(file[at..at + 8].try_into().unwrap()) as usize;
    /// Later versions have offsets of 64 bits.
    const SHORT_OFFSETS: usize = 7400;
    let (end, count, width) = match int(23) <= SHORT_OFFSETS {
        true => (int(at), int(at + 4), 4),
        false => (long(at), long(at + 8), 8),
    };
    at += 3 * width + 1 + usize::from(file[at + 3 * width]);
    if end == 0 {
        return at;
    }
    for _ in 0..count {
        at += 1 + match file[at] {
            b'C' | b'B' => 1,
            b'Y' => 2,
            b'I' | b'F' => 4,
            b'D' | b'L' => 8,
            b'S' | b'R' => 4 + int(at + 1),
            _ => {
                let (is_compressed, length) = (int(at + 5) == 1, int(at + 9));
                found.extend(is_compressed.then(|| &file[at + 13..at + 13 + length]));
                12 + length
            }
        };
    }
    while at < end {
        at = streams(file, at, found);
    }
    end
}

#[test]
fn a_run_over_both_lists_of_code_lengths_is_found() {
    let stream = fs::read("../../fixtures/made/run_over_code_lengths.zlib").unwrap();
    let found = refused(&stream).unwrap_err();
    assert_eq!(found, "block 0: a run of code lengths from 271 to 276, of 275 literals");
}

#[test]
fn older_readers_take_every_stream() {
    let mut blocks = 0;
    for (path, scene) in fixtures() {
        let (file, _) = FbxOptions::new().write(&scene).unwrap();
        let (mut at, mut found) = (HEADER, Vec::new());
        while file[at..at + 8] != [0; 8] {
            at = streams(&file, at, &mut found);
        }
        for stream in found {
            blocks += refused(stream).unwrap_or_else(|why| panic!("{}: {why}", path.display()));
        }
    }
    assert!(blocks > 1000, "{blocks}");
}
