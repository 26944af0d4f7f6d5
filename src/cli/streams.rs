//! `-` as a file: standard input, and standard output.

use std::fs;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

use mocap::files::{ReplacePolicy, remove_unfinished, write_file};
use mocap::job::Job;
use mocap::{Code, Diagnostic, Error, Importer, MemoryFile, Scene, Written};

use crate::args::{ForceArgs, Given};
use crate::{Failure, report};

/// Whether a path stands for standard input or standard output.
pub(crate) fn is_standard(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// Imports a file or standard input, which is read once however often it is imported.
pub(crate) fn import(importer: &Importer, path: &Path) -> mocap::Result<Scene> {
    match is_standard(path) {
        true => importer.read(standard_input(importer)?[0].bytes, path),
        false => importer.import(path),
    }
}

/// The text of a file that is no motion, of at most `most` bytes.
pub(crate) fn text(path: &Path, most: u64) -> mocap::Result<String> {
    mocap::files::check_confined(path)?;
    let mut text = String::new();
    let read = fs::File::open(path).and_then(|file| file.take(most + 1).read_to_string(&mut text));
    let diagnostic = match read {
        Ok(bytes) if bytes as u64 <= most => return Ok(text),
        Ok(_) => Diagnostic::new(Code::LimitExceeded, format!("the file has more than {most} bytes")),
        Err(error) if error.kind() == io::ErrorKind::InvalidData => {
            Diagnostic::new(Code::BinaryFile, "the file is no text in UTF-8")
        }
        Err(error) => Diagnostic::new(Code::Io, error.to_string()),
    };
    Err(Error::from(diagnostic).with_path(path))
}

/// What of the inputs of a job is not on a disk: standard input, where it is one of them.
pub(crate) fn given(job: &Job) -> mocap::Result<&'static [MemoryFile<'static>]> {
    let inputs = &job.source.inputs;
    match inputs.iter().chain(&job.source.with).any(|input| is_standard(input)) {
        true => standard_input(&job.read.importer()),
        false => Ok(&[]),
    }
}

/// Whether standard input and output carry the messages of a protocol.
static ARE_TAKEN: AtomicBool = AtomicBool::new(false);

/// From now on neither is a file: what they carry belongs to a protocol.
pub(crate) fn take() {
    ARE_TAKEN.store(true, Ordering::Relaxed);
}

fn check_free() -> mocap::Result<()> {
    match ARE_TAKEN.load(Ordering::Relaxed) {
        false => Ok(()),
        true => {
            let message = "- is standard input or output, which belong to the protocol";
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
pub(crate) fn check_output<P: AsRef<Path>>(inputs: &[P], output: &Path, force: ForceArgs) -> mocap::Result<()> {
    if is_standard(output) {
        return Ok(());
    }
    ReplacePolicy::new(inputs).force(force.force).check(output)
}

/// Refuses two outputs of a command that are one file, of which the second would replace the first. That may also be
/// the file of provenance beside the first, which has its name and `.json`.
pub(crate) fn refuse_one_file<'a>(outputs: impl IntoIterator<Item = &'a Path>) -> Result<(), Failure> {
    let mut taken: Vec<(PathBuf, &Path)> = Vec::new();
    for output in outputs {
        let absolute_path = absolute(output);
        if let Some((_, first)) = taken.iter().find(|(former, _)| *former == absolute_path) {
            let second = output.display();
            let message = match *first == output {
                true => format!("two outputs are called {second}; give each its own name"),
                false => format!(
                    "{second} is written beside {} already; name another file",
                    first.display()
                ),
            };
            return Err(Failure::Usage(message));
        }
        if taken.is_empty() {
            let mut provenance = absolute_path.clone().into_os_string();
            provenance.push(".json");
            taken.push((provenance.into(), output));
        }
        taken.push((absolute_path, output));
    }
    Ok(())
}

/// A path from the root of the system, with the links of its folder followed.
fn absolute(path: &Path) -> PathBuf {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    match (
        is_standard(path),
        path.file_name(),
        folder.unwrap_or(Path::new(".")).canonicalize(),
    ) {
        (false, Some(name), Ok(folder)) => folder.join(name),
        _ => path.to_owned(),
    }
}

/// Writes a file, of which a killed process may have left a part, or to standard output.
pub(crate) fn write(output: &Path, bytes: &[u8]) -> Result<(), Failure> {
    if !is_standard(output) {
        remove_unfinished(output);
        return Ok(write_file(output, bytes)?);
    }
    check_free()?;
    // Data, and not for a terminal to interpret: what of it could steer one is shown by `report::data`.
    let mut out = report::data();
    out.write_all(bytes)?;
    Ok(out.flush()?)
}

/// Writes the files of an output, as `policy` allows, or the one file to standard output. With `--dry-run` says what it
/// would write, unless `policy` refuses it.
pub(crate) fn save(written: &mut Written, output: &Path, policy: &ReplacePolicy, given: &Given) -> Result<(), Failure> {
    if given.is_dry_run() {
        return would_save(written, output, policy);
    }
    if is_standard(output) {
        let written = Written::clone(written);
        return write(output, &written.into_bytes()?);
    }
    written.save(output, policy)?;
    // Not before, because a `.gltf` that is left says whose its buffer is.
    remove_unfinished(output);
    Ok(())
}

fn would_save(written: &Written, output: &Path, policy: &ReplacePolicy) -> Result<(), Failure> {
    if is_standard(output) {
        let bytes = written.clone().into_bytes()?.len();
        report::say(&format!("dry run: {bytes} bytes would go to standard output"));
        return Ok(());
    }
    for (path, file) in written.check(output, policy)?.iter().zip(&written.files) {
        let replaces = if path.exists() {
            ", in absolute_path of what is there"
        } else {
            ""
        };
        let bytes = file.len();
        report::say(&format!(
            "dry run: {} would be written, {bytes} bytes{replaces}",
            path.display()
        ));
    }
    Ok(())
}
