//! The public interface of the library: its number of names, counted in the source.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use crate::source::{ItemPath, Modules, Source, is_hidden, sources};

/// The number of public names of the library: types, functions and constants. A new name must be worth its line in the
/// documentation. If the number becomes smaller, it is changed here. Modules called `report` are not counted: a program
/// reads fields of a report, and need not name its types.
const PUBLIC_NAMES: usize = 201;

/// The items that the root package re-exports and does not hide. Each item has its place of declaration, and the path
/// by which a user names it. Methods and modules do not count.
pub(super) fn public_items(sources: &[Source]) -> BTreeMap<ItemPath, String> {
    let modules = Modules::new(sources);
    let (mut items, mut read) = (BTreeMap::new(), BTreeSet::new());
    // Modules near the root come first, so an item has its shortest path.
    let mut queue = VecDeque::from([(ItemPath::new(), String::new())]);
    while let Some((module, path)) = queue.pop_front() {
        let source = sources.iter().find(|source| source.module == module).unwrap();
        for (item, name) in items_of(source) {
            let path = join(&path, &name);
            match modules.declared(item) {
                (module, below) if below.is_empty() => {
                    if read.insert(module.clone()) {
                        queue.push_back((module, path));
                    }
                }
                (module, below) => {
                    items.entry([module, below].concat()).or_insert(path);
                }
            }
        }
    }
    items
}

/// The items that a file declares or re-exports for users, each with its public name.
fn items_of(source: &Source) -> Vec<(ItemPath, String)> {
    let (code, module) = (&source.code, &source.module);
    let re_exported = source.imports.iter().filter(|import| import.is_public);
    let mut items: Vec<_> = re_exported
        .map(|import| (import.path.clone(), import.name.clone()))
        .collect();
    let mut declare =
        |module: &[String], name: &str| items.push(([module, &[name.to_owned()]].concat(), name.to_owned()));
    for (at, public) in code.match_indices("\npub ") {
        let (before, item) = code.split_at(at + public.len());
        let mut words = item.split(|c: char| !c.is_alphanumeric() && c != '_');
        let keywords = ["struct", "enum", "trait", "type", "fn", "const", "unsafe", "mod"];
        let name = words.find(|word| !keywords.contains(word)).unwrap();
        if name != "use" && !is_hidden(before) {
            declare(module, name);
        }
    }
    if code.contains("::steps! {") {
        // The macro in `list` declares the item.
        let list = [&module[..], &["list".to_owned()]].concat();
        declare(&list, "EditStep");
    }
    items
}

/// The public names. Types have unique names; functions and constants are distinguished by their modules.
fn public_names() -> BTreeSet<String> {
    let items = public_items(&sources());
    let name = |(item, path): (&ItemPath, &String)| {
        let name = item.last().unwrap();
        let is_type = name.starts_with(char::is_uppercase) && name.contains(char::is_lowercase);
        if is_type { name.clone() } else { path.clone() }
    };
    let is_report = |path: &str| path.split("::").any(|module| module == "report");
    let items = Vec::from_iter(items.iter().filter(|(_, path)| !is_report(path)));
    let names: BTreeSet<String> = items.iter().copied().map(name).collect();
    assert!(
        names.contains("Scene") && names.contains("figure::name_joints"),
        "{names:?}"
    );
    assert_eq!(names.len(), items.len(), "two public types share a name: {items:#?}");
    names
}

fn join(path: &str, name: &str) -> String {
    let parts = [path, name].into_iter().filter(|part| !part.is_empty());
    parts.collect::<Vec<_>>().join("::")
}

#[test]
fn public_names_do_not_grow_unseen() {
    let names = public_names();
    let list: Vec<&str> = names.iter().map(String::as_str).collect();
    assert_eq!(names.len(), PUBLIC_NAMES, "{}", list.join(" "));
}

/// Every type called a report is a `Report`: it has a text for people, and data for programs.
#[test]
fn every_report_has_a_text_and_is_data() {
    let sources = sources();
    let declared = declared(&sources);
    let is_report = |found: &&Declared| found.name.ends_with("Report") && found.keyword != "trait";
    let reports = Vec::from_iter(declared.iter().filter(is_report));
    assert!(reports.len() >= 10, "{} reports are found", reports.len());
    for Declared {
        name,
        place,
        attributes,
        ..
    } in reports
    {
        let display = format!("Display for {name} ");
        assert!(attributes.contains("Serialize"), "{place}: {name} is not Serialize");
        assert!(
            sources.iter().any(|source| source.text.contains(&display)),
            "{place}: {name} has no Display"
        );
    }
}

/// Types that will get no further variants or fields, and types that programs write as literals. In such a literal, a
/// new field should be an error.
const CLOSED: &[&str] = &[
    // The scene, which readers and writers of other formats build. Each new field requires a value from them.
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
    // The same reason applies to a robot.
    "Inertial",
    "JointLimits",
    "Mimic",
    "Placement",
    "Robot",
    "RobotJoint",
    "RobotLink",
    "RobotShape",
    // Complete values that a caller passes.
    "Clip",
    "MemoryFile",
    "PathPoint",
    "TimeRange",
    // A value with its origin.
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
    // The possible sources of a T-pose: the file's rest pose, its motion, or neither.
    "TPoseSource",
    // Types that several packages write as literals, or match exhaustively. A new field or variant should be an error
    // in these packages.
    "AlongBone",
    "AnalogChannel",
    "AppliedStep",
    "BodyGait",
    "Confidence",
    "Event",
    "Face",
    "FilledJoint",
    "ForcePlate",
    "JointRename",
    "LimbAngles",
    "Metadata",
    "MorphTarget",
    "NodeKind",
    "NodeRename",
    "Origin",
    "Provenance",
    "Recording",
    "RootMotion",
    "RootOffset",
    "RootOffsetUsed",
    "ShapeKind",
    "SolvedJoint",
    "SolvedMarker",
    "SwappedMarkers",
    "Target",
    "Wrap",
];

/// A public type at its declaration.
struct Declared {
    name: String,
    package: String,
    place: String,
    /// `struct`, `enum`, `trait` or `type`.
    keyword: &'static str,
    /// The documentation of the type.
    docs: String,
    /// The attributes of the type.
    attributes: String,
    /// Whether a program can write the type as a literal, or match it exhaustively: an enum, or a struct with a public
    /// field.
    is_open: bool,
    /// Whether the type is in a module `report`, so that no program builds it.
    is_report: bool,
    /// Whether a program can build the type without a literal that has all fields.
    has_constructor: bool,
}

/// The public types of the library, except types that `step!` declares. Each type that `step!` declares has an example.
fn declared(sources: &[Source]) -> Vec<Declared> {
    let items = public_items(sources);
    let declared: Vec<Declared> = sources.iter().flat_map(|source| declared_in(source, &items)).collect();
    assert!(declared.len() > 150, "the types are not found");
    declared
}

fn declared_in(source: &Source, items: &BTreeMap<ItemPath, String>) -> Vec<Declared> {
    let lines: Vec<&str> = source.text.lines().collect();
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
            // A declaration of several lines has its fields below.
            let body = body.take(if rest.ends_with(';') { 0 } else { usize::MAX });
            let has_field = rest.contains("(pub")
                || body
                    .clone()
                    .any(|line| line.starts_with("    pub ") && line.contains(':'));
            if let Some(path) = items.get(&[&source.module[..], &[name.to_owned()]].concat()) {
                let is_made = |line: &str| {
                    line.contains(&format!("Default for {name}"))
                        || line.starts_with("impl")
                            && line.contains(&format!("> {name}<")) | line.contains(&format!("impl {name} "))
                };
                let mut blocks = source.text.split("\nimpl").skip(1).map(|block| format!("impl{block}"));
                let is_constructed = |block: String| {
                    is_made(block.lines().next().unwrap_or_default())
                        && (block.contains("fn default()")
                            || block.contains("pub fn new(")
                            || block.contains("pub const fn new("))
                };
                declared.push(Declared {
                    is_report: path.split("::").any(|module| module == "report"),
                    has_constructor: attributes.contains("Default") || blocks.any(is_constructed),
                    package: source.module.first().cloned().unwrap_or_default(),
                    name: name.to_owned(),
                    place: format!("{}:{}", source.path, at + 1),
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
    let declared = declared(&sources());
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
        match declared.iter().find(|found| found.name == *name) {
            None => failures.push(format!("there is no public type {name}")),
            Some(found) if found.keyword == "struct" && !found.is_report && !found.has_constructor => {
                failures.push(format!(
                    "{}: {name} has neither a default nor a function new",
                    found.place
                ));
            }
            Some(_) => {}
        }
    }
    assert!(failures.is_empty(), "\n{}", failures.join("\n"));
}

/// Whether the documentation has an example, or names an item or a module that has one.
fn is_shown(found: &Declared, sources: &[Source], examples: &BTreeSet<String>) -> bool {
    let docs = &found.docs;
    let named = |link: &str| {
        let name = link
            .split(['`', '('])
            .find(|part| part.contains(char::is_alphanumeric))?;
        examples.contains(name.rsplit("::").next()?).then_some(())
    };
    let module = |link: &str| {
        let path = link.split_once("[module](")?.1.trim_end_matches(')');
        let path = path.replace("crate", &found.package);
        let mut files = sources.iter();
        let file = files.find(|source| source.module.iter().eq(path.split("::")))?;
        file.text.contains("//! ```").then_some(())
    };
    let says = |sentence: &str| {
        // A package cannot link to a package above it, so its documentation has the name as code.
        let open = if sentence.ends_with('`') { '`' } else { '[' };
        let link = &sentence[sentence[..sentence.len() - 1].rfind(open)?..];
        // A module names itself.
        named(link)
            .or_else(|| module(link))
            .or_else(|| link.contains("[module](self)").then_some(()))
    };
    docs.contains("```")
        || docs
            .split_once(" has an example")
            .is_some_and(|(sentence, _)| says(sentence).is_some())
}

#[test]
fn every_public_type_has_an_example_or_says_where_one_is() {
    let sources = sources();
    let examples = with_example(&sources);
    let mut failures = Vec::new();
    for found in declared(&sources) {
        // An alias has the documentation of its type.
        if found.keyword != "type" && !is_shown(&found, &sources, &examples) {
            failures.push(format!(
                "{}: {} has no example, nor a link to one",
                found.place, found.name
            ));
        }
    }
    assert!(failures.is_empty(), "\n{}", failures.join("\n"));
}

/// The names of types, functions and methods that have an example.
fn with_example(sources: &[Source]) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    for source in sources {
        let mut has_example = false;
        for line in source.text.lines().map(str::trim) {
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
                // The step is declared in `step!`.
                names.insert(step.trim().to_owned());
            } else if line.is_empty() || line.ends_with(['}', ';']) {
                has_example = false;
            }
        }
    }
    names
}
