//! One grammar: an option that several commands have takes the same value in each, and `docs/options.md` lists them.

use std::collections::BTreeMap;
use std::fs;

use clap::{Arg, Command, CommandFactory};
use mocap_cli::internals::{Args, arranged};

const DOCUMENT: &str = "../../docs/options.md";

/// Options whose values differ between commands on purpose, and why.
const DIFFERENT: [(&str, &str); 2] = [
    (
        "output",
        "where the output goes: of some commands a file, of some a folder, of some either",
    ),
    (
        "threshold",
        "how much is too much: the distance of two poses, or the size of a defect",
    ),
];

/// An option as a command has it.
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

/// `MOCAP_WRITE=1` writes the table.
#[test]
fn the_table_of_options_is_that_of_the_program() {
    let mut text = String::from(
        "# Options\n\nEach option of the program, with its value and the commands that have it. An option has one meaning: where \
         several commands\nhave it, it takes the same value in each. `MOCAP_WRITE=1 cargo test -p mocap-cli \
         --features parquet one_meaning` writes\nthis table, and a test holds it.\n\n| option | value | commands | meaning |\n|---|---|---|---|\n",
    );
    for (option, uses) in uses() {
        if option == "help" || option == "version" {
            continue;
        }
        let different = DIFFERENT.iter().find(|(known, _)| *known == option);
        let meaning = different.map_or_else(|| in_short(&uses[0].help), |(_, why)| (*why).to_owned());
        let mut values: Vec<&str> = uses.iter().map(|one| one.value.as_str()).collect();
        values.sort_unstable();
        values.dedup();
        let values: Vec<String> = values
            .into_iter()
            .filter(|value| !value.is_empty())
            .map(|value| format!("`{}`", value.replace('|', "\\|")))
            .collect();
        let commands: Vec<&str> = uses.iter().map(|one| one.command.as_str()).collect();
        text += &format!(
            "| `--{option}` | {} | {} | {} |\n",
            values.join(", "),
            commands.join(", "),
            meaning.replace('|', "\\|")
        );
    }
    if std::env::var_os("MOCAP_WRITE").is_some() {
        fs::write(DOCUMENT, &text).unwrap();
        return;
    }
    let written = fs::read_to_string(DOCUMENT).unwrap();
    assert!(
        written == text,
        "MOCAP_WRITE=1 cargo test -p mocap-cli --features parquet one_meaning writes {DOCUMENT}"
    );
}

/// The first sentence of a help, or its first clause.
fn in_short(help: &str) -> String {
    let help = help.lines().collect::<Vec<_>>().join(" ");
    let end = [". ", "; ", ": ", " ["].iter().filter_map(|end| help.find(end)).min();
    help[..end.unwrap_or(help.len())].to_owned()
}
