//! Makes a list of files from paths of files and folders, and from wildcards.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};

use mocap::files::check_confined;
use mocap::{Code, Diagnostic, FormatInfo};
use walkdir::WalkDir;

use crate::args::InputArgs;
use crate::{Failure, report};

/// An input file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Input {
    pub path: PathBuf,
    /// The path below the folder or the wildcards in which it was found, with `/` as separator; for a file named by the
    /// user, its name.
    pub relative: String,
    /// Its size when it was found.
    pub bytes: u64,
    /// Why it cannot be read, if that is known: a link without a target, a folder without permission.
    pub problem: Option<String>,
}

impl Input {
    fn new(path: PathBuf, folder: &Path) -> Self {
        let below = path.strip_prefix(folder).unwrap_or(&path);
        let parts = below.components().filter_map(|part| match part {
            Component::Normal(name) => Some(name.to_string_lossy()),
            _ => None,
        });
        Self {
            relative: parts.collect::<Vec<_>>().join("/"),
            bytes: path.metadata().map_or(0, |metadata| metadata.len()),
            path,
            problem: None,
        }
    }

    /// A file that the caller names. A pipe among many files would be read twice, or waited for: it is a failed row.
    fn named(path: &Path) -> Self {
        let input = Self::new(path.to_owned(), path.parent().unwrap_or(Path::new("")));
        let is_stream = path.metadata().is_ok_and(|metadata| !metadata.is_file());
        Self {
            problem: is_stream.then(|| "a pipe or a device is not read as one of many files".to_owned()),
            ..input
        }
    }

    /// The path of the file.
    ///
    /// # Errors
    /// If it is known that the file cannot be read.
    pub(crate) fn path(&self) -> mocap::Result<&Path> {
        match &self.problem {
            None => Ok(&self.path),
            Some(problem) => {
                let error = mocap::Error::from(Diagnostic::new(Code::Io, problem));
                Err(error.with_path(&self.path))
            }
        }
    }
}

/// The files that `paths` name, sorted by their relative paths: files with any extension; in folders and from wildcards
/// only files with the extension of a known format, and entries that cannot be read.
///
/// A path that does not exist is an input too, and fails as one of many.
pub fn find(paths: &[PathBuf], args: &InputArgs) -> Result<Vec<Input>, Failure> {
    find_except(paths, args, |_| false)
}

/// [`find`] without the entries of folders for which `is_excluded` is true.
pub(crate) fn find_except(
    paths: &[PathBuf],
    args: &InputArgs,
    is_excluded: impl Fn(&Path) -> bool,
) -> Result<Vec<Input>, Failure> {
    let mut found = Found::default();
    for path in paths {
        let before = found.inputs.len();
        if path.is_dir() {
            add_folder(path, path, &is_excluded, &mut found);
        } else if is_pattern(path) {
            add_matches(path, &is_excluded, &mut found)?;
        } else {
            found.inputs.push(Input::named(path));
        }
        if found.inputs.len() == before && !args.allow_empty {
            found.say_tables();
            let message = format!("{}: no motion files found; --allow-empty accepts that", path.display());
            return Err(Failure::Usage(message));
        }
    }
    found.say_tables();
    let mut inputs = found.inputs;
    inputs.sort_by(|a, b| (&a.relative, &a.path).cmp(&(&b.relative, &b.path)));
    inputs.dedup_by(|a, b| a.path == b.path);
    Ok(inputs)
}

/// What was found in folders and by wildcards.
#[derive(Default)]
struct Found {
    inputs: Vec<Input>,
    /// Tables that are no motion, as most are: lists of clips, reports.
    tables: Vec<PathBuf>,
}

impl Found {
    /// Adds a file with a known extension. Of tables only those are motions whose columns say so; a Parquet file has
    /// any number of clips, and must be named.
    fn add(&mut self, path: PathBuf, base: &Path) {
        const HEAD: u64 = 64 << 10;
        let has = |extension: &str| path.extension().is_some_and(|own| own.eq_ignore_ascii_case(extension));
        let is_motion = || {
            let mut head = Vec::new();
            let read = File::open(&path).and_then(|file| file.take(HEAD).read_to_end(&mut head));
            // One that cannot be read fails as any input.
            read.is_err() || FormatInfo::of_contents(&head).is_some()
        };
        if has("parquet") || has("csv") && !is_motion() {
            self.tables.push(path);
        } else {
            self.inputs.push(Input::new(path, base));
        }
    }

    /// Names the tables that are left out.
    fn say_tables(&mut self) {
        const NAMED: usize = 3;
        let Some(first) = self.tables.first() else { return };
        let names = self.tables.iter().take(NAMED).map(|path| path.display().to_string());
        let mut names = names.collect::<Vec<_>>().join(", ");
        if self.tables.len() > NAMED {
            names += ", ...";
        }
        let how = match first.extension().is_some_and(|own| own.eq_ignore_ascii_case("parquet")) {
            true => "; a Parquet file of motions is read where it is named",
            false => "",
        };
        report::say(&match self.tables.len() {
            1 => format!("left out, for it is a table and no motion: {names}{how}"),
            count => format!("left out, for they are tables and no motions: {count}: {names}{how}"),
        });
        self.tables.clear();
    }
}

/// Adds the motion files at any depth of `folder`, and the entries that cannot be read.
fn add_folder(folder: &Path, base: &Path, is_excluded: &impl Fn(&Path) -> bool, found: &mut Found) {
    let entries = WalkDir::new(folder).follow_links(true).into_iter();
    for entry in
        entries.filter_entry(|entry| is_allowed(entry.path()) && (entry.depth() == 0 || !is_excluded(entry.path())))
    {
        match entry {
            Ok(entry) => {
                if entry.file_type().is_file() && has_known_extension(entry.path()) {
                    found.add(entry.into_path(), base);
                }
            }
            Err(error) => {
                let path = error.path().unwrap_or(folder).to_owned();
                // A link without a target whose extension is unknown is ignored, as its target would be.
                if path.extension().is_none() || has_known_extension(&path) || path.is_dir() {
                    found.inputs.push(Input {
                        problem: Some(problem(&error)),
                        ..Input::new(path, base)
                    });
                }
            }
        }
    }
}

fn problem(error: &walkdir::Error) -> String {
    match (error.loop_ancestor(), error.io_error()) {
        (Some(ancestor), _) => format!("the link points to {}, which contains it", ancestor.display()),
        (None, Some(error)) if error.kind() == io::ErrorKind::NotFound => {
            "the target of the link does not exist".to_owned()
        }
        (None, Some(error)) => error.to_string(),
        (None, None) => error.to_string(),
    }
}

/// Adds the files that a wildcard pattern matches; their relative paths begin at its first wildcard.
fn add_matches(pattern: &Path, is_excluded: &impl Fn(&Path) -> bool, found: &mut Found) -> Result<(), Failure> {
    let base: PathBuf = pattern
        .components()
        .take_while(|part| !has_wildcard(Path::new(part)))
        .collect();
    let text = pattern
        .to_str()
        .ok_or_else(|| Failure::Usage(format!("{} is not UTF-8", pattern.display())))?;
    let matches = glob::glob(text).map_err(|error| Failure::Usage(format!("{text}: {error}")))?;
    for entry in matches {
        match entry {
            Ok(path) if is_excluded(&path) || !is_allowed(&path) => {}
            Ok(path) if path.is_dir() => add_folder(&path, &base, is_excluded, found),
            Ok(path) if has_known_extension(&path) => found.add(path, &base),
            Ok(_) => {}
            Err(error) => found.inputs.push(Input {
                problem: Some(error.error().to_string()),
                ..Input::new(error.path().to_owned(), &base)
            }),
        }
    }
    Ok(())
}

/// Whether a program that is confined to a folder may know of an entry.
fn is_allowed(path: &Path) -> bool {
    check_confined(path).is_ok()
}

/// Whether a path is no file, and its wildcards may match some.
fn is_pattern(path: &Path) -> bool {
    !path.exists() && has_wildcard(path)
}

/// Whether a path may name several files.
pub(crate) fn names_several(path: &Path) -> bool {
    path.is_dir() || is_pattern(path)
}

fn has_wildcard(path: &Path) -> bool {
    path.to_string_lossy().contains(['*', '?', '['])
}

fn has_known_extension(path: &Path) -> bool {
    let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or("");
    FormatInfo::ALL
        .iter()
        .flat_map(|format| format.extensions)
        .any(|known| known.eq_ignore_ascii_case(extension))
}
