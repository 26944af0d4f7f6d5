//! Writes the interface version into the shared library's name, so that a program loads the version that it was linked
//! against.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    if std::env::var("CARGO_CFG_TARGET_OS").as_deref() == Ok("linux") {
        println!("cargo:rustc-cdylib-link-arg=-Wl,-soname,libmocap.so.0");
    }
}
