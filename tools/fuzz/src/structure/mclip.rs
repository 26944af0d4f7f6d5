//! Changes to packed clips: numbers of the header, of the table of nodes, and anywhere in the tables and blocks.

use fastrand::Rng;

use super::number;

/// The positions of the header's numbers, and their sizes in bytes. `docs/packed-clip.md` has the layout.
const HEADER: [(usize, usize); 12] = [
    (4, 2),
    (6, 2),
    (8, 4),
    (12, 4),
    (16, 8),
    (24, 8),
    (32, 4),
    (36, 4),
    (40, 4),
    (44, 4),
    (48, 4),
    (12, 4),
];
const HEADER_BYTES: usize = 52;
/// A node has its parent, its flags, and the length of its name.
const NODE: [(usize, usize); 3] = [(0, 2), (2, 1), (3, 2)];
const NODE_BYTES: usize = 5;

/// The clip with one to three of its numbers changed.
pub(super) fn mutate(bytes: &[u8], random: &mut Rng) -> Option<Vec<u8>> {
    let mut bytes = bytes.to_vec();
    for _ in 0..random.usize(1..=3) {
        let (at, size) = place(&bytes, random)?;
        change(&mut bytes, at, size, random)?;
        let frames = bytes.get(12..16).and_then(|four| four.first_chunk().copied())?;
        // The duration must match, or the reader refuses any other number of frames.
        if at == 12 && random.bool() {
            let last = f64::from(u32::from_le_bytes(frames)) - 1.0;
            bytes.get_mut(24..32)?.copy_from_slice(&last.to_le_bytes());
        }
    }
    Some(bytes)
}

fn place(bytes: &[u8], random: &mut Rng) -> Option<(usize, usize)> {
    match random.u8(..3) {
        0 => Some(HEADER[random.usize(..HEADER.len())]),
        1 => {
            let count = bytes.get(8..12).and_then(|four| four.first_chunk().copied())?;
            let node = random.usize(..(u32::from_le_bytes(count) as usize).clamp(1, bytes.len()));
            let (at, size) = NODE[random.usize(..NODE.len())];
            Some((HEADER_BYTES + NODE_BYTES * node + at, size))
        }
        _ => Some((random.usize(..bytes.len().max(1)), 1 << random.u32(..3))),
    }
}

fn change(bytes: &mut [u8], at: usize, size: usize, random: &mut Rng) -> Option<()> {
    let place = bytes.get_mut(at..at.checked_add(size)?)?;
    let mut now = [0; 8];
    now[..size].copy_from_slice(place);
    let changed = match size {
        8 if random.bool() => f64::from(super::float(random)).to_le_bytes(),
        4 if random.u8(..4) == 0 => u64::from(super::float(random).to_bits()).to_le_bytes(),
        _ => number(u64::from_le_bytes(now), random).to_le_bytes(),
    };
    place.copy_from_slice(&changed[..size]);
    Some(())
}
