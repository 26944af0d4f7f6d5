//! The program `mocap`.

use std::process::ExitCode;

fn main() -> ExitCode {
    mocap_cli::run()
}
