//! Reads the tables of a `.vmd` file.
//!
//! ```text
//! file   := "Vocaloid Motion Data 0002" in 30 bytes, the name of the model in 20, bones, morphs, cameras, lights,
//!           shadows, states; after the bones a file may end before each of them. An older file begins with "Vocaloid
//!           Motion Data file", and has 10 bytes for the name.
//! bones  := u32, then for each key: name in 15 bytes, frame u32, position 3 f32, rotation 4 f32, curves 64 bytes
//! morphs := u32, then for each key: name in 15 bytes, frame u32, weight f32
//! cameras, lights, shadows := u32, then 61, 28 and 9 bytes for each key
//! states := u32, then for each key: frame u32, is shown u8, u32, and as many: name of an IK in 20 bytes, is on u8
//! ```
//!
//! Names are Shift-JIS, up to the first NUL. The 64 bytes of curves are four rows of 16. Each row is the first row,
//! shifted by one byte more. The first row begins with four numbers, one for each curve: the X of the first control
//! point of the curves of x, y, z and the rotation. Then come the Y of this point, and X and Y of the second control
//! point. Programs write other numbers into the third and the fourth byte, so every curve is read from the row that
//! begins with it.

use std::collections::BTreeMap;

use glam::{DQuat, DVec3};
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::limits::is_plausible;

use super::MOTION_HEAD;
use super::bezier::Curve;
use super::bytes::{Cursor, invalid};
use super::names::{self, LONG_NAME_BYTES, NAME_BYTES};
use crate::Failure;
use crate::warnings::Warnings;

const OLD: &[u8] = b"Vocaloid Motion Data file";

/// The size in bytes of the mark at the beginning of a file.
const HEADER_BYTES: usize = 30;

/// The size in bytes of the model name in the older version.
const OLD_MODEL_NAME_BYTES: usize = 10;

/// The size in bytes of a bone key's interpolation curves.
const CURVE_BYTES: usize = 64;

/// The size in bytes of a bone key: name, frame, seven numbers, curves.
const BONE_BYTES: usize = NAME_BYTES + 4 + 7 * 4 + CURVE_BYTES;

/// The size in bytes of a morph key: name, frame, weight.
const MORPH_BYTES: usize = NAME_BYTES + 4 + 4;

/// The size in bytes of a camera key.
const CAMERA_BYTES: usize = 61;

/// The size in bytes of a light key.
const LIGHT_BYTES: usize = 28;

/// The size in bytes of a shadow key.
const SHADOW_BYTES: usize = 9;

/// The contents of a file. Names are the bytes in the file.
#[derive(Default)]
pub(super) struct Motion {
    pub(super) model: String,
    pub(super) bones: BTreeMap<Vec<u8>, Vec<BoneKey>>,
    pub(super) morphs: BTreeMap<Vec<u8>, Vec<(u32, f64)>>,
    /// The states of each IK, by frame.
    pub(super) states: Vec<(u32, BTreeMap<Vec<u8>, bool>)>,
    /// The number of camera, light and shadow keys.
    pub(super) others: usize,
    /// The number of cameras and lights with keys. A motion has at most one of each.
    pub(super) cameras: usize,
    pub(super) lights: usize,
}

/// The offset of a bone from its rest pose at a frame, and the curves from the previous key.
#[derive(Clone, Copy)]
pub(super) struct BoneKey {
    pub(super) frame: u32,
    pub(super) position: DVec3,
    pub(super) rotation: DQuat,
    /// The curves of x, y, z and the rotation.
    pub(super) curves: [Curve; 4],
}

impl Motion {
    /// The frame of the last key; `None` without keys.
    pub(super) fn last(&self) -> Option<u32> {
        let bones = self.bones.values().filter_map(|keys| keys.last()).map(|key| key.frame);
        let morphs = self.morphs.values().filter_map(|keys| keys.last()).map(|key| key.0);
        bones.chain(morphs).max()
    }
}

pub(super) fn read(bytes: &[u8], warnings: &mut Warnings) -> Result<Motion, Failure> {
    if !bytes.starts_with(MOTION_HEAD) {
        let message = "the file does not begin with \"Vocaloid Motion Data\", as a motion of MikuMikuDance does";
        return Err(invalid(message));
    }
    let mut cursor = Cursor::new(bytes);
    let model_name_bytes = match cursor.take(HEADER_BYTES)?.starts_with(OLD) {
        true => OLD_MODEL_NAME_BYTES,
        false => LONG_NAME_BYTES,
    };
    let mut motion = Motion {
        model: names::decode(names::until_nul(cursor.take(model_name_bytes)?)),
        ..Motion::default()
    };
    for _ in 0..cursor.count("keys of bones", BONE_BYTES)? {
        let at = cursor.offset();
        let (name, key) = bone_key(&mut cursor)?;
        match key {
            Some(key) => motion.bones.entry(name).or_default().push(key),
            None => left_out(warnings, &name, at),
        }
    }
    if !cursor.is_at_end() {
        for _ in 0..cursor.count("keys of morphs", MORPH_BYTES)? {
            let at = cursor.offset();
            let name = names::until_nul(cursor.take(NAME_BYTES)?).to_owned();
            let (frame, weight) = (cursor.long()?, cursor.real()?);
            match is_plausible(weight) {
                true => motion.morphs.entry(name).or_default().push((frame, weight)),
                false => left_out(warnings, &name, at),
            }
        }
    }
    for (what, each) in [
        ("keys of cameras", CAMERA_BYTES),
        ("keys of lights", LIGHT_BYTES),
        ("keys of shadows", SHADOW_BYTES),
    ] {
        if cursor.is_at_end() {
            break;
        }
        let count = cursor.count(what, each)?;
        cursor.take(count * each)?;
        motion.others += count;
        match what {
            "keys of cameras" => motion.cameras = usize::from(count > 0),
            "keys of lights" => motion.lights = usize::from(count > 0),
            _ => {}
        }
    }
    if !cursor.is_at_end() {
        for _ in 0..cursor.count("states of IK", 4 + 1 + 4)? {
            motion.states.push(state(&mut cursor)?);
        }
    }
    if !cursor.is_at_end() {
        warnings.push(Code::TrailingText, || {
            let message = format!(
                "the bytes from byte {} on, after the last table, were ignored",
                cursor.offset()
            );
            Diagnostic::new(Code::TrailingText, message)
                .expected_found("the end of the file", format!("{} more bytes", cursor.rest()))
                .help("the file is incomplete, or has more than a motion: export it again, or remove the extra bytes")
        });
    }
    in_order(&mut motion);
    Ok(motion)
}

fn bone_key(cursor: &mut Cursor<'_>) -> Result<(Vec<u8>, Option<BoneKey>), Failure> {
    let name = names::until_nul(cursor.take(NAME_BYTES)?).to_owned();
    let (frame, position, rotation) = (cursor.long()?, cursor.position()?, cursor.rotation()?);
    let curves: [u8; CURVE_BYTES] = cursor.array()?;
    let length = rotation.length();
    let is_valid = position.to_array().into_iter().all(is_plausible) && length.is_finite() && length > 0.0;
    let key = is_valid.then(|| BoneKey {
        frame,
        position,
        rotation: rotation / length,
        curves: curves_of(&curves),
    });
    Ok((name, key))
}

fn curves_of(bytes: &[u8; CURVE_BYTES]) -> [Curve; 4] {
    // Some programs write only the first row.
    let has_rows = bytes[16..].iter().any(|byte| *byte != 0);
    [0, 1, 2, 3].map(|curve| {
        let begin = if has_rows { 16 * curve } else { curve };
        [0, 4, 8, 12].map(|coordinate| bytes[begin + coordinate])
    })
}

fn state(cursor: &mut Cursor<'_>) -> Result<(u32, BTreeMap<Vec<u8>, bool>), Failure> {
    let frame = cursor.long()?;
    let _is_shown = cursor.byte()?;
    let mut states = BTreeMap::new();
    for _ in 0..cursor.count("states of IK", LONG_NAME_BYTES + 1)? {
        let name = names::until_nul(cursor.take(LONG_NAME_BYTES)?).to_owned();
        states.insert(name, cursor.byte()? != 0);
    }
    Ok((frame, states))
}

fn left_out(warnings: &mut Warnings, name: &[u8], at: usize) {
    warnings.push(Code::NonFiniteValue, || {
        let message =
            format!("a key at byte {at} was skipped: its position, rotation or weight is not a usable number");
        Diagnostic::new(Code::NonFiniteValue, message).in_joint(names::decode(name))
    });
}

/// Sorts keys by time. Of several keys at one frame, the last counts.
fn in_order(motion: &mut Motion) {
    fn sort<K>(keys: &mut Vec<K>, frame: impl Fn(&K) -> u32) {
        keys.reverse();
        keys.sort_by_key(&frame);
        keys.dedup_by_key(|key| frame(key));
    }
    motion.bones.values_mut().for_each(|keys| sort(keys, |key| key.frame));
    motion.morphs.values_mut().for_each(|keys| sort(keys, |key| key.0));
    sort(&mut motion.states, |state| state.0);
}
