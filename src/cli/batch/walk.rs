//! The one search of folders, for folders and for wildcards.
//!
//! A link is followed to a file or a folder wherever it is, because data sets are often linked into a folder. No folder
//! is searched twice: not one that a link is in, and not one that was searched by another path. Folders are searched
//! before the links to them, so a link never hides the path that a folder has by itself.

use std::collections::HashSet;
use std::fs;
use std::io;
use std::mem;
use std::path::{Path, PathBuf};

use mocap::files::check_confined;
use walkdir::WalkDir;

use super::pattern::{Fit, Pattern};

/// What a search finds.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Found {
    /// A regular file that matches.
    File(PathBuf),
    /// A file or a folder that cannot be read, and why.
    Problem(PathBuf, String),
    /// A folder that was searched by another path.
    Again(PathBuf),
}

/// Searches the folder `base` for what matches `pattern`, and leaves out what is excluded, with what is below it.
pub(super) struct Search<'a> {
    pub(super) base: &'a Path,
    pub(super) pattern: &'a Pattern,
    pub(super) is_excluded: &'a dyn Fn(&Path) -> bool,
}

impl Search<'_> {
    /// Passes to `take` what is found, until that fails.
    pub(super) fn run<E>(&self, mut take: impl FnMut(Found) -> Result<(), E>) -> Result<(), E> {
        let (mut entered, mut links) = (HashSet::new(), vec![self.base.to_owned()]);
        while !links.is_empty() {
            links.sort();
            for link in mem::take(&mut links) {
                match self.target(&link, &entered) {
                    Ok(target) => self.folder(&link, &target, &mut entered, &mut links, &mut take)?,
                    Err(found) => take(found)?,
                }
            }
        }
        Ok(())
    }

    /// The folder to which a link leads, without links in its path; an error where it is not to be searched.
    fn target(&self, link: &Path, entered: &HashSet<PathBuf>) -> Result<PathBuf, Found> {
        let target = here(link).canonicalize();
        let target = target.map_err(|error| Found::Problem(link.to_owned(), cannot_be_read(&error)))?;
        let parent = link.parent().filter(|_| link != self.base);
        if parent.is_some_and(|parent| {
            here(parent)
                .canonicalize()
                .is_ok_and(|parent| parent.starts_with(&target))
        }) {
            let written = fs::read_link(link).unwrap_or(target);
            let problem = format!("the link points to {}, which contains it", written.display());
            return Err(Found::Problem(link.to_owned(), problem));
        }
        match entered.contains(&target) {
            true => Err(Found::Again(link.to_owned())),
            false => Ok(target),
        }
    }

    /// Searches a folder, which is `real` without links in its path, and gathers the links to folders.
    fn folder<E>(
        &self,
        folder: &Path,
        real: &Path,
        entered: &mut HashSet<PathBuf>,
        links: &mut Vec<PathBuf>,
        take: &mut impl FnMut(Found) -> Result<(), E>,
    ) -> Result<(), E> {
        let start = here(folder);
        let mut entries = WalkDir::new(start).into_iter();
        while let Some(entry) = entries.next() {
            let entry = match entry {
                Ok(entry) => entry,
                Err(error) => {
                    let path = below(folder, start, error.path().unwrap_or(start));
                    let problem = error.io_error().map_or_else(|| error.to_string(), cannot_be_read);
                    take(Found::Problem(path, problem))?;
                    continue;
                }
            };
            let path = below(folder, start, entry.path());
            let fit = self.fit(&path);
            let is_taken = fit != Fit::No && (path == self.base || !(self.is_excluded)(&path));
            // Of a link that is searched, the type is that of the link.
            if entry.depth() == 0 || entry.file_type().is_dir() {
                let real = below(real, start, entry.path());
                match is_taken && entered.insert(real) {
                    true => {}
                    false => {
                        if is_taken {
                            take(Found::Again(path))?;
                        }
                        entries.skip_current_dir();
                    }
                }
            } else if is_taken && entry.file_type().is_file() && fit == Fit::Whole {
                take(Found::File(path))?;
            } else if is_taken && entry.file_type().is_symlink() && check_confined(&path).is_ok() {
                match fs::metadata(&path) {
                    Ok(target) if target.is_dir() => links.push(path),
                    Ok(target) if target.is_file() && fit == Fit::Whole => take(Found::File(path))?,
                    Ok(_) => {}
                    Err(error) => take(Found::Problem(path, dangling(&error)))?,
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

/// The path by which the system opens a folder of which nothing is named.
fn here(path: &Path) -> &Path {
    match path.as_os_str().is_empty() {
        true => Path::new("."),
        false => path,
    }
}

/// The path in `folder` of an entry in `start`.
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

#[cfg(unix)]
#[cfg(test)]
mod tests {
    use std::convert::Infallible;
    use std::os::unix::fs::symlink;

    use super::*;

    /// A folder with files, links as `name -> target`, and nothing else.
    fn folder(entries: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for entry in entries {
            let (name, target) = entry.split_once(" -> ").unwrap_or((entry, ""));
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            match target {
                "" => fs::write(path, "").unwrap(),
                target => symlink(target, path).unwrap(),
            }
        }
        folder
    }

    /// What is found below `root`: files as they are, `!` before problems, `=` before folders that were searched.
    fn search(folder: &tempfile::TempDir, root: &str) -> Vec<String> {
        let root = folder.path().join(root);
        let (base, pattern) = match root.is_dir() {
            true => (root, Pattern::default()),
            false => Pattern::of(&root).map_err(crate::Failure::into_words).unwrap(),
        };
        let mut found = Vec::new();
        let search = Search {
            base: &base,
            pattern: &pattern,
            is_excluded: &|_| false,
        };
        let name = |path: &Path| path.strip_prefix(folder.path()).unwrap().display().to_string();
        let take = |entry: Found| {
            found.push(match entry {
                Found::File(path) => name(&path),
                Found::Problem(path, problem) => format!("!{}: {problem}", name(&path)),
                Found::Again(path) => format!("={}", name(&path)),
            });
            Ok::<_, Infallible>(())
        };
        let Ok(()) = search.run(take);
        found.sort();
        found
    }

    #[test]
    fn a_folder_is_searched_once_however_links_lead_to_it() {
        let two_loops = folder(&["in/a", "in/x -> .", "in/y -> ."]);
        for root in ["in", "in/**"] {
            let found = search(&two_loops, root);
            assert_eq!(found.len(), 3, "{found:?}");
            assert_eq!(found[2], "in/a");
            assert!(
                found[..2].iter().all(|found| found.contains("which contains it")),
                "{found:?}"
            );
        }
        // One folder is a link of the other, in both directions, and the link comes first.
        let crossed = folder(&["a/to_b -> ../b", "b/to_a -> ../a", "a/1", "b/2", "0 -> b"]);
        assert_eq!(search(&crossed, ""), ["=0", "=a/to_b", "=b/to_a", "a/1", "b/2"]);
        // Many links to one folder give one path.
        let links: Vec<String> = (0..50).map(|link| format!("in/{link:02} -> ../far")).collect();
        let entries: Vec<&str> = links
            .iter()
            .map(String::as_str)
            .chain(["far/a/b", "far/c -> a"])
            .collect();
        let found = search(&folder(&entries), "in");
        assert_eq!(
            found.iter().filter(|found| !found.starts_with('=')).collect::<Vec<_>>(),
            ["in/00/a/b"]
        );
    }

    #[test]
    fn links_lead_to_data_elsewhere_and_never_up() {
        let linked = folder(&[
            "data/set/1",
            "data/set/deep/2",
            "in/set -> ../data/set",
            "in/deep -> ../data/set/deep",
            "in/file -> ../data/set/1",
            "in/up -> ..",
            "data/set/back -> ../../in",
            "other/3",
        ]);
        let found = search(&linked, "in");
        assert_eq!(
            &found[1..],
            ["=in/set/back", "=in/set/deep", "in/deep/2", "in/file", "in/set/1"]
        );
        assert!(found[0].starts_with("!in/up: the link points to"), "{found:?}");
        // A wildcard follows links as a folder does, and enters only what may match.
        assert_eq!(search(&linked, "in/s*/1"), ["in/set/1"]);
        assert_eq!(search(&linked, "in/*/2")[1..], ["in/deep/2"]);
    }

    #[test]
    fn what_cannot_be_followed_is_told_and_ends_nothing() {
        let broken = folder(&["in/gone -> nowhere", "in/p -> q", "in/q -> p", "in/a"]);
        let found = search(&broken, "in");
        assert_eq!(found[0], "!in/gone: the target of the link does not exist");
        assert!(found[1].starts_with("!in/p: the link cannot be followed"), "{found:?}");
        assert_eq!((found.len(), found[3].as_str()), (4, "in/a"));
        assert!(search(&broken, "in/n*").is_empty());
    }

    #[test]
    fn a_deep_tree_is_searched_whole() {
        let deep = folder(&[]);
        let path = deep.path().join("d/".repeat(400));
        fs::create_dir_all(&path).unwrap();
        fs::write(path.join("a"), "").unwrap();
        assert_eq!(search(&deep, ""), ["d/".repeat(400) + "a"]);
        assert_eq!(search(&deep, "**/a"), ["d/".repeat(400) + "a"]);
    }
}
