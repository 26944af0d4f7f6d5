//! Computes the pose at a tick from the packed form.

use glam::{Quat, Vec3};
use mocap_scene::math::soa::single::{LANES, Lanes, Quaternions};
use mocap_scene::math::wide;
use mocap_scene::pose::Trs;

use super::PackedClip;
use super::bits::{bits_at, lowest};
use super::layout::{DROPPED_BITS, MAX_BLOCK_FRAMES, MIXED, RotationBlock, TranslationTrack, on_line};

/// The 64-bit words of a block's key mask.
type Mask = [u64; MAX_BLOCK_FRAMES / 64];

/// The position of one key frame in the file.
#[derive(Clone, Copy)]
struct Key {
    block: usize,
    /// The position of the headers of its block, in bits.
    headers: usize,
    /// The position of its numbers, in bits.
    at: usize,
    /// The frame relative to the first frame of its block.
    offset: i32,
    frame: usize,
}

impl PackedClip<'_> {
    /// Writes the pose at `tick` to `pose`: every node's transform relative to its parent. Ticks out of range are
    /// clamped. Translations between two keys are interpolated linearly, and rotations component by component. Nodes
    /// beyond the end of `pose` are skipped.
    pub fn sample(&self, tick: f64, pose: &mut [Trs]) {
        let count = pose.len().min(self.rest.len());
        pose[..count].copy_from_slice(&self.rest[..count]);
        if self.rotations.is_empty() && self.translations.is_empty() {
            return;
        }
        // `max` also turns NaN into the first tick.
        let tick = tick.max(self.tick_of(0));
        let [mut from, mut to] = self.keys_around(tick);
        let alpha = self.alpha(tick, from.frame, to.frame);
        sample_rotations(self, &mut from, &mut to, alpha, pose);
        for track in &self.translations {
            let a = self.translation(track, &mut from);
            let b = self.translation(track, &mut to);
            if let Some(node) = pose.get_mut(track.node as usize) {
                node.translation = (a + (b - a) * alpha) * track.step;
            }
        }
    }

    /// Reads the translation of `track` from a key, in steps. Moves the position of the key to the next track.
    fn translation(&self, track: &TranslationTrack, key: &mut Key) -> Vec3 {
        let block = track.in_block(&self.bytes, key.headers);
        let mut value = Vec3::ZERO;
        for axis in 0..3 {
            let (width, (number, rise)) = (block.widths[axis], block.lines[axis]);
            let above = lowest(bits_at(&self.bytes, key.at), width) as i32;
            key.at += width as usize;
            value[axis] = on_line((number, rise), key.offset, self.log2_block_frames).wrapping_add(above) as f32;
        }
        value
    }

    /// The tick of a frame.
    pub(super) fn tick_of(&self, frame: usize) -> f64 {
        let Some(ticks) = self.ticks else { return frame as f64 };
        let tick = self
            .bytes
            .get(ticks + 8 * frame..)
            .and_then(|rest| rest.first_chunk::<8>());
        tick.map_or(0.0, |tick| f64::from_le_bytes(*tick))
    }

    /// The last frame at or before `tick`, or the first frame.
    fn frame_at(&self, tick: f64) -> usize {
        let last = self.frames - 1;
        if self.ticks.is_none() {
            return (tick as usize).min(last);
        }
        let (mut low, mut high) = (0, last);
        while low < high {
            let middle = usize::midpoint(low, high) + 1;
            if self.tick_of(middle) <= tick {
                low = middle;
            } else {
                high = middle - 1;
            }
        }
        low
    }

    fn alpha(&self, tick: f64, from: usize, to: usize) -> f32 {
        let (start, end) = (self.tick_of(from), self.tick_of(to));
        if end > start {
            ((tick - start) / (end - start)).clamp(0.0, 1.0) as f32
        } else {
            0.0
        }
    }

    /// The last key at or before `tick`, and the next key; at the end, the last key twice.
    fn keys_around(&self, tick: f64) -> [Key; 2] {
        let frame = self.frame_at(tick);
        let log2 = self.log2_block_frames;
        let (block, offset) = (frame >> log2, frame & ((1 << log2) - 1));
        let start = self.block_start(block);
        let (key, offset, next) = if self.mask_bytes == 0 {
            let next = offset + 1;
            (offset, offset, (next >> log2 == 0).then_some(next))
        } else {
            key_in(&self.mask(start), offset)
        };
        let from = self.key(block, start, key, offset);
        if let Some(next) = next.filter(|next| (block << log2) + next < self.frames) {
            return [from, self.key(block, start, key + 1, next)];
        }
        let block = block + 1;
        if block << log2 >= self.frames {
            return [from, from];
        }
        // The first frame of every block has a key.
        [from, self.key(block, self.block_start(block), 0, 0)]
    }

    fn key(&self, block: usize, start: usize, key: usize, offset: usize) -> Key {
        let headers = 8 * (start + 4 + self.mask_bytes);
        let key_bits = lowest(bits_at(&self.bytes, 8 * start), 32) as usize;
        Key {
            block,
            headers,
            at: headers + self.header_bits + key * key_bits,
            offset: offset as i32,
            frame: (block << self.log2_block_frames) + offset,
        }
    }

    /// The byte position of a block.
    pub(super) fn block_start(&self, block: usize) -> usize {
        self.blocks + lowest(bits_at(&self.bytes, 8 * (self.table + 4 * block)), 32) as usize
    }

    /// The key mask of the block at `start`.
    pub(super) fn mask(&self, start: usize) -> Mask {
        std::array::from_fn(|word| {
            let bits = (8 * self.mask_bytes).saturating_sub(64 * word).min(64);
            let all = bits_at(&self.bytes, 8 * (start + 4 + 8 * word));
            if bits == 64 { all } else { all & ((1 << bits) - 1) }
        })
    }
}

/// The index of the last key at or before a frame, the frame of this key, and the frame of the next key. All frames are
/// relative to the block of the `mask`.
pub fn key_in(mask: &Mask, frame: usize) -> (usize, usize, Option<usize>) {
    let (word, bit) = (frame / 64, frame % 64);
    let not_after = mask[word] & (u64::MAX >> (63 - bit));
    // The first bit of every word is set: every 64th frame has a key.
    let offset = 64 * word + 63 - (not_after | 1).leading_zeros() as usize;
    let before: u32 = mask[..word].iter().map(|word| word.count_ones()).sum();
    let key = (before + not_after.count_ones()).saturating_sub(1) as usize;
    let after = mask[word] & !(u64::MAX >> (63 - bit));
    let next = match mask.get(word + 1) {
        _ if after != 0 => Some(64 * word + after.trailing_zeros() as usize),
        Some(next) if next & 1 == 1 => Some(64 * (word + 1)),
        _ => None,
    };
    (key, offset, next)
}

/// The lines of eight rotations in a block. Each number is a list of lanes, so that computations become vector
/// instructions.
#[derive(Clone, Copy)]
struct LineLanes {
    numbers: [[i32; LANES]; 3],
    rises: [[i32; LANES]; 3],
}

impl LineLanes {
    const ZERO: Self = Self {
        numbers: [[0; LANES]; 3],
        rises: [[0; LANES]; 3],
    };

    #[inline(always)]
    fn set(&mut self, lane: usize, block: &RotationBlock) {
        for axis in 0..3 {
            (self.numbers[axis][lane], self.rises[axis][lane]) = block.lines[axis];
        }
    }
}

/// The differences of eight rotations from their lines, and the indices of the dropped components.
#[derive(Clone, Copy)]
struct KeyLanes {
    above: [[i32; LANES]; 3],
    dropped: [u32; LANES],
}

impl KeyLanes {
    const ZERO: Self = Self {
        above: [[0; LANES]; 3],
        dropped: [0; LANES],
    };

    /// Reads one rotation of a key, and moves the position of the key to the next rotation.
    #[inline(always)]
    fn read(&mut self, lane: usize, block: &RotationBlock, bytes: &[u8], key: &mut Key) {
        let mut bits = bits_at(bytes, key.at);
        key.at += block.key_bits() as usize;
        self.dropped[lane] = block.kind;
        if block.kind >= MIXED {
            self.dropped[lane] = lowest(bits, DROPPED_BITS);
            bits >>= DROPPED_BITS;
        }
        for axis in 0..3 {
            self.above[axis][lane] = lowest(bits, block.widths[axis]) as i32;
            bits >>= block.widths[axis];
        }
    }

    /// The decoded quaternions. `x` is the dropped component, and `y`, `z` and `w` are the components after it.
    #[inline(always)]
    fn components(&self, lines: &LineLanes, offset: i32, log2: u32, step: Lanes) -> Quaternions {
        let mut stored = [Lanes::ZERO; 3];
        for (axis, stored) in stored.iter_mut().enumerate() {
            for lane in 0..LANES {
                let line = (lines.numbers[axis][lane], lines.rises[axis][lane]);
                stored.0[lane] = on_line(line, offset, log2).wrapping_add(self.above[axis][lane]) as f32;
            }
            *stored = *stored * step;
        }
        let [y, z, w] = stored;
        let square = Lanes::ONE - y * y - z * z - w * w;
        let x = Lanes::of(|lane| if square.0[lane] > 0.0 { square.0[lane] } else { 0.0 }).sqrt();
        Quaternions { x, y, z, w }
    }
}

/// Shifts the components of each lane cyclically by the lane's number of `slots`, modulo 4.
#[inline(always)]
fn moved_on(quaternions: Quaternions, slots: [u32; LANES]) -> Quaternions {
    let mut components = quaternions.components();
    for distance_of_bit in [1, 2] {
        let before = components;
        for (slot, component) in components.iter_mut().enumerate() {
            let from = before[(slot + 4 - distance_of_bit) % 4];
            for (lane, slots) in slots.iter().enumerate() {
                if slots & distance_of_bit as u32 != 0 {
                    component.0[lane] = from.0[lane];
                }
            }
        }
    }
    let [x, y, z, w] = components;
    Quaternions { x, y, z, w }
}

wide::dispatch! {
    /// Writes all rotations, and advances the keys past them.
    fn sample_rotations(clip: &PackedClip<'_>, from: &mut Key, to: &mut Key, alpha: f32, pose: &mut [Trs]) {
        sample_rotation_lanes(clip, from, to, alpha, pose);
    }
}

#[inline(always)]
fn sample_rotation_lanes(clip: &PackedClip<'_>, from: &mut Key, to: &mut Key, alpha: f32, pose: &mut [Trs]) {
    let (bytes, log2) = (&*clip.bytes, clip.log2_block_frames);
    let in_one_block = from.block == to.block;
    let (mut lines, mut next_lines) = (LineLanes::ZERO, LineLanes::ZERO);
    let (mut a, mut b) = (KeyLanes::ZERO, KeyLanes::ZERO);
    let mut step = Lanes::ZERO;
    for tracks in clip.rotations.chunks(LANES) {
        for (lane, track) in tracks.iter().enumerate() {
            step.0[lane] = track.step;
            let block = track.in_block(bytes, from.headers);
            lines.set(lane, &block);
            a.read(lane, &block, bytes, from);
            if in_one_block {
                b.read(lane, &block, bytes, to);
            } else {
                let block = track.in_block(bytes, to.headers);
                next_lines.set(lane, &block);
                b.read(lane, &block, bytes, to);
            }
        }
        let first = a.components(&lines, from.offset, log2, step);
        let lines_of_second = if in_one_block { &lines } else { &next_lines };
        let mut second = b.components(lines_of_second, to.offset, log2, step);
        if a.dropped != b.dropped {
            let mut slots = [0; LANES];
            for (lane, slots) in slots.iter_mut().enumerate() {
                *slots = b.dropped[lane].wrapping_sub(a.dropped[lane]);
            }
            second = moved_on(second, slots);
        }
        let weight = Lanes::all(alpha).negated_where_negative(first.dot(second));
        let mixed = (first * Lanes::all(1.0 - alpha) + second * weight).normalize();
        let mixed = moved_on(mixed, a.dropped);
        for (lane, track) in tracks.iter().enumerate() {
            if let Some(node) = pose.get_mut(track.node as usize) {
                node.rotation = Quat::from_array(mixed.lane(lane));
            }
        }
    }
}
