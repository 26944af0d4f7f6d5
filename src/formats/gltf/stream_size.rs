//! Computes the size of a meshopt vertex codec stream, version 0, without encoding it.
//!
//! The format is described in EXT_meshopt_compression, appendix A:
//! <https://github.com/KhronosGroup/glTF/tree/main/extensions/2.0/Vendor/EXT_meshopt_compression>

use std::sync::Arc;

use mocap_compress::{CompressedClip, KeyFrames, Track};

/// The number of elements that are encoded together.
const GROUP: usize = 16;

/// Seconds per tick at 100 frames per second, which represents any frame rate.
const SECONDS_IN_A_TICK: f32 = 0.01;

/// The approximate bytes of all keys of a clip and their times.
pub(super) fn of_clip(clip: &CompressedClip) -> usize {
    let mut size = 0;
    for track in &clip.tracks {
        if let Track::Animated { keys, .. } = &track.translation {
            size += stream_size(keys.len(), |key| keys[key].stored);
        }
        if let Track::Animated { keys, .. } = &track.rotation {
            size += stream_size(keys.len(), |key| words(keys[key].stored));
        }
    }
    let times = |key_frames: &&Arc<KeyFrames>| {
        stream_size(key_frames.len(), |key| {
            [(clip.ticks[key_frames[key] as usize] as f32 * SECONDS_IN_A_TICK).to_bits()]
        })
    };
    size + clip.distinct_key_frames().iter().map(times).sum::<usize>()
}

/// An element of four 16-bit integers as two words.
fn words(element: [i16; 4]) -> [u32; 2] {
    let word = |low: i16, high: i16| u32::from(low as u16) | (u32::from(high as u16) << 16);
    [word(element[0], element[1]), word(element[2], element[3])]
}

/// The bytes of a stream of `len` elements of `N` words.
///
/// Each byte of an element is encoded separately, as the difference to the same byte of the previous element. For every
/// group of elements two bits state the bits per difference: 0, 2, 4 or 8. A difference that does not fit into 2 or 4
/// bits takes another byte.
fn stream_size<const N: usize>(len: usize, element: impl Fn(usize) -> [u32; N]) -> usize {
    let mut bits = 0;
    let mut before = if len > 0 { element(0) } else { [0; N] };
    for start in (0..len).step_by(GROUP) {
        let end = (start + GROUP).min(len);
        // For every byte of an element: the number of nonzero differences, of differences beyond 2 bits, and beyond 4
        // bits.
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
        for [not_0, not_in_2, not_in_4] in counts.into_iter().flatten() {
            bits += 2 + match not_0 {
                0 => 0,
                _ => (32 + 8 * not_in_2).min(64 + 8 * not_in_4).min(128),
            };
        }
    }
    bits as usize / 8
}
