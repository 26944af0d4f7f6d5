//! A fuzzer for the stable toolchain: changes the fixtures of a format at random, for a number of seconds or of inputs.
//! All formats are tried side by side, a process each, as many at a time as there are cores. Half of the changes to
//! glTF, C3D, FBX and packed clips are to their structure.
//!
//! It has no coverage to guide it. In its place, an input about which the library says something new joins the seeds.
//! All memory is limited, so that an allocation without a bound ends the program; the input that was tried is then in
//! `artifacts`, as it is after a crash in C.

mod mutate;
mod structure;

use std::collections::{BTreeSet, HashSet};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};
use std::{env, fs, panic, thread};

use mocap_fuzz::{BVH, FORMATS, Input, fixture};
use peak_alloc::PeakAlloc;

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

/// An input that takes longer is taken for an endless loop.
const PATIENCE: Duration = Duration::from_secs(20);

/// Bytes of memory that the whole program may take.
const MEMORY: u64 = 1 << 30;

/// One of so many small files has each of its bytes tried, unless all are asked for.
const SHARE: usize = 4;

/// Bytes of the longest file of which every byte is tried.
const SHORT: usize = 320;

/// The input that is being tried, what it is called, and since when.
static CURRENT: Mutex<Option<(Vec<u8>, &str, Instant)>> = Mutex::new(None);

fn main() -> ExitCode {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let usage = || {
        let names: Vec<_> = FORMATS.iter().map(|input| input.name).collect();
        eprintln!(
            "usage: fuzz SECONDS|inputs=NUMBER [all|{}] [SEED], for each format, or fuzz every-byte [all|SEED]",
            names.join("|")
        );
        ExitCode::from(2)
    };
    if let Err(error) = limit_memory() {
        eprintln!("memory cannot be limited: {error}");
        return ExitCode::FAILURE;
    }
    if arguments.first().is_some_and(|first| first == "every-byte") {
        thread::spawn(watch);
        let files = match arguments.get(1).map(String::as_str) {
            Some("all") => Files::All,
            Some(seed) => match seed.parse() {
                Ok(seed) => Files::Some { seed },
                Err(_) => return usage(),
            },
            None => Files::Some { seed: 0 },
        };
        return match every_byte(files) {
            Ok(()) => ExitCode::SUCCESS,
            Err(finding) => {
                eprintln!("{finding}");
                ExitCode::FAILURE
            }
        };
    }
    let number = |text: &String| text.parse::<u64>().ok();
    let effort = arguments.first().and_then(|text| match text.strip_prefix("inputs=") {
        Some(inputs) => inputs.parse().ok().map(Effort::Inputs),
        None => text.parse().ok().map(Effort::Seconds),
    });
    let (Some(effort), Some(seed)) = (effort, arguments.get(2).map_or(Some(1), number)) else {
        return usage();
    };
    let name = arguments.get(1).map_or("all", String::as_str);
    if name == "all" {
        return side_by_side(&arguments[0], seed);
    }
    let Some(input) = FORMATS.iter().copied().find(|input| input.name == name) else {
        return usage();
    };
    thread::spawn(watch);
    match fuzz(input, effort, seed) {
        Ok(()) => ExitCode::SUCCESS,
        Err(finding) => {
            eprintln!("{finding}");
            ExitCode::FAILURE
        }
    }
}

/// Every byte of small BVH files, and all formats for so long each, in processes of this program: each has its own
/// limit of memory. What one prints stands together.
fn side_by_side(effort: &str, seed: u64) -> ExitCode {
    let seed = seed.to_string();
    let formats = FORMATS.iter().map(|input| vec![effort, input.name, &seed]);
    let jobs: Vec<_> = std::iter::once(vec!["every-byte", &seed]).chain(formats).collect();
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
        true => ExitCode::FAILURE,
        false => ExitCode::SUCCESS,
    }
}

/// How long to try a format.
#[derive(Clone, Copy)]
enum Effort {
    Seconds(u64),
    Inputs(u64),
}

/// Counted for the whole process, C included. Windows has no such limit.
fn limit_memory() -> std::io::Result<()> {
    #[cfg(unix)]
    rlimit::setrlimit(rlimit::Resource::AS, MEMORY, MEMORY)?;
    Ok(())
}

/// Which of the small files have each of their bytes tried.
#[derive(Clone, Copy)]
enum Files {
    All,
    /// Every [`SHARE`]th, from one on that the seed chooses.
    Some {
        seed: u64,
    },
}

/// Tries small BVH files with each of their bytes replaced by each of the 256 in turn.
fn every_byte(which: Files) -> Result<(), String> {
    let (first, step) = match which {
        Files::All => (0, 1),
        Files::Some { seed } => ((seed % SHARE as u64) as usize, SHARE),
    };
    let mut files = 0;
    let mut tried = 0_u64;
    for original in seeds(&BVH)
        .into_iter()
        .filter(|bytes| bytes.len() <= SHORT)
        .skip(first)
        .step_by(step)
    {
        for place in 0..original.len() {
            let mut bytes = original.clone();
            for byte in 0..=u8::MAX {
                bytes[place] = byte;
                note(&BVH, &bytes);
                panic::catch_unwind(|| BVH.survive(&bytes)).map_err(|_| {
                    let kept = keep(&bytes, BVH.name);
                    format!("the panic is above; the input is in {}", kept.display())
                })?;
                tried += 1;
            }
        }
        files += 1;
    }
    println!("bvh: {tried} inputs, each byte of {files} files as every other, no finding");
    Ok(())
}

/// Tries a format for a while. An error says what was found and where the input is.
fn fuzz(input: &'static Input, effort: Effort, seed: u64) -> Result<(), String> {
    let mut pool = seeds(input);
    let mut outcomes: HashSet<BTreeSet<String>> = pool.iter().map(|bytes| input.outcome(bytes)).collect();
    let mut random = fastrand::Rng::with_seed(seed);
    let (given, start) = (pool.len(), Instant::now());
    let (mut tried, mut read) = (0_u64, 0_u64);
    let goes_on = |tried| match effort {
        Effort::Seconds(seconds) => start.elapsed() < Duration::from_secs(seconds),
        Effort::Inputs(inputs) => tried < inputs,
    };
    while goes_on(tried) {
        // What was found on the way is broken for the most part.
        let from = if random.bool() { &pool[..given] } else { &pool[..] };
        let seed = &from[random.usize(..from.len())];
        let structured = random.bool().then(|| structure::mutate(input.name, seed, &mut random));
        let bytes = match structured.flatten() {
            Some(bytes) => bytes,
            None => mutate::mutate(from, input.words, &mut random),
        };
        if let Err(finding) = try_input(input, &bytes) {
            let kept = keep(&bytes, input.name);
            return Err(format!(
                "{finding}\nafter {tried} inputs; the input is in {}",
                kept.display()
            ));
        }
        let outcome = input.outcome(&bytes);
        read += u64::from(!outcome.contains("error"));
        if outcomes.insert(outcome) {
            pool.push(bytes);
        }
        tried += 1;
    }
    println!(
        "{}: {tried} inputs from {given} seeds in {} s: {read} were read, {} different outcomes, no finding",
        input.name,
        start.elapsed().as_secs(),
        outcomes.len()
    );
    let _ = fs::remove_file(artifact("running", input.name));
    Ok(())
}

/// The fixtures of a format; from longer ones the first bytes, where the beginning of a file says something.
fn seeds(input: &Input) -> Vec<Vec<u8>> {
    let mut paths: Vec<PathBuf> = (input.folders.iter())
        .flat_map(|name| fs::read_dir(fixture(name)).expect("the fixtures are there"))
        .map(|entry| entry.expect("a folder can be listed").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == input.name))
        .collect();
    // The order in which a folder is listed is not the same everywhere; the seed of the generator is.
    paths.sort();
    let files = paths.iter().map(|path| fs::read(path).expect("a fixture can be read"));
    let mut seeds: Vec<Vec<u8>> = files
        .filter(|bytes| input.cut || bytes.len() <= input.longest_seed)
        .map(|mut bytes| {
            bytes.truncate(input.longest_seed);
            bytes
        })
        .collect();
    seeds.extend((input.made)());
    assert!(!seeds.is_empty(), "there are no fixtures of {}", input.name);
    seeds
}

/// Notes what is tried now, for [`watch`].
fn note(input: &'static Input, bytes: &[u8]) {
    *CURRENT.lock().expect("no one panics with the lock") = Some((bytes.to_owned(), input.name, Instant::now()));
}

fn try_input(input: &'static Input, bytes: &[u8]) -> Result<(), String> {
    note(input, bytes);
    // What ends the program leaves no time to write it.
    write_artifact(&artifact("running", input.name), bytes);
    let before = ALLOCATOR.current_usage();
    ALLOCATOR.reset_peak_usage();
    panic::catch_unwind(|| input.hold(bytes)).map_err(|_| "the panic is above".to_owned())?;
    let taken = ALLOCATOR.peak_usage().saturating_sub(before);
    let budget = input.base + input.factor * bytes.len();
    if taken > budget {
        return Err(format!(
            "{} bytes of input took {taken} bytes of memory, more than {budget}",
            bytes.len()
        ));
    }
    Ok(())
}

/// Ends the program when an input takes too long: an endless loop cannot be caught.
fn watch() {
    loop {
        thread::sleep(PATIENCE / 10);
        let current = CURRENT.lock().expect("no one panics with the lock");
        if let Some((bytes, name, since)) = &*current
            && since.elapsed() > PATIENCE
        {
            eprintln!(
                "an input takes more than {PATIENCE:?}; it is in {}",
                keep(bytes, name).display()
            );
            std::process::exit(1);
        }
    }
}

fn keep(bytes: &[u8], extension: &str) -> PathBuf {
    let path = artifact("finding", extension);
    write_artifact(&path, bytes);
    path
}

fn artifact(name: &str, extension: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("artifacts");
    folder.join(name).with_extension(extension)
}

fn write_artifact(path: &Path, bytes: &[u8]) {
    let folder = path.parent().unwrap_or(Path::new("."));
    let written = fs::create_dir_all(folder).and_then(|()| fs::write(path, bytes));
    if let Err(error) = written {
        eprintln!("{}: {error}", path.display());
    }
}
