//! Joins the modules of the player to one script, and compresses the script, the style sheet and the font. For
//! WebAssembly, these files stay uncompressed, because the WebAssembly module is compressed as a whole.
//! `tools/wasm/page/lean_module.js` must find their bytes in the module, to replace unused data by zeros.

use std::fs::{File, read_to_string};
use std::io::{Result, Write};
use std::path::Path;

use flate2::Compression;
use flate2::write::ZlibEncoder;

fn main() -> Result<()> {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=view");
    let (mut script, mut joined) = (String::new(), Vec::new());
    join("page.js", &mut joined, &mut script)?;
    write_packed("player.js", script.as_bytes())?;
    write_packed("page.css", lean(&read_to_string("view/page.css")?).as_bytes())?;
    write_packed("font", dejavu::sans::regular())
}

/// Adds a module after the modules that it imports, each once, without import and export keywords.
fn join(module: &str, joined: &mut Vec<String>, script: &mut String) -> Result<()> {
    if joined.iter().any(|name| name == module) {
        return Ok(());
    }
    joined.push(module.to_owned());
    let source = lean(&read_to_string(Path::new("view").join(module))?);
    for line in source.lines().filter(|line| line.starts_with("import ")) {
        let name = line.split('"').nth(1).expect("an import is one line");
        join(name.trim_start_matches("./"), joined, script)?;
    }
    for line in source.lines().filter(|line| !line.starts_with("import ")) {
        script.push_str(line.strip_prefix("export ").unwrap_or(line));
        script.push('\n');
    }
    Ok(())
}

/// Removes indentation and comments from source text.
fn lean(source: &str) -> String {
    let lines = source.lines().map(str::trim);
    let kept = lines.filter(|line| !line.is_empty() && !line.starts_with("//"));
    kept.flat_map(|line| [line, "\n"]).collect()
}

/// Writes a file of the build, in zlib format except for browsers.
fn write_packed(name: &str, bytes: &[u8]) -> Result<()> {
    let folder = std::env::var_os("OUT_DIR").expect("Cargo names the folder");
    let mut file = File::create(Path::new(&folder).join(name))?;
    if std::env::var_os("CARGO_CFG_TARGET_ARCH").is_some_and(|arch| arch == "wasm32") {
        return file.write_all(bytes);
    }
    let mut packed = ZlibEncoder::new(file, Compression::best());
    packed.write_all(bytes)?;
    packed.finish()?;
    Ok(())
}
