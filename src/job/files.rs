//! The location of a job's files: on a disk, or in memory.

use std::path::{Path, PathBuf};

use mocap_formats::{Export, ExportFile};
use mocap_io::import::{self, Importer, MemoryFile};
use mocap_retarget::Target;
use mocap_scene::error::{Code, Diagnostic, Error, Result};
use mocap_scene::files::{OutputSet, ReplacePolicy, check_distinct, decode_text, read_text};
use mocap_scene::scene::Scene;
use mocap_scene::scene::robot::Robot;

use super::report::OutputFile;
use super::{InputOptions, JobTarget, refuse};

/// The location of a job's files.
#[derive(Clone, Copy, Debug)]
pub(super) struct Files<'a> {
    /// Files in memory, with their names in the job.
    pub(super) given: &'a [MemoryFile<'a>],
    /// Whether files that are not in `given` are read from a disk.
    pub(super) has_disk: bool,
}

impl<'a> Files<'a> {
    pub(super) fn import(&self, importer: &Importer, path: &Path) -> Result<Scene> {
        match (self.find(path), self.has_disk) {
            (None, true) => importer.import(path),
            (None, false) => Err(missing(path)),
            // The file is standard input. If it needs a skeleton file, that file is on the disk.
            (Some(file), true) => importer.read(file.bytes, path),
            (Some(file), false) => importer.read_among(file, &self.others(path)),
        }
    }

    /// The text of a file.
    pub(super) fn text(&self, path: &Path) -> Result<String> {
        let read = match (self.find(path), self.has_disk) {
            (None, false) => return Err(missing(path)),
            (None, true) => return read_text(path),
            (Some(file), _) => decode_text(file.bytes.to_vec()),
        };
        read.ok_or_else(|| {
            let diagnostic = Diagnostic::new(Code::InvalidValue, "the file is not UTF-8 text");
            Error::from(diagnostic).with_path(path)
        })
    }

    /// The text of a file. Refuses a pipe, a device, and a file above the size limit for reading.
    pub(super) fn regular_text(&self, path: &Path) -> Result<String> {
        match self.find(path).is_none() && self.has_disk {
            true => import::read_text(path),
            false => self.text(path),
        }
    }

    /// Reads the body to which motions are retargeted.
    pub(super) fn import_target(&self, target: &JobTarget, importer: &Importer) -> Result<Target> {
        let path = target.file();
        let file = self.find(path);
        if file.is_none() && !self.has_disk {
            return Err(missing(path));
        }
        match (target, file) {
            (JobTarget::Skeleton(_), _) => {
                let mut scene = self.import(importer, path)?;
                scene.original = None;
                scene.metadata.fbx = None;
                Ok(scene.into())
            }
            (JobTarget::Character(_), None) => Target::import(path, importer),
            (JobTarget::Character(_), Some(file)) => {
                match importer.for_characters().read_character(file, &self.others(path)) {
                    Err(error) if error.code() == Code::UnknownFormat => Ok(self.import(importer, path)?.into()),
                    read => Ok(read?.into()),
                }
            }
            (JobTarget::Robot(_), _) => Ok(self.import_robot(path)?.into()),
        }
    }

    /// Reads the robot of a file.
    pub(super) fn import_robot(&self, path: &Path) -> Result<Robot> {
        match self.find(path) {
            Some(file) => Importer::new().read_robot(file.bytes, path),
            None if self.has_disk => Importer::new().import_robot(path),
            None => Err(missing(path)),
        }
    }

    fn find(&self, path: &Path) -> Option<MemoryFile<'a>> {
        self.given.iter().find(|file| Path::new(file.name) == path).copied()
    }

    fn others(&self, path: &Path) -> Vec<MemoryFile<'a>> {
        let others = self.given.iter().filter(|file| Path::new(file.name) != path);
        others.copied().collect()
    }
}

fn missing(path: &Path) -> Error {
    let message = format!(
        "the job names the file {:?}, which was not given",
        path.display().to_string()
    );
    Diagnostic::new(Code::MissingFile, message).into()
}

/// The policy for replacing files: an output never replaces a file that the job reads.
pub(super) fn policy<'a>(
    inputs: &'a [PathBuf],
    read: &'a InputOptions,
    others: impl IntoIterator<Item = &'a Path>,
) -> ReplacePolicy {
    ReplacePolicy::new(inputs.iter().map(AsRef::as_ref).chain(others).chain(read.files()))
}

/// Refuses inputs that are not files.
pub(super) fn check_inputs(inputs: &[PathBuf]) -> Result<()> {
    if inputs.is_empty() {
        return refuse("the job names no input", "name files in source.inputs");
    }
    match inputs.iter().find(|input| Importer::is_of_many(input)) {
        Some(folder) => refuse(
            &format!("{} is a folder, but the job takes files", folder.display()),
            "name its files, or run the job with mocap run",
        ),
        None => Ok(()),
    }
}

/// Files to write, with their bytes.
pub(super) type Outputs = Vec<(PathBuf, Vec<u8>)>;

/// The names and the sizes of output files.
pub(super) fn output_files(made: &Outputs) -> Vec<OutputFile> {
    let of_output = |(path, bytes): &(PathBuf, Vec<u8>)| OutputFile {
        name: file_name(path),
        bytes: bytes.len(),
    };
    made.iter().map(of_output).collect()
}

/// The output files, in memory.
pub(super) fn written(made: Outputs) -> Export {
    let files = made
        .into_iter()
        .map(|(path, bytes)| ExportFile::new(file_name(&path), bytes));
    Export::of(files.collect())
}

/// The name of a file, without its folder.
fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// Refuses outputs that would replace an input or a file of the user, and two outputs of one name.
pub(super) fn check_outputs<'a>(policy: &ReplacePolicy, outputs: impl Iterator<Item = &'a Path>) -> Result<()> {
    let outputs: Vec<&Path> = outputs.collect();
    check_distinct(outputs.iter().copied())?;
    outputs.into_iter().try_for_each(|path| policy.check_ahead(path))
}

/// Writes files, all or none.
pub(super) fn write_all(policy: &ReplacePolicy, made: &Outputs) -> Result<()> {
    let mut set = OutputSet::new();
    made.iter().for_each(|(path, bytes)| set.add(path, [bytes.as_slice()]));
    set.save(policy)?;
    set.remove_unfinished();
    Ok(())
}
