//! The list of commands.

use clap::CommandFactory;
use mocap_cli::internals::{Args, GROUPS, grouped};

#[test]
fn every_command_is_listed_once_and_every_group_names_commands() {
    let command = Args::command();
    let help = grouped(command.clone()).render_help().to_string();
    for subcommand in command.get_subcommands() {
        let entry = format!("\n  {} ", subcommand.get_name());
        assert_eq!(help.matches(&entry).count(), 1, "{}\n{help}", subcommand.get_name());
    }
    for name in GROUPS.iter().flat_map(|(_, names)| *names) {
        assert!(command.find_subcommand(name).is_some(), "{name} is no command");
    }
}
