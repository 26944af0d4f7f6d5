//! The integration tests of compression: one program, because linking is slow, with one module per subject.

mod bit_rate;
mod curves;
mod decode;
mod error_metric;
mod fitted_keys;
mod key_frames;
mod measure;
mod packed;
mod packed_clip;
#[cfg(feature = "meshopt")]
mod quantize;
#[allow(dead_code, reason = "other packages use the rest of it")]
#[path = "../../../../tests/it/sample.rs"]
mod sample;
mod trellis;
