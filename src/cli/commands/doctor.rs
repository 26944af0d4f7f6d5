//! `mocap doctor`: missing features of this build and machine, and the commands that need them.

use std::env;
use std::fmt;
use std::io::{self, IsTerminal};
use std::net::{Ipv4Addr, UdpSocket};
use std::path::Path;

use serde::Serialize;

use super::{Place, print_report};
use crate::args::DoctorArgs;
use crate::{Failure, build_info, report};

/// The output of `--json`.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct DoctorReport {
    version: &'static str,
    commit: &'static str,
    target: &'static str,
    /// The optional features that this build has.
    features: Vec<&'static str>,
    needs: Vec<Requirement>,
}

/// A requirement of a command.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Requirement {
    name: &'static str,
    is_present: bool,
    /// The commands or features that have this requirement.
    used_for: &'static str,
    /// The remedy if the requirement is missing.
    help: String,
}

fn need(name: &'static str, is_present: bool, used_for: &'static str, help: impl Into<String>) -> Requirement {
    Requirement {
        name,
        is_present,
        used_for,
        help: help.into(),
    }
}

fn examine() -> DoctorReport {
    let used_for = |feature| match feature {
        "fbx" => "read and write FBX",
        "meshopt" => "read and write glTF compressed by meshopt",
        _ => "`pack`, and tables as .parquet",
    };
    let features = build_info::FEATURES.iter().map(|&(feature, is_built)| {
        let help = format!("in a checkout, run `cargo install --path src/cli --profile dist --features {feature}`");
        need(feature, is_built, used_for(feature), help)
    });
    let folder = env::temp_dir();
    let of_system = [
        need(
            "optimised build",
            !cfg!(debug_assertions),
            "full speed",
            "build with `--profile dist`",
        ),
        need(
            "browser",
            has_browser(),
            "`view` without -o",
            "write the page with -o, and open it",
        ),
        need(
            "temporary folder",
            tempfile::tempfile_in(&folder).is_ok(),
            "`view` without -o",
            format!("make {} writable, or name an output with -o", folder.display()),
        ),
        need(
            "UDP",
            UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).is_ok(),
            "`record`, `play`, `bridge`",
            "allow this program to open UDP sockets",
        ),
        need(
            "terminal",
            io::stderr().is_terminal(),
            "progress bars and colours",
            "run in a terminal; results are the same without a terminal",
        ),
    ];
    DoctorReport {
        version: build_info::VERSION,
        commit: build_info::COMMIT,
        target: build_info::TARGET,
        features: build_info::features(),
        needs: features.chain(of_system).collect(),
    }
}

/// Whether this system has a program that opens a page.
fn has_browser() -> bool {
    let folders = env::var_os("PATH").unwrap_or_default();
    let is_there = |program: &Path| env::split_paths(&folders).any(|folder| folder.join(program).is_file());
    // On Windows, the shell opens a page.
    cfg!(windows)
        || open::commands("page.html").iter().any(|command| {
            let program = Path::new(command.get_program());
            program.is_absolute() && program.is_file() || is_there(program)
        })
}

pub(crate) fn run(args: &DoctorArgs) -> Result<(), Failure> {
    print_report(&examine(), args.json, Place::Result)
}

impl fmt::Display for DoctorReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "mocap {} ({}, {})", self.version, self.commit, self.target)?;
        let width = self.needs.iter().map(|need| need.name.len()).max().unwrap_or_default();
        for need in &self.needs {
            let (name, used_for) = (need.name, need.used_for);
            match need.is_present {
                true => writeln!(f, "ok       {name:<width$}  {used_for}")?,
                false => {
                    let help = report::visible(&need.help);
                    writeln!(f, "missing  {name:<width$}  {used_for}: {help}")?;
                }
            }
        }
        Ok(())
    }
}
