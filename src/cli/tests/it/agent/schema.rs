//! Options of the tools.

use mocap_cli::internals::{Commands, TOOLS};

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
