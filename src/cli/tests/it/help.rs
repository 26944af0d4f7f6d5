//! Help texts: the list of commands, and the first options of each command.

use std::fs;
use std::process::Stdio;

use clap::{Command, CommandFactory};
use mocap_cli::internals::{Args, GROUPS, GUIDES, arranged};

use crate::at_root;
use crate::cut;
use crate::program::{Folder, command_in, words};

#[test]
fn every_command_is_listed_once_and_every_group_names_commands() {
    let command = Args::command();
    let help = arranged(command.clone()).render_long_help().to_string();
    for subcommand in command.get_subcommands() {
        let entry = format!("\n  {} ", subcommand.get_name());
        assert_eq!(help.matches(&entry).count(), 1, "{}\n{help}", subcommand.get_name());
    }
    for name in GROUPS.iter().flat_map(|(_, names)| *names) {
        assert!(command.find_subcommand(name).is_some(), "{name} is no command");
    }
}

/// `mocap -h` lists every command, the most used first, in at most 40 lines.
#[test]
fn the_short_help_of_the_program_has_40_lines() {
    const MOST_LINES: usize = 40;
    let folder = Folder::with(&[]);
    let help = String::from_utf8(folder.run("-h").stdout).unwrap();
    assert!(help.lines().count() <= MOST_LINES, "{}\n{help}", help.lines().count());
    let (before, first) = help.split_once("Most used:\n").unwrap();
    assert!(before.lines().count() <= 6, "{help}");
    let first = first.lines().take_while(|line| !line.is_empty());
    let described = Vec::from_iter(
        first
            .filter(|line| !line.starts_with("   "))
            .filter_map(|line| line.split_whitespace().next()),
    );
    assert!(
        described.starts_with(&["convert", "retarget"]) && described.len() == 8,
        "{described:?}"
    );
    for command in Args::command().get_subcommands() {
        let mut words = help.split([' ', ',', '\n']);
        assert!(
            words.any(|word| word == command.get_name()),
            "{}\n{help}",
            command.get_name()
        );
    }
    // The program without arguments prints the same help.
    let without = folder.run("");
    assert!(words(&without).lines().count() <= MOST_LINES, "{}", words(&without));
}

/// All commands and subcommands with their words.
fn commands() -> Vec<(String, Command)> {
    fn add(command: &Command, before: &str, all: &mut Vec<(String, Command)>) {
        for command in command.get_subcommands() {
            let words = format!("{before}{}", command.get_name());
            add(command, &format!("{words} "), all);
            // A build without Parquet has no help of this command.
            if command.get_name() != "help" && !command.is_disable_help_flag_set() {
                all.push((words, command.clone()));
            }
        }
    }
    let mut command = arranged(Args::command());
    command.build();
    let mut all = Vec::new();
    add(&command, "", &mut all);
    assert!(all.len() > 33, "{}", all.len());
    all
}

/// The options of a help text, in order.
fn options(help: &str) -> Vec<&str> {
    let named = help.lines().filter_map(|line| match line.strip_prefix("      --") {
        Some(name) => Some(name),
        // Options with a letter, such as ` -o, --output`.
        None => line.strip_prefix("  -")?.get(1..)?.strip_prefix(", --"),
    });
    named
        .map(|name| {
            name.split(|c: char| !c.is_ascii_alphanumeric() && c != '-')
                .next()
                .unwrap()
        })
        .collect()
}

#[test]
fn a_short_help_has_40_lines_and_the_options_that_are_used_most() {
    const MOST_LINES: usize = 40;
    let folder = Folder::with(&[]);
    for (name, _) in commands() {
        let guide = GUIDES.iter().find(|guide| guide.command == name);
        let guide = guide.unwrap_or_else(|| panic!("{name} has no guide"));
        assert!(guide.options.len() <= 6, "{name}");
        let short = String::from_utf8(folder.run(&format!("{name} -h")).stdout).unwrap();
        assert!(
            short.lines().count() <= MOST_LINES,
            "{name}: {}\n{short}",
            short.lines().count()
        );
        let wanted = [guide.options, &["quiet", "help"]].concat();
        let mut shown = options(&short);
        assert_eq!(
            shown.iter().filter(|name| wanted.contains(name)).count(),
            wanted.len(),
            "{short}"
        );
        shown.retain(|name| !["quiet", "help"].contains(name));
        assert_eq!(shown, guide.options, "{name}");
        let long = String::from_utf8(folder.run(&format!("{name} --help")).stdout).unwrap();
        let all: Vec<&str> = options(&long);
        assert_eq!(all[..guide.options.len()], *guide.options, "{name}");
    }
    // The output option comes first, after required options.
    for guide in GUIDES {
        let place = guide.options.iter().position(|name| *name == "output");
        assert!(
            place.is_none_or(|place| place == 0 || guide.command == "plot"),
            "{}",
            guide.command
        );
    }
}

#[test]
fn options_stand_under_their_own_headings() {
    for (name, command) in commands() {
        for (option, heading) in [
            ("out-unit", "Writing"),
            ("out-up", "Writing"),
            ("force", "Options"),
            ("verify", "Options"),
            ("velocities", "Arrays"),
            ("print-job", "Instead of writing"),
            ("compress", "Smaller files"),
        ] {
            let arg = command.get_arguments().find(|arg| arg.get_long() == Some(option));
            let found = arg.map_or(heading, |arg| arg.get_help_heading().unwrap_or("Options"));
            let is_alone = ["graph", "survey"].contains(&name.as_str()) && option == "print-job";
            assert!(found == heading || is_alone, "{name} --{option}: {found}");
        }
    }
}

#[test]
fn no_help_has_the_marks_of_the_library_s_pages() {
    for (name, mut command) in commands() {
        let help = command.render_long_help().to_string();
        for mark in ["](", "[`", "`]", "::", "crate", "rustdoc"] {
            assert!(!help.contains(mark), "{name}: {mark}\n{help}");
        }
    }
}

/// The examples of a help: the words after `mocap`, and the file that takes standard output.
fn examples(help: &str) -> Vec<(String, Option<String>)> {
    let (_, after) = help.split_once("\nExamples:\n").unwrap();
    let lines = after.lines().take_while(|line| line.starts_with("  mocap "));
    let parts = lines.map(|line| {
        let (line, _) = line.split_once("  #").unwrap();
        let line = line.trim().strip_prefix("mocap ").unwrap();
        match line.split_once(" > ") {
            Some((line, file)) => (line.to_owned(), Some(file.to_owned())),
            None => (line.to_owned(), None),
        }
    });
    parts.collect()
}

/// The files that the examples name.
fn folder_of_examples() -> Folder {
    let folder = Folder::of_real(&[]);
    for (name, file) in [
        ("walk.bvh", "fixtures/real/cmu_12_01_walk.bvh"),
        ("hero.glb", "fixtures/characters/human_default.glb"),
        ("h1.urdf", "fixtures/robots/h1.urdf"),
        ("trial.c3d", "fixtures/markers/cmu_01_01.c3d"),
        ("plates.c3d", "fixtures/made/plates.c3d"),
    ] {
        folder.write(name, &fs::read(at_root(file)).unwrap());
    }
    const FRAMES: usize = 120;
    for name in ["run.bvh", "takes/first.bvh", "takes/second.bvh"] {
        folder.write(name, cut::first_frames("real/cmu_12_01_walk.bvh", FRAMES).as_bytes());
    }
    folder
}

/// Every example in the help works. Examples that send or wait for a stream are only parsed.
#[test]
fn every_example_works() {
    let folder = folder_of_examples();
    for guide in GUIDES {
        let help = String::from_utf8(folder.run(&format!("{} --help", guide.command)).stdout).unwrap();
        let examples = examples(&help);
        assert_eq!(examples.len(), 2, "{help}");
        for (line, file) in examples {
            if ["record", "play", "bridge"].contains(&guide.command) {
                let words = std::iter::once("mocap").chain(line.split(' '));
                let parsed = Args::command().try_get_matches_from(words);
                assert!(parsed.is_ok(), "{line}: {}", parsed.unwrap_err());
                continue;
            }
            let run = command_in(&folder.path("."), &line).stdin(Stdio::null()).output();
            let output = run.unwrap();
            assert!(output.status.success(), "mocap {line}: {}", words(&output));
            if let Some(file) = file {
                assert!(!output.stdout.is_empty(), "{line}");
                folder.write(&file, &output.stdout);
            }
        }
    }
    let first = String::from_utf8(folder.run("--help").stdout).unwrap();
    assert_eq!(examples(&first).len(), 2, "{first}");
}

/// Every shell has completions of commands and options. The test runs bash if it is installed.
#[test]
fn shells_complete_commands_and_options() {
    let folder = Folder::with(&[]);
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = folder.run(&format!("completions {shell}")).stdout;
        let script = String::from_utf8(script).unwrap();
        for word in ["convert", "max-error", "retarget"] {
            assert!(script.contains(word), "{shell}: {word}");
        }
        folder.write(&format!("completions.{shell}"), script.as_bytes());
    }
    let ask = r#"source completions.bash
        COMP_WORDS=(mocap convert --max-e); COMP_CWORD=2; COMPREPLY=()
        _mocap mocap --max-e convert; echo "${COMPREPLY[*]}"
        COMP_WORDS=(mocap retar); COMP_CWORD=1; COMPREPLY=()
        _mocap mocap retar mocap; echo "${COMPREPLY[*]}""#;
    let asked = std::process::Command::new("bash")
        .args(["-c", ask])
        .current_dir(folder.path("."))
        .output();
    if let Ok(asked) = asked {
        assert_eq!(String::from_utf8(asked.stdout).unwrap(), "--max-error\nretarget\n");
    }
    folder.refuses(
        "completions tcsh",
        2,
        "possible values: bash, elvish, fish, powershell, zsh",
    );
}

#[test]
fn every_command_has_a_manual_page() {
    let folder = Folder::with(&[]);
    folder.succeeds("man -o pages");
    for (name, command) in commands() {
        let page = format!("mocap-{}", name.replace(' ', "-"));
        let text = String::from_utf8(folder.read(&format!("pages/{page}.1"))).unwrap();
        assert!(text.contains(&format!(".TH {page} 1")), "{name}");
        let shown = String::from_utf8(folder.run(&format!("man {name}")).stdout).unwrap();
        assert_eq!(shown, text, "{name}");
        for option in command.get_arguments().filter_map(clap::Arg::get_long) {
            let is_hidden = command
                .get_arguments()
                .any(|arg| arg.get_long() == Some(option) && arg.is_hide_set());
            assert!(
                is_hidden || text.contains(&option.replace('-', "\\-")),
                "{name} --{option}"
            );
        }
        assert!(text.contains("Examples:"), "{name}");
    }
    assert!(folder.read("pages/mocap.1").starts_with(b".ie"));
    folder.refuses("man conver", 2, "there is no command conver; did you mean convert?");
}

/// A quiet check only prints files with problems.
#[test]
fn a_quiet_check_says_nothing_of_good_files() {
    let folder = Folder::of_real(&["lecture_Test.bvh", "brekel_wrong_row_length.bvh"]);
    folder.write("broken.bvh", b"HIERARCHY\nROOT");
    assert!(folder.run("check lecture_Test.bvh -q").stdout.is_empty());
    let said = String::from_utf8(folder.run("check . -q").stdout).unwrap();
    assert!(
        !said.contains("lecture_Test.bvh") && said.contains("broken.bvh: 1 error"),
        "{said}"
    );
    let loud = String::from_utf8(folder.run("check .").stdout).unwrap();
    assert!(loud.contains("lecture_Test.bvh: ok"), "{loud}");
}
