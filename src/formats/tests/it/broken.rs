//! Broken files, each with its exact error message.

use std::fs;
use std::path::PathBuf;

use mocap::Importer;

#[test]
fn every_broken_file_is_refused_with_its_message() {
    let mut paths: Vec<PathBuf> = fs::read_dir("../../fixtures/broken")
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "bvh"));
    paths.sort();
    assert!(!paths.is_empty());

    let mut failures = String::new();
    for path in paths {
        let name = path.file_name().unwrap().to_str().unwrap();
        let expected = fs::read_to_string(path.with_extension("error")).unwrap();
        let message = match Importer::new().read(&fs::read(&path).unwrap(), name) {
            Ok(_) => "it loads".to_owned(),
            Err(error) => error.to_string(),
        };
        if message != expected.trim_end() {
            failures += &format!("\n  is     {message}\n  and not {expected}");
        }
    }
    assert!(failures.is_empty(), "{failures}");
}

#[test]
fn an_error_of_the_operating_system_names_the_file() {
    let error = mocap::import("../../fixtures/broken/there_is_no_such_file.bvh").unwrap_err();
    assert_eq!(error.code(), mocap::Code::Io);
    assert!(
        error
            .to_string()
            .starts_with("../../fixtures/broken/there_is_no_such_file.bvh: error[io]: "),
        "{error}"
    );
}

#[test]
fn an_unknown_format_is_refused_by_its_name() {
    let error = Importer::new()
        .read(b"Dear reader,\nthis is a letter.\n", "letter.txt")
        .unwrap_err();
    assert_eq!(error.code(), mocap::Code::UnknownFormat);
    assert!(
        error.to_string().starts_with("letter.txt: error[unknown-format]: "),
        "{error}"
    );
    assert_eq!(
        "fbx2".parse::<mocap::Format>().unwrap_err().code(),
        mocap::Code::UnknownFormat
    );
}
