//! `<include>`: files whose elements replace the reference to the file, as in every `scene.xml` of a robot.

use std::path::{Path, PathBuf};

use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::limits::Limits;

use crate::named_file::{LEVELS, near};
use crate::text::quote;
use crate::xml::{self, Element, IncludedFile};
use crate::{Failure, Source};

/// The largest number of included files.
const MOST_FILES: usize = 64;

/// The allowed outermost elements of an included file.
const ROOTS: &[&str] = &["mujoco", "mujocoinclude"];

/// The names and contents of all files that the text includes, directly or indirectly. Names are relative to the folder
/// of the main file, even in included files, or else to the folder of the including file. MuJoCo includes a file once.
pub(super) fn texts(source: &Source<'_>, text: &str, limits: &Limits) -> Result<Vec<(String, String)>, Failure> {
    let mut found: Vec<(String, String)> = Vec::new();
    let mut waiting = names((text, Path::new("")), &["mujoco"], &mut found, source, limits)?;
    while let Some((index, path)) = waiting.pop() {
        let (name, text) = found[index].clone();
        let folder = path.parent().unwrap_or(Path::new(""));
        let inner = self::names((&text, folder), ROOTS, &mut found, source, limits);
        waiting.extend(inner.map_err(|failure| in_included(*failure, &name))?);
    }
    Ok(found)
}

/// An error in an included file, whose lines differ from the lines of the main file.
fn in_included(mut failure: Diagnostic, name: &str) -> Failure {
    let line = failure
        .location
        .take()
        .map(|location| format!(" at line {}", location.line));
    let (name, line) = (quote(name.as_bytes()), line.unwrap_or_default());
    failure.message += &format!(", in {name}, which is included{line}");
    Box::new(failure)
}

/// Parses the trees of these files.
pub(super) fn parse<'a>(texts: &'a [(String, String)], limits: &Limits) -> Result<Vec<IncludedFile<'a>>, Failure> {
    let file = |(name, text): &'a (String, String)| {
        Ok(IncludedFile {
            name: name.clone(),
            document: xml::parse(text, ROOTS, limits).map_err(|failure| in_included(*failure, name))?,
        })
    };
    texts.iter().map(file).collect()
}

/// Reads the files that a file in a folder includes. Returns their indices among the found files, and their paths. All
/// folders are relative to the main file's folder.
fn names(
    (text, folder): (&str, &Path),
    roots: &[&str],
    found: &mut Vec<(String, String)>,
    source: &Source<'_>,
    limits: &Limits,
) -> Result<Vec<(usize, PathBuf)>, Failure> {
    let document = xml::parse(text, roots, limits)?;
    let root = Element::root(&document);
    let mut indices = Vec::new();
    for include in root.descendants().filter(|element| element.name() == "include") {
        let name = include.required("file")?;
        let missing = |message: &str, expected: &str| {
            let file = format!("<include file={}>", quote(name.as_bytes()));
            let diagnostic = include.at_attribute("file", Code::MissingFile, message);
            let help = "put it into the model's folder, or save the model as one file (mj_saveLastXML)";
            Box::new(diagnostic.expected_found(expected, file).help(help))
        };
        if found.iter().any(|(other, _)| other == name) {
            return Err(Box::new(
                include
                    .at_attribute("file", Code::InvalidRobot, "a file is included twice")
                    .help("include it once"),
            ));
        }
        let read: usize = found.iter().map(|(_, text)| text.len()).sum();
        if found.len() >= MOST_FILES || read as u64 > limits.max_bytes {
            let message = format!("the model includes more than {MOST_FILES} files, or too many bytes");
            return Err(Box::new(include.diagnostic(Code::LimitExceeded, message)));
        }
        let candidates: Vec<PathBuf> = [near(name), near(folder.join(name))].into_iter().flatten().collect();
        if candidates.is_empty() {
            let expected = format!("a relative path with at most {LEVELS} parent folders");
            return Err(missing(
                "the path of an included file leads too far away from the model",
                &expected,
            ));
        }
        let beside = source.name.parent().unwrap_or(Path::new(""));
        let mut opened = candidates.into_iter().filter_map(|path| {
            let bytes = (source.open)(&beside.join(&path)).ok()?;
            Some((path, bytes))
        });
        let (path, bytes) = opened.next().ok_or_else(|| {
            missing(
                "the model includes a file that cannot be read",
                "a file in the model's folder",
            )
        })?;
        indices.push((found.len(), path));
        let text = xml::text(&bytes)?;
        found.push((name.to_owned(), text));
    }
    Ok(indices)
}
