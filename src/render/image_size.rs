//! Reads the size of an image from the header of its file.

/// The media type, width and height of an image.
pub fn image_size(bytes: &[u8]) -> Option<(&'static str, [u32; 2])> {
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => {
            let number = |at: usize| Some(u32::from_be_bytes(bytes.get(at..at + 4)?.try_into().ok()?));
            Some(("image/png", [number(16)?, number(20)?]))
        }
        [0xFF, 0xD8, ..] => Some(("image/jpeg", jpeg(bytes)?)),
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => Some(("image/webp", webp(bytes)?)),
        _ => None,
    }
}

/// The frame header is the first segment with a marker from C0 to CF, except C4, C8 and CC.
fn jpeg(bytes: &[u8]) -> Option<[u32; 2]> {
    let number = |at: usize| Some(u16::from_be_bytes(bytes.get(at..at + 2)?.try_into().ok()?));
    let mut at = 2;
    loop {
        let [0xFF, marker] = *bytes.get(at..at + 2)? else {
            return None;
        };
        match marker {
            0xFF => at += 1,
            0xC0..=0xCF if ![0xC4, 0xC8, 0xCC].contains(&marker) => {
                return Some([number(at + 7)?.into(), number(at + 5)?.into()]);
            }
            0x01 | 0xD0..=0xD7 => at += 2,
            _ => at += 2 + usize::from(number(at + 2)?),
        }
    }
}

/// The three container variants: lossy, lossless, extended.
fn webp(bytes: &[u8]) -> Option<[u32; 2]> {
    let number = |at: usize, size: usize| {
        let bytes = bytes.get(at..at + size)?;
        Some(
            bytes
                .iter()
                .rev()
                .fold(0, |number, byte| number << 8 | u32::from(*byte)),
        )
    };
    match bytes.get(12..16)? {
        b"VP8 " => Some([number(26, 2)? & 0x3FFF, number(28, 2)? & 0x3FFF]),
        b"VP8L" => {
            let bits = number(21, 4)?;
            Some([(bits & 0x3FFF) + 1, (bits >> 14 & 0x3FFF) + 1])
        }
        b"VP8X" => Some([number(24, 3)? + 1, number(27, 3)? + 1]),
        _ => None,
    }
}
