//! Lossy compression of animations with an error bound: every joint stays within the bound of its position, at every
//! frame of the source, for every reader of the file.
//!
//! The algorithm is a variable bit rate quantizer with key frame reduction and in-place error compensation, after the
//! Animation Compression Library (ACL) of Nicholas Frechette: <https://github.com/nfrechette/acl>.
//! `docs/compression-algorithm.md` explains it. The modules in the order of use:
//!
//! 1. `raw_clip` samples the animation at every frame. `object_space` is the space in which errors are measured.
//! 2. `constant_tracks` makes tracks constant that hardly move anything.
//! 3. `shared_key_frames`, `key_frames` and `fitted_keys` remove key frames, for the whole pose or for each track.
//! 4. `encode` encodes joint by joint, starting at the root. The `error_metric` measures the effect of a rotation
//!    error, with lever arms and a shell distance. `compensation` computes the rotation of a joint relative to its
//!    lossy parent. `bit_rate` chooses the number of bits, and one of the `candidates` around that rotation, with the
//!    help of the `trellis`. `quantize` has the number formats.
//! 5. `measure` decodes the result in double precision as readers `decode` it: slerp, nlerp, unnormalized.
//! 6. `refinement` adds keys or shrinks tolerances until the error is within the bound.
//! 7. `clip` is the result. A clip for FBX has `curves`.
//!
//! Each format defines the storage of keys. The format implements `Encoding` next to its reader and writer.
//!
//! A [`PackedClip`] stores the result in a compact form, from which a pose is computed without unpacking the rest.

// Tests may unwrap and print; the library may not.
#![warn(clippy::unwrap_used, clippy::print_stdout, clippy::print_stderr)]

#[doc(hidden)]
pub mod at_rest;
mod bit_rate;
mod candidates;
mod clip;
#[doc(hidden)]
mod compensation;
mod constant_tracks;
mod curves;
mod decode;
mod encode;
mod encoding;
mod error_bound;
#[doc(hidden)]
mod error_metric;
#[doc(hidden)]
mod fitted_keys;
#[doc(hidden)]
pub mod internals;
mod key_frames;
#[doc(hidden)]
mod measure;
#[doc(hidden)]
mod object_space;
mod packed;
mod quantize;
#[doc(hidden)]
mod raw_clip;
mod read_ahead;
mod reduce_keys;
mod refinement;
mod shared_key_frames;
#[doc(hidden)]
mod trellis;

use std::sync::Arc;

use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::scene::{Animation, Scene};

#[doc(hidden)]
pub use self::clip::{CompressedClip, Track};
#[doc(hidden)]
pub use self::curves::{Curve, EulerAngles};
use self::encode::Encoder;
#[doc(hidden)]
pub use self::encoding::{Encoding, Float32, KeyFrameChoice};
use self::error_bound::Bounds;
pub use self::error_bound::ErrorBound;
use self::error_metric::LeverArms;
#[doc(hidden)]
pub use self::key_frames::KeyFrames;
use self::object_space::ObjectSpaceTrack;
pub use self::packed::PackedClip;
#[doc(hidden)]
pub use self::quantize::{Lattice, RotationFormat, TranslationFormat};
use self::raw_clip::RawClip;
#[doc(hidden)]
pub use self::reduce_keys::reduce_keys;
use self::refinement::Refinement;

// The constants below are tuned on the fixtures. The error bound holds with any other values.

/// The largest error of a track that is replaced by a constant, as a fraction of the bound.
const CONSTANT_FRACTION: f32 = 0.2;

/// The part of the bound that key frame reduction of the whole pose may use, if keys are stored in streams.
/// Quantization uses the rest of the bound. Rotations with 16 or 32 bits need a smaller rest.
const KEY_FRACTION_OF_STREAMS: f32 = 0.8;

/// The part of the bound that key frame reduction of the whole pose may use, if keys are stored as 32-bit numbers.
const KEY_FRACTION_OF_NUMBERS: f32 = 0.97;

/// If the shared key frames are more than this fraction of all frames, mocap writes keys at all frames, which are then
/// smaller in streams. Keys at all frames can be coarser, because quantization can use the whole bound.
const MAYBE_SMALLER: f32 = 0.9;
/// A clip with shared key frames is surely smaller if it has fewer keys than this fraction of the keys at all frames.
const SURELY_SMALLER: f32 = 0.85;

/// Shared key frames are tried only if this fraction of their estimated size is below the size of separate key frames.
const MAYBE_CONSTANT: f32 = 0.85;

/// The fractions of a bound to try if the bound itself is not kept. Near the precision of the numbers, roundings add up
/// by chance. So a smaller bound may be kept although a larger one is not.
const TIGHTER_BOUNDS: [f64; 2] = [0.5, 0.25];

/// Compresses `animation` so that no joint is farther from its position than `bound`.
///
/// # Errors
/// - [`Code::ErrorBound`]: the encoding is too coarse for the bound.
/// - [`Code::Unrepresentable`]: a scale is not uniform and constant, or a value is not finite.
/// - [`Code::LimitExceeded`]: there are too many frames.
/// - [`Code::InvalidValue`]: a shell distance below 0, a joint bound that is not above 0, or an unknown joint.
#[doc(hidden)]
pub fn compress(
    scene: &Scene,
    animation: &Animation,
    bound: &ErrorBound,
    encoding: &dyn Encoding,
) -> Result<CompressedClip> {
    let refused = match compress_once(scene, animation, bound, encoding) {
        Err(error) if error.code() == Code::ErrorBound => error,
        result => return result,
    };
    let tighter = TIGHTER_BOUNDS.map(|fraction| bound.clone().tighter(fraction));
    let kept = tighter
        .iter()
        .find_map(|bound| compress_once(scene, animation, bound, encoding).ok());
    kept.ok_or(refused)
}

/// Compresses as [`compress()`] does, but does not try a tighter bound.
fn compress_once(
    scene: &Scene,
    animation: &Animation,
    bound: &ErrorBound,
    encoding: &dyn Encoding,
) -> Result<CompressedClip> {
    let mut clip = RawClip::new(scene, animation, bound.checked_shell_distance()?)?;
    let bounds = Bounds::new(bound, scene, &clip)?;
    let raw = clip.object_space();
    constant_tracks::compact(&mut clip, &bounds, CONSTANT_FRACTION);
    let times: Vec<f32> = clip
        .ticks
        .iter()
        .map(|tick| encoding.time(*tick, animation.ticks_per_second))
        .collect();
    if !times.is_sorted_by(|a, b| a < b) {
        let message = "two frames have the same time as 32-bit floats, so that mocap can guarantee no error bound";
        return Err(Diagnostic::new(Code::LimitExceeded, message).into());
    }
    let farthest = |track: &ObjectSpaceTrack| track.positions.iter().map(|p| p.length()).fold(0.0, f32::max);
    let rounding = raw.iter().map(farthest).fold(0.0, f32::max) * f32::EPSILON;
    let refinement = Refinement {
        encoder: Encoder {
            arms: LeverArms::of_clip(&clip),
            clip,
            raw,
            bounds,
            encoding,
        },
        times,
        raw_rounding: f64::from(rounding) * encoding.roundings(),
    };
    match encoding.key_frames() {
        KeyFrameChoice::Own => refinement.within_bound(scene, None),
        KeyFrameChoice::OwnOrShared => own_or_shared(&refinement, scene),
        KeyFrameChoice::SharedOrAll => shared_or_all(&refinement, scene),
    }
}

/// Implements [`KeyFrameChoice::OwnOrShared`].
fn own_or_shared(refinement: &Refinement, scene: &Scene) -> Result<CompressedClip> {
    let own = refinement.within_bound(scene, None)?;
    let Encoder {
        clip,
        raw,
        bounds,
        encoding,
        ..
    } = &refinement.encoder;
    let shared = shared_key_frames::reduce(clip, raw, bounds, KEY_FRACTION_OF_NUMBERS);
    // Refinement adds further keys, so the final size is larger. But some tracks that are animated in `own` may be
    // constant with shared key frames.
    let size: usize = own.animated_tracks().map(|(_, bytes)| shared.len() * bytes).sum();
    if size as f32 * MAYBE_CONSTANT >= encoding.size(&own) as f32 {
        return Ok(own);
    }
    match refinement.within_bound(scene, Some(Arc::new(shared))) {
        Ok(shared) if encoding.size(&shared) < encoding.size(&own) => Ok(shared),
        _ => Ok(own),
    }
}

/// Implements [`KeyFrameChoice::SharedOrAll`].
fn shared_or_all(refinement: &Refinement, scene: &Scene) -> Result<CompressedClip> {
    let Encoder {
        clip,
        raw,
        bounds,
        encoding,
        ..
    } = &refinement.encoder;
    let all: Arc<KeyFrames> = Arc::new(key_frames::every_frame(clip.frames()));
    let reduced = shared_key_frames::reduce(clip, raw, bounds, KEY_FRACTION_OF_STREAMS);
    let reduced = encoding.with_required(reduced, clip.frames());
    if reduced.len() as f32 > MAYBE_SMALLER * all.len() as f32 {
        return refinement.within_bound(scene, Some(all));
    }
    let Ok(reduced) = refinement.within_bound(scene, Some(Arc::new(reduced))) else {
        return refinement.within_bound(scene, Some(all));
    };
    let keys_at_all_frames = reduced.animated_tracks().count() * all.len();
    if (reduced.key_count() as f32) < SURELY_SMALLER * keys_at_all_frames as f32 {
        return Ok(reduced);
    }
    let all = refinement.within_bound(scene, Some(all))?;
    Ok(if encoding.size(&reduced) < encoding.size(&all) {
        reduced
    } else {
        all
    })
}
