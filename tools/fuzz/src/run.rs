//! The loop of the fuzzer: makes an input, checks it, and records its coverage.

use std::collections::{BTreeSet, HashSet};
use std::path::PathBuf;
use std::sync::Mutex;
use std::time::{Duration, Instant};
use std::{fs, panic, thread};

use mocap_fuzz::{BVH, Input};

use crate::corpus::{artifact, hash, kept, remember, seeds, write};
use crate::coverage::Seen;
use crate::{ALLOCATOR, mutate, structure};

/// A longer time means an endless loop, even on a busy machine. The slowest inputs, large FBX files, take 3 seconds of
/// a processor.
const PATIENCE: Duration = Duration::from_secs(60);

/// One of this number of small files has each of its bytes tried, unless the caller requests all files.
const ONE_OF: u64 = 4;

/// The size of the longest file of which every byte is tried.
const SHORT: usize = 320;

/// The current input, its name, and its start time.
static CURRENT: Mutex<Option<(Vec<u8>, &str, Instant)>> = Mutex::new(None);

/// The time for which to try a format.
#[derive(Clone, Copy)]
pub(crate) enum Effort {
    Seconds(u64),
    Inputs(u64),
}

/// Which of the small files have each of their bytes tried.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Files {
    All,
    /// One of [`ONE_OF`], chosen by its bytes.
    Some,
}

/// Tries small BVH files with each of their bytes replaced by each of the 256 values in turn.
pub(crate) fn every_byte(which: Files) -> Result<(), String> {
    let mut files = 0;
    let mut tried = 0_u64;
    for original in seeds(&BVH)
        .into_iter()
        .filter(|bytes| bytes.len() <= SHORT && (which == Files::All || hash(bytes).is_multiple_of(ONE_OF)))
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

/// The news of the inputs: their coverage or, in a build without counters, their messages.
enum News {
    Coverage(Seen),
    Outcomes(HashSet<BTreeSet<String>>),
}

impl News {
    /// Tries an input. Returns whether it could be read, and whether it was news.
    fn of(&mut self, input: &'static Input, bytes: &[u8]) -> Result<(bool, bool), String> {
        Seen::reset();
        let is_read = try_input(input, bytes)?;
        let is_new = match self {
            Self::Coverage(seen) => seen.note(),
            Self::Outcomes(outcomes) => outcomes.insert(input.outcome(bytes)),
        };
        Ok((is_read, is_new))
    }
}

/// Tries the seeds of a format, the kept inputs, and changed inputs for a while. An error describes a finding and names
/// the file of the input.
pub(crate) fn fuzz(input: &'static Input, effort: Effort, seed: u64) -> Result<(), String> {
    let mut news = match cfg!(feature = "coverage") {
        true => News::Coverage(Seen::default()),
        false => News::Outcomes(HashSet::new()),
    };
    let mut pool = seeds(input);
    let given = pool.len();
    pool.extend(kept(input));
    let all = pool.len();
    for bytes in &pool {
        news.of(input, bytes)?;
    }
    let mut random = fastrand::Rng::with_seed(seed);
    let start = Instant::now();
    let (mut tried, mut read) = (0_u64, 0_u64);
    let goes_on = |tried| match effort {
        Effort::Seconds(seconds) => start.elapsed() < Duration::from_secs(seconds),
        Effort::Inputs(inputs) => tried < inputs,
    };
    while goes_on(tried) {
        // Most inputs that this run found are broken.
        let from = if random.bool() { &pool[..given] } else { &pool[..] };
        let seed = &from[random.usize(..from.len())];
        let structured = random.bool().then(|| structure::mutate(input.name, seed, &mut random));
        let bytes = match structured.flatten() {
            Some(bytes) => bytes,
            None if random.u8(..4) == 0 => mutate::extreme(seed, &mut random),
            None => mutate::mutate(from, input.words, &mut random),
        };
        let (is_read, is_new) = news
            .of(input, &bytes)
            .map_err(|finding| format!("{finding}, after {tried} inputs"))?;
        read += u64::from(is_read);
        if is_new {
            if matches!(news, News::Coverage(_)) {
                remember(input, &bytes);
            }
            pool.push(bytes);
        }
        tried += 1;
    }
    let regions = match &news {
        News::Coverage(seen) => {
            let (hit, all) = seen.count();
            format!(", {hit} of {all} counters")
        }
        News::Outcomes(_) => String::new(),
    };
    println!(
        "{}: {tried} inputs from {all} seeds in {} s: {read} were read, {} were news{regions}, no finding",
        input.name,
        start.elapsed().as_secs(),
        pool.len() - all
    );
    let _ = fs::remove_file(artifact("running", input.name));
    Ok(())
}

/// Tries the kept inputs of a format, its seeds, and a number of changes of each. The changes of a file depend only on
/// its bytes. So a commit changes the findings only if it changes the files or the tested code.
pub(crate) fn whole_corpus(input: &'static Input, changes: usize) -> Result<(), String> {
    let mut all = seeds(input);
    all.extend(kept(input));
    for bytes in &all {
        try_input(input, bytes)?;
        let alone = std::slice::from_ref(bytes);
        let mut random = fastrand::Rng::with_seed(hash(bytes));
        if changes > 0 {
            try_input(input, &mutate::extreme(bytes, &mut random))?;
        }
        for _ in 0..changes {
            let changed = structure::mutate(input.name, bytes, &mut random).filter(|_| random.bool());
            let changed = changed.unwrap_or_else(|| mutate::mutate(alone, input.words, &mut random));
            try_input(input, &changed)?;
        }
    }
    println!(
        "{}: {} inputs, {changes} changes of each, no finding",
        input.name,
        all.len()
    );
    Ok(())
}

/// Records the current input for [`watch`].
fn note(input: &'static Input, bytes: &[u8]) {
    *CURRENT.lock().expect("no one panics with the lock") = Some((bytes.to_owned(), input.name, Instant::now()));
}

/// Tries an input. Returns whether it could be read, or the finding.
pub(crate) fn try_input(input: &'static Input, bytes: &[u8]) -> Result<bool, String> {
    note(input, bytes);
    // Writes the input first, because a crash leaves no time to write it.
    write(&artifact("running", input.name), bytes);
    let before = ALLOCATOR.current_usage();
    ALLOCATOR.reset_peak_usage();
    let found = |what: String| format!("{what}; the input is in {}", keep(bytes, input.name).display());
    let is_read = panic::catch_unwind(|| input.hold(bytes)).map_err(|_| found("the panic is above".to_owned()))?;
    let taken = ALLOCATOR.peak_usage().saturating_sub(before);
    let budget = input.base + input.factor * bytes.len();
    if taken > budget {
        return Err(found(format!(
            "{} bytes of input took {taken} bytes of memory, more than {budget}",
            bytes.len()
        )));
    }
    Ok(is_read)
}

/// Ends the program when an input takes too long: an endless loop cannot be caught.
pub(crate) fn watch() {
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
    write(&path, bytes);
    path
}
