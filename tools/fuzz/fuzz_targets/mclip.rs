//! A packed clip, from any bytes: an error, or a scene that can be written.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| mocap_fuzz::MCLIP.hold(bytes));
