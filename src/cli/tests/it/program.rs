//! Runs the program as users do.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

use crate::ROOT;

/// The manifest of a folder of outputs.
pub(crate) const MANIFEST: &str = "mocap-manifest.jsonl";

/// The folder of the program's record in tests, instead of the user's folder.
pub(crate) const STATE_HOME: &str = concat!(env!("CARGO_TARGET_TMPDIR"), "/state");

/// The program with these arguments, in the root of the repository.
pub(crate) fn command<A: AsRef<OsStr>>(arguments: &[A]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_mocap"));
    command
        .args(arguments)
        .current_dir(ROOT)
        .env("XDG_STATE_HOME", STATE_HOME);
    command
}

pub(crate) fn run<A: AsRef<OsStr>>(arguments: &[A]) -> Output {
    command(arguments).output().unwrap()
}

/// The program in a folder, with arguments that are separated by spaces.
pub(crate) fn command_in(folder: &Path, arguments: &str) -> Command {
    let mut command = command(&arguments.split(' ').collect::<Vec<_>>());
    command.current_dir(folder);
    command
}

/// The program's standard error.
pub(crate) fn words(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// A folder to run the program in.
pub(crate) struct Folder(tempfile::TempDir);

impl Folder {
    /// A folder with copies of real captures, under the names of the captures.
    pub(crate) fn of_real(names: &[&str]) -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        for name in names {
            folder.write(
                name,
                &fs::read(Path::new(ROOT).join("fixtures/real").join(name)).unwrap(),
            );
        }
        folder
    }

    /// A folder with files of these names: copies of two real captures in turn.
    pub(crate) fn with(names: &[&str]) -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        for (index, name) in names.iter().enumerate() {
            let source = ["lecture_Test.bvh", "cmu_short.bvh"][index % 2];
            folder.write(
                name,
                &fs::read(Path::new(ROOT).join("fixtures/real").join(source)).unwrap(),
            );
        }
        folder
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, bytes: &[u8]) {
        fs::create_dir_all(self.path(name).parent().unwrap()).unwrap();
        fs::write(self.path(name), bytes).unwrap();
    }

    pub(crate) fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap()
    }

    /// All files with their contents, including files in subfolders.
    pub(crate) fn contents(&self) -> Vec<(PathBuf, Vec<u8>)> {
        let mut contents = Vec::new();
        let mut folders = vec![self.0.path().to_owned()];
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                match path.is_dir() && !path.is_symlink() {
                    true => folders.push(path),
                    false => contents.push((path.clone(), fs::read(path).unwrap_or_default())),
                }
            }
        }
        contents.sort();
        contents
    }

    /// Runs the program with arguments that are separated by spaces.
    pub(crate) fn run(&self, arguments: &str) -> Output {
        command_in(self.0.path(), arguments).output().unwrap()
    }

    /// Runs the program with a file of the folder as standard input.
    pub(crate) fn run_with_input(&self, arguments: &str, input: &str) -> Output {
        let mut command = command_in(self.0.path(), arguments);
        command
            .stdin(fs::File::open(self.path(input)).unwrap())
            .output()
            .unwrap()
    }

    /// Checks that a command succeeds. Returns its messages.
    pub(crate) fn succeeds(&self, arguments: &str) -> String {
        let output = self.run(arguments);
        let words = words(&output);
        assert!(output.status.success(), "{arguments}: {words}");
        words
    }

    /// Checks that a command ends with `status`. Returns its messages.
    pub(crate) fn ends_with(&self, status: i32, arguments: &str) -> String {
        let output = self.run(arguments);
        assert_eq!(output.status.code(), Some(status), "{arguments}: {}", words(&output));
        words(&output)
    }

    /// The lines of the manifest in a folder.
    pub(crate) fn records(&self, name: &str) -> Vec<Value> {
        let text = String::from_utf8(self.read(&format!("{name}/{MANIFEST}"))).unwrap();
        text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
    }

    /// Checks that a command ends with `status`, prints `reason`, and changes no file.
    pub(crate) fn refuses(&self, arguments: &str, status: i32, reason: &str) {
        let before = self.contents();
        let output = self.run(arguments);
        let words = words(&output);
        assert_eq!(output.status.code(), Some(status), "{arguments}: {words}");
        assert!(words.contains(reason), "{arguments}: {words}");
        assert!(self.contents() == before, "{arguments} changed a file");
    }
}
