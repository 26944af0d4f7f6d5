//! Runs the two programs and reads their output.

use std::ffi::OsString;
use std::path::Path;
use std::process::Command;

use crate::scene::Scene;
use crate::{assimp_json, mocap_json};

/// The failure of a program itself.
pub(crate) type Failure = String;

/// A scene, or the reason why the program refuses the file.
pub(crate) type Answer = Result<Scene, String>;

/// The program of `assimp/dump.cpp` and the `mocap` program.
pub(crate) struct Programs {
    pub assimp: OsString,
    pub mocap: OsString,
}

impl Programs {
    pub(crate) fn assimp_scene(&self, file: &Path, processed: bool) -> Result<Answer, Failure> {
        assimp_json::read(&self.assimp(file, processed, "json")?).map_err(|error| format!("Assimp's JSON: {error}"))
    }

    pub(crate) fn assimp_text(&self, file: &Path, processed: bool, layout: &str) -> Result<String, Failure> {
        self.assimp(file, processed, layout)
    }

    pub(crate) fn our_scene(&self, file: &Path, processed: bool) -> Result<Answer, Failure> {
        match self.mocap(file, processed, &["--json"])? {
            Ok(json) => mocap_json::read(&json)
                .map(Ok)
                .map_err(|error| format!("mocap's JSON: {error}")),
            Err(refusal) => Ok(Err(refusal)),
        }
    }

    pub(crate) fn our_text(&self, file: &Path, processed: bool, layout: &str) -> Result<String, Failure> {
        self.mocap(file, processed, &["--layout", layout])?
    }

    fn assimp(&self, file: &Path, processed: bool, format: &str) -> Result<String, Failure> {
        let flags = if processed { "MaxQuality+Debone" } else { "none" };
        let output = Command::new(&self.assimp).arg(file).args([flags, format]).output();
        let output = output.map_err(|error| format!("{}: {error}", self.assimp.display()))?;
        if output.status.success() {
            Ok(decoded(&output.stdout))
        } else {
            Err(format!("Assimp ended with {}", output.status))
        }
    }

    /// The output of the program, or its message if it ends with status 1.
    fn mocap(&self, file: &Path, processed: bool, options: &[&str]) -> Result<Result<String, String>, Failure> {
        let raw = if processed { None } else { Some("--raw") };
        let output = Command::new(&self.mocap)
            .arg("dump")
            .arg(file)
            .args(options)
            .args(raw)
            .output();
        let output = output.map_err(|error| format!("{}: {error}", self.mocap.display()))?;
        match output.status.code() {
            Some(0) => Ok(Ok(String::from_utf8_lossy(&output.stdout).into_owned())),
            Some(1) => Ok(Err(String::from_utf8_lossy(&output.stderr).into_owned())),
            _ => Err(format!(
                "mocap ended with {}: {}",
                output.status,
                String::from_utf8_lossy(&output.stderr).trim()
            )),
        }
    }
}

/// Text in which bytes that are not UTF-8 are Latin-1. Assimp does not change a file's bytes.
fn decoded(bytes: &[u8]) -> String {
    let chunks = bytes.utf8_chunks();
    chunks
        .flat_map(|chunk| {
            chunk
                .valid()
                .chars()
                .chain(chunk.invalid().iter().map(|&byte| char::from(byte)))
        })
        .collect()
}
