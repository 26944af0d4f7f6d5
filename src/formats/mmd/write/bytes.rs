//! Writes the bytes of a `.vmd` file. `motion.rs` describes the format.

use glam::{DQuat, DVec3};
use mocap_scene::error::{Code, Diagnostic, Result};

use super::super::names::{self, LONG_NAME_BYTES, NAME_BYTES};
use super::{BoneTrack, MorphTrack, is_near};

const HEADER: &[u8; 30] = b"Vocaloid Motion Data 0002\0\0\0\0\0";

/// The control point of straight curves in MMD: points at 20 and 107 of 127.
const NEAR_POINT: u8 = 20;
const FAR_POINT: u8 = 107;

pub(super) fn file(model: &str, bones: &[BoneTrack], morphs: &[MorphTrack], ik: &[String]) -> Result<Vec<u8>> {
    let mut bytes = HEADER.to_vec();
    bytes.extend(field(model, LONG_NAME_BYTES));
    let mut section = Section::begin(&mut bytes);
    for track in bones {
        let is_repeated = |at: usize| {
            let [before, own, after] = [at - 1, at, at + 1].map(|frame| track.keys[frame]);
            is_near(own, before) && is_near(own, after)
        };
        for frame in kept(track.keys.len(), is_repeated) {
            section.add(&bone(&track.name, frame, track.keys[frame]));
        }
    }
    section.end()?;
    let mut section = Section::begin(&mut bytes);
    for track in morphs {
        let is_repeated = |at: usize| {
            let [before, own, after] = [at - 1, at, at + 1].map(|frame| track.weights[frame]);
            own == before && own == after
        };
        for frame in kept(track.weights.len(), is_repeated) {
            let mut key = field(&track.name, NAME_BYTES);
            key.extend((frame as u32).to_le_bytes());
            key.extend(track.weights[frame].to_le_bytes());
            section.add(&key);
        }
    }
    section.end()?;
    // The file has no cameras, lights and shadows.
    bytes.extend([0; 3 * 4]);
    let mut section = Section::begin(&mut bytes);
    // The model is visible from frame 0.
    let mut state = [0_u32.to_le_bytes().as_slice(), &[1], &(ik.len() as u32).to_le_bytes()].concat();
    for name in ik {
        state.extend(field(name, LONG_NAME_BYTES));
        state.push(0);
    }
    section.add(&state);
    section.end()?;
    Ok(bytes)
}

/// The frames whose keys are written.
fn kept(count: usize, is_repeated: impl Fn(usize) -> bool) -> impl Iterator<Item = usize> {
    (0..count).filter(move |frame| *frame == 0 || *frame + 1 == count || !is_repeated(*frame))
}

/// A key of a bone.
fn bone(name: &str, frame: usize, (offset, rotation): (DVec3, DQuat)) -> Vec<u8> {
    let mut key = field(name, NAME_BYTES);
    key.extend((frame as u32).to_le_bytes());
    // The axes of the file are left-handed.
    let position = [offset.x, offset.y, -offset.z];
    let rotation = [-rotation.x, -rotation.y, rotation.z, rotation.w];
    for number in position.into_iter().chain(rotation) {
        key.extend((number as f32).to_le_bytes());
    }
    let first = [[NEAR_POINT; 8], [FAR_POINT; 8]].concat();
    for row in 0..4 {
        key.extend(&first[row..]);
        key.extend(vec![0; row]);
    }
    key
}

/// A name, cut or padded to its field.
fn field(name: &str, length: usize) -> Vec<u8> {
    let mut bytes = names::encode(name).unwrap_or_default();
    bytes.resize(length, 0);
    bytes
}

/// Keys, preceded by their number.
struct Section<'b> {
    bytes: &'b mut Vec<u8>,
    at: usize,
    count: usize,
}

impl<'b> Section<'b> {
    fn begin(bytes: &'b mut Vec<u8>) -> Self {
        let at = bytes.len();
        bytes.extend([0; 4]);
        Self { bytes, at, count: 0 }
    }

    fn add(&mut self, key: &[u8]) {
        self.bytes.extend(key);
        self.count += 1;
    }

    fn end(self) -> Result<()> {
        let count = u32::try_from(self.count).map_err(|_| {
            let message = format!(
                "a VMD file has at most 4294967295 keys, but this motion has {}",
                self.count
            );
            Diagnostic::new(Code::Unrepresentable, message).help("shorten it with {trim}")
        })?;
        self.bytes[self.at..self.at + 4].copy_from_slice(&count.to_le_bytes());
        Ok(())
    }
}
