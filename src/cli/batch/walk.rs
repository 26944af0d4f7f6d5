//! The search of folders, also for wildcards.
//!
//! Links to files and folders are followed anywhere, because datasets are often linked into a folder. No folder is
//! searched twice: neither a folder that contains the link, nor a folder already searched through another path. Folders
//! are searched before links to them, so a link never hides the real path of a folder.

use std::collections::HashSet;
use std::fs;
use std::io;
use std::mem;
use std::path::{Path, PathBuf};

use mocap::files::check_confined;
use walkdir::WalkDir;

use super::pattern::{Fit, Pattern};

/// An entry that a search finds.
#[derive(Debug, PartialEq, Eq)]
pub enum Entry {
    /// A regular file that matches.
    File(PathBuf),
    /// A file or a folder that cannot be read, and the reason.
    Problem(PathBuf, String),
    /// A folder that was already searched through another path.
    Again(PathBuf),
}

/// Searches the folder `base` for files that match `pattern`. Excluded folders and their contents are skipped.
pub struct Search<'a> {
    /// The folder to search.
    pub base: &'a Path,
    /// The pattern for paths relative to `base`.
    pub pattern: &'a Pattern,
    /// Whether a path and its contents are skipped.
    pub is_excluded: &'a dyn Fn(&Path) -> bool,
}

impl Search<'_> {
    /// Passes each entry to `take`, until `take` fails.
    pub fn run<E>(&self, mut take: impl FnMut(Entry) -> Result<(), E>) -> Result<(), E> {
        let (mut entered, mut links) = (HashSet::new(), vec![self.base.to_owned()]);
        while !links.is_empty() {
            links.sort_unstable();
            for link in mem::take(&mut links) {
                match self.target(&link, &entered) {
                    Ok(target) => self.folder(&link, &target, &mut entered, &mut links, &mut take)?,
                    Err(found) => take(found)?,
                }
            }
        }
        Ok(())
    }

    /// The target folder of a link, as a path without links; an error if it must not be searched.
    fn target(&self, link: &Path, entered: &HashSet<PathBuf>) -> Result<PathBuf, Entry> {
        let target = here(link).canonicalize();
        let target = target.map_err(|error| Entry::Problem(link.to_owned(), cannot_be_read(&error)))?;
        let parent = link.parent().filter(|_| link != self.base);
        if parent.is_some_and(|parent| {
            here(parent)
                .canonicalize()
                .is_ok_and(|parent| parent.starts_with(&target))
        }) {
            let written = fs::read_link(link).unwrap_or(target);
            let problem = format!("the link points to {}, which contains it", written.display());
            return Err(Entry::Problem(link.to_owned(), problem));
        }
        match entered.contains(&target) {
            true => Err(Entry::Again(link.to_owned())),
            false => Ok(target),
        }
    }

    /// Searches a folder, and collects links to folders. `real` is its path without links.
    fn folder<E>(
        &self,
        folder: &Path,
        real: &Path,
        entered: &mut HashSet<PathBuf>,
        links: &mut Vec<PathBuf>,
        take: &mut impl FnMut(Entry) -> Result<(), E>,
    ) -> Result<(), E> {
        let start = here(folder);
        let mut entries = WalkDir::new(start).into_iter();
        while let Some(entry) = entries.next() {
            let entry = match entry {
                Ok(entry) => entry,
                Err(error) => {
                    let path = below(folder, start, error.path().unwrap_or(start));
                    let problem = error.io_error().map_or_else(|| error.to_string(), cannot_be_read);
                    take(Entry::Problem(path, problem))?;
                    continue;
                }
            };
            let path = below(folder, start, entry.path());
            let fit = self.fit(&path);
            let is_taken = fit != Fit::No && (path == self.base || !(self.is_excluded)(&path));
            // For a link, this is the type of the link itself.
            if entry.depth() == 0 || entry.file_type().is_dir() {
                let real = below(real, start, entry.path());
                match is_taken && entered.insert(real) {
                    true => {}
                    false => {
                        if is_taken {
                            take(Entry::Again(path))?;
                        }
                        entries.skip_current_dir();
                    }
                }
            } else if is_taken && entry.file_type().is_file() && fit == Fit::Whole {
                take(Entry::File(path))?;
            } else if is_taken && entry.file_type().is_symlink() && check_confined(&path).is_ok() {
                match fs::metadata(&path) {
                    Ok(target) if target.is_dir() => links.push(path),
                    Ok(target) if target.is_file() && fit == Fit::Whole => take(Entry::File(path))?,
                    Ok(_) => {}
                    Err(error) => take(Entry::Problem(path, dangling(&error)))?,
                }
            }
        }
        Ok(())
    }

    fn fit(&self, path: &Path) -> Fit {
        let names = path.strip_prefix(self.base).unwrap_or(path).components();
        let names: Vec<_> = names.map(|name| name.as_os_str().to_string_lossy()).collect();
        self.pattern.fit(names.iter().map(AsRef::as_ref))
    }
}

/// The path that opens a folder: `.` for an empty path.
fn here(path: &Path) -> &Path {
    match path.as_os_str().is_empty() {
        true => Path::new("."),
        false => path,
    }
}

/// The path of an entry that was found through `start`, as a path in `folder`.
fn below(folder: &Path, start: &Path, entry: &Path) -> PathBuf {
    match entry.strip_prefix(start) {
        Ok(names) if names.as_os_str().is_empty() => folder.to_owned(),
        Ok(names) => folder.join(names),
        Err(_) => entry.to_owned(),
    }
}

fn cannot_be_read(error: &io::Error) -> String {
    format!("it cannot be read: {error}")
}

fn dangling(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => "the target of the link does not exist".to_owned(),
        _ => format!("the link cannot be followed: {error}"),
    }
}
