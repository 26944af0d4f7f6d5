//! Compiles and runs the C++ programs.

#[path = "../../../succeed.rs"]
mod succeed;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

pub(crate) use succeed::succeed;

/// The `libassimp.so.5` with which a program runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Library {
    Debian,
    Ours,
}

/// The folder of our library under the name that programs load. The library is built when first needed.
pub(crate) fn our_folder() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap();
        // `check` has built it.
        if std::env::var_os("MOCAP_BUILT").is_none() {
            succeed(
                Command::new(env!("CARGO"))
                    .args(["build", "--quiet", "--target-dir"])
                    .arg(target)
                    // The profile of the tests, so that mocap is not compiled a second time.
                    .args(if cfg!(feature = "meshopt") {
                        &["--features", "meshopt"][..]
                    } else {
                        &[]
                    }),
            );
        }
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("lib");
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::copy(target.join("debug/libassimp.so"), folder.join("libassimp.so.5")).unwrap();
        folder
    })
}

/// Compiles `tests/NAME.cpp` against Debian's headers and library.
pub(crate) fn compile(name: &str, options: &[&str]) -> PathBuf {
    // Tests run at the same time, so each compiles for itself.
    static COUNT: std::sync::atomic::AtomicUsize = std::sync::atomic::AtomicUsize::new(0);
    let count = COUNT.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
    let program = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}-{count}"));
    succeed(
        Command::new("c++")
            .args(["-std=c++17", "-O1", "-g", "-Wall", "-Wextra", "-Werror"])
            .args(options)
            .arg(format!("tests/{name}.cpp"))
            .arg("-o")
            .arg(&program)
            .arg("-lassimp"),
    );
    program
}

/// Runs a program on a file, and returns its output.
pub(crate) fn run(program: &Path, library: Library, file: &str) -> String {
    run_with(program, library, &[file])
}

/// Runs a program, and returns its output.
pub(crate) fn run_with(program: &Path, library: Library, arguments: &[&str]) -> String {
    let mut command = Command::new(program);
    command.args(arguments);
    text(succeed(with(&mut command, library)))
}

/// Runs a program with our library under valgrind, which fails on invalid accesses and memory leaks.
pub(crate) fn run_under_valgrind(program: &Path, file: &str) {
    let mut command = Command::new("valgrind");
    command.args([
        "--quiet",
        "--error-exitcode=99",
        "--leak-check=full",
        "--errors-for-leak-kinds=definite,indirect,possible",
    ]);
    command.arg(program).arg(file);
    // Runs without the system's Assimp, whose memory is not tested. Memory for the whole process is still reachable.
    succeed(with(command.env("MOCAP_ASSIMP_FORWARD", "off"), Library::Ours));
}

/// Sets the command's search path for libraries.
pub(crate) fn with(command: &mut Command, library: Library) -> &mut Command {
    match library {
        Library::Debian => command.env_remove("LD_LIBRARY_PATH"),
        Library::Ours => command.env("LD_LIBRARY_PATH", our_folder()),
    }
}

/// The output of a command.
pub(crate) fn text(output: Output) -> String {
    String::from_utf8(output.stdout).unwrap()
}
