//! Compresses the font, which would be a twentieth of the program.

use std::fs::File;
use std::io::{Result, Write};
use std::path::Path;

use flate2::Compression;
use flate2::write::ZlibEncoder;

fn main() -> Result<()> {
    println!("cargo:rerun-if-changed=build.rs");
    let folder = std::env::var_os("OUT_DIR").expect("Cargo names the folder");
    let file = File::create(Path::new(&folder).join("font.zlib"))?;
    let mut packed = ZlibEncoder::new(file, Compression::best());
    packed.write_all(dejavu::sans::regular())?;
    packed.finish()?;
    Ok(())
}
