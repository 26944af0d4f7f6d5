//! Pickles and archives that expand a small input to large data.

use std::iter::repeat_n;

/// The approximate number of bytes of each pickle.
const SIZE: usize = 1 << 20;

/// A pickle of a list. `operations` push its elements.
fn list(operations: impl IntoIterator<Item = u8>) -> Vec<u8> {
    let mut pickle = b"\x80\x02](N".to_vec();
    pickle.extend(operations);
    pickle.extend(b"e.");
    pickle
}

/// Stores the function `encode`, a text and its encoding, and encodes the text repeatedly.
fn encodes(text: &str, calls: usize) -> Vec<u8> {
    let mut operations = b"c_codecs\nencode\nq\x02X".to_vec();
    operations.extend((text.len() as u32).to_le_bytes());
    operations.extend(text.as_bytes());
    operations.extend(b"q\x01X\x06\0\0\0latin1q\x03\x86R");
    operations.extend(b"h\x02h\x01h\x03\x86R".repeat(calls));
    list(operations)
}

/// Reshapes one array of two bytes repeatedly, to the largest number of axes of a pickle's array.
fn reshapes() -> Vec<u8> {
    let mut operations = b"cnumpy\nfrombuffer\nC\x02ab\x8c\x02u1\x86Rq\x01cnumpy\nreshape\nq\x02h\x01(".to_vec();
    operations.extend(b"K\x01".repeat(5));
    operations.extend(b"K\x02t\x86q\x03");
    operations.extend(b"h\x02h\x03R".repeat(SIZE / 5));
    list(operations)
}

/// Pickles, each with the name of the repeated operation.
pub(crate) fn pickles() -> Vec<(&'static str, Vec<u8>)> {
    let one = |operation: u8| list(repeat_n(operation, SIZE));
    let many = |operations: &[u8]| list(operations.repeat(SIZE / operations.len()));
    vec![
        (
            "a text that is encoded 30,000 times",
            encodes(&"a".repeat(20_000), 30_000),
        ),
        (
            "a text with an accent that is encoded 30,000 times",
            encodes(&"\u{e9}".repeat(20_000), 30_000),
        ),
        ("nothing", one(b'N')),
        ("true", one(0x88)),
        ("empty lists", one(b']')),
        ("empty tuples", one(b')')),
        ("empty dictionaries", one(b'}')),
        ("tuples in tuples", one(0x85)),
        ("marks", one(b'(')),
        ("the last object", one(b'2')),
        ("memories", one(0x94)),
        ("numbers", many(b"K\x07")),
        ("texts", many(b"\x8c\x01a")),
        ("lists of one", many(b"]Na")),
        ("dictionaries of one", many(b"}NNs")),
        ("functions", many(b"cnumpy\narray\n")),
        ("types", many(b"cnumpy\ndtype\n\x8c\x02f4\x85R")),
        ("arrays of one buffer", reshapes()),
    ]
}

/// A zip archive of these entries: name, method, stored bytes, size, check sum.
fn zip(entries: &[(&str, u16, &[u8], usize, u32)]) -> Vec<u8> {
    let (mut out, mut central) = (Vec::new(), Vec::new());
    let mut written: Vec<(&[u8], u32)> = Vec::new();
    for (name, method, bytes, size, sum) in entries {
        let mut shared = Vec::new();
        for number in [20, 0, *method, 0, 0x21] {
            shared.extend(number.to_le_bytes());
        }
        for number in [*sum, bytes.len() as u32, *size as u32] {
            shared.extend(number.to_le_bytes());
        }
        shared.extend((name.len() as u16).to_le_bytes());
        shared.extend([0; 2]);
        // Entries with the same bytes overlap: they share one header.
        let earlier = written.iter().find(|(earlier, _)| std::ptr::eq(*earlier, *bytes));
        let offset = earlier.map_or(out.len() as u32, |(_, offset)| *offset);
        if earlier.is_none() {
            written.push((bytes, offset));
            out.extend(b"PK\x03\x04");
            out.extend(&shared);
            out.extend(name.as_bytes());
            out.extend(*bytes);
        }
        central.extend(b"PK\x01\x02\x14\0");
        central.extend(&shared);
        central.extend([0; 10]);
        central.extend(offset.to_le_bytes());
        central.extend(name.as_bytes());
    }
    let begin = out.len() as u32;
    out.extend(&central);
    out.extend(b"PK\x05\x06\0\0\0\0");
    out.extend([(entries.len() as u16).to_le_bytes(); 2].concat());
    out.extend((central.len() as u32).to_le_bytes());
    out.extend(begin.to_le_bytes());
    out.extend([0; 2]);
    out
}

/// A deflate stream: one zero, then copies of 258 zeros, in the fixed code, which needs no table.
fn deflated_zeros(copies: usize) -> Vec<u8> {
    let mut bits: Vec<bool> = vec![true, true, false];
    // Codes begin with their highest bit. A literal 0 is 00110000, a length of 258 is 11000101, a distance of 1 is
    // 00000, and the end is 0000000.
    let mut code = |word: &str| bits.extend(word.bytes().map(|bit| bit == b'1'));
    code("00110000");
    (0..copies).for_each(|_| code("1100010100000"));
    code("0000000");
    let byte = |bits: &[bool]| bits.iter().rev().fold(0_u8, |byte, bit| byte << 1 | u8::from(*bit));
    bits.chunks(8).map(byte).collect()
}

fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |sum, byte| {
        (0..8).fold(sum ^ u32::from(*byte), |sum, _| {
            sum >> 1 ^ (0xEDB8_8320 & (sum & 1).wrapping_neg())
        })
    })
}

/// The header of an array with this number of zeros. It has 64 bytes.
fn npy_header(descr: &str, count: usize) -> Vec<u8> {
    let literal = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({count},), }}");
    let mut header = b"\x93NUMPY\x01\0\x76\0".to_vec();
    header.extend(format!("{literal:<117}\n").bytes());
    header
}

/// Archives, each with a word of its error message.
pub(crate) fn archives() -> Vec<(&'static str, Vec<u8>)> {
    const COPIES: usize = 400_000;
    let zeros = deflated_zeros(COPIES);
    let size = 258 * COPIES + 1;
    let mut listed = npy_header("|O", 1);
    listed.extend(list(b"K\x07".repeat(50_000)));
    let sum = crc32(&listed);
    let names: Vec<String> = (0..1000).map(|index| format!("a{index:03}.npy")).collect();
    let overlapping: Vec<_> = names
        .iter()
        .map(|name| (name.as_str(), 0, listed.as_slice(), listed.len(), sum))
        .collect();
    vec![
        ("inflated", zip(&[("poses.npy", 8, &zeros, size, 0)])),
        ("overlaps", zip(&overlapping)),
    ]
}
