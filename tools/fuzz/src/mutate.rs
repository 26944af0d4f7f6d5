//! Random changes to a file, of the kinds that damage, exporters and attackers make.

use fastrand::Rng;

/// Changes that one input gets at most. Few, or nothing of the seed's meaning is left to break.
const MOST_CHANGES: usize = 6;

/// Inputs do not grow beyond this, or beyond their seed.
const LONGEST: usize = 64 << 10;

/// Numbers at the edges of what numbers are.
const NUMBERS: &[&str] = &[
    "0",
    "-0",
    "1",
    "-1",
    "0.0-5.0",
    "1,5",
    "1e",
    "1e5",
    "1e-46",
    "3.4e38",
    "-3.4e38",
    "1e29",
    "1e400",
    "nan",
    "-inf",
    "1.#IND",
    "+1",
    "-.5",
    "5.",
    ".",
    "-",
    "4294967295",
    "4294967296",
    "18446744073709551616",
    "-2147483648",
    "360",
    "90",
    "3.4e38",
    "0.0083333",
    "[1]",
];

/// The same for files that hold numbers as bytes.
const EDGES: &[&[u8]] = &[
    b"\0",
    b"\xff",
    b"\x80",
    b"\0\0",
    b"\xff\xff",
    b"\xff\x7f",
    b"\0\0\0\0",
    b"\xff\xff\xff\xff",
    b"\xff\xff\xff\x7f",
    b"\0\0\xc0\x7f",
    b"\0\0\x80\xff",
    b"\0\0\0\0\0\0\xf0\x7f",
    b"\xff\xff\xff\xff\xff\xff\xff\xff",
];

/// A seed with some changes.
pub(crate) fn mutate(pool: &[Vec<u8>], words: &[&str], random: &mut Rng) -> Vec<u8> {
    let mut bytes = choose(pool, random).clone();
    let longest = LONGEST.max(bytes.len());
    for _ in 0..random.usize(1..=MOST_CHANGES) {
        change(&mut bytes, pool, words, random);
    }
    bytes.truncate(longest);
    bytes
}

fn change(bytes: &mut Vec<u8>, pool: &[Vec<u8>], words: &[&str], random: &mut Rng) {
    let place = random.usize(..=bytes.len());
    match random.u8(..12) {
        0 => flip_bit(bytes, random),
        1 => bytes.insert(place, random.u8(..)),
        2 => bytes.truncate(place),
        3 => drop(bytes.drain(range(bytes.len(), random))),
        4 => insert(bytes, place, choose(words, random).as_bytes()),
        5 | 6 => replace_word(bytes, choose(NUMBERS, random).as_bytes(), random),
        7 => replace_word(bytes, choose(words, random).as_bytes(), random),
        8 | 9 => overwrite(bytes, place, choose::<&[u8]>(EDGES, random)),
        10 => {
            let other = choose(pool, random);
            let part = &other[range(other.len(), random)];
            insert(bytes, place, part);
        }
        _ => {
            let part = bytes[range(bytes.len(), random)].to_owned();
            let times = random.usize(1..=8);
            insert(bytes, place, &part.repeat(times));
        }
    }
}

fn choose<'a, T>(from: &'a [T], random: &mut Rng) -> &'a T {
    &from[random.usize(..from.len())]
}

/// A range within `length`, short more often than long.
fn range(length: usize, random: &mut Rng) -> std::ops::Range<usize> {
    let start = random.usize(..=length);
    let longest = length - start;
    let longest = if random.bool() { longest } else { longest.min(40) };
    start..start + random.usize(..=longest)
}

fn flip_bit(bytes: &mut [u8], random: &mut Rng) {
    if !bytes.is_empty() {
        let place = random.usize(..bytes.len());
        bytes[place] ^= 1 << random.u8(..8);
    }
}

/// Puts bytes in place of as many, so that what a binary file points at stays where it is.
fn overwrite(bytes: &mut [u8], place: usize, with: &[u8]) {
    let end = bytes.len().min(place + with.len());
    bytes[place..end].copy_from_slice(&with[..end - place]);
}

fn insert(bytes: &mut Vec<u8>, place: usize, part: &[u8]) {
    bytes.splice(place..place, part.iter().copied());
}

/// Puts `word` in place of one of the words, so that the text around it keeps its shape.
fn replace_word(bytes: &mut Vec<u8>, word: &[u8], random: &mut Rng) {
    let middle = random.usize(..=bytes.len());
    let start = bytes[..middle]
        .iter()
        .rposition(u8::is_ascii_whitespace)
        .map_or(0, |space| space + 1);
    let length = bytes[start..]
        .iter()
        .position(u8::is_ascii_whitespace)
        .unwrap_or(bytes.len() - start);
    bytes.splice(start..start + length, word.iter().copied());
}
