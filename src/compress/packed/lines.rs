//! Fits a line to the keys of a component in each block. Keys are stored as differences from the lines.

use std::ops::Range;

use super::bits::width;
use super::layout::{Lines, MAX_ROTATION_BITS, on_line};

/// The lines of one component of a track.
pub(super) struct AxisLines {
    pub(super) least: i32,
    pub(super) least_rise: i32,
    pub(super) bits: u32,
    pub(super) rise_bits: u32,
    pub(super) blocks: Vec<AxisBlock>,
}

/// The line of one component in one block, and the number of bits of a key's difference from the line.
#[derive(Clone, Copy)]
pub(super) struct AxisBlock {
    pub(super) number: i32,
    pub(super) rise: i32,
    pub(super) width: u32,
}

/// The largest rise that is tried. Its product with a frame of a block fits into 32 bits.
pub(super) const MAX_RISE: i64 = 1 << 21;

impl AxisLines {
    /// Fits lines with or without rises, whichever takes fewer bits. A component of a key has at most `most` bits.
    pub(super) fn fit(values: &[i32], key_frames: &[u32], blocks: &[Range<usize>], log2: u32, most: u32) -> Self {
        let block_bits = |lines: &Self| {
            let keys = std::iter::zip(blocks, &lines.blocks).map(|(keys, line)| keys.len() * line.width as usize);
            keys.sum::<usize>() + blocks.len() * (lines.bits + lines.rise_bits) as usize
        };
        let flat = Self::of(blocks.iter().map(|keys| line(&values[keys.clone()], &[], 0, log2)));
        let rising = Self::of(blocks.iter().enumerate().map(|(block, keys)| {
            let first = (block << log2) as u32;
            best_line(&values[keys.clone()], &key_frames[keys.clone()], first, log2)
        }));
        let widest = rising.blocks.iter().map(|block| block.width).max().unwrap_or(0);
        let fits = rising.bits <= most && rising.rise_bits <= most && widest <= most && {
            // The file has 16 bits for numbers and rises of rotations.
            let limit = if most == MAX_ROTATION_BITS {
                i32::from(i16::MAX)
            } else {
                i32::MAX
            };
            [rising.least, rising.least_rise]
                .iter()
                .all(|least| least.abs() <= limit)
        };
        if fits && block_bits(&rising) < block_bits(&flat) {
            rising
        } else {
            flat
        }
    }

    pub(super) fn of(blocks: impl Iterator<Item = AxisBlock>) -> Self {
        let blocks: Vec<AxisBlock> = blocks.collect();
        let range = |of: fn(&AxisBlock) -> i32| {
            let least = blocks.iter().map(of).min().unwrap_or(0);
            let largest = blocks.iter().map(of).max().unwrap_or(0);
            (least, width(largest.abs_diff(least)))
        };
        let ((least, bits), (least_rise, rise_bits)) = (range(|block| block.number), range(|block| block.rise));
        Self {
            least,
            least_rise,
            bits,
            rise_bits,
            blocks,
        }
    }

    pub(super) fn rotation_width(&self, block: usize) -> u32 {
        match self.blocks[block].width {
            15 => 16,
            width => width,
        }
    }
}

/// The highest line with this `rise` that is nowhere above `values`. `offsets` are the frames of the values, relative
/// to the first frame of the block.
pub(super) fn line(values: &[i32], offsets: &[i32], rise: i32, log2: u32) -> AxisBlock {
    let above = |key: usize| {
        let offset = if rise == 0 { 0 } else { offsets[key] };
        values[key] - on_line((0, rise), offset, log2)
    };
    let least = (0..values.len()).map(above).min().unwrap_or(0);
    let largest = (0..values.len()).map(above).max().unwrap_or(0);
    AxisBlock {
        number: least,
        rise,
        width: width(largest.abs_diff(least)),
    }
}

/// The line with the fewest bits per key, among some rises near the rise of the values.
pub(super) fn best_line(values: &[i32], key_frames: &[u32], first: u32, log2: u32) -> AxisBlock {
    let offsets: Vec<i32> = key_frames.iter().map(|frame| (frame - first) as i32).collect();
    let mut best = line(values, &offsets, 0, log2);
    if values.len() < 3 {
        return best;
    }
    let count = values.len() as i64;
    let (mean, mean_offset) = (sum(values), sum(&offsets));
    // Least squares of the differences, with all sums multiplied by the count.
    let (mut product, mut square) = (0i64, 0i64);
    for (value, offset) in std::iter::zip(values, &offsets) {
        let offset = i64::from(*offset) * count - mean_offset;
        product += offset * (i64::from(*value) * count - mean) / count;
        square += offset * offset / count;
    }
    let by_squares = (product << log2) / square.max(1);
    let (start, end) = (0, values.len() - 1);
    let by_ends = (i64::from(values[end] - values[start]) << log2) / i64::from((offsets[end] - offsets[start]).max(1));
    for rise in [by_squares, by_ends, i64::midpoint(by_squares, by_ends)] {
        if rise.abs() < MAX_RISE {
            let found = line(values, &offsets, rise as i32, log2);
            if found.width < best.width {
                best = found;
            }
        }
    }
    best
}

pub(super) fn sum(values: &[i32]) -> i64 {
    values.iter().map(|value| i64::from(*value)).sum()
}

pub(super) fn lines_of(axes: &[AxisLines; 3]) -> Lines {
    let [a, b, c] = axes;
    Lines {
        least: [a.least, b.least, c.least],
        least_rise: [a.least_rise, b.least_rise, c.least_rise],
        bits: [a.bits as u8, b.bits as u8, c.bits as u8],
        rise_bits: [a.rise_bits as u8, b.rise_bits as u8, c.rise_bits as u8],
        all_bits: (a.bits + b.bits + c.bits) as u8,
    }
}
