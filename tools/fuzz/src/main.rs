//! A fuzzer for the stable toolchain: changes the fixtures at random, for a number of seconds.
//!
//! It has no coverage to guide it. In its place, an input about which the library says something new joins the seeds.

mod mutate;

use std::collections::{BTreeSet, HashSet};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Mutex;
use std::time::{Duration, Instant};
use std::{env, fs, panic, thread};

use peak_alloc::PeakAlloc;

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

/// No input may need more memory than this plus [`FACTOR`] times its length. An export holds the scene, its buffer,
/// and the file.
const BASE: usize = 1 << 20;
const FACTOR: usize = 512;

/// Seeds beyond this length are left out: a change in a long file is mostly a change of one more number.
const LONGEST_SEED: usize = 8 << 10;

/// An input that takes longer is taken for an endless loop.
const PATIENCE: Duration = Duration::from_secs(20);

/// The input that is being tried, and since when.
static CURRENT: Mutex<Option<(Vec<u8>, Instant)>> = Mutex::new(None);

fn main() -> ExitCode {
    let mut arguments = env::args().skip(1);
    let (Some(seconds), seed) = (number(arguments.next(), None), number(arguments.next(), Some(1))) else {
        eprintln!("usage: fuzz SECONDS [SEED]");
        return ExitCode::from(2);
    };
    thread::spawn(watch);

    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures");
    let mut pool = seeds(&folder);
    let mut outcomes: HashSet<BTreeSet<&str>> = pool.iter().map(|bytes| mocap_fuzz::outcome(bytes)).collect();
    let mut random = fastrand::Rng::with_seed(seed.unwrap_or(1));
    let (given, end) = (pool.len(), Instant::now() + Duration::from_secs(seconds));
    let mut tried = 0_u64;
    while Instant::now() < end {
        let bytes = mutate::mutate(&pool, &mut random);
        if let Err(finding) = try_input(&bytes) {
            eprintln!(
                "{finding}\nafter {tried} inputs; the input is in {}",
                keep(&bytes).display()
            );
            return ExitCode::FAILURE;
        }
        if outcomes.insert(mocap_fuzz::outcome(&bytes)) {
            pool.push(bytes);
        }
        tried += 1;
    }
    println!(
        "{tried} inputs from {given} seeds in {seconds} s: {} different outcomes, no finding",
        outcomes.len()
    );
    ExitCode::SUCCESS
}

fn number(argument: Option<String>, default: Option<u64>) -> Option<u64> {
    argument.map_or(default, |text| text.parse().ok())
}

fn seeds(folder: &Path) -> Vec<Vec<u8>> {
    let mut paths: Vec<PathBuf> = ["dialects", "broken", "real"]
        .iter()
        .flat_map(|name| fs::read_dir(folder.join(name)).expect("the fixtures are there"))
        .map(|entry| entry.expect("a folder can be listed").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "bvh"))
        .collect();
    // The order in which a folder is listed is not the same everywhere; the seed of the generator is.
    paths.sort();
    let files = paths.iter().map(|path| fs::read(path).expect("a fixture can be read"));
    files.filter(|bytes| bytes.len() <= LONGEST_SEED).collect()
}

fn try_input(bytes: &[u8]) -> Result<(), String> {
    *CURRENT.lock().expect("no one panics with the lock") = Some((bytes.to_owned(), Instant::now()));
    let before = ALLOCATOR.current_usage();
    ALLOCATOR.reset_peak_usage();
    panic::catch_unwind(|| {
        mocap_fuzz::import(bytes);
        mocap_fuzz::import_export(bytes);
    })
    .map_err(|_| "the panic is above".to_owned())?;
    let (taken, budget) = (
        ALLOCATOR.peak_usage().saturating_sub(before),
        BASE + FACTOR * bytes.len(),
    );
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
        if let Some((bytes, since)) = &*current
            && since.elapsed() > PATIENCE
        {
            eprintln!(
                "an input takes more than {PATIENCE:?}; it is in {}",
                keep(bytes).display()
            );
            std::process::exit(1);
        }
    }
}

fn keep(bytes: &[u8]) -> PathBuf {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("artifacts");
    let path = folder.join("finding.bvh");
    let written = fs::create_dir_all(&folder).and_then(|()| fs::write(&path, bytes));
    if let Err(error) = written {
        eprintln!("{}: {error}", path.display());
    }
    path
}
