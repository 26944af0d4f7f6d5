//! Compresses the JSON Schema of jobs.

use std::fs::{File, read};
use std::io::{Result, Write};
use std::path::Path;

use flate2::Compression;
use flate2::write::ZlibEncoder;

fn main() -> Result<()> {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=job.schema.json");
    let folder = std::env::var_os("OUT_DIR").expect("Cargo names the folder");
    let file = File::create(Path::new(&folder).join("job.schema.json.zlib"))?;
    let mut packed = ZlibEncoder::new(file, Compression::best());
    packed.write_all(&read("job.schema.json")?)?;
    packed.finish()?;
    Ok(())
}
