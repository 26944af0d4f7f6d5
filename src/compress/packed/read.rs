//! Opens packed clips, and checks everything that sampling relies on.

use std::borrow::Cow;

use glam::{Quat, Vec3};
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::pose::Trs;

use super::bits::{PADDING, bits_at, lowest};
use super::layout::{
    ALL_KEYS, HAS_TICKS, LOG2_BLOCK_FRAMES, Lines, MAGIC, MAX_ROTATION_BITS, MAX_TRANSLATION_BITS, MIXED, NO_PARENT,
    NODE, ROTATION, RotationTrack, TRANSLATION, TranslationTrack, VERSION, VERSION_WITH_REST, node,
};
use super::{ClipNode, PackedClip};
use crate::quantize::Lattice;

type Result<T> = std::result::Result<T, Box<Diagnostic>>;

fn invalid(message: impl Into<String>) -> Box<Diagnostic> {
    Box::new(Diagnostic::new(Code::InvalidClip, message))
}

fn expected_found(message: impl Into<String>, expected: impl Into<String>, found: impl ToString) -> Box<Diagnostic> {
    Box::new(Diagnostic::new(Code::InvalidClip, message).expected_found(expected, found.to_string()))
}

/// Reads consecutive numbers.
struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Reader<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8]> {
        let end = self.at.checked_add(count);
        let taken = end.and_then(|end| self.bytes.get(self.at..end)).ok_or_else(|| {
            expected_found(
                "the file is shorter than its header states",
                format!("{count} bytes from byte {}", self.at),
                format!("{} bytes in all", self.bytes.len()),
            )
        })?;
        self.at += count;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N]> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(N)?);
        Ok(array)
    }

    fn u16(&mut self) -> Result<u16> {
        Ok(u16::from_le_bytes(self.array()?))
    }

    fn u32(&mut self) -> Result<u32> {
        Ok(u32::from_le_bytes(self.array()?))
    }

    fn f32(&mut self) -> Result<f32> {
        let at = self.at;
        let value = f32::from_le_bytes(self.array()?);
        if value.is_finite() {
            Ok(value)
        } else {
            Err(invalid(format!("the number at byte {at} is not finite")))
        }
    }

    fn f64(&mut self) -> Result<f64> {
        let at = self.at;
        let value = f64::from_le_bytes(self.array()?);
        if value.is_finite() {
            Ok(value)
        } else {
            Err(invalid(format!("the number at byte {at} is not finite")))
        }
    }

    fn vector(&mut self) -> Result<Vec3> {
        Ok(Vec3::new(self.f32()?, self.f32()?, self.f32()?))
    }

    /// The rotation of a node.
    fn rotation(&mut self, node: usize) -> Result<Quat> {
        let rotation = Quat::from_xyzw(self.f32()?, self.f32()?, self.f32()?, self.f32()?);
        if (rotation.length_squared() - 1.0).abs() > 1e-3 {
            return Err(invalid(format!("the rotation of node {node} does not have length 1")));
        }
        Ok(rotation)
    }

    /// Checks that a table of `count` entries of `size` bytes fits into the remaining bytes, before memory is allocated
    /// for the table.
    fn expect(&self, count: usize, size: usize) -> Result<()> {
        let bytes = count.saturating_mul(size);
        let left = self.bytes.len() - self.at;
        if bytes <= left {
            return Ok(());
        }
        Err(expected_found(
            "a table is longer than the file",
            format!("at most {left} bytes from byte {}", self.at),
            format!("{count} entries of {size} bytes"),
        ))
    }
}

pub(super) fn open(bytes: Cow<'_, [u8]>) -> Result<PackedClip<'_>> {
    let mut reader = Reader { bytes: &bytes, at: 0 };
    if !bytes.starts_with(&MAGIC) {
        return Err(invalid("this is not a packed clip: it does not begin with MCLP"));
    }
    reader.take(MAGIC.len())?;
    let version = reader.u16()?;
    if !(VERSION..=VERSION_WITH_REST).contains(&version) {
        return Err(expected_found(
            "this version of packed clips cannot be read",
            format!("{VERSION} or {VERSION_WITH_REST}"),
            version.to_string(),
        ));
    }
    let log2 = u32::from(reader.u16()?);
    if !LOG2_BLOCK_FRAMES.contains(&log2) {
        return Err(expected_found(
            "blocks must have 2^4 to 2^8 frames: the exponent in the header is wrong",
            "4 to 8",
            log2.to_string(),
        ));
    }
    let [node_count, frames] = [reader.u32()? as usize, reader.u32()? as usize];
    let [ticks_per_second, duration] = [reader.f64()?, reader.f64()?];
    let max_error = reader.f32()?;
    let [rotations, translations, name_bytes] =
        [reader.u32()?, reader.u32()?, reader.u32()?].map(|count| count as usize);
    let flags = reader.u32()?;
    if node_count == 0 || node_count >= usize::from(NO_PARENT) || frames == 0 || flags & !(HAS_TICKS | ALL_KEYS) != 0 {
        return Err(invalid(
            "the header has no nodes, too many, no frames, or unknown flags",
        ));
    }
    if ticks_per_second <= 0.0 || duration < 0.0 || max_error < 0.0 {
        return Err(invalid("the rate, the duration and the error must not be below 0"));
    }
    let known = if version == VERSION { node::FIRST } else { u8::MAX };
    let Nodes {
        nodes,
        rest,
        at_rest,
        driven: [rotates, translates],
    } = read_nodes(&mut reader, node_count, name_bytes, known)?;
    if rotates.len() != rotations || translates.len() != translations {
        return Err(expected_found(
            "the number of tracks in the header does not match the nodes",
            format!("{} rotations and {} translations", rotates.len(), translates.len()),
            format!("{rotations} and {translations}"),
        ));
    }
    let ticks = (flags & HAS_TICKS != 0).then_some(reader.at);
    let mut last_tick = (frames - 1) as f64;
    if ticks.is_some() {
        reader.expect(frames, size_of::<f64>())?;
        for frame in 0..frames {
            let tick = reader.f64()?;
            let last = std::mem::replace(&mut last_tick, tick);
            if frame == 0 && tick != 0.0 {
                return Err(expected_found("the tick of the first frame is wrong", "0", tick));
            }
            if frame > 0 && tick <= last {
                return Err(invalid(format!(
                    "the tick of frame {frame} is not above the previous tick"
                )));
            }
        }
    }
    if !(last_tick..last_tick + 1.0).contains(&duration) {
        return Err(expected_found(
            "the duration does not match the frames",
            format!("at least {last_tick}, and less than 1 above it"),
            duration,
        ));
    }
    let (rotations, translations, header_bits) = read_tracks(&mut reader, &rotates, &translates)?;
    let has_blocks = !(rotations.is_empty() && translations.is_empty());
    let blocks = if has_blocks { frames.div_ceil(1 << log2) } else { 0 };
    reader.expect(blocks + 1, size_of::<u32>())?;
    let table = reader.at;
    reader.take((blocks + 1) * size_of::<u32>())?;
    let clip = PackedClip {
        rest,
        at_rest,
        nodes,
        rotations,
        translations,
        frames,
        ticks_per_second,
        duration,
        max_error,
        log2_block_frames: log2,
        mask_bytes: if flags & ALL_KEYS != 0 { 0 } else { (1 << log2) / 8 },
        header_bits,
        ticks,
        table,
        blocks: reader.at,
        bytes,
    };
    check_blocks(&clip, blocks)?;
    Ok(clip)
}

/// The contents of the table of nodes. `rest` has the constant transforms; `at_rest` has the transforms of the rest
/// pose that differ from the constant transforms. `driven` lists the rotating nodes, and the translating nodes.
struct Nodes {
    nodes: Vec<ClipNode>,
    rest: Vec<Trs>,
    at_rest: Vec<(u32, Trs)>,
    driven: [Vec<u32>; 2],
}

/// `known` are the allowed flags of a node.
fn read_nodes(reader: &mut Reader<'_>, count: usize, name_bytes: usize, known: u8) -> Result<Nodes> {
    reader.expect(count, NODE)?;
    let mut table = Reader {
        bytes: reader.take(count * NODE)?,
        at: 0,
    };
    let first_name = reader.at;
    reader.take(name_bytes)?;
    let mut name = first_name;
    let (mut nodes, mut rest) = (Vec::with_capacity(count), Vec::with_capacity(count));
    let (mut driven, mut at_rest) = ([Vec::new(), Vec::new()], Vec::new());
    for index in 0..count {
        let parent = Some(table.u16()?).filter(|parent| *parent != NO_PARENT);
        let [flags] = table.array()?;
        let end = name + usize::from(table.u16()?);
        if !is_depth_first(&nodes, parent) {
            return Err(expected_found(
                "the nodes are not in depth-first order",
                format!("node {index} as a child of the previous node or of its ancestors"),
                parent.map_or_else(|| "no parent".to_owned(), |parent| format!("parent {parent}")),
            ));
        }
        if flags & !known != 0 {
            return Err(invalid(format!("node {index} has unknown flags")));
        }
        if end > first_name + name_bytes || std::str::from_utf8(&reader.bytes[name..end]).is_err() {
            return Err(invalid(format!(
                "the name of node {index} is not UTF-8, or longer than all names"
            )));
        }
        nodes.push(ClipNode {
            parent,
            is_end_site: flags & node::END_SITE != 0,
            name: (name, end),
        });
        name = end;
        let mut trs = Trs::IDENTITY;
        if flags & node::ROTATION != 0 {
            trs.rotation = reader.rotation(index)?;
        }
        if flags & node::TRANSLATION != 0 {
            trs.translation = reader.vector()?;
        }
        if flags & node::SCALE != 0 {
            trs.scale = reader.vector()?;
        }
        rest.push(trs);
        if flags & node::REST_ROTATION != 0 {
            trs.rotation = reader.rotation(index)?;
        }
        if flags & node::REST_TRANSLATION != 0 {
            trs.translation = reader.vector()?;
        }
        if flags & !node::FIRST != 0 {
            at_rest.push((index as u32, trs));
        }
        for (flag, driven) in std::iter::zip([node::ROTATES, node::TRANSLATES], &mut driven) {
            if flags & flag != 0 {
                driven.push(index as u32);
            }
        }
    }
    Ok(Nodes {
        nodes,
        rest,
        at_rest,
        driven,
    })
}

/// Whether a node with this parent may follow `nodes`. The parent must be the last of `nodes`, or an ancestor of the
/// last.
fn is_depth_first(nodes: &[ClipNode], parent: Option<u16>) -> bool {
    let Some(parent) = parent.map(usize::from) else {
        return nodes.is_empty();
    };
    let mut above = nodes.len().checked_sub(1);
    while let Some(node) = above.filter(|node| *node > parent) {
        above = nodes[node].parent.map(usize::from);
    }
    above == Some(parent)
}

type Tracks = (Vec<RotationTrack>, Vec<TranslationTrack>, usize);

/// The tracks, and the bits of their headers in a block.
fn read_tracks(reader: &mut Reader<'_>, rotates: &[u32], translates: &[u32]) -> Result<Tracks> {
    let mut header = 0;
    let (mut rotations, mut translations) = (Vec::new(), Vec::new());
    reader.expect(rotates.len(), ROTATION)?;
    for &node in rotates {
        let max = reader.u16()?;
        if !(1..=i16::MAX as u16).contains(&max) {
            return Err(invalid(format!(
                "the lattice of node {node} must have 1 to 32,767 steps, not {max}"
            )));
        }
        let mut six = [0i32; 6];
        for number in &mut six {
            *number = i16::from_le_bytes(reader.array()?).into();
        }
        let lines = read_lines(reader, six, MAX_ROTATION_BITS, node)?;
        let step = 1.0 / Lattice::of_max(max).scale();
        rotations.push(RotationTrack {
            node,
            header,
            step,
            lines,
        });
        header += RotationTrack::header_bits(&lines);
    }
    reader.expect(translates.len(), TRANSLATION)?;
    for &node in translates {
        let step = reader.f32()?;
        let mut six = [0i32; 6];
        for number in &mut six {
            *number = i32::from_le_bytes(reader.array()?);
        }
        let lines = read_lines(reader, six, MAX_TRANSLATION_BITS, node)?;
        translations.push(TranslationTrack {
            node,
            header,
            step,
            lines,
        });
        header += TranslationTrack::header_bits(&lines);
    }
    Ok((rotations, translations, header as usize))
}

fn read_lines(reader: &mut Reader<'_>, [a, b, c, d, e, f]: [i32; 6], most: u32, node: u32) -> Result<Lines> {
    let mut lines = Lines {
        least: [a, b, c],
        least_rise: [d, e, f],
        bits: reader.array()?,
        rise_bits: reader.array()?,
        all_bits: 0,
    };
    lines.all_bits = lines.bits.iter().fold(0, |sum, bits| sum.wrapping_add(*bits));
    if lines
        .bits
        .iter()
        .chain(&lines.rise_bits)
        .all(|bits| u32::from(*bits) <= most)
    {
        return Ok(lines);
    }
    Err(invalid(format!("the lines of node {node} have more than {most} bits")))
}

/// Checks that the blocks are consecutive in the file, and that their headers match their lengths.
fn check_blocks(clip: &PackedClip<'_>, blocks: usize) -> Result<()> {
    let bytes = &*clip.bytes;
    let Some(after) = bytes.len().checked_sub(clip.blocks + PADDING) else {
        return Err(invalid("the file ends before its blocks"));
    };
    let offset = |block: usize| lowest(bits_at(bytes, 8 * (clip.table + 4 * block)), 32) as usize;
    if offset(0) != 0 || offset(blocks) != after {
        return Err(expected_found(
            "the length of the blocks does not match the length of the file",
            format!("{after} bytes"),
            offset(blocks).to_string(),
        ));
    }
    for block in 0..blocks {
        let at_block = |what: &str| invalid(format!("block {block}: {what}"));
        let (start, length) = (clip.block_start(block), offset(block + 1).checked_sub(offset(block)));
        let length = length
            .filter(|_| offset(block + 1) <= after)
            .ok_or_else(|| at_block("the block ends before its start, or beyond the file"))?;
        let log2 = clip.log2_block_frames;
        let frames = (clip.frames - (block << log2)).min(1 << log2);
        if length < 4 + clip.mask_bytes {
            return Err(at_block("the block is too short"));
        }
        let keys = if clip.mask_bytes == 0 {
            frames
        } else {
            let mask = clip.mask(start);
            for (word, keys) in mask.iter().enumerate() {
                let of_word = frames.saturating_sub(64 * word);
                let possible = if of_word >= 64 { u64::MAX } else { (1 << of_word) - 1 };
                if keys & !possible != 0 || (of_word > 0 && keys & 1 == 0) {
                    return Err(at_block(
                        "a frame beyond the end has a key, or a frame whose number is divisible by 64 has no key",
                    ));
                }
            }
            let last = frames - 1;
            if block + 1 == blocks && mask[last / 64] >> (last % 64) & 1 == 0 {
                return Err(at_block("the last frame has no key"));
            }
            mask.iter().map(|word| word.count_ones() as usize).sum()
        };
        let headers = 8 * (start + 4 + clip.mask_bytes);
        let stated = lowest(bits_at(bytes, 8 * start), 32) as usize;
        if (clip.header_bits + keys.saturating_mul(stated)).div_ceil(8) != length - 4 - clip.mask_bytes {
            return Err(at_block("its length does not match its number of keys"));
        }
        let mut key_bits = 0;
        for track in &clip.rotations {
            let track = track.in_block(bytes, headers);
            if track.kind > MIXED {
                return Err(at_block("a rotation has an unknown kind"));
            }
            key_bits += track.key_bits();
        }
        for track in &clip.translations {
            let track = track.in_block(bytes, headers);
            if track.widths.iter().any(|width| *width > MAX_TRANSLATION_BITS) {
                return Err(at_block("a translation has too many bits"));
            }
            key_bits += track.key_bits();
        }
        if key_bits as usize != stated {
            return Err(at_block(
                "the bits of its tracks do not add up to the stated bits of a key",
            ));
        }
    }
    Ok(())
}
