//! Tests that the options of the tools of `mocap mcp` are the options of the commands.

use mocap_cli::internals::{ABOUT, Commands, TOOLS};

#[test]
fn every_option_of_a_tool_is_one_of_its_command() {
    let commands = Commands::default();
    for tool in TOOLS {
        for option in tool.options {
            assert!(
                commands.schema(tool, option).is_some(),
                "{} has no --{option}",
                tool.name
            );
        }
        assert!(commands.command(tool).is_some(), "{}", tool.name);
    }
}

/// Every text belongs to an option of a tool.
#[test]
fn every_text_about_an_option_is_read() {
    for (name, _) in ABOUT {
        let is_read = TOOLS.iter().any(|tool| {
            let mut options = tool.options.iter();
            options.any(|option| option == name || format!("{} {option}", tool.name) == *name)
        });
        assert!(is_read, "{name}");
    }
}
