//! Advice about files that a command cannot read: the kind of the file, the right command, and similar file names.

use std::fs::{self, File};
use std::io::Read;
use std::path::Path;

use mocap::{Code, Diagnostic, Error, Format, FormatInfo};

pub(crate) use mocap::nearest;

use crate::Failure;

/// The kind of a file, by its first bytes.
#[derive(Clone, Copy, Debug)]
enum Kind {
    /// A motion or a character.
    Motion(&'static FormatInfo),
    Robot,
    /// A database of `mocap index`.
    Database,
    /// A motion graph of `mocap graph`.
    Graph,
    Job,
    /// The manifest of an output folder.
    Manifest,
    /// The JSON of a scene, from `mocap dump` or from Assimp.
    Dump,
    /// A map of bones.
    Map,
}

impl Kind {
    /// The kind of a file; `None` if this program neither reads nor writes it, or it is not a file.
    fn of(path: &Path) -> Option<Self> {
        /// The number of examined bytes: enough to detect a format.
        const BEGINNING: u64 = 64 * 1024;
        if !path.is_file() || mocap::files::check_confined(path).is_err() {
            return None;
        }
        let mut bytes = Vec::new();
        File::open(path).ok()?.take(BEGINNING).read_to_end(&mut bytes).ok()?;
        if bytes.starts_with(b"mocapMDB") {
            return Some(Self::Database);
        }
        if let Some(row) = FormatInfo::of_contents(&bytes) {
            return Some(match row.format {
                Format::Urdf | Format::Mjcf => Self::Robot,
                _ => Self::Motion(row),
            });
        }
        let text = String::from_utf8_lossy(&bytes);
        let has = |key: &str| text.contains(&format!("\"{key}\""));
        match text.trim_start().starts_with('{') {
            false => None,
            true if text.starts_with("{\"input\":") && has("sha256") => Some(Self::Manifest),
            true if has("motion-graph") => Some(Self::Graph),
            true if has("inputs") && has("source") => Some(Self::Job),
            true if has("metadata") && has("nodes") => Some(Self::Dump),
            true if has("bones") => Some(Self::Map),
            true => None,
        }
    }

    /// Describes the kind of the file, and the command for it. `code` is the error of the user's command.
    fn advice(self, code: Code) -> Option<String> {
        Some(match self {
            Self::Robot => "it is a robot: mocap robot INPUT --robot TARGET retargets motions to it".to_owned(),
            Self::Database => "it is a database of motions: mocap find and mocap match read it".to_owned(),
            Self::Graph => "it is a motion graph: mocap graph walk reads it".to_owned(),
            Self::Job => "it is a job: mocap run runs it".to_owned(),
            Self::Manifest => "it is the manifest of a folder: name the motions of the folder".to_owned(),
            Self::Dump => "it is a printed scene, as mocap dump writes it: name the file of the motion".to_owned(),
            Self::Map => "a JSON file with \"bones\" may be a map of bones: --map reads such a file".to_owned(),
            Self::Motion(row) => {
                let maker = match code {
                    Code::InvalidDatabase => "mocap index makes a database of motions",
                    Code::InvalidGraph => "mocap graph makes a graph of motions",
                    Code::UnknownFormat => "mocap retarget retargets motions to a character; a robot is URDF or MJCF",
                    Code::InvalidValue => "mocap convert and other commands take motions; --print-job prints a job",
                    _ => return None,
                };
                format!("it is {}, a motion or a character: {maker}", row.name)
            }
        })
    }
}

/// Adds help to an error, from the kind of the file or from its folder.
pub(crate) fn helped(path: Option<&Path>, diagnostic: &Diagnostic) -> Diagnostic {
    let mut helped = diagnostic.clone();
    if let Some(help) = path.and_then(|path| help(path, diagnostic)) {
        helped.help = Some(help);
    }
    helped
}

fn help(path: &Path, diagnostic: &Diagnostic) -> Option<String> {
    match diagnostic.code {
        Code::Io => near_file(path).map(|near| format!("did you mean {near}?")),
        Code::UnknownFormat | Code::BinaryFile | Code::InvalidDatabase | Code::InvalidGraph => {
            Kind::of(path)?.advice(diagnostic.code)
        }
        _ => None,
    }
}

/// A file with a similar name in the same folder as a missing file.
fn near_file(path: &Path) -> Option<String> {
    /// The largest number of names to compare.
    const MOST: usize = 10_000;
    if path.exists() {
        return None;
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    mocap::files::check_confined(path).ok()?;
    let entries = fs::read_dir(folder.unwrap_or(Path::new("."))).ok()?;
    let names: Vec<String> = entries
        .take(MOST)
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .collect();
    let near = nearest(path.file_name()?.to_str()?, names.iter().map(String::as_str))?;
    Some(path.with_file_name(near).display().to_string())
}

/// Whether a file is a robot.
pub(crate) fn is_robot(path: &Path) -> bool {
    matches!(Kind::of(path), Some(Kind::Robot))
}

/// Refuses a robot as a character: a motion would be wrong because of the axes of the robot's links.
pub(crate) fn refuse_robot<'a>(characters: impl IntoIterator<Item = &'a Path>) -> Result<(), Failure> {
    match characters.into_iter().find(|path| is_robot(path)) {
        None => Ok(()),
        Some(robot) => {
            let file = robot.display();
            let message = format!("{file} is a robot, not a character: mocap robot INPUT --robot {file} -o OUTPUT");
            Err(Failure::Usage(message))
        }
    }
}

/// The error of a file that is not a job.
pub(crate) fn no_job(error: Error, path: &Path) -> Error {
    let advice = match Kind::of(path) {
        None | Some(Kind::Job) => None,
        Some(kind) => kind.advice(Code::InvalidValue),
    };
    match advice {
        Some(advice) => Diagnostic::new(Code::InvalidValue, "the file is not a job")
            .help(advice)
            .into(),
        None => error,
    }
}

/// The commands that write files of an extension, for messages of other commands.
const WRITERS: &[(&[&str], &str)] = &[
    (
        &["npz", "npy", "csv", "parquet"],
        "mocap convert and mocap fk write arrays",
    ),
    (&["html"], "mocap view writes pages"),
    (&["gif", "apng"], "mocap gif draws animations"),
    (&["png", "svg"], "mocap sheet and mocap plot draw pictures"),
    (
        &["mot", "sto"],
        "mocap angles and mocap forces write tables for OpenSim",
    ),
    (&["mdb"], "mocap index writes databases"),
    (&["pkl"], "mocap robot writes pickles"),
];

/// The remedy for the name of an output that must end in one of `known`, such as `.a, .b or .c`. The text begins with
/// `;`.
pub(crate) fn other_output(path: &Path, known: &str) -> String {
    let found = path
        .extension()
        .unwrap_or_default()
        .to_string_lossy()
        .to_ascii_lowercase();
    let known = known
        .split([' ', ','])
        .filter_map(|word| word.strip_prefix('.'))
        .filter(|word| !word.is_empty());
    let known: Vec<&str> = known.collect();
    let is_motion = known
        .iter()
        .any(|known| FormatInfo::of_output(&path.with_extension(known)).is_some());
    let writer = WRITERS
        .iter()
        .find(|(extensions, _)| extensions.contains(&found.as_str()));
    match (writer, nearest(&found, known.into_iter())) {
        (Some((_, writer)), _) => format!("; {writer}"),
        (None, Some(near)) => format!("; did you mean {}?", path.with_extension(near).display()),
        (None, None) if !is_motion && FormatInfo::of_output(path).is_some() => {
            format!("; mocap convert writes .{found}")
        }
        (None, None) => String::new(),
    }
}
