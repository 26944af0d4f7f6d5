//! The architecture: which modules may use which, and what is not allowed.

use std::fs;
use std::path::{Path, PathBuf};

/// The modules of the library, each with the modules that it may use, all of which stand before it. Data flows in one
/// direction: bytes, format, scene, steps and poses, outputs. `lib` only re-exports.
const MAY_USE: &[(&str, &[&str])] = &[
    ("error", &[]),
    ("options", &[]),
    ("limits", &["error", "options"]),
    ("files", &["error"]),
    ("scene", &["error", "limits"]),
    ("math", &["scene"]),
    ("pose", &["error", "limits", "scene"]),
    ("player", &["error", "limits", "scene", "pose"]),
    ("figure", &["error", "scene", "math", "pose"]),
    ("ik", &["options", "scene", "math", "pose"]),
    ("compress", &["error", "scene", "math", "pose", "player"]),
    (
        "process",
        &[
            "error", "limits", "options", "scene", "math", "pose", "figure", "compress",
        ],
    ),
    (
        "convert",
        &["error", "limits", "options", "scene", "pose", "figure", "process"],
    ),
    (
        "biomechanics",
        &["error", "files", "scene", "pose", "figure", "convert"],
    ),
    (
        "graph",
        &["error", "limits", "options", "scene", "math", "pose", "figure"],
    ),
    (
        "edit",
        &[
            "error", "limits", "options", "scene", "math", "pose", "figure", "ik", "convert", "graph",
        ],
    ),
    (
        "retarget",
        &["error", "limits", "options", "scene", "math", "pose", "figure", "edit"],
    ),
    (
        "robot",
        &[
            "error", "options", "scene", "math", "pose", "figure", "edit", "retarget",
        ],
    ),
    (
        "live",
        &["error", "scene", "math", "pose", "figure", "edit", "retarget", "robot"],
    ),
    ("solve", &["error", "scene", "math"]),
    (
        "format",
        &[
            "error",
            "limits",
            "options",
            "files",
            "scene",
            "math",
            "pose",
            "figure",
            "compress",
            "solve",
            "biomechanics",
        ],
    ),
    (
        "import",
        &[
            "error", "limits", "files", "scene", "pose", "figure", "process", "convert", "solve", "format",
        ],
    ),
    (
        "export",
        &[
            "error", "files", "scene", "pose", "figure", "process", "compress", "format",
        ],
    ),
    (
        "retargeting",
        &[
            "error", "scene", "pose", "figure", "process", "edit", "retarget", "robot", "convert", "format", "import",
        ],
    ),
    ("dump", &["error", "scene", "pose", "figure"]),
    (
        "arrays",
        &[
            "error",
            "limits",
            "options",
            "files",
            "scene",
            "math",
            "pose",
            "figure",
            "graph",
            "edit",
            "robot",
            "convert",
            "biomechanics",
            "solve",
            "format",
            "export",
        ],
    ),
    (
        "render",
        &[
            "error", "options", "scene", "math", "pose", "figure", "compress", "graph", "edit",
        ],
    ),
    (
        "verify",
        &[
            "error",
            "limits",
            "scene",
            "pose",
            "figure",
            "edit",
            "process",
            "format",
            "import",
            "retargeting",
            "arrays",
        ],
    ),
    (
        "survey",
        &[
            "error", "limits", "files", "scene", "math", "pose", "figure", "process", "edit", "export", "render",
        ],
    ),
    (
        "matching",
        &[
            "error",
            "limits",
            "options",
            "files",
            "scene",
            "math",
            "pose",
            "figure",
            "compress",
            "process",
            "ik",
            "edit",
            "convert",
            "import",
            "retargeting",
            "survey",
        ],
    ),
    (
        "job",
        &[
            "error",
            "options",
            "scene",
            "figure",
            "files",
            "edit",
            "compress",
            "process",
            "retarget",
            "robot",
            "convert",
            "solve",
            "format",
            "import",
            "export",
            "retargeting",
            "arrays",
            "verify",
            "math",
            "survey",
            "graph",
            "render",
        ],
    ),
];

/// The source of one file without comments and without its tests.
struct Source {
    path: PathBuf,
    /// Line numbers and lines.
    code: Vec<(usize, String)>,
}

impl Source {
    fn read(path: PathBuf) -> Self {
        let text = fs::read_to_string(&path).unwrap();
        let lines = text
            .lines()
            .take_while(|line| line.trim() != "#[cfg(test)]")
            .enumerate();
        let code = lines.filter(|(_, line)| !line.trim_start().starts_with("//"));
        Self {
            code: code.map(|(index, line)| (index + 1, line.to_owned())).collect(),
            path,
        }
    }

    /// `cli`, which is the program, or the module of the library that the file belongs to: the first part of its path
    /// below `src`.
    fn module(&self) -> String {
        let below = self.path.strip_prefix("src").unwrap().with_extension("");
        let first = below.components().next().unwrap().as_os_str().to_str().unwrap();
        first.to_owned()
    }

    /// What follows each `prefix` in the code, up to the end of the name, with its place. A list in braces counts as
    /// each of its names.
    fn names_after(&self, prefix: &str) -> Vec<(String, String)> {
        let mut names = Vec::new();
        for (number, line) in &self.code {
            let place = format!("{}:{number}", self.path.display());
            for rest in line.split(prefix).skip(1) {
                let list = match rest.strip_prefix('{') {
                    Some(list) => list.split(',').map(str::trim).collect(),
                    None => vec![rest],
                };
                for item in list {
                    let end = item
                        .find(|c: char| !c.is_alphanumeric() && c != '_')
                        .unwrap_or(item.len());
                    if end > 0 {
                        names.push((place.clone(), item[..end].to_owned()));
                    }
                }
            }
        }
        names
    }
}

fn sources() -> Vec<Source> {
    fn collect(folder: &Path, sources: &mut Vec<Source>) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                // The program has its tests beside it.
                if !path.ends_with("cli/tests") {
                    collect(&path, sources);
                }
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                sources.push(Source::read(path));
            }
        }
    }
    let mut sources = Vec::new();
    collect(Path::new("src"), &mut sources);
    assert!(sources.len() > 10, "the source is somewhere else");
    sources
}

fn report(failures: &[String]) {
    assert!(failures.is_empty(), "\n{}", failures.join("\n"));
}

#[test]
fn modules_use_only_what_stands_before_them() {
    let mut failures = Vec::new();
    for source in sources() {
        let module = source.module();
        if module == "lib" || module == "cli" {
            continue;
        }
        let Some((_, allowed)) = MAY_USE.iter().find(|(name, _)| *name == module) else {
            failures.push(format!(
                "{}: the table has no row for `{module}`",
                source.path.display()
            ));
            continue;
        };
        for (place, used) in source.names_after("crate::") {
            if used.starts_with(char::is_uppercase) {
                failures.push(format!("{place}: name the module that owns `{used}`"));
            } else if used != module && !allowed.contains(&&*used) {
                failures.push(format!("{place}: `{module}` uses `{used}`"));
            }
        }
    }
    report(&failures);
}

#[test]
fn the_table_is_without_circles() {
    for (position, (module, allowed)) in MAY_USE.iter().enumerate() {
        for used in *allowed {
            let place = MAY_USE.iter().position(|(name, _)| name == used);
            assert!(
                place.is_some_and(|place| place < position),
                "{module} uses {used}, which does not stand before it"
            );
        }
    }
}

/// The files of the library that `source` names by `use`, or by a path in its code, each as its place in `modules`.
///
/// A file is known by its module path; a path of names leads to the file with the longest module path that it begins
/// with. The file of a folder declares what the files below it share, and calls them: the two are one room, so a file
/// and those it stands in are left out.
fn files_used(source: &Source, modules: &[Vec<String>], own: &[String]) -> Vec<usize> {
    let code: Vec<&str> = source.code.iter().map(|(_, line)| line.as_str()).collect();
    let mut paths = Vec::new();
    let is_path = |word: &&str| word.contains("::");
    for statement in code.join("\n").split(';') {
        // `use a::{b, c::d};` is `a::b` and `a::c::d`.
        let begin = statement.find("use ").filter(|at| !statement[..*at].contains('{'));
        match begin {
            Some(at) => expand("", &statement[at + 4..], &mut paths),
            None => {
                let words = statement.split(|c: char| !c.is_alphanumeric() && c != '_' && c != ':');
                paths.extend(words.filter(is_path).map(str::to_owned));
            }
        }
    }
    let mut used = Vec::new();
    for path in paths {
        let mut names: Vec<String> = Vec::new();
        for (index, name) in path.split("::").map(str::trim).enumerate() {
            match name {
                "crate" => names.clear(),
                "self" if index == 0 => names = own.to_vec(),
                "super" => {
                    if index == 0 {
                        names = own.to_vec();
                    }
                    names.pop();
                }
                // A path that begins with a name of this file's, or of another crate.
                _ if index == 0 => break,
                _ => names.push(name.to_owned()),
            }
        }
        let leads_to = |module: &&Vec<String>| !module.is_empty() && names.starts_with(module);
        let Some(target) = modules.iter().filter(leads_to).max_by_key(|module| module.len()) else {
            continue;
        };
        if !own.starts_with(target) && !target.starts_with(own) {
            used.push(modules.iter().position(|module| module == target).unwrap());
        }
    }
    used.sort_unstable();
    used.dedup();
    used
}

/// The paths of a tree of names, as in `a::{b, c::{d, e}}`.
fn expand(prefix: &str, tree: &str, paths: &mut Vec<String>) {
    let Some(open) = tree.find('{') else {
        paths.push(format!("{prefix}{}", tree.trim()));
        return;
    };
    let prefix = format!("{prefix}{}", tree[..open].trim());
    let close = tree.rfind('}').unwrap_or(tree.len());
    let (mut depth, mut begin) = (0, open + 1);
    for (at, c) in tree.char_indices().filter(|(at, _)| *at > open && *at <= close) {
        match c {
            '{' => depth += 1,
            '}' if at < close => depth -= 1,
            ',' | '}' if depth == 0 => {
                expand(&prefix, &tree[begin..at], paths);
                begin = at + 1;
            }
            _ => {}
        }
    }
}

#[test]
fn files_within_a_module_use_each_other_without_circles() {
    let sources: Vec<Source> = sources()
        .into_iter()
        .filter(|source| !source.path.ends_with("lib.rs"))
        .collect();
    let modules: Vec<Vec<String>> = sources
        .iter()
        .map(|source| {
            let below = source.path.strip_prefix("src").unwrap().with_extension("");
            // The program is a crate of its own, whose file `main` is the root.
            let below = below.strip_prefix("cli").unwrap_or(&below);
            below
                .iter()
                .map(|part| part.to_str().unwrap().to_owned())
                .filter(|part| part != "main")
                .collect()
        })
        .collect();
    let is_program = |source: &Source| source.module() == "cli";
    let edges: Vec<Vec<usize>> = std::iter::zip(&sources, &modules)
        .map(|(source, own)| {
            let mut used = files_used(source, &modules, own);
            used.retain(|&other| is_program(&sources[other]) == is_program(source));
            used
        })
        .collect();
    assert!(
        edges.iter().map(Vec::len).sum::<usize>() > 200,
        "the imports are not found"
    );
    // Files that use no other that is left, or that none uses, go round by round. What stays is on a circle, or between
    // two.
    let mut users: Vec<Vec<usize>> = vec![Vec::new(); sources.len()];
    for (file, used) in edges.iter().enumerate() {
        used.iter().for_each(|&other| users[other].push(file));
    }
    let mut left: Vec<bool> = vec![true; sources.len()];
    loop {
        let are_gone = |files: &[usize]| !files.iter().any(|&other| left[other]);
        let is_on_an_end = |file: usize| are_gone(&edges[file]) || are_gone(&users[file]);
        let ends: Vec<usize> = (0..sources.len())
            .filter(|&file| left[file] && is_on_an_end(file))
            .collect();
        if ends.is_empty() {
            break;
        }
        ends.into_iter().for_each(|file| left[file] = false);
    }
    let mut failures = Vec::new();
    for file in (0..sources.len()).filter(|&file| left[file]) {
        for &other in edges[file].iter().filter(|&&other| left[other]) {
            failures.push(format!(
                "{} uses {}",
                sources[file].path.display(),
                sources[other].path.display()
            ));
        }
    }
    report(&failures);
}

/// The part of `format` that a file belongs to: the name of a file or folder right below `src/format`.
fn part_of_format(path: &Path) -> Option<String> {
    let below = path.strip_prefix("src/format").ok()?.with_extension("");
    Some(below.components().next()?.as_os_str().to_str()?.to_owned())
}

#[test]
fn a_format_knows_no_other_format() {
    let sources = sources();
    // What has a row for the table is a format; the others are shared.
    let has_row = |source: &&Source| {
        source
            .code
            .iter()
            .any(|(_, line)| line.contains("const FORMAT: FormatInfo"))
    };
    let formats: Vec<String> = sources
        .iter()
        .filter(has_row)
        .filter_map(|source| part_of_format(&source.path))
        .collect();
    assert!(formats.len() >= 3, "{formats:?}");
    let mut failures = Vec::new();
    for source in &sources {
        let Some(own) = part_of_format(&source.path) else {
            continue;
        };
        for prefix in ["super::", "format::"] {
            for (place, used) in source.names_after(prefix) {
                if used != own && formats.contains(&used) {
                    failures.push(format!("{place}: `{own}` uses `{used}`"));
                }
            }
        }
    }
    report(&failures);
}

#[test]
fn a_step_calls_no_other_step() {
    let sources = sources();
    let is_step = |path: &Path| path.starts_with("src/process");
    // Its name, where a line declares a step: a method on the whole scene.
    let declared = |line: &str| {
        let (name, _) = line.trim_start().strip_prefix("pub fn ")?.split_once("(&mut self")?;
        Some(name.to_owned())
    };
    let of_file = |source: &Source| -> Vec<String> {
        let lines = source.code.iter().map(|(_, line)| line);
        lines.filter_map(|line| declared(line)).collect()
    };
    let files: Vec<&Source> = sources.iter().filter(|source| is_step(&source.path)).collect();
    let steps: Vec<String> = files.iter().flat_map(|source| of_file(source)).collect();
    assert!(steps.iter().any(|name| name == "debone"), "{steps:?}");
    let mut failures = Vec::new();
    for source in files {
        let own = of_file(source);
        for (number, line) in &source.code {
            let called = steps.iter().filter(|name| !own.contains(name));
            for name in called.filter(|name| line.contains(&format!(".{name}("))) {
                failures.push(format!("{}:{number}: calls {name}", source.path.display()));
            }
        }
    }
    report(&failures);
}

#[test]
fn the_program_uses_only_the_public_interface() {
    // It is a crate of its own, so the compiler sees to it, unless a file of the library is pulled in by its path.
    let mut failures = Vec::new();
    for source in sources().iter().filter(|source| source.module() == "cli") {
        for (number, line) in &source.code {
            if line.contains("#[path") || line.contains("include!") {
                failures.push(format!("{}:{number}: {line}", source.path.display()));
            }
        }
    }
    report(&failures);
}

#[test]
fn only_import_opens_an_input_and_only_files_looks_at_an_output() {
    let mut failures = Vec::new();
    for source in sources() {
        let module = source.module();
        if module == "cli" {
            continue;
        }
        for (number, line) in &source.code {
            let reads = line.contains("File::open") || line.contains("fs::read") || line.contains("fs::metadata");
            let writes = line.contains("File::create") || line.contains("fs::write") || line.contains("tempfile");
            if (reads && module != "import" && module != "files") || (writes && module != "files") {
                failures.push(format!("{}:{number}: {line}", source.path.display()));
            }
        }
    }
    report(&failures);
}

/// Columns of a comment, as of the code; `rustfmt.toml` has the same number.
const COLUMNS: usize = 120;

#[test]
fn comments_keep_to_the_columns_of_the_code() {
    let mut failures = Vec::new();
    for folder in ["src", "tests", "examples", "tools"] {
        let mut folders = vec![PathBuf::from(folder)];
        while let Some(folder) = folders.pop() {
            for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
                let name = path.file_name().unwrap().to_string_lossy();
                if path.is_dir() && !["target", "node_modules"].contains(&&*name) {
                    folders.push(path);
                } else if name.ends_with(".rs") {
                    let text = fs::read_to_string(&path).unwrap();
                    for (number, line) in (1..).zip(text.lines()) {
                        let comment = line.trim_start();
                        // A row of a table cannot be wrapped.
                        let is_table = ["//! |", "/// |"].iter().any(|row| comment.starts_with(row));
                        if comment.starts_with("//") && !is_table && line.chars().count() > COLUMNS {
                            failures.push(format!("{}:{number}: {line}", path.display()));
                        }
                    }
                }
            }
        }
    }
    report(&failures);
}

#[test]
fn no_two_public_types_share_a_name() {
    let mut types: Vec<(String, String)> = Vec::new();
    for source in sources().iter().filter(|source| source.module() != "cli") {
        for keyword in ["struct", "enum", "trait", "type"] {
            for (place, name) in source.names_after(&format!("pub {keyword} ")) {
                types.push((name, place));
            }
        }
    }
    assert!(types.len() > 60, "the types are not found");
    types.sort();
    let failures: Vec<String> = types
        .windows(2)
        .filter(|pair| pair[0].0 == pair[1].0)
        .map(|pair| {
            format!(
                "{}: {} has a type of the same name, `{}`",
                pair[1].1, pair[0].1, pair[0].0
            )
        })
        .collect();
    report(&failures);
}
