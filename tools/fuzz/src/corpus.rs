//! The inputs that the fuzzer changes: the fixtures of a format, and the inputs in `corpus/`, which reach other code.

use std::path::{Path, PathBuf};
use std::{fs, io};

use mocap_fuzz::{Input, fixture};

use crate::coverage::Seen;

/// The size of the longest kept input in bytes.
const LONGEST: usize = 24 << 10;

/// The largest total of the kept inputs of one format in bytes.
const MOST: usize = 140 << 10;

/// The fixtures of a format. Of a longer file, only the first bytes, if the format allows a part of a file.
pub(crate) fn seeds(input: &Input) -> Vec<Vec<u8>> {
    let mut paths: Vec<PathBuf> = (input.folders.iter())
        .flat_map(|name| fs::read_dir(fixture(name)).expect("the fixtures are there"))
        .map(|entry| entry.expect("a folder can be listed").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == input.name))
        .collect();
    // The order of files in a folder differs between systems, but a seed must always give the same run.
    paths.sort();
    let files = paths.iter().map(|path| fs::read(path).expect("a fixture can be read"));
    let mut seeds: Vec<Vec<u8>> = files
        .filter(|bytes| input.cut || bytes.len() <= input.longest_seed)
        .map(|mut bytes| {
            bytes.truncate(input.longest_seed);
            bytes
        })
        .collect();
    seeds.extend((input.made)());
    assert!(!seeds.is_empty(), "there are no fixtures of {}", input.name);
    seeds
}

/// The inputs of a format that the repository keeps.
pub(crate) fn kept(input: &Input) -> Vec<Vec<u8>> {
    files(&folder("corpus", input))
}

/// Adds an input to the inputs that earlier runs found on this machine.
pub(crate) fn remember(input: &Input, bytes: &[u8]) {
    write(&folder("artifacts/found", input).join(name_of(bytes)), bytes);
}

/// Keeps, of the found and the kept inputs, the shortest that together reach all code that the fixtures do not reach.
/// `try_input` runs one input.
pub(crate) fn minimize(input: &Input, try_input: impl Fn(&[u8]) -> Result<(), String>) -> Result<(), String> {
    let mut candidates = kept(input);
    candidates.extend(files(&folder("artifacts/found", input)));
    candidates.sort_by_key(|bytes| (bytes.len(), name_of(bytes)));
    candidates.dedup();
    let mut seen = Seen::default();
    let mut reach = |bytes: &[u8]| {
        Seen::reset();
        try_input(bytes).map(|()| seen.reach())
    };
    for bytes in seeds(input) {
        reach(&bytes)?;
    }
    let (mut keep, mut length) = (Vec::new(), 0);
    for bytes in &candidates {
        if bytes.len() <= LONGEST && length + bytes.len() <= MOST && reach(bytes)? {
            length += bytes.len();
            keep.push(bytes);
        }
    }
    let folder = folder("corpus", input);
    // Inputs with names instead of hashes were findings, and always remain.
    for path in paths(&folder) {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if fs::read(&path).is_ok_and(|bytes| name_of(&bytes) == name) {
            fs::remove_file(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        }
    }
    for bytes in &keep {
        write(&folder.join(name_of(bytes)), bytes);
    }
    println!(
        "{}: {} of {} inputs are kept, {length} bytes",
        input.name,
        keep.len(),
        candidates.len()
    );
    Ok(())
}

/// The file for an input that caused a failure (a finding), or for the input that is now being tried.
pub(crate) fn artifact(name: &str, extension: &str) -> PathBuf {
    here().join("artifacts").join(name).with_extension(extension)
}

/// Writes a file and creates its folder. Prints an error and continues.
pub(crate) fn write(path: &Path, bytes: &[u8]) {
    let folder = path.parent().unwrap_or(Path::new("."));
    let written = fs::create_dir_all(folder).and_then(|()| fs::write(path, bytes));
    if let Err(error) = written {
        eprintln!("{}: {error}", path.display());
    }
}

/// The folder of this program.
fn here() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn folder(of: &str, input: &Input) -> PathBuf {
    here().join(of).join(input.name)
}

/// The files of a folder, sorted by name; empty if the folder does not exist.
fn files(folder: &Path) -> Vec<Vec<u8>> {
    let read = |path: &PathBuf| fs::read(path).expect("a kept input can be read");
    paths(folder).iter().map(read).collect()
}

fn paths(folder: &Path) -> Vec<PathBuf> {
    let listed = match fs::read_dir(folder) {
        Ok(listed) => listed,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Vec::new(),
        Err(error) => panic!("{}: {error}", folder.display()),
    };
    let mut paths: Vec<PathBuf> = listed
        .map(|entry| entry.expect("a folder can be listed").path())
        .collect();
    paths.sort();
    paths
}

/// The same name for the same bytes on every machine.
fn name_of(bytes: &[u8]) -> String {
    format!("{:016x}", hash(bytes))
}

/// FNV-1a, 64 bits.
pub(crate) fn hash(bytes: &[u8]) -> u64 {
    let mix = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, mix)
}
