//! How long a stream of meshopt's attribute codec, version 0, will be, without making it.

/// Elements that are coded together.
const GROUP: usize = 16;

/// The two words of an element of four 16-bit integers.
pub(super) fn words(code: [i16; 4]) -> [u32; 2] {
    let word = |low: i16, high: i16| u32::from(low as u16) | (u32::from(high as u16) << 16);
    [word(code[0], code[1]), word(code[2], code[3])]
}

/// Bytes of the stream of `len` elements of `N` words: for every byte of an element and every 16 elements two bits that
/// say how the differences to the byte before are stored, then these, with 0, 2, 4 or 8 bits each. What does not fit
/// into 2 or 4 bits takes a byte more.
pub(super) fn size<const N: usize>(len: usize, element: impl Fn(usize) -> [u32; N]) -> usize {
    let mut bits = 0;
    let mut before = if len > 0 { element(0) } else { [0; N] };
    for start in (0..len).step_by(GROUP) {
        let end = (start + GROUP).min(len);
        // Of every byte of an element: how many are not 0, not below 3, not below 15.
        let mut counts = [[[0u32; 3]; 4]; N];
        for index in start..end {
            let now = element(index);
            for word in 0..N {
                if now[word] == before[word] {
                    continue;
                }
                let bytes = std::iter::zip(now[word].to_le_bytes(), before[word].to_le_bytes());
                for (count, (now, before)) in std::iter::zip(&mut counts[word], bytes) {
                    let difference = now.wrapping_sub(before) as i8;
                    let zigzag = ((difference >> 7) as u8) ^ ((difference as u8) << 1);
                    count[0] += u32::from(zigzag > 0);
                    count[1] += u32::from(zigzag >= 3);
                    count[2] += u32::from(zigzag >= 15);
                }
            }
            before = now;
        }
        for [some, three, fifteen] in counts.into_iter().flatten() {
            bits += 2 + match some {
                0 => 0,
                _ => (32 + 8 * three).min(64 + 8 * fifteen).min(128),
            };
        }
    }
    bits as usize / 8
}
