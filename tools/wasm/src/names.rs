//! What options of a job are called in the package. `tools/bindings` writes the types of TypeScript by the same tables.

/// Options with another name: their records and their names in a job, then in the package. Others are in camel case.
const NAMES: &[(&str, &str, &str)] = &[
    ("InputOptions", "from", "format"),
    ("Sources", "map", "bones"),
    ("SourceFrames", "fps", "frameRate"),
    ("SourceFrames", "drop-first-frame", "firstFrame"),
];

/// Options of a job that calls do not take: files of other calls, and what calls have in a form of their own.
const LEFT_OUT: &[(&str, &[&str])] = &[
    ("InputOptions", &["skeleton"]),
    ("SourceFrames", &["trim"]),
    ("BvhOutputOptions", &["sidecar"]),
    (
        "CharacterTarget",
        &["file", "map", "names-of-clips", "replace-animations", "max-angle"],
    ),
    (
        "RobotTarget",
        &["file", "map", "scale", "names-of-clips", "velocity-limits", "require"],
    ),
];

/// Words with another name: record, option, word of a job, and that of the package; `None` where calls do not take it.
const WORDS: &[(&str, &str, &str, Option<&str>)] = &[
    ("SourceFrames", "drop-first-frame", "no", Some("keep")),
    ("SourceFrames", "drop-first-frame", "yes", Some("drop")),
    ("SourceFrames", "root", "in-place", Some("inPlace")),
    ("SizeOptions", "compress", "meshopt", None),
    ("SizeOptions", "compress", "meshopt-khr", None),
];

/// The name in the package of an option of a record; `None` where calls do not take it.
pub(crate) fn option(record: &str, name: &str) -> Option<String> {
    let is_left_out = |(own, names): &(&str, &[&str])| *own == record && names.contains(&name);
    if LEFT_OUT.iter().any(is_left_out) {
        return None;
    }
    let row = NAMES.iter().find(|(own, option, _)| *own == record && *option == name);
    Some(row.map_or_else(|| camel_case(name), |(_, _, own)| (*own).to_owned()))
}

/// What a word of a job is called in the package; `None` where calls do not take it.
pub(crate) fn word<'a>(record: &str, option: &str, word: &'a str) -> Option<&'a str> {
    match rows(record, option).find(|row| row.0 == word) {
        Some((_, own)) => own,
        None => Some(word),
    }
}

/// The word of a job for one of the package; `None` where only a job has it.
pub(crate) fn word_of_job<'a>(record: &str, option: &str, word: &'a str) -> Option<&'a str> {
    if let Some((job, _)) = rows(record, option).find(|row| row.1 == Some(word)) {
        return Some(job);
    }
    rows(record, option).all(|row| row.0 != word).then_some(word)
}

fn rows<'a>(record: &'a str, option: &'a str) -> impl Iterator<Item = (&'static str, Option<&'static str>)> + 'a {
    let is_of = move |row: &&(&str, &str, &str, Option<&str>)| row.0 == record && row.1 == option;
    WORDS.iter().filter(is_of).map(|row| (row.2, row.3))
}

/// What an option of a job is called in the package, whichever record has it.
pub(crate) fn spelling(name: &str) -> String {
    let row = NAMES.iter().find(|(_, option, _)| *option == name);
    row.map_or_else(|| camel_case(name), |(_, _, own)| (*own).to_owned())
}

/// `max-error` as `maxError`.
fn camel_case(name: &str) -> String {
    let mut words = name.split('-');
    let first = words.next().unwrap_or_default().to_owned();
    words.fold(first, |name, word| {
        let (initial, rest) = word.split_at(word.len().min(1));
        name + &initial.to_uppercase() + rest
    })
}
