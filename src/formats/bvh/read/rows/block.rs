//! A block of frames in columns, and the fast reader for lines of numbers.

use mocap_scene::limits::is_plausible;
use mocap_scene::math::wide;

use crate::text::is_line_end;

/// The values of some consecutive frames, column by column.
#[derive(Debug)]
pub struct Block {
    pub(super) values: Vec<f64>,
    pub(super) frames: usize,
    capacity: usize,
    /// The number of values from the start of one column to the start of the next column.
    pub(super) stride: usize,
}

impl Block {
    /// The number of frames of a block. With a usual skeleton the block fits in the second-level cache.
    const FRAMES: usize = 128;
    /// The number of values above which a block of an unusual skeleton gets fewer frames.
    const VALUES: usize = 1 << 16;
    /// Padding between columns, in values. Columns a power of two apart would share a few sets of the first-level cache
    /// and evict each other.
    const GAP: usize = 8;

    pub fn new(channel_count: usize) -> Self {
        let capacity = (Self::VALUES / channel_count).clamp(1, Self::FRAMES);
        let stride = capacity + Self::GAP;
        Self {
            values: vec![0.0; stride * channel_count],
            frames: 0,
            capacity,
            stride,
        }
    }

    /// The number of frames in the block.
    pub(in crate::bvh) fn frames(&self) -> usize {
        self.frames
    }

    /// The values of one column, one per frame.
    pub(in crate::bvh) fn column(&self, column: usize) -> &[f64] {
        &self.values[column * self.stride..][..self.frames]
    }

    pub(super) fn is_full(&self) -> bool {
        self.frames == self.capacity
    }

    /// The values of the last frame, if there is one.
    pub fn last_row(&self) -> Option<Vec<f64>> {
        let last = self.frames.checked_sub(1)?;
        Some(
            self.values
                .chunks_exact(self.stride)
                .map(|column| column[last])
                .collect(),
        )
    }

    /// Reads a line with exactly one finite number for each column into the next frame, and returns its length. `None`
    /// for any other line.
    pub fn read_plain_row(&mut self, text: &[u8]) -> Option<usize> {
        read_plain_row(self, text)
    }

    /// Reads a line like [`Self::read_plain_row`]. `read_short` reads short numbers faster, and returns `None` for
    /// other numbers.
    #[inline(always)]
    pub fn read_numbers(&mut self, text: &[u8], read_short: impl Fn(&[u8]) -> Option<(f64, usize)>) -> Option<usize> {
        let frame = self.frames;
        let mut rest = skip_blanks(text);
        let mut is_plain = true;
        // Long numbers tend to follow long numbers.
        let mut was_long = false;
        for column in self.values.chunks_exact_mut(self.stride) {
            let short = if was_long { None } else { read_short(rest) };
            let (value, length) = match short {
                Some(short) => short,
                None => {
                    // By reference, so that the compiler inlines the parser here: see `tools/bench/README.md`.
                    #[allow(clippy::needless_borrows_for_generic_args, reason = "a seventh of the time")]
                    let (value, length) = fast_float2::parse_partial::<f64, _>(&rest).ok()?;
                    // Comparisons with NaN are false.
                    is_plain &= is_plausible(value);
                    was_long = length >= LONG;
                    (value, length)
                }
            };
            rest = match &rest[length..] {
                [b' ', after @ ..] if after.first().is_some_and(|&byte| byte > b' ') => after,
                gap => skip_gap(gap)?,
            };
            column[frame] = value;
        }
        let ends = rest.first().is_none_or(|&byte| is_line_end(byte));
        if !(ends && is_plain) {
            return None;
        }
        self.frames += 1;
        Some(text.len() - rest.len())
    }
}

wide::dispatch! {
    fn read_plain_row(block: &mut Block, text: &[u8]) -> Option<usize> {
        block.read_numbers(text, |text| super::short::parse(text))
    } else {
        #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
        let read_short = super::short::parse;
        #[cfg(not(all(target_arch = "wasm32", target_feature = "simd128")))]
        let read_short = |_: &[u8]| None;
        block.read_numbers(text, read_short)
    }
}

/// The smallest number of bytes of a long number.
const LONG: usize = 16;

/// Skips the spaces after a number. A line may end after the number.
#[inline(never)]
fn skip_gap(text: &[u8]) -> Option<&[u8]> {
    match text {
        [b' ' | b'\t', after @ ..] => Some(skip_blanks(after)),
        [byte, ..] if !is_line_end(*byte) => None,
        _ => Some(text),
    }
}

fn skip_blanks(mut text: &[u8]) -> &[u8] {
    while let [b' ' | b'\t', after @ ..] = text {
        text = after;
    }
    text
}
