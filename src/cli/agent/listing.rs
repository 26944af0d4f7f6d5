//! The contents of a folder.

use std::fs::{self, File};
use std::io::Read;
use std::path::Path;

use mocap::FormatInfo;
use mocap::files::check_confined;
use serde_json::{Value, json};

use super::answer::Answer;
use crate::Failure;
use crate::batch::pattern::Pattern;
use crate::batch::walk::{Entry, Search};

/// The most files in an answer. The report has more.
const MOST_SHOWN: usize = 200;

/// The most files that a list may have. A folder with more files is refused.
const MOST: usize = 100_000;

/// The bytes of a file from which its format is determined. If its extension belongs to no format, fewer bytes are
/// read, because a folder may have many pictures and tables.
const HEAD: u64 = 64 << 10;
const HEAD_OF_UNKNOWN: u64 = 4 << 10;

/// The files of a folder and its subfolders. All commands use this search, which always ends and stays in the root
/// folder.
pub(super) fn list(folder: &Path) -> Result<Answer, Failure> {
    check_confined(folder)?;
    if !folder.is_dir() {
        let words = format!(
            "folder not found: {}; pass a folder, or describe a file with inspect",
            folder.display()
        );
        return Err(Failure::Usage(words));
    }
    // Paths in the root folder have no `./` before them.
    let base = folder.strip_prefix(".").unwrap_or(folder);
    let search = Search {
        base,
        pattern: &Pattern::default(),
        is_excluded: &|_| false,
    };
    let mut paths = Vec::new();
    search.run(|found| {
        // A broken link or a folder without permission has no readable file.
        if let Entry::File(path) = found {
            paths.push(path);
        }
        match paths.len() > MOST {
            true => Err(Failure::Usage(format!(
                "{} has more than {MOST} files; list one of its subfolders",
                folder.display()
            ))),
            false => Ok(()),
        }
    })?;
    paths.sort_unstable();
    let (mut files, mut others) = (Vec::new(), Vec::new());
    for path in paths {
        match described(&path) {
            Some(file) => files.push(file),
            None => others.push(path.display().to_string()),
        }
    }
    let answer = |files: &[Value], others: &[String]| json!({"folder": folder.display().to_string(), "count": files.len(), "files": files, "others": others});
    let mut brief = answer(
        &files[..files.len().min(MOST_SHOWN)],
        &others[..others.len().min(MOST_SHOWN)],
    );
    brief["count"] = files.len().into();
    if files.len().max(others.len()) > MOST_SHOWN {
        brief["note"] =
            format!("this answer has only the first {MOST_SHOWN} files; the report has all; or list a subfolder")
                .into();
    }
    let mut found = Answer::new(answer(&files, &others));
    found.brief = Some(brief);
    Ok(found)
}

/// Describes a file that mocap reads, by its contents or else by its extension; `None` for other files.
fn described(path: &Path) -> Option<Value> {
    let has = |known: &str| path.extension().is_some_and(|own| own.eq_ignore_ascii_case(known));
    let named = FormatInfo::ALL
        .iter()
        .find(|row| row.extensions.iter().any(|known| has(known)));
    let longest = if named.is_some() { HEAD } else { HEAD_OF_UNKNOWN };
    let mut head = Vec::new();
    // An unreadable file is described by its extension.
    let _ = File::open(path).and_then(|file| file.take(longest).read_to_end(&mut head));
    // A `.csv` counts only if its contents show a motion, because most tables are not motions.
    let format = FormatInfo::of_contents(&head).or(named.filter(|_| !has("csv")))?;
    Some(json!({
        "file": path.display().to_string(),
        "format": format.format.as_str(),
        "bytes": fs::metadata(path).map_or(0, |found| found.len()),
    }))
}
