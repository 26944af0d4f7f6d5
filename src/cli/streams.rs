//! `-` as a file: standard input, and standard output.

use std::fs;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

use mocap::files::{FilePart, OutputSet, ReplacePolicy, remove_unfinished, write_file};
use mocap::job::InputOptions;
use mocap::{Code, Diagnostic, Error, Export, Importer, MemoryFile, Scene};

use crate::{Failure, report};

/// Whether a path stands for standard input or standard output.
pub(crate) fn is_standard(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// Whether an output is standard output, a pipe or a device.
pub(crate) fn is_stream(path: &Path) -> bool {
    let is_device = || fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir());
    // A shell may redirect `/dev/stdout` to a file.
    is_standard(path) || path == Path::new("/dev/stdout") || is_device()
}

/// Whether an output is a stream whose name has no extension, so that `--to` names the format.
pub(crate) fn is_unnamed(path: &Path) -> bool {
    path.extension().is_none() && is_stream(path)
}

/// Imports a file or standard input. Standard input is read once, however often it is imported.
pub(crate) fn import(importer: &Importer, path: &Path) -> mocap::Result<Scene> {
    match is_standard(path) {
        true => importer.read(standard_input(importer)?[0].bytes, path),
        false => importer.import(path),
    }
}

/// The text of a file that is not a motion, with at most `most` bytes.
pub(crate) fn text(path: &Path, most: u64) -> mocap::Result<String> {
    mocap::files::check_confined(path)?;
    let mut text = String::new();
    let read = fs::File::open(path).and_then(|file| file.take(most + 1).read_to_string(&mut text));
    let diagnostic = match read {
        Ok(bytes) if bytes as u64 <= most => return Ok(text),
        Ok(_) => Diagnostic::new(Code::LimitExceeded, format!("the file has more than {most} bytes")),
        Err(error) if error.kind() == io::ErrorKind::InvalidData => {
            Diagnostic::new(Code::BinaryFile, "the file is not UTF-8 text")
        }
        Err(error) => return Err(Error::io(path, error)),
    };
    Err(Error::from(diagnostic).with_path(path))
}

/// The motions of a job that are not files: standard input, if the job names it.
pub(crate) fn given<'a>(
    read: &InputOptions,
    mut motions: impl Iterator<Item = &'a PathBuf>,
) -> mocap::Result<&'static [MemoryFile<'static>]> {
    match motions.any(|motion| is_standard(motion)) {
        true => standard_input(&read.importer()),
        false => Ok(&[]),
    }
}

/// Whether standard input and output carry the messages of a protocol.
static ARE_TAKEN: AtomicBool = AtomicBool::new(false);

/// From now on, standard input and output belong to a protocol, and cannot be files.
pub(crate) fn take() {
    ARE_TAKEN.store(true, Ordering::Relaxed);
}

fn check_free() -> mocap::Result<()> {
    match ARE_TAKEN.load(Ordering::Relaxed) {
        false => Ok(()),
        true => {
            let message = "- is standard input or output, which the protocol uses";
            Err(Diagnostic::new(Code::InvalidValue, message).help("name a file").into())
        }
    }
}

/// Standard input, under the name `-`.
fn standard_input(importer: &Importer) -> mocap::Result<&'static [MemoryFile<'static>]> {
    check_free()?;
    static BYTES: OnceLock<Vec<u8>> = OnceLock::new();
    static INPUT: OnceLock<[MemoryFile<'static>; 1]> = OnceLock::new();
    let bytes = match BYTES.get() {
        Some(bytes) => bytes,
        None => {
            let bytes = importer.read_stream(io::stdin().lock(), "-")?;
            BYTES.get_or_init(|| bytes)
        }
    };
    Ok(INPUT.get_or_init(|| [MemoryFile { name: "-", bytes }]))
}

/// Refuses an output that would replace an input or a file that may be a source.
pub(crate) fn check_output<P: AsRef<Path>>(inputs: &[P], output: &Path, force: bool) -> mocap::Result<()> {
    if is_standard(output) {
        return Ok(());
    }
    ReplacePolicy::new(inputs).force(force).check(output)
}

/// Writes a file or standard output. A killed process may have left a partial file.
pub(crate) fn write(output: &Path, bytes: &[u8]) -> Result<(), Failure> {
    if !is_standard(output) {
        remove_unfinished(output);
        return Ok(write_file(output, bytes)?);
    }
    check_free()?;
    // A terminal must not interpret the data: `report::data` escapes control characters.
    let mut out = report::data();
    out.write_all(bytes)?;
    Ok(out.flush()?)
}

/// Writes the files of an output and further files that the user named, all or none, as `policy` allows. Files for
/// standard output are printed. A dry run reports the files, unless `policy` refuses them.
pub(crate) fn save(
    written: &Export,
    output: &Path,
    besides: &[(&Path, &[u8])],
    policy: &ReplacePolicy,
    is_dry_run: bool,
) -> Result<(), Failure> {
    let is_stream = is_standard(output);
    let stream = is_stream.then(|| written.clone().into_bytes()).transpose()?;
    let mut set = OutputSet::new();
    besides.iter().for_each(|(path, bytes)| set.add(path, [*bytes]));
    if !is_stream {
        written.add_to(&mut set, output)?;
    }
    if is_dry_run {
        return would_save(&set, stream.as_deref(), policy);
    }
    write_set(&set, stream.as_deref(), policy)
}

/// Writes files that a user named, all or none, as `policy` allows. One of them may be standard output.
pub(crate) fn write_all<P: AsRef<Path>>(files: &[(P, Vec<u8>)], policy: &ReplacePolicy) -> Result<(), Failure> {
    let (mut set, mut stream) = (OutputSet::new(), None);
    for (path, bytes) in files {
        match is_standard(path.as_ref()) {
            true => stream = Some(bytes.as_slice()),
            false => set.add(path.as_ref(), [bytes.as_slice()]),
        }
    }
    write_set(&set, stream, policy)
}

fn write_set(set: &OutputSet<'_>, stream: Option<&[u8]>, policy: &ReplacePolicy) -> Result<(), Failure> {
    set.save(policy)?;
    set.remove_unfinished();
    stream.map_or(Ok(()), |bytes| write(Path::new("-"), bytes))
}

fn would_save(set: &OutputSet<'_>, stream: Option<&[u8]>, policy: &ReplacePolicy) -> Result<(), Failure> {
    set.check(policy)?;
    if let Some(bytes) = stream {
        report::say(&format!("dry run: {} bytes would go to standard output", bytes.len()));
    }
    for (path, parts) in set.files() {
        let replaces = if path.exists() {
            ", replacing the existing file"
        } else {
            ""
        };
        let bytes: usize = parts.iter().map(FilePart::len).sum();
        report::say(&format!(
            "dry run: {} would be written, {bytes} bytes{replaces}",
            path.display()
        ));
    }
    Ok(())
}
