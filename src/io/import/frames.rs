//! A folder with one file of arrays for each frame, as pose estimators write it.

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};

use mocap_formats::{BodyFrames, Contents, FormatInfo, Source};
use mocap_scene::error::{Code, Diagnostic, Error, Result};
use mocap_scene::files::check_confined;
use mocap_scene::limits::Limits;
use mocap_scene::report::counted;
use mocap_scene::scene::{Assumption, Confidence, Scene, Topic};

use super::Importer;

/// The words after the frame number in the file name of one person.
const PERSONS: [&str; 3] = ["subj", "person", "id"];

/// File extensions of arrays.
const EXTENSIONS: [&str; 4] = ["npz", "npy", "pkl", "pickle"];

/// The largest number of file names or frame numbers in a message.
const NAMED: usize = 5;

impl Importer {
    /// Whether a path is a folder of several motions, not the frames of one take.
    #[doc(hidden)]
    pub fn is_of_many(path: &Path) -> bool {
        path.is_dir() && !Self::reads_folder(path)
    }

    /// Whether a path is a folder with the frames of one take. The first file of arrays decides: a take has a single
    /// frame in each file. If the first file is broken, the last file decides.
    pub(super) fn reads_folder(path: &Path) -> bool {
        let is_frame = |(_, path): &(Option<u64>, PathBuf)| {
            let bytes = fs::read(path);
            bytes.is_ok_and(|bytes| BodyFrames::default().read(0, &bytes, &Limits::default()).is_ok())
        };
        let mut found = files(path).unwrap_or_default();
        found.sort_unstable();
        path.is_dir() && [found.first(), found.last()].into_iter().flatten().any(is_frame)
    }

    /// Reads the files of a folder as the frames of one take, in the order of the frame numbers in their names.
    pub(super) fn import_folder(&self, folder: &Path) -> Result<Scene> {
        check_others(folder)?;
        let mut files = files(folder)?;
        let has_numbers = files.iter().all(|(number, _)| number.is_some());
        // Sorts by number, or by name if some names have no number.
        files.sort_unstable();
        let mut frames = BodyFrames::default();
        let mut numbers = Vec::new();
        for (place, (number, path)) in (0..).zip(&files) {
            let frame = number.filter(|_| has_numbers).unwrap_or(place);
            if numbers.last() != Some(&frame) {
                numbers.push(frame);
            }
            let read = frames.read(frame, &self.open(path)?, &self.read.limits);
            read.map_err(|error| error.with_path(path))?;
        }
        let source = Source {
            open: &|other| self.open(other),
            ..Source::of_bytes(&[], folder)
        };
        self.check_rates(&source)?;
        let scene = frames.scene(&self.read).and_then(|mut scene| {
            scene.metadata.assumptions.push(Assumption {
                reason: match has_numbers {
                    true => "their names have numbers",
                    false => "the folder has no other files",
                }
                .to_owned(),
                confidence: Some(Confidence::Likely),
                ..Assumption::new(Topic::Layout, one_take(files.len(), &numbers))
            });
            self.finish(scene, &source, String::new())
        });
        scene.map_err(|error| error.with_path(folder))
    }
}

/// A sentence such as `3 files are the frames 0, 1, 2 of one take`.
fn one_take(files: usize, numbers: &[u64]) -> String {
    let named: Vec<String> = match numbers {
        [first, .., last] if numbers.len() > NAMED => vec![first.to_string(), "...".to_owned(), last.to_string()],
        numbers => numbers.iter().map(u64::to_string).collect(),
    };
    format!(
        "{} are the frames {} of one take",
        counted(files, "file"),
        named.join(", ")
    )
}

/// Refuses a folder of frames that also has motions, because the motions would be lost.
fn check_others(folder: &Path) -> Result<()> {
    let is_motion = |path: &PathBuf| {
        let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
        let mut rows = FormatInfo::ALL.iter();
        let rows = rows.find(|row| row.extensions.iter().any(|known| extension == *known));
        rows.is_some_and(|row| matches!(row.contents, Contents::Motion | Contents::Points | Contents::Keys))
    };
    let entries = fs::read_dir(folder).map_err(|error| Error::io(folder, error))?;
    let mut others: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).filter(is_motion).collect();
    if others.is_empty() {
        return Ok(());
    }
    others.sort_unstable();
    let names = others.iter().take(NAMED).filter_map(|path| path.file_name());
    let mut names: Vec<String> = names.map(|name| name.to_string_lossy().into_owned()).collect();
    if others.len() > NAMED {
        names.push("...".to_owned());
    }
    let message = format!(
        "the folder has the frames of one take, and also {}: {}",
        counted(others.len(), "other motion"),
        names.join(", ")
    );
    let error = Diagnostic::new(Code::InvalidValue, message).help("move the frames to a separate folder");
    Err(Error::from(error).with_path(folder))
}

/// The files of arrays in a folder, with their frame numbers.
fn files(folder: &Path) -> Result<Vec<(Option<u64>, PathBuf)>> {
    check_confined(folder)?;
    let failed = |error| Error::io(folder, error);
    let mut paths = Vec::new();
    for entry in fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
        if EXTENSIONS.iter().any(|known| extension == *known) {
            paths.push(path);
        }
    }
    let of_name = |path: &PathBuf| numbers(&path.file_stem().unwrap_or_default().to_string_lossy());
    let numbers: Vec<Vec<u64>> = paths.iter().map(of_name).collect();
    let place = place_of_frame(&numbers);
    let frames = numbers.iter().map(|own| own.get(place).copied());
    Ok(frames.zip(paths).collect())
}

/// The numbers in a name from last to first, without the number of a person.
fn numbers(stem: &str) -> Vec<u64> {
    let is_digit = |letter: char| letter.is_ascii_digit();
    let without = stem.trim_end_matches(is_digit);
    let word = without.trim_end_matches(['_', '-', '.']).to_ascii_lowercase();
    let person = PERSONS.iter().find(|person| word.ends_with(*person));
    let named = match person {
        Some(person) if without.len() < stem.len() => &word[..word.len() - person.len()],
        _ => stem,
    };
    let numbers = named.rsplit(|letter: char| !is_digit(letter));
    numbers.filter_map(|digits| digits.parse().ok()).collect()
}

/// The position of the frame number among the numbers in the names, counted from the last. The frame number is the
/// number with the most distinct values. In `shot_12_0` and `shot_13_0` it is the first number, because the second
/// number is a person.
fn place_of_frame(numbers: &[Vec<u64>]) -> usize {
    let all = numbers.iter().map(Vec::len).min().unwrap_or(0);
    let values = |place: usize| numbers.iter().map(|own| own[place]).collect::<HashSet<u64>>().len();
    // On a tie, the last number in the name.
    (0..all).rev().max_by_key(|place| values(*place)).unwrap_or(0)
}
