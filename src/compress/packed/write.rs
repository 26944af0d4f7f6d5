//! Writes packed clips.

use std::ops::Range;

use glam::{Quat, Vec3};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::pose::Trs;
use mocap_scene::scene::{NodeKind, Scene};

use super::bits::{BitWriter, PADDING};
use super::layout::{
    ALL_KEYS, DROPPED_BITS, HAS_TICKS, KIND_BITS, LOG2_BLOCK_FRAMES, MAGIC, MAX_ROTATION_BITS, MAX_TRANSLATION_BITS,
    MIXED, MUST_HAVE_KEY, NO_PARENT, ROTATION_WIDTH_BITS, RotationTrack, TRANSLATION_WIDTH_BITS, TranslationTrack,
    VERSION, VERSION_WITH_REST, node, on_line, rotation_width_code,
};
use super::lines::{AxisBlock, AxisLines, lines_of};
use crate::at_rest::{is_rotation_of_rest, is_translation_of_rest};
use crate::clip::{CompressedClip, CompressedTrack, Track};
use crate::quantize::{QuantizedRotation, RotationFormat, TranslationFormat};
use crate::{Encoding, ErrorBound, compress};

/// The packed form of an animation with the keys of `encoding`, and the packed values.
pub(super) fn encode(
    scene: &Scene,
    animation: usize,
    bound: &ErrorBound,
    encoding: &dyn Encoding,
) -> Result<(Vec<u8>, CompressedClip)> {
    let found = scene.animations.get(animation);
    let animation = found.ok_or_else(|| {
        let count = scene.animations.len();
        let message =
            format!("a packed clip consists of motion, but there is no animation {animation}: the scene has {count}");
        Diagnostic::new(Code::Unrepresentable, message)
    })?;
    if !(1..usize::from(NO_PARENT)).contains(&scene.nodes.len()) {
        let message = "the number of nodes does not fit a packed clip";
        return Err(Diagnostic::new(Code::Unrepresentable, message)
            .expected_found(format!("1 to {}", NO_PARENT - 1), scene.nodes.len().to_string())
            .into());
    }
    let clip = compress(scene, animation, bound, encoding)?;
    let file = File {
        scene,
        ticks_per_second: animation.ticks_per_second,
        duration: animation.duration,
        clip: &clip,
    };
    let bytes = file.bytes()?;
    Ok((bytes, clip))
}

/// The approximate bytes of the key frames of a clip. The other bytes are the same for all clips of a scene.
pub(super) fn packed_size(clip: &CompressedClip) -> usize {
    Columns::of(clip).smallest().1.bytes()
}

struct File<'a> {
    scene: &'a Scene,
    ticks_per_second: f64,
    duration: f64,
    clip: &'a CompressedClip,
}

/// The keys of all tracks, in a column per component.
struct Columns<'a> {
    frames: usize,
    key_frames: &'a [u32],
    has_all_keys: bool,
    rotations: Vec<RotationColumns<'a>>,
    translations: Vec<TranslationColumns>,
}

struct RotationColumns<'a> {
    max: i32,
    keys: &'a [QuantizedRotation],
    axes: [Vec<i32>; 3],
}

struct TranslationColumns {
    step: f32,
    axes: [Vec<i32>; 3],
}

impl<'a> Columns<'a> {
    fn of(clip: &'a CompressedClip) -> Self {
        let mut shared: &[u32] = &[];
        let (mut rotations, mut translations) = (Vec::new(), Vec::new());
        for track in &clip.tracks {
            if let Track::Animated {
                format: RotationFormat::SmallestThree(lattice),
                key_frames,
                keys,
            } = &track.rotation
            {
                shared = key_frames;
                let axis = |axis: usize| keys.iter().map(|key| i32::from(key.stored[axis])).collect();
                rotations.push(RotationColumns {
                    max: lattice.max(),
                    keys,
                    axes: [0, 1, 2].map(axis),
                });
            }
            if let Track::Animated {
                format: TranslationFormat::Multiples(step),
                key_frames,
                keys,
            } = &track.translation
            {
                shared = key_frames;
                let axis = |axis: usize| keys.iter().map(|key| key.stored[axis] as i32).collect();
                translations.push(TranslationColumns {
                    step: *step,
                    axes: [0, 1, 2].map(axis),
                });
            }
        }
        Self {
            frames: clip.ticks.len(),
            key_frames: shared,
            has_all_keys: shared.len() == clip.ticks.len(),
            rotations,
            translations,
        }
    }

    fn is_empty(&self) -> bool {
        self.rotations.is_empty() && self.translations.is_empty()
    }

    /// The blocks of the length that takes the fewest bytes, and the binary logarithm of the length.
    fn smallest(&self) -> (u32, Blocks) {
        let lengths = LOG2_BLOCK_FRAMES.filter(|log2| self.has_all_keys || 1 << log2 >= MUST_HAVE_KEY);
        let blocks = lengths.map(|log2| (log2, self.blocks(log2)));
        let smallest = blocks.min_by_key(|(_, blocks)| blocks.bytes());
        smallest.unwrap_or_else(|| (*LOG2_BLOCK_FRAMES.end(), self.blocks(*LOG2_BLOCK_FRAMES.end())))
    }

    /// The lines of all tracks in blocks of one length.
    fn blocks(&self, log2: u32) -> Blocks {
        let count = if self.is_empty() {
            0
        } else {
            self.frames.div_ceil(1 << log2)
        };
        let key_at = |frame: usize| self.key_frames.partition_point(|key| (*key as usize) < frame);
        let keys: Vec<Range<usize>> = (0..count)
            .map(|block| key_at(block << log2)..key_at((block + 1) << log2))
            .collect();
        let lines = |axes: &[Vec<i32>; 3], most: u32| {
            axes.each_ref()
                .map(|axis| AxisLines::fit(axis, self.key_frames, &keys, log2, most))
        };
        let rotations = self.rotations.iter().map(|track| {
            let kinds = keys.iter().map(|keys| kind(&track.keys[keys.clone()])).collect();
            (lines(&track.axes, MAX_ROTATION_BITS), kinds)
        });
        Blocks {
            log2,
            mask_bytes: if self.has_all_keys || self.is_empty() {
                0
            } else {
                (1 << log2) / 8
            },
            rotations: rotations.collect(),
            translations: self
                .translations
                .iter()
                .map(|track| lines(&track.axes, MAX_TRANSLATION_BITS))
                .collect(),
            keys,
        }
    }
}

/// The kind of a rotation track in a block.
fn kind(keys: &[QuantizedRotation]) -> u32 {
    let first = keys.first().map_or(0, QuantizedRotation::dropped);
    if keys.iter().all(|key| key.dropped() == first) {
        first as u32
    } else {
        MIXED
    }
}

/// The lines of all tracks, and the keys of every block.
struct Blocks {
    log2: u32,
    mask_bytes: usize,
    keys: Vec<Range<usize>>,
    rotations: Vec<([AxisLines; 3], Vec<u32>)>,
    translations: Vec<[AxisLines; 3]>,
}

impl Blocks {
    /// Bits of all track headers of a block.
    fn header_bits(&self) -> usize {
        let rotations = self
            .rotations
            .iter()
            .map(|(axes, _)| RotationTrack::header_bits(&lines_of(axes)));
        let translations = self
            .translations
            .iter()
            .map(|axes| TranslationTrack::header_bits(&lines_of(axes)));
        rotations.chain(translations).sum::<u32>() as usize
    }

    /// The number of bits of one key frame in a block, over all tracks.
    fn key_bits(&self, block: usize) -> usize {
        let rotations = self.rotations.iter().map(|(axes, kinds)| {
            let dropped = if kinds[block] == MIXED { DROPPED_BITS } else { 0 };
            dropped + axes.iter().map(|axis| axis.rotation_width(block)).sum::<u32>()
        });
        let translations = self.translations.iter().flatten().map(|axis| axis.blocks[block].width);
        (rotations.sum::<u32>() + translations.sum::<u32>()) as usize
    }

    /// Bytes of all blocks and their offsets.
    fn bytes(&self) -> usize {
        let header_bits = self.header_bits();
        let block = |(block, keys): (usize, &Range<usize>)| {
            8 + self.mask_bytes + (header_bits + keys.len() * self.key_bits(block)).div_ceil(8)
        };
        self.keys.iter().enumerate().map(block).sum()
    }
}

impl File<'_> {
    fn bytes(&self) -> Result<Vec<u8>, Box<Diagnostic>> {
        let columns = Columns::of(self.clip);
        let (log2, blocks) = columns.smallest();
        let ticks = &self.clip.ticks;
        let has_ticks = ticks.iter().enumerate().any(|(frame, tick)| *tick != frame as f64);
        let mut flags = 0;
        if has_ticks {
            flags |= HAS_TICKS;
        }
        if blocks.mask_bytes == 0 {
            flags |= ALL_KEYS;
        }
        let names: usize = self.scene.nodes.iter().map(|node| node.name.len()).sum();
        let has_rest = std::iter::zip(&self.scene.nodes, &self.clip.tracks)
            .any(|(node, track)| rest_flags(&Trs::from_matrix(node.transform), track) != 0);
        let version = if has_rest { VERSION_WITH_REST } else { VERSION };
        let mut out = MAGIC.to_vec();
        out.extend(version.to_le_bytes());
        out.extend((log2 as u16).to_le_bytes());
        for number in [self.scene.nodes.len(), ticks.len()] {
            out.extend(fits_u32(number)?.to_le_bytes());
        }
        out.extend(self.ticks_per_second.to_le_bytes());
        out.extend(self.duration.to_le_bytes());
        out.extend((self.clip.error.max as f32).next_up().to_le_bytes());
        for number in [columns.rotations.len(), columns.translations.len(), names] {
            out.extend(fits_u32(number)?.to_le_bytes());
        }
        out.extend(flags.to_le_bytes());
        self.nodes(&mut out)?;
        if has_ticks {
            out.extend(ticks.iter().flat_map(|tick| tick.to_le_bytes()));
        }
        tracks(&columns, &blocks, &mut out);
        let mut offsets = vec![0u32];
        let mut bytes = Vec::new();
        for block in 0..blocks.keys.len() {
            write_block(&columns, &blocks, block, &mut bytes);
            offsets.push(fits_u32(bytes.len())?);
        }
        out.extend(offsets.iter().flat_map(|offset| offset.to_le_bytes()));
        out.extend(bytes);
        out.extend([0; PADDING]);
        Ok(out)
    }

    /// Writes the table of nodes, their names and their values.
    fn nodes(&self, out: &mut Vec<u8>) -> Result<(), Box<Diagnostic>> {
        let mut values: Vec<f32> = Vec::new();
        for (scene_node, track) in std::iter::zip(&self.scene.nodes, &self.clip.tracks) {
            let mut flags = 0;
            let rest = Trs::from_matrix(scene_node.transform);
            let rotation = match &track.rotation {
                Track::Constant(value) => *value,
                Track::Animated { .. } => {
                    flags |= node::ROTATES;
                    rest.rotation
                }
            };
            let translation = match &track.translation {
                Track::Constant(value) => *value,
                Track::Animated { .. } => {
                    flags |= node::TRANSLATES;
                    rest.translation
                }
            };
            if scene_node.kind == NodeKind::EndSite {
                flags |= node::END_SITE;
            }
            if rotation != Quat::IDENTITY {
                flags |= node::ROTATION;
                values.extend(rotation.to_array());
            }
            if translation != Vec3::ZERO {
                flags |= node::TRANSLATION;
                values.extend(translation.to_array());
            }
            if rest.scale.distance(Vec3::ONE) > 1e-6 {
                flags |= node::SCALE;
                values.extend(rest.scale.to_array());
            }
            let at_rest = rest_flags(&rest, track);
            flags |= at_rest;
            if at_rest & node::REST_ROTATION != 0 {
                values.extend(rest.rotation.to_array());
            }
            if at_rest & node::REST_TRANSLATION != 0 {
                values.extend(rest.translation.to_array());
            }
            let parent = scene_node.parent.map_or(NO_PARENT, |parent| parent.0 as u16);
            out.extend(parent.to_le_bytes());
            out.push(flags);
            let length = u16::try_from(scene_node.name.len()).map_err(|_| {
                let message = "a name of more than 65,535 bytes cannot be in a packed clip";
                Diagnostic::new(Code::Unrepresentable, message).in_joint(&scene_node.name)
            })?;
            out.extend(length.to_le_bytes());
        }
        out.extend(self.scene.nodes.iter().flat_map(|node| node.name.bytes()));
        out.extend(values.iter().flat_map(|value| value.to_le_bytes()));
        Ok(())
    }
}

/// Flags for the components of a node that are constant in the motion and differ in the rest pose.
fn rest_flags(rest: &Trs, track: &CompressedTrack) -> u8 {
    let mut flags = 0;
    if let Track::Constant(rotation) = &track.rotation
        && !is_rotation_of_rest(*rotation, rest.rotation)
    {
        flags |= node::REST_ROTATION;
    }
    if let Track::Constant(translation) = &track.translation
        && !is_translation_of_rest(*translation, rest.translation)
    {
        flags |= node::REST_TRANSLATION;
    }
    flags
}

fn fits_u32(number: usize) -> Result<u32, Box<Diagnostic>> {
    u32::try_from(number).map_err(|_| {
        let message = "a packed clip has at most 4 GiB and 2^32 frames";
        Box::new(Diagnostic::new(Code::Unrepresentable, message))
    })
}

/// Writes the tables of tracks.
fn tracks(columns: &Columns, blocks: &Blocks, out: &mut Vec<u8>) {
    for (track, (axes, _)) in std::iter::zip(&columns.rotations, &blocks.rotations) {
        let lines = lines_of(axes);
        out.extend((track.max as u16).to_le_bytes());
        for number in lines.least.into_iter().chain(lines.least_rise) {
            out.extend((number as i16).to_le_bytes());
        }
        out.extend(lines.bits);
        out.extend(lines.rise_bits);
    }
    for (track, axes) in std::iter::zip(&columns.translations, &blocks.translations) {
        let lines = lines_of(axes);
        out.extend(track.step.to_le_bytes());
        for number in lines.least.into_iter().chain(lines.least_rise) {
            out.extend(number.to_le_bytes());
        }
        out.extend(lines.bits);
        out.extend(lines.rise_bits);
    }
}

fn write_block(columns: &Columns, blocks: &Blocks, block: usize, out: &mut Vec<u8>) {
    let keys = blocks.keys[block].clone();
    let first = block << blocks.log2;
    out.extend((blocks.key_bits(block) as u32).to_le_bytes());
    let mut mask = vec![0u8; blocks.mask_bytes];
    for &frame in &columns.key_frames[keys.clone()] {
        let offset = frame as usize - first;
        if let Some(byte) = mask.get_mut(offset / 8) {
            *byte |= 1 << (offset % 8);
        }
    }
    out.extend(mask);
    let mut bits = BitWriter::default();
    let push_lines = |bits: &mut BitWriter, axes: &[AxisLines; 3]| {
        for axis in axes {
            bits.push(axis.blocks[block].number.wrapping_sub(axis.least) as u32, axis.bits);
        }
        for axis in axes {
            bits.push(
                axis.blocks[block].rise.wrapping_sub(axis.least_rise) as u32,
                axis.rise_bits,
            );
        }
    };
    for (axes, kinds) in &blocks.rotations {
        bits.push(kinds[block], KIND_BITS);
        for axis in axes {
            bits.push(rotation_width_code(axis.rotation_width(block)), ROTATION_WIDTH_BITS);
        }
        push_lines(&mut bits, axes);
    }
    for axes in &blocks.translations {
        for axis in axes {
            bits.push(axis.blocks[block].width, TRANSLATION_WIDTH_BITS);
        }
        push_lines(&mut bits, axes);
    }
    for key in keys {
        let offset = columns.key_frames[key] as i32 - first as i32;
        let above = |axis: &AxisLines, value: i32| {
            let AxisBlock { number, rise, .. } = axis.blocks[block];
            value.wrapping_sub(on_line((number, rise), offset, blocks.log2)) as u32
        };
        for (track, (axes, kinds)) in std::iter::zip(&columns.rotations, &blocks.rotations) {
            if kinds[block] == MIXED {
                bits.push(track.keys[key].dropped() as u32, DROPPED_BITS);
            }
            for (axis, values) in std::iter::zip(axes, &track.axes) {
                bits.push(above(axis, values[key]), axis.rotation_width(block));
            }
        }
        for (track, axes) in std::iter::zip(&columns.translations, &blocks.translations) {
            for (axis, values) in std::iter::zip(axes, &track.axes) {
                bits.push(above(axis, values[key]), axis.blocks[block].width);
            }
        }
    }
    bits.align();
    out.extend(bits.bytes);
}
