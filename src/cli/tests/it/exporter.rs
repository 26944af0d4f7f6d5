//! The options and the lists of the program: they follow from the table of formats.

use std::path::Path;

use mocap::{FormatInfo, Importer, WriteOption};

use crate::program::Folder;
use crate::sample::{Sample, is_all};

/// Each written format with each of its extensions.
fn written() -> Vec<(&'static FormatInfo, &'static str)> {
    let rows = FormatInfo::ALL.iter().filter(|row| row.writes());
    let written: Vec<_> = rows
        .flat_map(|row| row.extensions.iter().map(move |extension| (row, *extension)))
        .collect();
    assert!(written.len() >= 6, "{}", written.len());
    written
}

/// An option with a valid value, and the other options that it needs.
fn given(option: WriteOption) -> String {
    let value = match option {
        WriteOption::Mesh => "none",
        WriteOption::Compress => "int16",
        WriteOption::MaxError => "1mm",
        WriteOption::ShellDistance => "5cm --max-error 1mm",
        WriteOption::Order => "XYZ",
        WriteOption::Digits => "3",
        WriteOption::Channels => "6",
        WriteOption::FbxVersion => "7.4",
        WriteOption::FbxRest => "pre-rotation",
        WriteOption::Target => "unity",
        WriteOption::Textures => "beside",
        WriteOption::OutUnit => "m",
        WriteOption::OutUp => "z",
        WriteOption::Rest => "frame:1",
        WriteOption::Names => "unreal",
        WriteOption::BoneAxis => "y",
        _ => "",
    };
    format!("--{option} {value}").trim_end().to_owned()
}

/// `convert` accepts and rejects options according to the rows of the table.
#[test]
fn every_option_is_taken_or_refused_as_the_row_of_the_format_says() {
    let folder = Folder::of_real(&["cmu_short.bvh"]);
    let mut counts = [0, 0];
    // Test every third combination of a format and an option.
    let parts = if is_all() { 1 } else { 3 };
    let first = Sample::new().below(parts);
    for (place, (row, extension)) in written().into_iter().enumerate() {
        for option in WriteOption::ALL
            .into_iter()
            .skip((first + place) % parts)
            .step_by(parts)
        {
            let arguments = format!("convert cmu_short.bvh new.{extension} --force {}", given(option));
            match row.refusal(option, extension) {
                Some(refusal) => {
                    // Library messages have Rust's names of options.
                    let name = format!("`{}`", option.as_str().replace('-', "_"));
                    let message = refusal.message.replacen(&name, &format!("--{option}"), 1);
                    assert!(
                        message.starts_with(&format!("--{option} has no effect on ")),
                        "{refusal:?}"
                    );
                    // If two options have no effect, the error names the first.
                    let is_alone = option != WriteOption::ShellDistance || row.takes(WriteOption::MaxError);
                    let reason = if is_alone {
                        message.as_str()
                    } else {
                        " has no effect on "
                    };
                    folder.refuses(&arguments, 2, reason);
                    counts[0] += 1;
                }
                None => {
                    folder.succeeds(&arguments);
                    counts[1] += 1;
                }
            }
        }
    }
    assert!(counts.into_iter().all(|count| count > 10), "{counts:?}");
}

/// The table is the only list of written formats: the program's lists are made from it.
#[test]
fn the_lists_of_the_program_are_those_of_the_table() {
    let folder = Folder::of_real(&["cmu_short.bvh"]);
    let list = String::from_utf8(folder.run("formats").stdout).unwrap();
    let help = String::from_utf8(folder.run("convert --help").stdout).unwrap();
    for row in FormatInfo::ALL {
        let line = list
            .lines()
            .find(|line| line.starts_with(&format!("{:<8}  ", row.format.as_str())))
            .unwrap();
        assert_eq!(line.contains("write"), row.writes(), "{line}");
        assert_eq!(line.contains("read"), row.reads, "{line}");
        for extension in row.extensions {
            assert!(line.contains(&format!(".{extension}")), "{line}");
            let is_value = help
                .lines()
                .any(|line| line.trim_start().starts_with(&format!("- {extension}:")));
            let is_arrays = ["npz", "csv", "parquet", "pkl"].contains(extension);
            assert_eq!(is_value, row.writes() || is_arrays, "{extension}\n{help}");
        }
    }
    folder.refuses("convert cmu_short.bvh new.xyz", 2, &FormatInfo::written_extensions());
    for (_, extension) in written() {
        folder.succeeds(&format!("convert cmu_short.bvh -o folder --to {extension}"));
        assert!(
            Path::new(&folder.path("folder"))
                .join(format!("cmu_short.{extension}"))
                .exists()
        );
        let bytes = folder.run(&format!("convert cmu_short.bvh - --to {extension}")).stdout;
        assert!(
            Importer::new()
                .read(&bytes, Path::new("take").with_extension(extension))
                .is_ok(),
            "{extension}"
        );
    }
}
