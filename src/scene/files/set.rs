//! The files that one call writes. All files are checked before the first is written, and all are written or none.

use std::collections::HashMap;
use std::ffi::OsString;
use std::fs;
use std::io::{self, Write};
use std::path::{Component, Path, PathBuf};

use tempfile::TempPath;

use super::existing::needs_record;
use super::file_id::FileId;
use super::unfinished::{UnfinishedFile, named};
use super::{
    FilePart, ReplacePolicy, Target, folder_of, own, record, remove_all_unfinished, write_noted, write_stream, writing,
};
use crate::error::{Code, Diagnostic, Error, Result};

/// All files of an output: the files that a user named, and their companion files, such as buffers, textures and
/// sidecars. Every interface writes outputs with this type.
///
/// The last file refers to the others, as a `.gltf` refers to its buffer. An existing last file gets a temporary name
/// before the others are replaced. So a last file never refers to files of another output, even if the process is
/// killed. The file with the temporary name then shows [`ReplacePolicy`] to which output the other files belong.
#[doc(hidden)]
#[derive(Debug, Default)]
pub struct OutputSet<'a> {
    files: Vec<OutputFile<'a>>,
}

#[derive(Debug)]
struct OutputFile<'a> {
    path: PathBuf,
    /// The bytes, in parts.
    parts: Vec<FilePart<'a>>,
    /// Whether an input may have chosen the name, such as the name of a texture.
    is_beside: bool,
}

impl<'a> OutputSet<'a> {
    /// A set without files.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a file that a user named.
    pub fn add(&mut self, path: &Path, parts: impl IntoIterator<Item = impl Into<FilePart<'a>>>) {
        self.files.push(OutputFile {
            path: path.to_owned(),
            parts: parts.into_iter().map(Into::into).collect(),
            is_beside: false,
        });
    }

    /// Adds a companion file in the folder of the output `main`.
    ///
    /// # Errors
    /// [`Code::InvalidValue`] if `main` is a pipe or a device, or if `name` is not a file name.
    pub fn add_beside(
        &mut self,
        main: &Path,
        name: &str,
        parts: impl IntoIterator<Item = impl Into<FilePart<'a>>>,
    ) -> Result<()> {
        if fs::metadata(main).is_ok_and(|found| !found.is_file() && !found.is_dir()) {
            let message = "an output of several files cannot be written to a pipe or a device";
            let diagnostic = Diagnostic::new(Code::InvalidValue, message)
                .expected_found("one file", format!("{name} beside it"))
                .help("write to a file, or choose a format with one file");
            return Err(Error::from(diagnostic).with_path(main));
        }
        let is_name =
            matches!(Path::new(name).components().collect::<Vec<_>>()[..], [Component::Normal(only)] if only == name);
        if !is_name || name.contains('\0') {
            let message = format!("a companion file of the output cannot have the name {name:?}");
            return Err(Error::from(Diagnostic::new(Code::InvalidValue, message)).with_path(main));
        }
        self.files.push(OutputFile {
            path: main.with_file_name(name),
            parts: parts.into_iter().map(Into::into).collect(),
            is_beside: true,
        });
        Ok(())
    }

    /// The path and the parts of each file.
    pub fn files(&self) -> impl Iterator<Item = (&Path, &[FilePart<'a>])> {
        self.files
            .iter()
            .map(|file| (file.path.as_path(), file.parts.as_slice()))
    }

    /// Makes the checks of [`save`](Self::save), and writes nothing.
    ///
    /// # Errors
    /// [`Code::OutputIsInput`] and [`Code::OutputExists`] by the rules of [`ReplacePolicy`], and the errors of
    /// [`check_distinct`].
    pub fn check(&self, policy: &ReplacePolicy) -> Result<()> {
        self.to_write(policy).map(drop)
    }

    /// Writes all files or none, if `policy` allows them to replace existing files. After an error the existing files
    /// are unchanged.
    ///
    /// # Errors
    /// The errors of [`check`](Self::check), and [`Code::Io`] with the path.
    pub fn save(&self, policy: &ReplacePolicy) -> Result<()> {
        let files = self.to_write(policy)?;
        let sources = policy.noted_sources();
        match files.as_slice() {
            [file] => write_noted(&file.path, file.noted(&sources), |to| file.write(to)).map(drop),
            files => write_whole(files, &sources),
        }
    }

    /// The files to write. Companion files that exist with the same bytes are not written. Fails unless all files may
    /// be written.
    fn to_write(&self, policy: &ReplacePolicy) -> Result<Vec<&OutputFile<'a>>> {
        check_distinct(self.files.iter().map(|file| file.path.as_path()))?;
        let mut files = Vec::new();
        for file in &self.files {
            let is_wanted = match file.is_beside {
                true => policy.check_beside(&file.path, &file.parts)?,
                false => policy.check_parts(&file.path, &file.parts).map(|()| true)?,
            };
            files.extend(is_wanted.then_some(file));
        }
        Ok(files)
    }

    /// Removes temporary files that killed processes left for these outputs. Call it after [`save`](Self::save),
    /// because a remaining `.gltf` shows the owner of its buffer.
    pub fn remove_unfinished(&self) {
        remove_all_unfinished(self.files.iter().map(|file| file.path.as_path()));
    }
}

impl OutputFile<'_> {
    /// The sources to record for this file; `None` if the file needs no record.
    fn noted<'s, 'n>(&self, sources: &'s [&'n str]) -> Option<&'s [&'n str]> {
        (self.is_beside || needs_record(&self.path)).then_some(sources)
    }

    fn write(&self, to: &mut dyn Write) -> io::Result<()> {
        self.parts.iter().try_for_each(|part| to.write_all(&part.bytes()))
    }
}

/// Refuses two outputs of one call that are the same file, or that would be the same file on a system that ignores
/// case. The second would replace the first.
///
/// # Errors
/// [`Code::InvalidValue`].
#[doc(hidden)]
pub fn check_distinct<'a>(outputs: impl IntoIterator<Item = &'a Path>) -> Result<()> {
    let (mut names, mut ids) = (
        HashMap::<(PathBuf, OsString), &Path>::new(),
        HashMap::<FileId, &Path>::new(),
    );
    for output in outputs {
        let target = match Target::of(output) {
            Ok(Target::File(target)) => target,
            _ => output.to_owned(),
        };
        let folder = folder_of(&target);
        let name = target.file_name().unwrap_or_default();
        let name = name
            .to_str()
            .map_or_else(|| name.to_owned(), |name| name.to_lowercase().into());
        let key = (fs::canonicalize(folder).unwrap_or_else(|_| folder.to_owned()), name);
        let by_name = names.insert(key, output);
        let by_id = FileId::of(&target).and_then(|id| ids.insert(id, output));
        let Some(first) = by_name.or(by_id) else { continue };
        let message = match first == output {
            true => format!("two outputs have the name {}; give each its own name", output.display()),
            false => format!(
                "two outputs are one file: {} and {}; give each its own name",
                first.display(),
                output.display()
            ),
        };
        return Err(Diagnostic::new(Code::InvalidValue, message).into());
    }
    Ok(())
}

fn write_whole(files: &[&OutputFile<'_>], sources: &[&str]) -> Result<()> {
    let _writing = writing();
    // All files are complete before the first is replaced.
    let (mut written, mut streams) = (Vec::new(), Vec::new());
    for &file in files {
        let path = file.path.as_path();
        let in_file = |source| Error::io(path, source);
        match Target::to_write(path).map_err(in_file)? {
            Target::Stream => streams.push(file),
            Target::File(target) => {
                let unfinished = UnfinishedFile::new(&target, |to| file.write(to)).map_err(in_file)?;
                if let Some(sources) = file.noted(sources) {
                    record::note(&target, || unfinished.contents(), sources);
                }
                written.push((path, target, unfinished));
            }
        }
    }
    // Bytes sent to a pipe or a device cannot be taken back.
    for file in streams {
        write_stream(&file.path, |to| file.write(to)).map_err(|source| Error::io(&file.path, source))?;
    }
    // If the process is killed now, this file identifies the owner of the others.
    if let Some((path, target, file)) = written.pop() {
        let file = file.with_name(&target).map_err(|source| Error::io(path, source))?;
        written.push((path, target, file));
    }
    let mut replaced = Replaced::default();
    for (path, target, _) in written.iter().rev() {
        replaced.set_aside(target).map_err(|source| Error::io(path, source))?;
    }
    for (path, target, file) in written {
        file.persist(&target).map_err(|error| Error::io(path, error))?;
        replaced.new.push(target);
    }
    replaced.keep();
    files.iter().for_each(|file| record::written(&file.path));
    Ok(())
}

/// Existing files that were renamed to make room for new ones. Dropping restores them, unless [`Replaced::keep`] was
/// called.
#[doc(hidden)]
#[derive(Default)]
pub struct Replaced {
    /// The path of each existing file, and its temporary path.
    old: Vec<(PathBuf, TempPath)>,
    /// The paths of the new files.
    pub new: Vec<PathBuf>,
}

impl Replaced {
    pub fn set_aside(&mut self, target: &Path) -> io::Result<()> {
        if !target.try_exists()? {
            return Ok(());
        }
        let aside = named(target)?.into_temp_path();
        fs::rename(target, &aside)?;
        self.old.push((target.to_owned(), aside));
        Ok(())
    }

    fn keep(mut self) {
        self.new.drain(..).for_each(|path| own::note(&path));
        // Dropping a temporary path removes its file.
        self.old.clear();
    }
}

impl Drop for Replaced {
    fn drop(&mut self) {
        for path in &self.new {
            // An error cannot be handled here.
            let _ = fs::remove_file(path);
        }
        for (target, aside) in self.old.drain(..).rev() {
            let _ = aside.persist(target);
        }
    }
}
