//! FBX of a scene of any format, from any bytes: an error, or a file that is read back.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| mocap_fuzz::FBX_OUT.hold(bytes));
