//! What a user of the library sees: how many names there are, read from the source.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// How many public names the library has, of types, functions and constants. A new one is worth its line in the
/// documentation that everybody reads; a number below this is written here.
const PUBLIC_NAMES: usize = 388;

/// The public names that are found from the root of the crate, each with its path. Methods and modules do not count,
/// and a type that is re-exported counts once.
fn public_names() -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    let mut modules = Vec::new();
    collect(Path::new("src/lib.rs"), "", &mut modules, &mut names);
    assert!(
        names.contains("Scene") && names.contains("files::write_file"),
        "the names are not found: {names:?}"
    );
    names
}

/// Adds what `file`, which is the module `module`, makes public. `read` has the files that were read.
fn collect(file: &Path, module: &str, read: &mut Vec<PathBuf>, names: &mut BTreeSet<String>) {
    if read.contains(&file.to_owned()) {
        return;
    }
    read.push(file.to_owned());
    let text = fs::read_to_string(file).unwrap();
    for line in text.lines().take_while(|line| *line != "#[cfg(test)]") {
        let Some(item) = line.strip_prefix("pub ") else {
            continue;
        };
        let mut words = item
            .split(|c: char| !c.is_alphanumeric() && c != '_')
            .filter(|word| !word.is_empty());
        match (words.next(), words.next()) {
            (Some("mod"), Some(name)) => collect(&file_of(file, name).unwrap(), &join(module, name), read, names),
            (Some("use"), _) => {}
            (Some("const"), Some("fn")) => add(words.next().unwrap(), module, names),
            (_, Some(name)) => add(name, module, names),
            _ => {}
        }
    }
    for list in text.split("\npub use ").skip(1) {
        let list = list.split(';').next().unwrap();
        let (path, list) = list
            .split_once('{')
            .or_else(|| list.rsplit_once("::"))
            .unwrap_or(("", list));
        let path = path.trim_end_matches("::");
        for name in list
            .trim_end_matches('}')
            .split(',')
            .map(str::trim)
            .filter(|name| !name.is_empty())
        {
            let source = match path.strip_prefix("crate::") {
                Some(below) => Path::new("src").join(below.replace("::", "/")).with_extension("rs"),
                None => file.to_owned(),
            };
            let is_module = fs::read_to_string(&source).is_ok_and(|text| text.contains(&format!("\npub mod {name};")));
            match file_of(&source, name).filter(|_| is_module) {
                Some(module_file) => collect(&module_file, &join(module, name), read, names),
                None => add(name, module, names),
            }
        }
    }
    if let Some(steps) = text.split("::steps! {").nth(1) {
        // `FILE: NAME, NAME;`, and what the macro declares.
        let listed = steps.split(';').filter_map(|step| step.split_once(':'));
        listed
            .flat_map(|(_, list)| list.split(','))
            .for_each(|name| add(name.trim(), module, names));
        let declares = fs::read_to_string("src/edit/list.rs").unwrap();
        let declared = declares
            .lines()
            .filter_map(|line| line.strip_prefix("        pub enum "));
        declared.for_each(|line| add(line.split(' ').next().unwrap(), module, names));
    }
}

fn join(module: &str, name: &str) -> String {
    [module, name]
        .into_iter()
        .filter(|part| !part.is_empty())
        .collect::<Vec<_>>()
        .join("::")
}

/// The file of the module `name` that `file` declares, if it is a module.
fn file_of(file: &Path, name: &str) -> Option<PathBuf> {
    let folder = if file.ends_with("lib.rs") {
        PathBuf::from("src")
    } else {
        file.with_extension("")
    };
    Some(folder.join(name).with_extension("rs")).filter(|file| file.exists())
}

/// Other crates do not count. Types have names of their own, wherever they are re-exported; functions and constants are
/// told by their modules.
fn add(name: &str, module: &str, names: &mut BTreeSet<String>) {
    let is_type = name.starts_with(char::is_uppercase) && name.contains(char::is_lowercase);
    if !["glam", "arrow_array", "arrow_schema"].contains(&name) {
        names.insert(if is_type { name.to_owned() } else { join(module, name) });
    }
}

#[test]
fn public_names_do_not_grow_unseen() {
    let names = public_names();
    let list: Vec<&str> = names.iter().map(String::as_str).collect();
    assert_eq!(names.len(), PUBLIC_NAMES, "{}", list.join(" "));
}

/// Types that have all the variants or fields that they will ever have, or that a program makes as literals, so that a
/// new field is to be an error in it.
const CLOSED: &[&str] = &[
    // The scene, which readers and writers of other formats build: each field is an answer that they owe.
    "Animation",
    "Bone",
    "Channel",
    "Keys",
    "Material",
    "Mesh",
    "Node",
    "NodeId",
    "Scene",
    "SourceLines",
    "Surface",
    "Texture",
    "VertexWeight",
    "Trs",
    // A robot likewise.
    "Inertial",
    "JointLimits",
    "Mimic",
    "Placement",
    "Robot",
    "RobotJoint",
    "RobotLink",
    "RobotShape",
    // What a caller hands over, whole.
    "Angle",
    "Clip",
    "MemoryFile",
    "PathPoint",
    "RobotClip",
    "TPoseClip",
    "TimeRange",
    // A value and how it came about.
    "Assumption",
    "Guess",
    "Location",
    // Mathematics, or a published list: bones of VRM, primitives of Assimp, alpha modes of glTF.
    "AlphaMode",
    "Axis",
    "HumanoidBone",
    "Primitive",
    "RotationOrder",
    "Side",
    "UpAxis",
    // From where a T-pose may be: the file's rest pose, its motion, neither.
    "TPoseSource",
];

/// A public type where it is declared.
struct Declared {
    name: String,
    place: String,
    /// `struct`, `enum`, `trait` or `type`.
    keyword: &'static str,
    /// Its documentation.
    docs: String,
    /// Its attributes.
    attributes: String,
    /// Whether a program can write it as a literal, or match it to the end: an enum, or a struct with a public field.
    is_open: bool,
}

/// The public types of the library, but for those that `step!` declares, which have an example each.
fn declared() -> Vec<Declared> {
    let names = public_names();
    let declared: Vec<Declared> = files_below("src")
        .iter()
        .flat_map(|path| declared_in(path, &names))
        .collect();
    assert!(declared.len() > 150, "the types are not found");
    declared
}

fn declared_in(path: &Path, names: &BTreeSet<String>) -> Vec<Declared> {
    let text = fs::read_to_string(path).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    let mut declared = Vec::new();
    let (mut docs, mut attributes, mut is_attribute) = (String::new(), String::new(), false);
    for (at, line) in lines.iter().enumerate() {
        let bare = line.trim();
        if let Some(doc) = bare.strip_prefix("///") {
            docs += doc;
            docs += "\n";
            continue;
        }
        if bare.starts_with("#[") || bare.starts_with("$(#[") || is_attribute {
            attributes += bare;
            is_attribute = !bare.ends_with([']', '*']);
            continue;
        }
        for keyword in ["struct", "enum", "trait", "type"] {
            let Some(rest) = bare.strip_prefix(&format!("pub {keyword} ")) else {
                continue;
            };
            let name = rest.split(|c: char| !c.is_alphanumeric()).next().unwrap();
            let body = lines[at + 1..].iter().take_while(|line| !line.starts_with('}'));
            // What is not on one line has its fields below.
            let body = body.take(if rest.ends_with(';') { 0 } else { usize::MAX });
            let has_field = rest.contains("(pub")
                || body
                    .clone()
                    .any(|line| line.starts_with("    pub ") && line.contains(':'));
            if names.contains(name) {
                declared.push(Declared {
                    name: name.to_owned(),
                    place: format!("{}:{}", path.display(), at + 1),
                    keyword,
                    docs: std::mem::take(&mut docs),
                    attributes: attributes.clone(),
                    is_open: keyword == "enum" || (keyword == "struct" && has_field),
                });
            }
        }
        docs.clear();
        attributes.clear();
    }
    declared
}

#[test]
fn a_new_field_or_variant_breaks_no_program() {
    let declared = declared();
    let mut failures = Vec::new();
    for found in &declared {
        let may_grow = found.attributes.contains("#[non_exhaustive]");
        let is_closed = CLOSED.contains(&found.name.as_str());
        if found.is_open && may_grow == is_closed {
            let what = if is_closed {
                "is in the list of those that do not grow"
            } else {
                "lacks #[non_exhaustive]"
            };
            failures.push(format!("{}: {} {what}", found.place, found.name));
        }
    }
    for name in CLOSED {
        if !declared.iter().any(|found| found.name == *name) {
            failures.push(format!("there is no public type {name}"));
        }
    }
    assert!(failures.is_empty(), "\n{}", failures.join("\n"));
}

/// Whether the documentation has an example, or says which item, or which module, has one.
fn is_shown(docs: &str, examples: &BTreeSet<String>) -> bool {
    let named = |link: &str| {
        let name = link
            .split(['`', '('])
            .find(|part| part.contains(char::is_alphanumeric))?;
        examples.contains(name.rsplit("::").next()?).then_some(())
    };
    let module = |link: &str| {
        let path = link.split_once("[module](")?.1.strip_prefix("crate::")?;
        let text = fs::read_to_string(format!("src/{}.rs", path.trim_end_matches(')'))).ok()?;
        text.contains("//! ```").then_some(())
    };
    let says = |sentence: &str| {
        let link = &sentence[sentence
            .rfind('[')
            .filter(|_| sentence.ends_with(')') || sentence.ends_with(']'))?..];
        // A module says so of itself.
        named(link)
            .or_else(|| module(link))
            .or_else(|| link.contains("[module](self)").then_some(()))
    };
    docs.contains("```")
        || docs
            .split(" has an example")
            .next()
            .filter(|_| docs.contains(" has an example"))
            .and_then(says)
            .is_some()
}

#[test]
fn every_public_type_has_an_example_or_says_where_one_is() {
    let examples = with_example();
    let mut failures = Vec::new();
    for found in declared() {
        // An alias is what it stands for.
        if found.keyword != "type" && !is_shown(&found.docs, &examples) {
            failures.push(format!(
                "{}: {} has no example, nor a link to one",
                found.place, found.name
            ));
        }
    }
    assert!(failures.is_empty(), "\n{}", failures.join("\n"));
}

/// The names of types, functions and methods that have an example.
fn with_example() -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    for path in files_below("src") {
        let mut has_example = false;
        for line in fs::read_to_string(&path).unwrap().lines().map(str::trim) {
            if line.starts_with("///") {
                has_example |= line.contains("```");
            } else if let Some(item) = line.strip_prefix("pub ") {
                let mut words = item.split(|c: char| !c.is_alphanumeric() && c != '_');
                let kinds = ["struct", "enum", "trait", "fn"];
                if has_example && words.any(|word| kinds.contains(&word)) {
                    names.extend(words.next().map(str::to_owned));
                }
                has_example = false;
            } else if let Some(step) = line.trim_end_matches('}').strip_suffix('{').filter(|_| has_example) {
                // In `step!`.
                names.insert(step.trim().to_owned());
            } else if line.is_empty() || line.ends_with(['}', ';']) {
                has_example = false;
            }
        }
    }
    names
}

/// The files of Rust below a folder, but for the program's.
fn files_below(folder: &str) -> Vec<PathBuf> {
    let (mut files, mut folders) = (Vec::new(), vec![PathBuf::from(folder)]);
    while let Some(folder) = folders.pop() {
        for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            if path.is_dir() && !path.ends_with("cli") {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                files.push(path);
            }
        }
    }
    files
}
