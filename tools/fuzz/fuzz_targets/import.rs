//! Any bytes: an error or a valid scene.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| mocap_fuzz::import(bytes));
