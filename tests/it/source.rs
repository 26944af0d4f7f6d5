//! Reads the Rust source of the packages, for the tests that check the architecture and the public names.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// The modules of an item, beginning with its package, and its name: `["figure", "humanoid", "Humanoid"]`.
pub(crate) type ItemPath = Vec<String>;

/// A file of a package.
pub(crate) struct Source {
    /// The path from the root of the repository.
    pub(crate) path: String,
    /// The package and the modules of the file. The root package has an empty name.
    pub(crate) module: ItemPath,
    pub(crate) text: String,
    /// The text without comments.
    pub(crate) code: String,
    pub(crate) imports: Vec<Import>,
}

/// A path into a package of this workspace that a file names with `use`, or in its code.
pub(crate) struct Import {
    pub(crate) path: ItemPath,
    /// The name in this file.
    pub(crate) name: String,
    pub(crate) is_use: bool,
    /// Whether the path is re-exported without `#[doc(hidden)]`.
    pub(crate) is_public: bool,
}

impl Source {
    fn read(path: &Path) -> Self {
        let below = path.strip_prefix("src").unwrap().with_extension("");
        let names = below.iter().map(|name| name.to_str().unwrap());
        let module = names.filter(|name| *name != "lib").map(str::to_owned);
        let text = fs::read_to_string(path).unwrap();
        let is_code = |line: &&str| !line.trim_start().starts_with("//");
        let code: Vec<&str> = text.lines().filter(is_code).collect();
        let mut source = Self {
            path: path.to_str().unwrap().to_owned(),
            module: module.collect(),
            code: code.join("\n"),
            text,
            imports: Vec::new(),
        };
        source.imports = ["crate::", "self::", "super::", "mocap_"]
            .iter()
            .flat_map(|root| source.code.match_indices(root))
            .flat_map(|(at, _)| source.imports_at(at))
            .chain(source.steps())
            .collect();
        source
    }

    /// The imports of the path, or of the tree of paths, that begins at a position of the code.
    fn imports_at(&self, at: usize) -> Vec<Import> {
        let is_name = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
        let (before, tree) = self.code.split_at(at);
        let is_use = before.ends_with("use ");
        let end = tree.find(|c| if is_use { c == ';' } else { !is_name(c) });
        let mut paths = Vec::new();
        if !before.ends_with(is_name) {
            expand("", &tree[..end.unwrap_or(tree.len())], &mut paths);
        }
        let is_public = before.ends_with("pub use ") && !is_hidden(before);
        let import = |(path, name): (String, String)| Import {
            path: self.absolute(&path),
            name,
            is_use,
            is_public,
        };
        paths.into_iter().map(import).collect()
    }

    /// The items that the macro `steps!` re-exports in addition to reports. Each step has a line `FILE: NAME, NAME =>
    /// REPORT;`.
    fn steps(&self) -> Vec<Import> {
        let lists = self.code.split("::steps! {").skip(1);
        let rows = lists
            .filter_map(|list| list.split_once('}'))
            .flat_map(|(_, steps)| steps.split(';'));
        let rows = rows.filter_map(|row| row.split("=>").next()?.split_once(':'));
        let names = rows.flat_map(|(file, names)| names.split(',').map(move |name| (file.trim(), name.trim())));
        let import = |(file, name): (&str, &str)| Import {
            path: self.absolute(&format!("self::{file}::{name}")),
            name: name.to_owned(),
            is_use: true,
            is_public: true,
        };
        names.map(import).collect()
    }

    fn absolute(&self, path: &str) -> ItemPath {
        let mut names = self.module.clone();
        for name in path.split("::").map(str::trim) {
            match name {
                "crate" => names.truncate(1),
                "super" => names.truncate(names.len() - 1),
                "self" | "*" | "" => {}
                name => match name.strip_prefix("mocap_") {
                    Some(package) => names = vec![package.to_owned()],
                    None => names.push(name.to_owned()),
                },
            }
        }
        names
    }
}

/// Whether attributes hide an item from the documentation. The text before the item ends with these attributes.
pub(crate) fn is_hidden(before: &str) -> bool {
    let above = before.lines().rev().skip(1);
    let mut attributes = above.take_while(|line| line.starts_with('#'));
    attributes.any(|line| line == "#[doc(hidden)]")
}

/// Adds the paths of a tree such as `a::{b, c::{d, e as f}}`, each with its name in the file.
fn expand(prefix: &str, tree: &str, paths: &mut Vec<(String, String)>) {
    let (head, list) = tree.split_once('{').unwrap_or((tree, ""));
    let path = format!("{prefix}{}", head.trim());
    if list.is_empty() && !path.ends_with("::") {
        let own = path.trim_end_matches("::self").rsplit("::").next().unwrap();
        let (path, name) = path.split_once(" as ").unwrap_or((&path, own));
        paths.push((path.to_owned(), name.to_owned()));
    }
    let (mut depth, mut begin) = (0, 0);
    for (at, c) in list.char_indices() {
        if depth == 0 && (c == ',' || c == '}') {
            expand(&path, &list[begin..at], paths);
            begin = at + 1;
        }
        depth += i32::from(c == '{') - i32::from(c == '}');
    }
}

/// The files of all packages, without integration tests.
pub(crate) fn sources() -> Vec<Source> {
    let paths = rust_files(|folder| !folder.ends_with("tests"));
    assert!(paths.len() > 500, "the source is somewhere else");
    paths.iter().map(|path| Source::read(path)).collect()
}

/// The Rust files below `src`, in the folders that `is_entered` allows.
pub(crate) fn rust_files(is_entered: impl Fn(&Path) -> bool) -> Vec<PathBuf> {
    let (mut files, mut folders) = (Vec::new(), vec![PathBuf::from("src")]);
    while let Some(folder) = folders.pop() {
        for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            if path.is_dir() {
                folders.extend(is_entered(&path).then_some(path));
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                files.push(path);
            }
        }
    }
    files
}

/// Finds the declaration of an item through re-exports.
pub(crate) struct Modules(BTreeMap<ItemPath, BTreeMap<String, ItemPath>>);

impl Modules {
    pub(crate) fn new(sources: &[Source]) -> Self {
        let used = |source: &Source| {
            let uses = source.imports.iter().filter(|import| import.is_use);
            uses.map(|import| (import.name.clone(), import.path.clone())).collect()
        };
        let modules = sources.iter().map(|source| (source.module.clone(), used(source)));
        Self(modules.collect())
    }

    /// The module that declares an item, and the path of the item within this module. The path is empty for a module.
    pub(crate) fn declared(&self, mut path: ItemPath) -> (ItemPath, ItemPath) {
        // A function may import a name that its own module re-exports, so the steps are counted.
        for _ in 0..8 {
            let (module, below) = self.split(&path);
            let Some(to) = below.first().and_then(|name| self.0[module].get(name)) else {
                break;
            };
            path = [to, &below[1..]].concat();
        }
        let (module, below) = self.split(&path);
        (module.to_vec(), below.to_vec())
    }

    /// Splits a path after the longest path of a module.
    fn split<'a>(&self, path: &'a [String]) -> (&'a [String], &'a [String]) {
        let mut lengths = (0..=path.len()).rev();
        let length = lengths.find(|length| self.0.contains_key(&path[..*length]));
        path.split_at(length.unwrap())
    }
}

/// An import from one module to another. Both modules are children of the longest common part of the two paths.
pub(crate) struct Crossing<'a> {
    pub(crate) source: &'a Source,
    /// The last name of the imported path.
    pub(crate) name: &'a str,
    pub(crate) from: ItemPath,
    pub(crate) to: ItemPath,
}

/// All imports except imports between a module and its submodules.
pub(crate) fn crossings(sources: &[Source]) -> Vec<Crossing<'_>> {
    let modules = Modules::new(sources);
    let mut crossings = Vec::new();
    for source in sources {
        for import in &source.imports {
            let (own, target) = (&source.module, modules.declared(import.path.clone()).0);
            let shared = own.iter().zip(&target).take_while(|(a, b)| a == b).count();
            if shared < own.len() && shared < target.len() {
                crossings.push(Crossing {
                    source,
                    name: import.path.last().unwrap(),
                    from: own[..=shared].to_vec(),
                    to: target[..=shared].to_vec(),
                });
            }
        }
    }
    assert!(crossings.len() > 2000, "the imports are not found");
    crossings
}
