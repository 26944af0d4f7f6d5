//! Packs the keys of a clip as blocks of bytes, which a page unpacks one after another.
//!
//! A block has a range of frames of every animated track. Each component of a track is a row of numbers. A row is
//! stored as its least value, a step, and for each frame the number of steps above the least value. A row has the
//! fewest bytes per frame for which the step is within the precision. If no such step exists, the row has 32-bit
//! floats. A rotation omits the component that stays farthest from zero, because a quaternion has length 1. (Smallest
//! three, as in Glenn Fiedler's "Snapshot Compression", with the ranges of a run of frames, as in ACL.)
//!
//! The positions of all joints are compared with the source in every frame. If a joint of a block deviates by more than
//! [`MAX_ERROR`], the block is packed again with finer steps.
//!
//! In a page that is written as a file, a block is a packed clip (`pack/clip_block.rs`) if possible. A packed clip has
//! less than half of the bytes of rows, and takes several times as long to write.

mod clip_block;

use std::ops::Range;

use glam::{Quat, Vec3, Vec4};
use mocap_scene::pose::{Binding, Pose, Trs};
use mocap_scene::scene::{Animation, Channel, Keys, Scene};

use self::clip_block::ClipBlocks;

/// The largest size in bytes, as 32-bit floats, of keys that are stored without any error.
const EXACT_BYTES: usize = 4 << 20;

/// The approximate size of a block in bytes.
const BLOCK_BYTES: usize = 1 << 20;

/// Half a step in a component of a rotation: two bytes per frame hold the component over the range from -1 to 1.
pub const ROTATION_PRECISION: f64 = 1.0 / 65_000.0;

/// Half a step in a translation, as a fraction of the figure's reach. Also half a step in a scale.
const LINEAR_PRECISION: f64 = 1e-5;

/// The largest distance of a joint from its position in the file, as a fraction of the figure's reach.
const MAX_ERROR: f64 = 1e-4;

/// The size in bytes, as 32-bit floats, above which a page that is written as a file has keys within
/// [`LONG_MAX_ERROR`]. This size is half an hour at 120 frames per second.
const LONG_BYTES: usize = 128 << 20;

/// As [`MAX_ERROR`], a fraction of the figure's reach, for motions larger than [`LONG_BYTES`]. This distance is 1.4 mm
/// for a person, less than a pixel if the figure fills a screen of 1080 lines.
const LONG_MAX_ERROR: f64 = 1.5e-3;

/// The smallest component of a unit quaternion that may be omitted: the largest of the four is at least a half.
const LEAST_LEFT_OUT: f32 = 0.5;

/// One of the three tracks of a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    Translation,
    Rotation,
    Scale,
}

/// The storage of long motions' blocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Storage {
    /// Rows, which are written fast: for a player that is already loaded.
    Rows,
    /// Packed clips, which are small: for a file.
    Clips,
}

/// A track with a value for every tick.
pub struct Track<'a> {
    #[doc(hidden)]
    pub node: usize,
    pub(super) part: Part,
    channel: &'a Channel,
    rest: Trs,
}

/// Half of the largest allowed steps.
#[derive(Clone, Copy)]
struct Precision {
    rotation: f64,
    linear: f64,
    scale: f64,
}

/// The numbers of one component in a range of frames.
pub type Row = Vec<f32>;

/// The keys of a clip.
pub struct Packed {
    pub(super) frames_per_block: usize,
    pub blocks: Vec<Vec<u8>>,
    /// The largest distance of a joint from its position in the file, in any frame, in the file's unit.
    pub max_error: f64,
}

/// The animated tracks of a clip, in the order of the nodes.
pub struct Tracks<'a> {
    scene: &'a Scene,
    animation: Option<&'a Animation>,
    frames: usize,
    tracks: Vec<Track<'a>>,
}

impl<'a> Tracks<'a> {
    pub fn new(scene: &'a Scene, frames: u64) -> Self {
        Self {
            scene,
            animation: scene.animations.first(),
            frames: frames as usize,
            tracks: Vec::new(),
        }
    }

    /// Adds a track, and returns its number.
    pub fn push(&mut self, node: usize, part: Part, channel: &'a Channel, rest: Trs) -> usize {
        self.tracks.push(Track {
            node,
            part,
            channel,
            rest,
        });
        self.tracks.len() - 1
    }

    /// Packs all tracks. `reach` is the reach of the figure, in the file's unit.
    pub fn pack(&self, storage: Storage, reach: f64, metres_per_unit: f64) -> Packed {
        match 4 * self.components() * self.frames <= EXACT_BYTES {
            true => self.pack_blocks(true, None, reach),
            false => self.pack_all(storage, reach, metres_per_unit),
        }
    }

    /// Packs all tracks of a motion of any length in the way in which [`Self::pack`] packs a long motion.
    pub fn pack_all(&self, storage: Storage, reach: f64, metres_per_unit: f64) -> Packed {
        let clips = match storage {
            Storage::Clips => ClipBlocks::new(self.scene, self.animation, &self.tracks, metres_per_unit),
            Storage::Rows => None,
        };
        self.pack_blocks(false, clips, reach)
    }

    fn components(&self) -> usize {
        self.tracks.iter().map(|track| track.part.components()).sum()
    }

    pub fn pack_blocks(&self, is_exact: bool, mut clips: Option<ClipBlocks>, reach: f64) -> Packed {
        let components = self.components();
        let frames_per_block = (BLOCK_BYTES / (2 * components).max(1)).clamp(64, 1 << 16);
        let is_long = 4 * components * self.frames > LONG_BYTES;
        let clip_error = reach * if is_long { LONG_MAX_ERROR } else { MAX_ERROR };
        let mut packed = Packed {
            frames_per_block,
            blocks: Vec::new(),
            max_error: 0.0,
        };
        let mut error = ErrorMetric::new(self.scene, self.animation);
        for first in (0..self.frames).step_by(frames_per_block) {
            let frames = first..self.frames.min(first + frames_per_block);
            let source: Vec<Vec<Row>> = self.tracks.iter().map(|track| track.rows(frames.clone())).collect();
            let clip = clips
                .as_mut()
                .and_then(|clips| clips.pack(&self.tracks, &source, &frames, clip_error));
            if let Some((bytes, distance)) = clip {
                packed.blocks.push(bytes);
                packed.max_error = packed.max_error.max(distance);
                continue;
            }
            let finer_and_finer: &[f64] = if is_exact { &[] } else { &[1.0, 1.0 / 16.0] };
            let coarsest = finer_and_finer.iter().find_map(|factor| {
                let precision = Precision {
                    rotation: ROTATION_PRECISION * factor,
                    linear: LINEAR_PRECISION * factor * reach,
                    scale: LINEAR_PRECISION * factor,
                };
                let (bytes, unpacked) = self.pack_block(&source, precision);
                let distance = error.largest(&self.tracks, &unpacked, frames.clone());
                (distance <= MAX_ERROR * reach).then_some((bytes, distance))
            });
            let (bytes, distance) = coarsest.unwrap_or_else(|| (self.pack_block(&source, Precision::EXACT).0, 0.0));
            packed.blocks.push(bytes);
            packed.max_error = packed.max_error.max(distance);
        }
        packed
    }

    /// The bytes, and the rows that a page decodes from them.
    fn pack_block(&self, source: &[Vec<Row>], precision: Precision) -> (Vec<u8>, Vec<Vec<Row>>) {
        let mut bytes = Vec::new();
        let pack_track = |(track, rows): (&Track<'_>, &Vec<Row>)| match track.part {
            Part::Translation => pack_rows(rows, precision.linear, &mut bytes),
            Part::Scale => pack_rows(rows, precision.scale, &mut bytes),
            Part::Rotation => pack_rotations(rows, precision.rotation, &mut bytes),
        };
        let unpacked = self.tracks.iter().zip(source).map(pack_track).collect();
        (bytes, unpacked)
    }
}

impl Precision {
    const EXACT: Self = Self {
        rotation: 0.0,
        linear: 0.0,
        scale: 0.0,
    };
}

impl Part {
    const fn components(self) -> usize {
        match self {
            Self::Rotation => 4,
            Self::Translation | Self::Scale => 3,
        }
    }
}

impl Track<'_> {
    fn rows(&self, frames: Range<usize>) -> Vec<Row> {
        let Self { channel, rest, .. } = self;
        match self.part {
            Part::Translation => vectors(&channel.position_keys, rest.translation, frames),
            Part::Scale => vectors(&channel.scaling_keys, rest.scale, frames),
            Part::Rotation => {
                let value = |tick| channel.rotation_keys.sample(tick).unwrap_or(rest.rotation).to_array();
                rows_of(frames, value)
            }
        }
    }
}

fn vectors(keys: &Keys<Vec3>, rest: Vec3, frames: Range<usize>) -> Vec<Row> {
    rows_of(frames, |tick| keys.sample(tick).unwrap_or(rest).to_array())
}

fn rows_of<const N: usize>(frames: Range<usize>, value: impl Fn(f64) -> [f32; N]) -> Vec<Row> {
    let mut rows = vec![Row::with_capacity(frames.len()); N];
    for frame in frames {
        for (row, component) in rows.iter_mut().zip(value(frame as f64)) {
            row.push(component);
        }
    }
    rows
}

fn pack_rows(rows: &[Row], precision: f64, bytes: &mut Vec<u8>) -> Vec<Row> {
    rows.iter().map(|row| pack_row(row, precision, bytes)).collect()
}

/// The form of a rotation track with all four components.
const ALL_FOUR: u8 = 4;
/// Added to the index of the omitted component if that component is negative.
const NEGATIVE: u8 = 8;

pub fn pack_rotations(rows: &[Row], precision: f64, bytes: &mut Vec<u8>) -> Vec<Row> {
    // Exact values need all four components.
    let left_out = (0..rows.len()).filter(|_| precision > 0.0).find_map(|component| {
        let is_far = |sign: f32| rows[component].iter().all(|value| sign * value >= LEAST_LEFT_OUT);
        let sign = [1.0, -1.0].into_iter().find(|sign| is_far(*sign))?;
        Some((component, sign))
    });
    let Some((left_out, sign)) = left_out else {
        bytes.push(ALL_FOUR);
        return pack_rows(rows, precision, bytes);
    };
    bytes.push(left_out as u8 + if sign < 0.0 { NEGATIVE } else { 0 });
    let mut unpacked: Vec<Row> = Vec::with_capacity(rows.len());
    for (component, row) in rows.iter().enumerate() {
        unpacked.push(if component == left_out {
            Row::new()
        } else {
            pack_row(row, precision, bytes)
        });
    }
    unpacked[left_out] = (0..rows[left_out].len())
        .map(|frame| {
            let stored = (0..rows.len()).filter(|component| *component != left_out);
            let squares: f64 = stored
                .map(|component| f64::from(unpacked[component][frame]).powi(2))
                .sum();
            sign * (1.0 - squares).max(0.0).sqrt() as f32
        })
        .collect();
    unpacked
}

/// Appends a row: the bytes per frame, the least value, the step, and the steps of each frame. 4 bytes per frame mean
/// floats.
pub fn pack_row(row: &Row, precision: f64, bytes: &mut Vec<u8>) -> Row {
    let least = row.iter().copied().fold(f32::INFINITY, f32::min);
    let most = row.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let range = f64::from(most) - f64::from(least);
    let steps_of = |width: u32| f64::from(256_u32.pow(width) - 1);
    let width = (0..=3).find(|&width| match width {
        0 => range == 0.0,
        _ => range / steps_of(width) <= 2.0 * precision,
    });
    let Some(width) = width.filter(|_| range.is_finite()) else {
        bytes.push(4);
        bytes.extend(row.iter().flat_map(|value| value.to_le_bytes()));
        return row.clone();
    };
    let step = if width == 0 { 0.0 } else { range / steps_of(width) };
    bytes.push(width as u8);
    bytes.extend(least.to_le_bytes());
    bytes.extend(step.to_le_bytes());
    let mut unpacked = Row::with_capacity(row.len());
    for &value in row {
        let steps = match width {
            0 => 0,
            _ => ((f64::from(value) - f64::from(least)) / step).round() as u32,
        };
        bytes.extend(&steps.to_le_bytes()[..width as usize]);
        unpacked.push((f64::from(least) + f64::from(steps) * step) as f32);
    }
    unpacked
}

/// Compares joint positions.
struct ErrorMetric<'a> {
    source: Option<(Binding, &'a Animation)>,
    pose: Pose,
    unpacked: Pose,
}

impl<'a> ErrorMetric<'a> {
    fn new(scene: &Scene, animation: Option<&'a Animation>) -> Self {
        Self {
            source: animation.map(|animation| (Binding::new(scene, animation), animation)),
            pose: Pose::rest(scene),
            unpacked: Pose::rest(scene),
        }
    }

    /// The largest distance of a joint from its position in the file.
    fn largest(&mut self, tracks: &[Track<'_>], rows: &[Vec<Row>], frames: Range<usize>) -> f64 {
        let Some((binding, animation)) = &self.source else {
            return 0.0;
        };
        let mut largest = 0.0_f32;
        let tracks: Vec<_> = tracks.iter().zip(rows).collect();
        for (index, frame) in frames.enumerate() {
            self.pose.sample(binding, animation, frame as f64);
            self.unpacked.node_to_parent.clone_from(&self.pose.node_to_parent);
            for of_node in tracks.chunk_by(|(a, _), (b, _)| a.node == b.node) {
                let Some((first, _)) = of_node.first() else { continue };
                let mut trs = first.channel.sample(frame as f64, first.rest);
                for (track, rows) in of_node {
                    let at = |component: usize| rows.get(component).and_then(|row| row.get(index)).copied();
                    let value = Vec4::from_array([0, 1, 2, 3].map(|component| at(component).unwrap_or(0.0)));
                    match track.part {
                        Part::Translation => trs.translation = value.truncate(),
                        Part::Rotation => trs.rotation = Quat::from_vec4(value),
                        Part::Scale => trs.scale = value.truncate(),
                    }
                }
                self.unpacked.node_to_parent[first.node] = trs.matrix();
            }
            self.unpacked.update_world();
            for (a, b) in self.pose.node_to_world.iter().zip(&self.unpacked.node_to_world) {
                let distance = a.w_axis.distance(b.w_axis);
                // `max` would drop NaN.
                if distance > largest || distance.is_nan() {
                    largest = distance;
                }
            }
        }
        f64::from(largest)
    }
}
