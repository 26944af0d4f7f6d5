//! Lengths on the command line need a unit, because `1` would be a metre. Times may have a unit.

use std::collections::BTreeSet;

use clap::{Arg, Command, CommandFactory};
use mocap::edit::{EditStep, ValueKind};
use mocap_cli::internals::Args;

use crate::program::{Folder, words};

/// The error of an argument's value.
fn refusal(arg: &Arg, value: &str) -> Option<String> {
    let parser = arg.get_value_parser().clone();
    let alone = Command::new("it").arg(Arg::new("value").value_parser(parser));
    let parsed = alone.try_get_matches_from(["it", value]);
    parsed.err().map(|error| error.to_string())
}

fn add_lengths(command: &Command, names: &mut BTreeSet<String>) {
    let lengths = command
        .get_arguments()
        .filter(|arg| arg.get_value_names().is_some_and(|names| names[0] == "LENGTH"));
    for arg in lengths {
        let name = format!("{} --{}", command.get_name(), arg.get_long().unwrap());
        let said = refusal(arg, "1").unwrap_or_default();
        assert!(said.contains("did you mean 1mm? For metres write 1m"), "{name}: {said}");
        let said = refusal(arg, "0.02").unwrap_or_default();
        assert!(
            said.contains("did you mean 20mm? For metres write 0.02m"),
            "{name}: {said}"
        );
        assert!(refusal(arg, "wide").unwrap().contains("such as 1mm"), "{name}");
        for length in ["0", "1mm", "0.5 cm", "20um", "1m"] {
            assert_eq!(refusal(arg, length), None, "{name}");
        }
        names.insert(arg.get_long().unwrap().to_owned());
    }
    command
        .get_subcommands()
        .for_each(|command| add_lengths(command, names));
}

#[test]
fn every_length_needs_its_unit() {
    let mut names = BTreeSet::new();
    add_lengths(&Args::command(), &mut names);
    let names: Vec<_> = names.iter().map(String::as_str).collect();
    assert_eq!(names, ["contact-height", "max-error", "shell-distance", "threshold"]);
}

#[test]
fn every_length_of_a_step_needs_its_unit() {
    let command = Args::command();
    let edit = command.find_subcommand("edit").unwrap();
    let step = edit.get_arguments().find(|arg| arg.get_id() == "step").unwrap();
    let mut tried = 0;
    for info in EditStep::ALL {
        for key in info.keys.iter().filter(|key| key.takes == ValueKind::Metres) {
            for name in [key.name(), key.field.to_owned()] {
                let said = refusal(step, &format!("{}:{name}=5", info.name)).unwrap_or_default();
                assert!(
                    said.contains(&format!("{name}=5: a length needs a unit: did you mean 5mm?")),
                    "{said}"
                );
                assert_eq!(refusal(step, &format!("{}:{name}=5cm", info.name)), None);
            }
            tried += 1;
        }
    }
    assert!(tried >= 4, "{tried}");
    // A step is printed in the form of the command line.
    let printed = "foot-lock:height=5cm,largest-change=2cm"
        .parse::<EditStep>()
        .unwrap()
        .to_string();
    assert!(printed.contains("height=0.05m"), "{printed}");
    assert_eq!(refusal(step, &printed), None);
}

#[test]
fn a_bare_length_stops_a_command_and_metres_in_a_job_do_not() {
    let folder = Folder::of_real(&["lecture_Test.bvh"]);
    for arguments in [
        "convert lecture_Test.bvh out.glb --max-error 1",
        "convert lecture_Test.bvh out.glb --max-error 1mm --shell-distance 3",
        "edit lecture_Test.bvh -o out.bvh --step foot-lock:height=5",
        "edit lecture_Test.bvh -o out.bvh --step foot-lock:blend=0.1,largest-change=0.5",
        "fk lecture_Test.bvh -o out.csv --contacts --contact-height 5",
        "verify lecture_Test.bvh lecture_Test.bvh --max-error .001",
    ] {
        folder.refuses(arguments, 2, "a length needs a unit: did you mean ");
    }
    let job = r#"{"source": {"inputs": ["lecture_Test.bvh"]},
                  "write": {"output": "job.glb", "smaller": {"max-error": 0.001}}}"#;
    folder.write("job.json", job.as_bytes());
    folder.succeeds("run job.json");
    folder.succeeds("convert lecture_Test.bvh line.glb --max-error 1mm");
    assert!(folder.read("job.glb") == folder.read("line.glb"));
}

/// An error bound above 5 cm gives a warning, and is used.
#[test]
fn a_large_error_is_questioned() {
    let folder = Folder::of_real(&["lecture_Test.bvh"]);
    for (bound, is_questioned) in [("5cm", false), ("51mm", true), ("1m", true)] {
        let said = folder.succeeds(&format!(
            "convert lecture_Test.bvh {bound}.glb --quiet --max-error {bound}"
        ));
        assert_eq!(said.contains("warning: --max-error "), is_questioned, "{bound}: {said}");
    }
    let said = words(&folder.run("verify lecture_Test.bvh 1m.glb --max-error 1m"));
    assert!(said.contains("allows an error of 100 cm for each joint"), "{said}");
}

#[test]
fn times_take_s_and_f() {
    let folder = Folder::of_real(&["lecture_Test.bvh"]);
    for (index, part) in ["0.2..0.8", "0.2s..0.8s", "2f..8f", "0.2s..8f"].iter().enumerate() {
        folder.succeeds(&format!("convert lecture_Test.bvh {index}.bvh --trim {part}"));
        assert!(folder.read(&format!("{index}.bvh")) == folder.read("0.bvh"), "{part}");
        folder.succeeds(&format!(
            "edit lecture_Test.bvh -o step{index}.bvh --step trim:range={part}"
        ));
        assert!(
            folder.read(&format!("step{index}.bvh")) == folder.read("step0.bvh"),
            "{part}"
        );
    }
    folder.refuses(
        "convert lecture_Test.bvh new.bvh --trim 1m..2m",
        2,
        "1.5s..4s (seconds)",
    );
}
