//! Runs other programs, if they are installed.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

const HERE: &str = env!("CARGO_MANIFEST_DIR");

/// The program of this repository.
pub(crate) fn mocap() -> PathBuf {
    Path::new(HERE).join("../../target/dist/mocap")
}

/// Runs a program, and returns whether it succeeded.
pub(crate) fn run(program: &Path, args: &[&str]) -> bool {
    let status = Command::new(program)
        .args(args)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status();
    status.is_ok_and(|status| status.success())
}

/// The median seconds of `aiImportFile`, and of one update of all node matrices as the course does it.
pub(crate) fn assimp(file: &Path, rounds: usize) -> Option<(f64, f64)> {
    let program = Path::new(HERE).join("../../target/assimp-time");
    let text = output(Command::new(program).arg(file).arg("none").arg(rounds.to_string()))?;
    let median = |what: &str| {
        let lines = text
            .lines()
            .filter_map(|line| serde_json::from_str::<serde_json::Value>(line).ok());
        let found = lines.into_iter().find(|line| line["what"] == what)?;
        Some(found["median_us"].as_f64()? / 1e6)
    };
    Some((median("import")?, median("update")?))
}

/// The median seconds of three.js' `BVHLoader`.
pub(crate) fn three(file: &Path, rounds: usize) -> Option<f64> {
    let script = Path::new(HERE).join("peers/three.mjs");
    let text = output(Command::new("node").arg(script).arg(file).arg(rounds.to_string()))?;
    let value: serde_json::Value = serde_json::from_str(&text).ok()?;
    Some(value["median_ms"].as_f64()? / 1e3)
}

fn output(command: &mut Command) -> Option<String> {
    let output = command.stdin(Stdio::null()).stderr(Stdio::null()).output().ok()?;
    output
        .status
        .success()
        .then(|| String::from_utf8_lossy(&output.stdout).into_owned())
}
