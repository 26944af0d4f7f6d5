//! Tells the program its commit and its target, for `mocap --version` and `mocap doctor`.

use std::path::Path;
use std::process::Command;
use std::{env, fs};

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    let target = env::var("TARGET").unwrap_or_default();
    println!("cargo:rustc-env=MOCAP_TARGET={target}");
    let commit = of_package().or_else(of_repository);
    println!(
        "cargo:rustc-env=MOCAP_COMMIT={}",
        commit.as_deref().unwrap_or("unknown")
    );
}

/// The commit that `cargo package` wrote into the package.
fn of_package() -> Option<String> {
    let text = fs::read_to_string(".cargo_vcs_info.json").ok()?;
    let (_, after) = text.split_once("\"sha1\"")?;
    let hash = after.split('"').nth(1)?;
    Some(short(hash))
}

/// The commit of the repository that contains this file. A copy of the sources in another repository has no commit.
fn of_repository() -> Option<String> {
    git(&["ls-files", "--error-unmatch", "build.rs"])?;
    // Each commit and each checkout writes the log of HEAD, whatever the branch.
    for name in ["logs/HEAD", "HEAD"] {
        let path = git(&["rev-parse", "--git-path", name])?;
        if Path::new(&path).exists() {
            println!("cargo:rerun-if-changed={path}");
            break;
        }
    }
    Some(short(&git(&["rev-parse", "HEAD"])?))
}

fn git(words: &[&str]) -> Option<String> {
    let done = Command::new("git").args(words).output().ok()?;
    let text = String::from_utf8(done.stdout).ok()?;
    (done.status.success() && !text.is_empty()).then(|| text.trim().to_owned())
}

fn short(hash: &str) -> String {
    /// Enough digits to be unique among millions of commits.
    const DIGITS: usize = 12;
    hash.chars().take(DIGITS).collect()
}
