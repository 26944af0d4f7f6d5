//! C3D: the words of the header, and the lengths, types, dimensions and values of parameters.

use std::ops::Range;

use fastrand::Rng;

use super::{float, number};

const BLOCK: usize = 512;

/// The bytes of a number in a file.
struct Field(Range<usize>);

pub(super) fn mutate(bytes: &[u8], random: &mut Rng) -> Option<Vec<u8>> {
    let fields = fields(bytes)?;
    let mut bytes = bytes.to_vec();
    for _ in 0..random.usize(1..=4) {
        let Field(place) = &fields[random.usize(..fields.len())];
        let field = bytes.get_mut(place.clone())?;
        match (field.len(), random.u8(..4)) {
            (4, 0..=2) => field.copy_from_slice(&float(random).to_le_bytes()),
            (length, _) => {
                let mut now = [0; 8];
                now[..length].copy_from_slice(field);
                let changed = number(u64::from_le_bytes(now), random).to_le_bytes();
                field.copy_from_slice(&changed[..length]);
            }
        }
    }
    // The data ends early, or continues.
    match random.u8(..8) {
        0 => bytes.truncate(random.usize(..=bytes.len())),
        1 => bytes.extend(vec![random.u8(..); random.usize(..2 * BLOCK)]),
        _ => {}
    }
    Some(bytes)
}

/// The fields of the header and of the parameters, as an Intel processor writes them.
fn fields(bytes: &[u8]) -> Option<Vec<Field>> {
    let word = |at: usize| Some(usize::from(u16::from_le_bytes(*bytes.get(at..at + 2)?.first_chunk()?)));
    // Points, analog samples, first and last frame, the longest gap, scale, block of the data, samples a frame, rate.
    let header = [2..4, 4..6, 6..8, 8..10, 10..12, 12..16, 16..18, 18..20, 20..24];
    let mut fields: Vec<_> = header.into_iter().map(Field).collect();
    fields.push(Field(0..1));
    let start = (usize::from(*bytes.first()?).checked_sub(1)?).checked_mul(BLOCK)?;
    // Changes the number of blocks and the processor type.
    fields.extend([Field(start + 2..start + 3), Field(start + 3..start + 4)]);
    let mut at = start + 4;
    while let Some(length) = bytes
        .get(at)
        .map(|length| usize::from(length.cast_signed().unsigned_abs()))
    {
        let next = at + 2 + length;
        let (Some(id), Some(to_next), true) = (bytes.get(at + 1), word(next), length > 0) else {
            break;
        };
        fields.extend([Field(at..at + 1), Field(at + 1..at + 2), Field(next..next + 2)]);
        if id.cast_signed() > 0
            && let Some(&[kind, dimensions]) = bytes.get(next + 2..next + 4).and_then(|two| two.first_chunk::<2>())
        {
            let values = next + 4 + usize::from(dimensions);
            fields.extend([Field(next + 2..next + 3), Field(next + 3..next + 4)]);
            fields.extend((next + 4..values).map(|dimension| Field(dimension..dimension + 1)));
            let size = usize::from(kind.cast_signed().unsigned_abs()).clamp(1, 4);
            fields.push(Field(values..values + size));
        }
        if to_next == 0 {
            break;
        }
        at = next + to_next;
    }
    fields.retain(|Field(place)| place.end <= bytes.len());
    Some(fields)
}
