//! An option of several commands takes the same values in each. `docs/options.md` lists these options.

use std::collections::BTreeMap;
use std::fs;

use clap::{Arg, Command, CommandFactory};
use mocap_cli::internals::{Args, arranged};

const DOCUMENTS: [&str; 2] = ["../../docs/options.md", "../../docs/options-of-one-command.md"];

/// Options whose values intentionally differ between commands, with reasons.
const DIFFERENT: [(&str, &str); 1] = [(
    "threshold",
    "`graph`: the largest distance of two similar poses. `survey`: the size from which a defect counts",
)];

/// The meaning of options whose help texts differ between commands.
const MEANINGS: [(&str, &str); 13] = [
    (
        "clean",
        "Remove noise. `record` cleans the whole recording, as `mocap clean` does",
    ),
    ("json", "Print the result as JSON"),
    (
        "max-error",
        "Largest distance of a joint from its position in the source, such as 1mm. A writing command removes keys and bits within this distance",
    ),
    ("output", "The file to write"),
    ("path", "The path over the ground, through these points in metres"),
    (
        "rate",
        "Frames per second of the comparison, of the playback, or of the GIF",
    ),
    (
        "report",
        "Write a report to this file: `robot` a .parquet table with a row for each motion, `clean` JSON",
    ),
    (
        "resume",
        "Skip unchanged inputs that an earlier run has processed with the same options",
    ),
    (
        "root-motion",
        "Move the horizontal translation and the heading of the figure to a joint above the hips",
    ),
    ("seconds", "Duration of the walk or of the recording, in seconds"),
    ("trim", "Part to keep or to show, both ends included"),
    (
        "where",
        "Use only the clips for which this is true, such as \"skate < 1 and not twin\"",
    ),
    (
        "with",
        "A second motion, which a step joins, blends or layers with the input",
    ),
];

/// Positional arguments that are neither inputs nor outputs.
const OTHERS: [(&str, &str); 4] = [
    ("chain", "JOINT"),
    ("dump", "SECTIONS"),
    ("completions", "SHELL"),
    ("man", "COMMAND"),
];

/// Options that name the body to which motions are retargeted.
const TARGETS: [&str; 3] = ["character", "robot", "to-skeleton"];

/// An option of a command.
struct Use {
    command: String,
    value: String,
    help: String,
}

fn uses() -> BTreeMap<String, Vec<Use>> {
    let mut found = BTreeMap::new();
    collect(&arranged(Args::command()), "", &mut found);
    found
}

fn collect(command: &Command, words: &str, found: &mut BTreeMap<String, Vec<Use>>) {
    for arg in command.get_arguments().filter(|arg| !arg.is_hide_set()) {
        if let Some(long) = arg.get_long().filter(|_| !words.is_empty()) {
            found.entry(long.to_owned()).or_default().push(Use {
                command: words.to_owned(),
                value: value(arg),
                help: arg.get_help().map_or_else(String::new, ToString::to_string),
            });
        }
    }
    for inner in command.get_subcommands().filter(|inner| inner.get_name() != "help") {
        collect(inner, format!("{words} {}", inner.get_name()).trim(), found);
    }
}

fn value(arg: &Arg) -> String {
    if !arg.get_action().takes_values() {
        return String::new();
    }
    let names = arg.get_value_names().unwrap_or_default().iter();
    names.map(ToString::to_string).collect::<Vec<_>>().join(" ")
}

/// Every command, with its words.
fn commands(command: &Command, words: &str) -> Vec<(String, Command)> {
    let inner = command.get_subcommands().filter(|inner| inner.get_name() != "help");
    let below = inner.flat_map(|inner| commands(inner, format!("{words} {}", inner.get_name()).trim()));
    std::iter::once((words.to_owned(), command.clone()))
        .chain(below)
        .collect()
}

/// Inputs are called `INPUT`, the bodies to which motions are retargeted `TARGET`, and outputs `OUTPUT`.
#[test]
fn inputs_targets_and_outputs_have_one_word_each() {
    let (mut counts, all) = ([0; 3], commands(&arranged(Args::command()), ""));
    for (name, command) in &all {
        for arg in command.get_arguments().filter(|arg| !arg.is_hide_set()) {
            let (word, id) = (value(arg), arg.get_id());
            let option = arg.get_long();
            match option {
                None => {
                    let is_other = OTHERS.contains(&(name, &word));
                    assert!(
                        is_other || ["INPUT", "OUTPUT"].contains(&word.as_str()),
                        "{name}: {id} is {word}"
                    );
                    counts[0] += usize::from(word == "INPUT");
                }
                Some("output") => {
                    assert_eq!((word.as_str(), arg.get_short()), ("OUTPUT", Some('o')), "{name}");
                    counts[2] += 1;
                }
                Some(option) if TARGETS.contains(&option) => {
                    assert_eq!(word, "TARGET", "{name} --{option}");
                    counts[1] += 1;
                }
                Some(option) => {
                    assert!(
                        !["INPUT", "OUTPUT", "TARGET"].contains(&word.as_str()),
                        "{name} --{option}"
                    );
                }
            }
        }
    }
    assert!(counts.iter().all(|count| *count > 8), "{counts:?}");
    // The old names still work.
    for (line, name, id) in [
        ("convert a.bvh --out-dir b/", "convert", "out_dir"),
        ("graph a.bvh -o a.json --on b.bvh", "graph", "on"),
        ("bridge vmc:0 --onto b.vrm --vmc 1", "bridge", "onto"),
    ] {
        let found = Args::command().get_matches_from(std::iter::once("mocap").chain(line.split(' ')));
        let (command, matches) = found.subcommand().unwrap();
        assert!(command == name && matches.get_raw(id).is_some(), "{line}");
    }
}

#[test]
fn an_option_takes_the_same_value_in_every_command() {
    let mut wrong = Vec::new();
    for (option, uses) in uses() {
        let is_known = DIFFERENT.iter().any(|(known, _)| *known == option);
        let is_same = uses.iter().all(|one| one.value == uses[0].value);
        if is_same == is_known {
            let values = uses.iter().map(|one| format!("{} {}", one.command, one.value));
            wrong.push(format!("--{option}: {}", values.collect::<Vec<_>>().join("; ")));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The largest number of commands in a list. A longer list is replaced by the number of its group.
const LONGEST_LIST: usize = 6;

const SHARED: &str = "# Options

This page lists the options that several commands have. An option takes the same values in all of its commands, except
`--threshold`. [Options of one command](options-of-one-command.md) lists the other options. In the column of
commands, a number is the number of a group in this list:

| group | commands |
|---|---|
";

const OWN: &str = "# Options of one command

This page lists the options that only one command has. [Options](options.md) lists the options that several commands
have.

| command | option | value | meaning |
|---|---|---|---|
";

/// The pages of options with several commands, and with one.
fn pages() -> [String; 2] {
    let (mut rows, mut own, mut groups) = (String::new(), Vec::new(), Vec::new());
    for (option, uses) in uses() {
        if option == "help" || option == "version" {
            continue;
        }
        let common = DIFFERENT.iter().chain(&MEANINGS).find(|(known, _)| *known == option);
        let meaning = common.map_or_else(|| in_short(&uses[0].help), |(_, meaning)| (*meaning).to_owned());
        let mut values: Vec<&str> = uses.iter().map(|one| one.value.as_str()).collect();
        values.sort_unstable();
        values.dedup();
        let values: Vec<String> = values
            .into_iter()
            .filter(|value| !value.is_empty())
            .map(|value| format!("`{}`", value.replace('|', "\\|")))
            .collect();
        let (values, meaning) = (values.join(", "), meaning.replace('|', "\\|"));
        let commands: Vec<&str> = uses.iter().map(|one| one.command.as_str()).collect();
        match commands[..] {
            [command] => own.push(format!("| {command} | `--{option}` | {values} | {meaning} |\n")),
            _ => {
                rows += &format!(
                    "| `--{option}` | {values} | {} | {meaning} |\n",
                    listed(&commands, &mut groups)
                );
            }
        }
    }
    own.sort();
    let numbered = groups.iter().enumerate();
    let groups: String = numbered
        .map(|(index, group)| format!("| {} | {group} |\n", index + 1))
        .collect();
    let head = "\n| option | value | commands | meaning |\n|---|---|---|---|\n";
    [
        format!("{SHARED}{groups}{head}{rows}"),
        format!("{OWN}{}", own.concat()),
    ]
}

/// A short list of commands, or the number of its group.
fn listed(commands: &[&str], groups: &mut Vec<String>) -> String {
    let list = commands.join(", ");
    if commands.len() <= LONGEST_LIST {
        return list;
    }
    let known = groups.iter().position(|group| *group == list);
    let index = known.unwrap_or_else(|| {
        groups.push(list);
        groups.len() - 1
    });
    (index + 1).to_string()
}

/// `MOCAP_WRITE=1` writes the tables.
#[test]
fn the_tables_of_options_are_those_of_the_program() {
    for (document, text) in DOCUMENTS.iter().zip(pages()) {
        if std::env::var_os("MOCAP_WRITE").is_some() {
            fs::write(document, &text).unwrap();
        }
        assert!(
            fs::read_to_string(document).unwrap_or_default() == text,
            "MOCAP_WRITE=1 cargo test -p mocap-cli --features parquet one_meaning writes {document}"
        );
    }
}

/// The first sentence of a help, or its first clause.
fn in_short(help: &str) -> String {
    let help = help.lines().collect::<Vec<_>>().join(" ");
    let end = [". ", "; ", ": ", " ["].iter().filter_map(|end| help.find(end)).min();
    help[..end.unwrap_or(help.len())].to_owned()
}
