//! Gives the library the name under which programs built on Debian 12 look for Assimp, and links the C++ library, whose
//! `new` and `delete` and type infos it uses.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rustc-cdylib-link-arg=-Wl,-soname,libassimp.so.5");
    // Links by the file's name, so that no C++ compiler must be installed.
    println!("cargo:rustc-link-lib=dylib:+verbatim=libstdc++.so.6");
}
