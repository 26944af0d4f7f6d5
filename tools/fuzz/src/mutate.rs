//! Random changes to a file, like those of damage, exporters and attackers.

use fastrand::Rng;

/// The largest number of changes to one input. More changes would leave nothing of the seed's meaning.
const MOST_CHANGES: usize = 6;

/// Inputs do not grow beyond this size, or beyond their seed.
const LONGEST: usize = 64 << 10;

/// Numbers at the limits of number types.
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

/// Numbers at the limits of number types, for binary files.
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

/// Counts and times beyond every motion, as text.
const EXTREMES: &[&str] = &[
    "1e20",
    "1e9",
    "1e7",
    "1e6",
    "-1e12",
    "1e-20",
    "1e308",
    "nan",
    "-1",
    "10000000",
    "2147483647",
    "4294967295",
    "9223372036854775807",
    "-9223372036854775808",
    "18446744073709551615",
];

/// Counts and times beyond every motion, as bytes: of 64 bits, and the values that fit into 32 bits.
const EXTREME_INTEGERS: &[i64] = &[
    10_000_000,
    1_000_000_000,
    1_000_000_000_000,
    -1_000_000_000_000,
    i32::MAX as i64,
    i32::MIN as i64,
    u32::MAX as i64,
    i64::MAX,
    i64::MIN,
    -1,
];
const EXTREME_FLOATS: &[f64] = &[1e20, 1e9, 1e7, 1e6, -1e12, 1e-20, 1e308, f64::NAN];

/// A seed with one or a few extreme numbers in place of its own numbers.
pub(crate) fn extreme(seed: &[u8], random: &mut Rng) -> Vec<u8> {
    let mut bytes = seed.to_vec();
    let is_text = !bytes.iter().take(1024).any(|byte| *byte == 0);
    for _ in 0..random.usize(1..=2) {
        match is_text {
            true => replace_number(&mut bytes, choose(EXTREMES, random).as_bytes(), random),
            false => {
                let place = random.usize(..=bytes.len());
                overwrite(&mut bytes, place, &extreme_bytes(random));
            }
        }
    }
    bytes
}

fn extreme_bytes(random: &mut Rng) -> Vec<u8> {
    let float = *choose(EXTREME_FLOATS, random);
    let integer = *choose(EXTREME_INTEGERS, random);
    match random.u8(..4) {
        0 => float.to_le_bytes().to_vec(),
        1 => (float as f32).to_le_bytes().to_vec(),
        2 => integer.to_le_bytes().to_vec(),
        _ => (integer as i32).to_le_bytes().to_vec(),
    }
}

/// Puts `with` in place of a number of the text, with any separator around the number.
fn replace_number(bytes: &mut Vec<u8>, with: &[u8], random: &mut Rng) {
    let from = random.usize(..=bytes.len());
    let is_of_number = |byte: &u8| byte.is_ascii_digit() || matches!(byte, b'.' | b'-' | b'+');
    let Some(start) = bytes[from..].iter().position(u8::is_ascii_digit) else {
        return;
    };
    // Starts at the beginning of the number at this place.
    let before = bytes[..from + start].iter().rposition(|byte| !is_of_number(byte));
    let start = before.map_or(0, |before| before + 1);
    let length = bytes[start..].iter().take_while(|byte| is_of_number(byte)).count();
    bytes.splice(start..start + length, with.iter().copied());
}

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

/// Replaces bytes by the same number of bytes, so that the offsets of a binary file stay right.
fn overwrite(bytes: &mut [u8], place: usize, with: &[u8]) {
    let end = bytes.len().min(place + with.len());
    bytes[place..end].copy_from_slice(&with[..end - place]);
}

fn insert(bytes: &mut Vec<u8>, place: usize, part: &[u8]) {
    bytes.splice(place..place, part.iter().copied());
}

/// Replaces one of the words by `word`, so that the text around it keeps its shape.
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
