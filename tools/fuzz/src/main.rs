//! A fuzzer for the stable toolchain: changes the fixtures of a format at random, for a number of seconds or of inputs.
//! Each format has its own process. At most one process per core runs at a time. Half of the changes to glTF, C3D, FBX,
//! packed clips and archives are to their structure.
//!
//! An input that reaches new code becomes a seed, if the library was compiled with coverage counters (`guided`).
//! Without counters, an input with a new message becomes a seed. The memory is limited, so that an unbounded allocation
//! ends the program. The input is then in `artifacts`, as after a crash in C.

mod corpus;
mod coverage;
mod mutate;
mod run;
mod structure;

use std::io::{self, Write};
use std::process::{Command, ExitCode};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::{env, thread};

use mocap_fuzz::{FORMATS, Input};
use peak_alloc::PeakAlloc;

use self::run::{Effort, Files};

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

/// Bytes of memory that the whole program may take.
const MEMORY: u64 = 1 << 30;

fn main() -> ExitCode {
    let arguments: Vec<String> = env::args().skip(1).collect();
    if let Err(error) = limit_memory() {
        eprintln!("memory cannot be limited: {error}");
        return ExitCode::FAILURE;
    }
    let Some(outcome) = work(&arguments) else {
        let names: Vec<_> = FORMATS.iter().map(|input| input.name).collect();
        eprintln!(
            "usage: fuzz SECONDS|inputs=NUMBER|corpus|changes=NUMBER|minimize [all|{}] [SEED], for each format, fuzz try \
             FORMAT FILE, fuzz formats, or fuzz every-byte [all]",
            names.join("|")
        );
        return ExitCode::from(2);
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(finding) => {
            eprintln!("{finding}");
            ExitCode::FAILURE
        }
    }
}

/// The request of the arguments; `None` if they are wrong.
fn work(arguments: &[String]) -> Option<Result<(), String>> {
    let what = arguments.first()?.as_str();
    if what == "every-byte" {
        let files = match arguments.get(1).map(String::as_str) {
            Some("all") => Files::All,
            Some(_) => return None,
            None => Files::Some,
        };
        thread::spawn(run::watch);
        return Some(run::every_byte(files));
    }
    if what == "formats" {
        FORMATS.iter().for_each(|input| println!("{}", input.name));
        return Some(Ok(()));
    }
    if let ["try", name, path] = *arguments.iter().map(String::as_str).collect::<Vec<_>>() {
        let input: &Input = FORMATS.iter().find(|input| input.name == name)?;
        let bytes = std::fs::read(path).map_err(|error| format!("{path}: {error}"));
        return Some(bytes.and_then(|bytes| run::try_input(input, &bytes)).map(drop));
    }
    let name = arguments.get(1).map_or("all", String::as_str);
    let seed = arguments.get(2).map_or(Some(1), |seed| seed.parse().ok())?;
    let effort = match what.strip_prefix("inputs=") {
        Some(inputs) => Some(Effort::Inputs(inputs.parse().ok()?)),
        None => what.parse().ok().map(Effort::Seconds),
    };
    let changes = match what.strip_prefix("changes=") {
        Some(changes) => Some(changes.parse().ok()?),
        None => (what == "corpus").then_some(0),
    };
    if effort.is_none() && changes.is_none() && what != "minimize" {
        return None;
    }
    if name == "all" {
        let with_bytes = effort.is_some() || changes.is_some_and(|changes| changes > 0);
        return Some(side_by_side(what, with_bytes, seed));
    }
    let input: &Input = FORMATS.iter().find(|input| input.name == name)?;
    thread::spawn(run::watch);
    Some(match (effort, changes) {
        (Some(effort), _) => run::fuzz(input, effort, seed),
        (None, Some(changes)) => run::whole_corpus(input, changes),
        (None, None) => corpus::minimize(input, |bytes| run::try_input(input, bytes).map(drop)),
    })
}

/// Runs all formats, and every byte of small BVH files on request, in processes of this program: each has its own
/// memory limit. The output of a process stays together.
fn side_by_side(what: &str, with_bytes: bool, seed: u64) -> Result<(), String> {
    let seed = seed.to_string();
    let formats = FORMATS.iter().map(|input| vec![what, input.name, &seed]);
    let bytes = with_bytes.then(|| vec!["every-byte"]);
    let jobs: Vec<_> = bytes.into_iter().chain(formats).collect();
    let next = AtomicUsize::new(0);
    let has_finding = AtomicBool::new(false);
    let work = || {
        while let Some(job) = jobs.get(next.fetch_add(1, Ordering::Relaxed)) {
            let program = env::current_exe().expect("the program knows where it is");
            let output = Command::new(program).args(job).output();
            let output = output.expect("the program can be run again");
            let (out, err) = (io::stdout(), io::stderr());
            let (mut out, mut err) = (out.lock(), err.lock());
            let _ = out.write_all(&output.stdout).and(err.write_all(&output.stderr));
            if !output.status.success() {
                has_finding.store(true, Ordering::Relaxed);
                let _ = writeln!(err, "{}: {}", job.join(" "), output.status);
            }
        }
    };
    let cores = thread::available_parallelism().map_or(1, usize::from);
    thread::scope(|scope| {
        for _ in 0..cores.min(jobs.len()) {
            scope.spawn(work);
        }
    });
    match has_finding.into_inner() {
        true => Err("there are findings".to_owned()),
        false => Ok(()),
    }
}

/// The limit is for the whole process, including C. Windows has no such limit.
fn limit_memory() -> std::io::Result<()> {
    #[cfg(unix)]
    rlimit::setrlimit(rlimit::Resource::AS, MEMORY, MEMORY)?;
    Ok(())
}
