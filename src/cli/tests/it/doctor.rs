//! The program's description of its build and of the machine: `mocap --version` and `mocap doctor`.

use std::process::Command;

use serde_json::Value;

use crate::program::Folder;

/// The optional features as Cargo knows them, with whether this build has them.
const FEATURES: [(&str, bool); 3] = [
    ("fbx", cfg!(feature = "fbx")),
    ("meshopt", cfg!(feature = "meshopt")),
    ("parquet", cfg!(feature = "parquet")),
];

fn printed(line: &str) -> String {
    let output = Folder::with(&[]).run(line);
    assert!(output.status.success(), "{line}");
    String::from_utf8(output.stdout).unwrap()
}

/// The commit that git reports, or none without a repository.
fn commit() -> Option<String> {
    let done = Command::new("git")
        .args(["rev-parse", "--short=12", "HEAD"])
        .output()
        .ok()?;
    done.status
        .success()
        .then(|| String::from_utf8(done.stdout).unwrap().trim().to_owned())
}

#[test]
fn the_version_has_commit_features_and_target() {
    let version = env!("CARGO_PKG_VERSION");
    assert_eq!(printed("-V"), format!("mocap {version}\n"));
    let long = printed("--version");
    let lines: Vec<&str> = long.lines().collect();
    let [name, stated_commit, features, target] = lines[..] else {
        panic!("{long}");
    };
    assert_eq!(name, format!("mocap {version}"));
    let commit = commit().unwrap_or_else(|| "unknown".to_owned());
    assert_eq!(stated_commit, format!("commit: {commit}"));
    for (feature, is_built) in FEATURES {
        assert_eq!(features.contains(feature), is_built, "{long}");
    }
    let rustc = Command::new("rustc").arg("-vV").output().unwrap();
    let host = String::from_utf8(rustc.stdout).unwrap();
    let host = host.lines().find_map(|line| line.strip_prefix("host: ")).unwrap();
    assert_eq!(target, format!("target: {host}"));
}

#[test]
fn the_doctor_names_what_is_missing_in_ten_lines() {
    let text = printed("doctor");
    assert!(text.lines().count() <= 10, "{text}");
    let found: Value = serde_json::from_str(&printed("doctor --json")).unwrap();
    let needs = found["needs"].as_array().unwrap();
    let is_present = |name: &str| {
        let need = needs.iter().find(|need| need["name"] == name);
        need.unwrap_or_else(|| panic!("{name}"))["is_present"]
            .as_bool()
            .unwrap()
    };
    for (feature, is_built) in FEATURES {
        assert_eq!(is_present(feature), is_built, "{feature}");
    }
    // The tests read its output through pipes.
    assert!(!is_present("terminal"));
    for need in needs {
        let name = need["name"].as_str().unwrap();
        let line = text.lines().find(|line| line.contains(&format!("  {name} "))).unwrap();
        let status = if is_present(name) { "ok " } else { "missing " };
        assert!(line.starts_with(status), "{text}");
        let help = need["help"].as_str().unwrap();
        assert_eq!(line.ends_with(help), !is_present(name), "{text}");
    }
}

/// The doctor makes the same checks as the commands.
#[cfg(target_os = "linux")]
#[test]
fn the_doctor_finds_a_browser_and_a_temporary_folder_where_they_are() {
    let folder = Folder::with(&[]);
    folder.write("programs/xdg-open", b"");
    let is_present = |name: &str, programs: &str, temporary: &str| {
        let mut command = crate::program::command_in(&folder.path(""), "doctor --json");
        let command = command
            .env("PATH", folder.path(programs))
            .env("TMPDIR", folder.path(temporary));
        let found: Value = serde_json::from_slice(&command.output().unwrap().stdout).unwrap();
        let needs = found["needs"].as_array().unwrap();
        needs.iter().find(|need| need["name"] == name).unwrap()["is_present"] == true
    };
    assert!(is_present("browser", "programs", ""));
    assert!(!is_present("browser", "nowhere", ""));
    assert!(is_present("temporary folder", "programs", "programs"));
    assert!(!is_present("temporary folder", "programs", "nowhere"));
}
