//! Arranges the help: commands in groups by the user's goal, and the most used options of a command first.

use clap::builder::{Resettable, StyledStr};
use clap::{Arg, Command};

use super::edit;
use super::guides::{FIRST, GUIDES, Guide};

/// The groups and their commands, in the order of the help.
pub const GROUPS: &[(&str, &[&str])] = &[
    (
        "Convert and change",
        &["convert", "retarget", "robot", "edit", "clean", "graph", "solve", "run"],
    ),
    ("Search", &["index", "find", "match"]),
    ("Stream", &["record", "play", "bridge"]),
    ("Look", &["view", "info", "skeleton", "sheet", "gif", "plot"]),
    (
        "Compute",
        &[
            "fk", "angles", "gait", "forces", "analog", "pack", "pose", "chain", "dump",
        ],
    ),
    ("Check and compare", &["check", "survey", "verify", "score"]),
];

/// The most used commands: `mocap -h` describes them.
const MOST_USED: [&str; 8] = [
    "convert", "retarget", "robot", "edit", "clean", "view", "info", "verify",
];

/// The heading of the commands without a group.
const OTHER: &str = "Other";

/// The command with its help arranged.
pub fn arranged(command: Command) -> Command {
    let command = guided(grouped(command), "");
    let (examples, exit_codes) = (examples(&FIRST), super::EXIT_CODES);
    command
        .after_long_help(format!("{examples}\n\n{exit_codes}"))
        .after_help(examples)
        .mut_arg("quiet", |quiet| quiet.display_order(LAST))
}

/// The display order of options outside a guide. No guide has this many options.
const LATER: usize = 100;

/// The display order of the last options.
const LAST: usize = 1000;

/// A command with the guides of all its subcommands. `words` are the words before a subcommand.
fn guided(command: Command, words: &str) -> Command {
    command.mut_subcommands(|command| {
        let words = format!("{words}{}", command.get_name());
        let command = match GUIDES.iter().find(|guide| guide.command == words) {
            Some(guide) => with_guide(command, guide),
            None => command,
        };
        guided(command, &format!("{words} "))
    })
}

fn with_guide(command: Command, guide: &Guide) -> Command {
    let mut place = LATER;
    let arranged = |arg: Arg| {
        let name = arg.get_long();
        place += 1;
        match guide.options.iter().position(|option| Some(*option) == name) {
            _ if arg.is_positional() => arg,
            Some(first) => arg.display_order(first).help_heading(Resettable::Reset),
            None => arg.display_order(place).hide_short_help(true),
        }
    };
    let examples = examples(&guide.examples);
    let command = command.mut_args(arranged);
    let (short, long) = match guide.command {
        "edit" => (
            format!("{}\n\n", edit::names_of_steps()),
            format!("\n\n{}", edit::steps()),
        ),
        _ => (String::new(), String::new()),
    };
    command
        .after_help(format!("{short}{examples}"))
        .after_long_help(format!("{examples}{long}"))
}

/// Command lines, with their effects in a second column.
fn examples(lines: &[(&str, &str)]) -> String {
    let width = lines.iter().map(|(line, _)| line.len()).max().unwrap_or_default();
    let lines = lines
        .iter()
        .map(|(line, about)| format!("\n  mocap {line:<width$}  # {about}"));
    format!("Examples:{}", lines.collect::<String>())
}

/// Lists the subcommands: `-h` describes the most used ones and names the others; `--help` describes all, in groups.
/// clap has headings only for options, so this function splits clap's list, with its styles and line breaks.
fn grouped(command: Command) -> Command {
    let listing = command
        .clone()
        .disable_help_subcommand(true)
        .help_template("{subcommands}");
    let entries = entries(&listing.clone().render_help());
    let lines_of = |wanted: &str| {
        let found = entries.iter().find(|(name, _)| name == wanted);
        found.map_or("", |(_, lines)| lines.as_str())
    };
    let is_grouped = |name: &str| GROUPS.iter().any(|(_, names)| names.contains(&name));
    let others = entries.iter().map(|(name, _)| name.as_str());
    let others = Vec::from_iter(others.filter(|name| !is_grouped(name)));
    let groups = || GROUPS.iter().copied().chain([(OTHER, others.as_slice())]);
    let styles = command.get_styles().clone();
    let (heading, literal) = (styles.get_header(), styles.get_literal());
    let headed = |name: &str, lines: &str| format!("{heading}{name}:{heading:#}\n{}\n", lines.trim_end());

    let width = groups().map(|(name, _)| name.len()).max().unwrap_or_default();
    let rest = groups().map(|(name, commands)| {
        let is_rest = |command: &&&str| !MOST_USED.contains(*command) && !lines_of(command).is_empty();
        let rest = commands.iter().filter(is_rest);
        let rest = Vec::from_iter(rest.map(|command| format!("{literal}{command}{literal:#}")));
        format!("  {name:<width$}  {}\n", rest.join(", "))
    });
    let most_used = headed("Most used", &MOST_USED.map(lines_of).concat());
    let rest = headed("Other commands, each with its own -h", &rest.collect::<String>());
    let all = groups().map(|(name, commands)| {
        let lines = commands.iter().map(|command| lines_of(command));
        headed(name, &lines.collect::<String>())
    });
    let all = all.collect::<Vec<_>>().join("\n");
    command
        .before_help(format!("{most_used}\n{}", rest.trim_end()))
        .before_long_help(all.trim_end().to_owned())
        .help_template(format!(
            "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{{before-help}}{heading}Options:{heading:#}\n{{options}}{{after-help}}"
        ))
}

/// The names of the listed commands, each with its lines.
fn entries(listing: &StyledStr) -> Vec<(String, String)> {
    let (plain, styled) = (listing.to_string(), listing.ansi().to_string());
    let mut entries: Vec<(String, String)> = Vec::new();
    for (plain, styled) in plain.lines().zip(styled.lines()) {
        let is_first = plain.starts_with("  ") && !plain[2..].starts_with(' ');
        match entries.last_mut() {
            Some((_, lines)) if !is_first => lines.push_str(&format!("{styled}\n")),
            _ => {
                let name = plain.split_whitespace().next().unwrap_or_default().to_owned();
                entries.push((name, format!("{styled}\n")));
            }
        }
    }
    entries
}
