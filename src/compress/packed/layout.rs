//! The layout of a packed clip, for its writer, its reader and its sampler.

use super::bits::{bits_at, lowest};

pub(super) const MAGIC: [u8; 4] = *b"MCLP";
/// The version of files whose rest transforms equal the constant transforms of the motion. Other files have the next
/// version.
pub(super) const VERSION: u16 = 1;
pub(super) const VERSION_WITH_REST: u16 = 2;

/// The size of an entry in the table of nodes, in bytes: see `docs/packed-clip.md`.
pub(super) const NODE: usize = 5;

/// The size of an entry in the table of rotation tracks, in bytes: see `docs/packed-clip.md`.
pub(super) const ROTATION: usize = 2 + 6 + 6 + 6;

/// The size of an entry in the table of translation tracks, in bytes: see `docs/packed-clip.md`.
pub(super) const TRANSLATION: usize = 4 + 12 + 12 + 6;
/// The parent value of a node without a parent.
pub(super) const NO_PARENT: u16 = u16::MAX;
/// The allowed binary logarithms of the number of frames in a block: 16 to 256 frames.
pub(super) const LOG2_BLOCK_FRAMES: std::ops::RangeInclusive<u32> = 4..=8;
/// A frame has a key if its number is divisible by this number.
pub(super) const MUST_HAVE_KEY: usize = 64;
/// The largest number of frames in the key mask of a block.
pub(super) const MAX_BLOCK_FRAMES: usize = 256;

/// The flag of a file in which each frame states its own tick.
pub(super) const HAS_TICKS: u32 = 1;
/// The flag of a file in which every frame has a key.
pub(super) const ALL_KEYS: u32 = 2;

/// Flags of a node. `ROTATES` and `TRANSLATES` mark a component with a track. `ROTATION`, `TRANSLATION` and `SCALE`
/// mark a component that differs from the identity.
pub(super) mod node {
    pub(in super::super) const ROTATES: u8 = 1;
    pub(in super::super) const TRANSLATES: u8 = 2;
    pub(in super::super) const ROTATION: u8 = 4;
    pub(in super::super) const TRANSLATION: u8 = 8;
    pub(in super::super) const SCALE: u8 = 16;
    pub(in super::super) const END_SITE: u8 = 32;
    /// Marks a rotation that is constant in the motion and differs in the rest pose. `REST_TRANSLATION` marks such a
    /// translation.
    pub(in super::super) const REST_ROTATION: u8 = 64;
    pub(in super::super) const REST_TRANSLATION: u8 = 128;
    /// All flags that exist in version 1.
    pub(in super::super) const FIRST: u8 = 63;
}

/// The kind of a rotation track in a block whose keys drop different components. The smaller kinds, 0 to 3, are the
/// component that all keys of the block drop.
pub(super) const MIXED: u32 = 4;
/// The number of bits for the kind of a rotation track in a block.
pub(super) const KIND_BITS: u32 = 3;
/// The number of bits for the width of a rotation's component.
pub(super) const ROTATION_WIDTH_BITS: u32 = 4;
/// The number of bits for the width of a translation's component.
pub(super) const TRANSLATION_WIDTH_BITS: u32 = 5;
/// The number of bits for the dropped component in a key of kind [`MIXED`].
pub(super) const DROPPED_BITS: u32 = 2;
/// The largest number of bits of a rotation's component in a key.
pub(super) const MAX_ROTATION_BITS: u32 = 16;
/// The largest number of bits of a translation's component in a key.
pub(super) const MAX_TRANSLATION_BITS: u32 = 24;

/// The code for the width of a rotation's component. Code 15 means 16 bits, because no component has 15 bits.
pub(super) fn rotation_width_code(width: u32) -> u32 {
    width.min(15)
}

/// How the block headers store the lines of a track's three components. A line is a number at the first frame of a
/// block, and a rise over the whole block.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lines {
    /// The smallest number in any block, for each component. `least_rise` has the smallest rises.
    pub(super) least: [i32; 3],
    pub(super) least_rise: [i32; 3],
    /// The bits of the difference between a block's number and `least`, for each component. `rise_bits` is the same for
    /// rises.
    pub(super) bits: [u8; 3],
    pub(super) rise_bits: [u8; 3],
    /// The sum of `bits`.
    pub(super) all_bits: u8,
}

impl Lines {
    /// The number of bits of the three lines in a block header.
    pub(super) fn header_bits(&self) -> u32 {
        self.bits
            .iter()
            .chain(&self.rise_bits)
            .map(|bits| u32::from(*bits))
            .sum()
    }
}

/// A rotation track.
#[derive(Clone, Copy, Debug)]
pub(super) struct RotationTrack {
    pub(super) node: u32,
    /// The position of the track's header among the headers of a block, in bits.
    pub(super) header: u32,
    /// The step of the lattice.
    pub(super) step: f32,
    pub(super) lines: Lines,
}

/// A translation track.
#[derive(Clone, Copy, Debug)]
pub(super) struct TranslationTrack {
    pub(super) node: u32,
    pub(super) header: u32,
    pub(super) step: f32,
    pub(super) lines: Lines,
}

/// A rotation track in one block.
#[derive(Clone, Copy)]
pub(super) struct RotationBlock {
    pub(super) kind: u32,
    pub(super) widths: [u32; 3],
    pub(super) lines: [(i32, i32); 3],
}

impl RotationTrack {
    /// The bits of the track's header in a block.
    pub(super) fn header_bits(lines: &Lines) -> u32 {
        KIND_BITS + 3 * ROTATION_WIDTH_BITS + lines.header_bits()
    }

    /// Reads the track's header in the block whose headers start at bit `headers`.
    #[inline(always)]
    pub(super) fn in_block(&self, bytes: &[u8], headers: usize) -> RotationBlock {
        let at = headers + self.header as usize;
        let head = bits_at(bytes, at);
        let at = at + (KIND_BITS + 3 * ROTATION_WIDTH_BITS) as usize;
        let mut numbers = bits_at(bytes, at);
        let mut rises = bits_at(bytes, at + usize::from(self.lines.all_bits));
        let mut block = RotationBlock {
            kind: lowest(head, KIND_BITS),
            widths: [0; 3],
            lines: [(0, 0); 3],
        };
        for axis in 0..3 {
            let code = lowest(
                head >> (KIND_BITS + axis as u32 * ROTATION_WIDTH_BITS),
                ROTATION_WIDTH_BITS,
            );
            block.widths[axis] = code + u32::from(code == 15);
            let (bits, rise_bits) = (self.lines.bits[axis].into(), self.lines.rise_bits[axis].into());
            let number = self.lines.least[axis].wrapping_add(lowest(numbers, bits) as i32);
            let rise = self.lines.least_rise[axis].wrapping_add(lowest(rises, rise_bits) as i32);
            block.lines[axis] = (number, rise);
            numbers >>= bits;
            rises >>= rise_bits;
        }
        block
    }
}

impl RotationBlock {
    /// The number of bits of this track in a key.
    #[inline(always)]
    pub(super) fn key_bits(&self) -> u32 {
        let dropped = if self.kind >= MIXED { DROPPED_BITS } else { 0 };
        dropped + self.widths[0] + self.widths[1] + self.widths[2]
    }
}

/// A component of a translation track in one block: its width and its line.
#[derive(Clone, Copy)]
pub(super) struct TranslationBlock {
    pub(super) widths: [u32; 3],
    pub(super) lines: [(i32, i32); 3],
}

impl TranslationTrack {
    /// The bits of the track's header in a block.
    pub(super) fn header_bits(lines: &Lines) -> u32 {
        3 * TRANSLATION_WIDTH_BITS + lines.header_bits()
    }

    /// Reads the track's header in the block whose headers start at bit `headers`.
    #[inline(always)]
    pub(super) fn in_block(&self, bytes: &[u8], headers: usize) -> TranslationBlock {
        let mut at = headers + self.header as usize;
        let mut next = |bits: u32| {
            let value = lowest(bits_at(bytes, at), bits);
            at += bits as usize;
            value
        };
        let mut block = TranslationBlock {
            widths: [0; 3],
            lines: [(0, 0); 3],
        };
        for width in &mut block.widths {
            *width = next(TRANSLATION_WIDTH_BITS);
        }
        for axis in 0..3 {
            block.lines[axis].0 = self.lines.least[axis].wrapping_add(next(self.lines.bits[axis].into()) as i32);
        }
        for axis in 0..3 {
            block.lines[axis].1 =
                self.lines.least_rise[axis].wrapping_add(next(self.lines.rise_bits[axis].into()) as i32);
        }
        block
    }
}

impl TranslationBlock {
    /// The number of bits of this track in a key.
    #[inline(always)]
    pub(super) fn key_bits(&self) -> u32 {
        self.widths[0] + self.widths[1] + self.widths[2]
    }
}

/// The value of a line, `at` frames after the first frame of its block.
#[inline(always)]
pub(super) fn on_line((number, rise): (i32, i32), at: i32, log2_block_frames: u32) -> i32 {
    number.wrapping_add(rise.wrapping_mul(at) >> log2_block_frames)
}
