//! Makes a list of files from paths of files and folders, from wildcards, and from lists of paths.

use std::collections::HashSet;
use std::convert::Infallible;
use std::ffi::OsStr;
use std::fmt::Write;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};

use mocap::files::{check_confined, decode_text, read_text};
use mocap::{Code, Diagnostic, FormatInfo};

use super::for_each;
use super::pattern::{Pattern, has_wildcard};
use super::walk::{Entry, Search};
use crate::{Failure, kinds, report};

/// Which files to read.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "Many files")]
pub struct InputArgs {
    /// Accept a folder or a wildcard without motion files. By default this is an error
    #[arg(long)]
    pub allow_empty: bool,
}

/// An input file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Input {
    pub path: PathBuf,
    /// The path relative to the folder or wildcard that found the file, with `/` as separator. For a file named by the
    /// user, its name. A byte that is not UTF-8 becomes `%` and two digits, so that different names stay different.
    pub relative: String,
    /// The size when the file was found.
    pub bytes: u64,
    /// The reason why the file cannot be read, if known: a broken link, a folder without permission.
    pub problem: Option<String>,
    /// The clip of the file, if each of its clips is a separate input. Then `relative` ends with the name of the clip.
    pub clip: Option<usize>,
}

impl Input {
    fn new(path: PathBuf, folder: &Path) -> Self {
        let below = path.strip_prefix(folder).unwrap_or(&path);
        let parts = below.components().filter_map(|part| match part {
            Component::Normal(name) => Some(text_of(name)),
            _ => None,
        });
        Self {
            relative: parts.collect::<Vec<_>>().join("/"),
            bytes: path.metadata().map_or(0, |metadata| metadata.len()),
            path,
            problem: None,
            clip: None,
        }
    }

    /// A file that the caller names. A pipe among many files is an input that fails: a pipe cannot be read twice, and
    /// may block the program.
    fn named(path: &Path) -> Self {
        let input = Self::new(path.to_owned(), path.parent().unwrap_or(Path::new("")));
        let is_stream = path.metadata().is_ok_and(|metadata| !metadata.is_file());
        Self {
            problem: is_stream.then(|| "a pipe or a device cannot be one of many files".to_owned()),
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

/// Makes an input of each clip of a file that has several, such as `pack.glb/Walk`. `clips` returns the number and the
/// name of each clip of a file.
pub(crate) fn split_clips(
    inputs: Vec<Input>,
    threads: usize,
    clips: impl Fn(&Path) -> Vec<(usize, String)> + Sync,
) -> Vec<Input> {
    let mut found: Vec<Vec<(usize, String)>> = inputs.iter().map(|_| Vec::new()).collect();
    let of_input = |input: &Input| match input.problem {
        None => clips(&input.path),
        Some(_) => Vec::new(),
    };
    let done = for_each(
        &inputs,
        threads,
        of_input,
        |_| Vec::new(),
        |index, clips| {
            found[index] = clips;
            Ok::<_, Infallible>(())
        },
    );
    let Ok(()) = done;
    let mut split = Vec::new();
    for (input, clips) in inputs.into_iter().zip(found) {
        if clips.len() < 2 {
            split.push(input);
            continue;
        }
        let mut taken = HashSet::new();
        for (clip, name) in clips {
            let mut name = file_name_of(&name);
            if name.is_empty() {
                name = clip.to_string();
            }
            // Some file systems ignore case.
            while !taken.insert(name.to_lowercase()) {
                name = format!("{name}-{clip}");
            }
            split.push(Input {
                relative: format!("{}/{name}", input.relative),
                clip: Some(clip),
                ..input.clone()
            });
        }
    }
    split
}

/// The name of a clip without the characters that file names cannot have.
fn file_name_of(clip: &str) -> String {
    /// A file name has at most 255 bytes on common systems. Its extension and a number need some of them.
    const MOST_BYTES: usize = 200;
    let is_allowed = |c: char| !c.is_control() && !r#"/\:*?"<>|"#.contains(c);
    let mut name: String = clip.chars().map(|c| if is_allowed(c) { c } else { '_' }).collect();
    while name.len() > MOST_BYTES {
        name.pop();
    }
    name.trim_matches(['.', ' ']).to_owned()
}

/// The text of a name, with `%` and two digits for a byte that is not UTF-8.
fn text_of(name: &OsStr) -> String {
    let mut text = String::new();
    for chunk in name.as_encoded_bytes().utf8_chunks() {
        text += chunk.valid();
        for byte in chunk.invalid() {
            let _ = write!(text, "%{byte:02X}");
        }
    }
    text
}

/// The most inputs of one call. More inputs would fill the memory before the first input is read.
const MOST_INPUTS: usize = 1_000_000;

/// The files of `paths`, sorted by their relative paths. A named file may have any extension. Folders and wildcards
/// only give files with the extension of a known format, and unreadable entries.
/// A path that does not exist is an input too. It fails like any other input, and does not stop the others.
pub fn find(paths: &[PathBuf], args: &InputArgs) -> Result<Vec<Input>, Failure> {
    find_except(paths, args, &|_, _| false)
}

/// [`find`] without the entries for which `is_excluded` is true. Its arguments are the searched folder and the entry.
pub(crate) fn find_except(
    paths: &[PathBuf],
    args: &InputArgs,
    is_excluded: &dyn Fn(&Path, &Path) -> bool,
) -> Result<Vec<Input>, Failure> {
    let mut gathered = InputFiles::default();
    for path in paths {
        let before = gathered.inputs.len();
        if path.is_dir() {
            gathered.search(path, &Pattern::default(), is_excluded)?;
        } else if is_pattern(path) {
            let (base, pattern) = Pattern::of(path)?;
            if base.as_os_str().is_empty() || base.is_dir() {
                gathered.search(&base, &pattern, is_excluded)?;
            }
        } else if is_list(path) {
            for input in list_of(path)? {
                gathered.add(input)?;
            }
        } else {
            gathered.add(Input::named(path))?;
        }
        if gathered.inputs.len() == before && !args.allow_empty {
            gathered.say_what_is_skipped();
            let message = format!("{}: no motion files found; --allow-empty accepts this", path.display());
            return Err(Failure::Usage(message));
        }
    }
    gathered.say_what_is_skipped();
    let mut inputs = gathered.inputs;
    inputs.sort_by(|a, b| (&a.relative, &a.path).cmp(&(&b.relative, &b.path)));
    inputs.dedup_by(|a, b| a.path == b.path);
    Ok(inputs)
}

/// Refuses the inputs if none of them exists, before any output or output folder is made. If only some inputs are
/// missing, each of them is reported like a broken file.
pub(crate) fn refuse_missing(inputs: &[Input]) -> mocap::Result<()> {
    let is_missing = |input: &Input| !input.path.exists() && !input.path.is_symlink();
    match inputs.first().filter(|_| inputs.iter().all(is_missing)) {
        Some(missing) => Err(mocap::Error::io(&missing.path, io::ErrorKind::NotFound.into())),
        None => Ok(()),
    }
}

/// Whether a file is a list, as `mocap survey --select -o chosen.txt` writes it: a path in each line. A motion may have
/// the extension of a text too, so the first line decides. The rest of the file is not read.
fn is_list(path: &Path) -> bool {
    const MOST_BYTES: u64 = 256 << 20;
    const LONGEST_LINE: u64 = 16 << 10;
    let is_text = path
        .extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("txt"));
    let is_file = || std::fs::metadata(path).is_ok_and(|found| found.is_file() && found.len() <= MOST_BYTES);
    if !is_text || !is_file() || check_confined(path).is_err() {
        return false;
    }
    let mut head = Vec::new();
    let read = File::open(path).and_then(|file| file.take(LONGEST_LINE).read_to_end(&mut head));
    // The last character of the head may be incomplete, so invalid text is allowed here. Reading the whole list refuses
    // invalid text.
    let text = decode_text(head.clone()).unwrap_or_else(|| String::from_utf8_lossy(&head).into_owned());
    let first = text.lines().find(|line| !line.is_empty()).map(Path::new);
    read.is_ok() && first.is_some_and(|first| first.is_file() || has_known_extension(first))
}

/// The files of a list. Their relative paths start at the folder that all files have in common.
fn list_of(path: &Path) -> mocap::Result<Vec<Input>> {
    let text = read_text(path)?;
    let files: Vec<&Path> = text.lines().filter(|line| !line.is_empty()).map(Path::new).collect();
    let above = |folder: &&Path| files.iter().all(|file| file.starts_with(folder));
    let first = files.first().copied().unwrap_or(Path::new(""));
    let folder = first.ancestors().skip(1).find(above).unwrap_or(Path::new(""));
    let listed = |file: &&Path| Input {
        relative: Input::new(file.to_path_buf(), folder).relative,
        ..Input::named(file)
    };
    Ok(files.iter().map(listed).collect())
}

/// The files found in folders and by wildcards.
#[derive(Default)]
struct InputFiles {
    inputs: Vec<Input>,
    /// Tables that are not motions, such as lists of clips and reports.
    tables: Vec<PathBuf>,
    /// Robots, which are not motions.
    robots: Vec<PathBuf>,
    /// Links to folders that were already searched through another path.
    again: Vec<PathBuf>,
}

impl InputFiles {
    fn add(&mut self, input: Input) -> Result<(), Failure> {
        if self.inputs.len() == MOST_INPUTS {
            let message = format!("more than {MOST_INPUTS} files are found; name a folder with fewer");
            return Err(Failure::Usage(message));
        }
        self.inputs.push(input);
        Ok(())
    }

    /// Adds the matching motion files in `base`, and unreadable entries. Paths are relative to `base`.
    fn search(
        &mut self,
        base: &Path,
        pattern: &Pattern,
        is_excluded: &dyn Fn(&Path, &Path) -> bool,
    ) -> Result<(), Failure> {
        let search = Search {
            base,
            pattern,
            is_excluded: &|path| is_excluded(base, path),
        };
        search.run(|found| match found {
            Entry::File(path) if has_known_extension(&path) => self.add_file(path, base),
            Entry::File(path) => {
                // MuJoCo's robots have the extension `.xml`, which many other files have too.
                let is_xml = path.extension().is_some_and(|own| own.eq_ignore_ascii_case("xml"));
                if is_xml && kinds::is_robot(&path) {
                    self.robots.push(path);
                }
                Ok(())
            }
            Entry::Again(path) => {
                self.again.push(path);
                Ok(())
            }
            // Ignore unreadable entries without the extension of a motion, because readable ones are ignored too.
            Entry::Problem(path, problem)
                if path.extension().is_none() || has_known_extension(&path) || path.is_dir() =>
            {
                self.add(Input {
                    problem: Some(problem),
                    ..Input::new(path, base)
                })
            }
            Entry::Problem(..) => Ok(()),
        })
    }

    /// Adds a file with a known extension. A table is a motion only if its columns show it. A Parquet file may have any
    /// number of clips, and must be named.
    fn add_file(&mut self, path: PathBuf, base: &Path) -> Result<(), Failure> {
        const HEAD: u64 = 64 << 10;
        let has = |extension: &str| path.extension().is_some_and(|own| own.eq_ignore_ascii_case(extension));
        let is_motion = || {
            let mut head = Vec::new();
            let read = File::open(&path).and_then(|file| file.take(HEAD).read_to_end(&mut head));
            // An unreadable table fails like any input.
            read.is_err() || FormatInfo::of_contents(&head).is_some()
        };
        if has("parquet") || has("csv") && !is_motion() {
            self.tables.push(path);
            return Ok(());
        }
        self.add(Input::new(path, base))
    }

    /// Reports skipped tables and links.
    fn say_what_is_skipped(&mut self) {
        if let Some(first) = self.tables.first() {
            let how = match first.extension().is_some_and(|own| own.eq_ignore_ascii_case("parquet")) {
                true => "; to read a Parquet file of motions, name the file",
                false => "",
            };
            say_skipped(&self.tables, "table, not a motion", "tables, not motions", how);
        }
        let how = "; mocap robot INPUT --robot TARGET retargets motions to a robot";
        say_skipped(&self.robots, "robot, not a motion", "robots, not motions", how);
        say_skipped(
            &self.again,
            "link to a folder that was already searched",
            "links to folders that were already searched",
            "",
        );
        self.tables.clear();
        self.robots.clear();
        self.again.clear();
    }
}

fn say_skipped(paths: &[PathBuf], one: &str, several: &str, how: &str) {
    /// The most files that a note names: more would fill the line.
    const NAMED: usize = 3;
    let names = paths
        .iter()
        .take(NAMED)
        .map(|path| report::visible(&path.to_string_lossy()).into_owned());
    let mut names = names.collect::<Vec<_>>().join(", ");
    if paths.len() > NAMED {
        names += ", ...";
    }
    match paths.len() {
        0 => {}
        1 => report::say(&format!("skipped 1 {one}: {names}{how}")),
        count => report::say(&format!("skipped {count} {several}: {names}{how}")),
    }
}

/// Whether a path is not a file, and has wildcards.
fn is_pattern(path: &Path) -> bool {
    !path.exists() && has_wildcard(path)
}

/// Whether a path may name several files.
pub(crate) fn names_several(path: &Path) -> bool {
    path.is_dir() || is_pattern(path) || is_list(path)
}

fn has_known_extension(path: &Path) -> bool {
    let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or("");
    FormatInfo::ALL
        .iter()
        .flat_map(|format| format.extensions)
        .any(|known| known.eq_ignore_ascii_case(extension))
}
