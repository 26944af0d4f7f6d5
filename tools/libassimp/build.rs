//! Gives the library the name under which programs built on Debian 12 look for Assimp.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rustc-cdylib-link-arg=-Wl,-soname,libassimp.so.5");
}
