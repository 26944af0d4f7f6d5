//! Any bytes: an error, or a scene whose glTF can be read back.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| mocap_fuzz::import_export(bytes));
