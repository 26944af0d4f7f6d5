//! Errors in the paths of a call, in words for agents. The commands' messages address users of the command line.

use std::path::Path;

use serde_json::{Map, Value};

use super::tools::{FileArgument, Tool};
use crate::Failure;
use crate::batch::inputs::names_several;

/// The tools whose inputs may always be folders and wildcards.
const OF_FOLDERS: [&str; 4] = ["check", "survey", "index", "graph"];

/// Refuses inputs that do not exist, folders instead of files, and outputs in folders that do not exist.
pub(super) fn check(tool: &Tool, arguments: &Map<String, Value>) -> Result<(), Failure> {
    let refuse = |words: String| Err(Failure::Usage(words));
    let name = tool.tool_name();
    let has_folder = texts(arguments, "output").any(is_folder);
    for file in tool.files {
        let count = texts(arguments, file.name).count();
        for text in texts(arguments, file.name) {
            let path = Path::new(text);
            match kind(file) {
                Kind::Output if is_folder(text) => {}
                Kind::Output => {
                    let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty());
                    if let Some(parent) = parent.filter(|parent| !parent.is_dir()) {
                        let folder = parent.display();
                        return refuse(format!(
                            "{text}: there is no folder {folder}; name a folder that is there, or end \"output\" with /, \
                             which makes a new folder"
                        ));
                    }
                }
                Kind::Input if !names_several(path) => {
                    // A missing file among many becomes a row of the answer.
                    if count == 1 && !path.exists() {
                        return refuse(format!("file not found: {text}; list shows the files of a folder"));
                    }
                }
                Kind::Input if OF_FOLDERS.contains(&tool.name) => {}
                Kind::Input if file.is_list && tool.has_folder_outputs() => {
                    if !has_folder {
                        return refuse(format!(
                            "{text} names many motions: end \"output\" with /, for a folder with one file for each \
                             motion"
                        ));
                    }
                }
                Kind::Input => {
                    return refuse(format!(
                        "{text} is not a file, but {name} takes files; list shows the files of a folder"
                    ));
                }
                Kind::Other => {}
            }
        }
    }
    let has = |name: &str| texts(arguments, name).next().is_some();
    // The last of several inputs is the character, as on the command line.
    if tool.name == "retarget" && !has("character") && !has("to-skeleton") && texts(arguments, "inputs").count() < 2 {
        return refuse("retarget needs \"character\", or \"to-skeleton\"".to_owned());
    }
    Ok(())
}

enum Kind {
    Input,
    Output,
    Other,
}

fn kind(file: &FileArgument) -> Kind {
    match file.name {
        "output" | "html" | "matrix" => Kind::Output,
        "folder" | "uri" | "pointer" => Kind::Other,
        _ => Kind::Input,
    }
}

fn is_folder(text: &str) -> bool {
    text.ends_with('/') || Path::new(text).is_dir()
}

fn texts<'a>(arguments: &'a Map<String, Value>, name: &str) -> impl Iterator<Item = &'a str> {
    let several = match arguments.get(name) {
        Some(Value::Array(values)) => values.as_slice(),
        Some(value) => std::slice::from_ref(value),
        None => &[],
    };
    several.iter().filter_map(Value::as_str)
}
