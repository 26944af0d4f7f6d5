//! The names of job options in the package. `tools/bindings` generates the TypeScript types from the same tables.

/// Options with another name: record, name in a job, name in the package. Other names are converted to camel case.
const NAMES: &[(&str, &str, &str)] = &[
    ("InputOptions", "from", "format"),
    ("Sources", "map", "bones"),
    ("SourceFrames", "fps", "frameRate"),
    ("SourceFrames", "drop-first-frame", "firstFrame"),
];

/// Options of a job that calls do not take: files of other calls, and options with a separate form in calls.
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

/// Words with another name: record, option, word in a job, word in the package; `None` if calls do not take the word.
const WORDS: &[(&str, &str, &str, Option<&str>)] = &[
    ("SourceFrames", "drop-first-frame", "no", Some("keep")),
    ("SourceFrames", "drop-first-frame", "yes", Some("drop")),
    ("SourceFrames", "root", "in-place", Some("inPlace")),
    ("SizeOptions", "compress", "meshopt", None),
    ("SizeOptions", "compress", "meshopt-khr", None),
];

/// The name of a record's option in the package; `None` if calls do not take the option.
pub(crate) fn option(record: &str, name: &str) -> Option<String> {
    let is_left_out = |(own, names): &(&str, &[&str])| *own == record && names.contains(&name);
    if LEFT_OUT.iter().any(is_left_out) {
        return None;
    }
    let row = NAMES.iter().find(|(own, option, _)| *own == record && *option == name);
    Some(row.map_or_else(|| camel_case(name), |(_, _, own)| (*own).to_owned()))
}

/// The package's word for a word of a job; `None` if calls do not take the word.
pub(crate) fn word<'a>(record: &str, option: &str, word: &'a str) -> Option<&'a str> {
    match rows(record, option).find(|row| row.0 == word) {
        Some((_, own)) => own,
        None => Some(word),
    }
}

/// The job's word for a word of the package; `None` for a word that only jobs have.
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

/// The name of a job's option in the package, for any record.
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
