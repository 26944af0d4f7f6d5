//! `mocap --help`: the commands in groups, by what a person wants to do.

use clap::Command;
use clap::builder::StyledStr;

/// The groups in their order, each with its commands in theirs.
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
        &["fk", "angles", "gait", "forces", "analog", "pack", "pose", "dump"],
    ),
    ("Prove", &["check", "survey", "verify"]),
];

/// The heading of the commands that no group names.
const OTHER: &str = "Other";

/// The command with its subcommands listed in groups. clap has headings for options alone, so the list that it makes is
/// taken apart, with its styles and line breaks.
pub fn grouped(command: Command) -> Command {
    let listing = command
        .clone()
        .disable_help_subcommand(true)
        .help_template("{subcommands}");
    let entries = entries(&listing.clone().render_help());
    let headings = command.get_styles().get_header();
    let mut template = String::from("{about-with-newline}\n{usage-heading} {usage}\n");
    let mut add = |heading: &str, lines: String| {
        if !lines.is_empty() {
            template.push_str(&format!("\n{headings}{heading}:{headings:#}\n{lines}"));
        }
    };
    let lines_of = |wanted: &str| {
        let found = entries.iter().find(|(name, _)| name == wanted);
        found.map_or("", |(_, lines)| lines.as_str())
    };
    for (heading, names) in GROUPS {
        add(heading, names.iter().map(|name| lines_of(name)).collect());
    }
    let is_grouped = |name: &str| GROUPS.iter().any(|(_, names)| names.contains(&name));
    let others = entries.iter().filter(|(name, _)| !is_grouped(name));
    add(OTHER, others.map(|(_, lines)| lines.as_str()).collect());
    add("Options", "{options}".to_owned());
    template.push_str("{after-help}");
    command.help_template(template)
}

/// The names of the commands in a list of them, each with its lines.
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
