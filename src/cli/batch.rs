//! Work on many files: the list of inputs, the threads, the manifest and the progress.
//!
//! This module is independent of the commands. A command that makes one output per file, in a [`folder`], only defines
//! the work on one file. Other commands find their [`inputs`], and pass each input to [`for_each`]. They receive the
//! results on their own thread, write them to a [`manifest`] or to standard output, and update the [`progress`].

pub(crate) mod folder;
pub(crate) mod gather;
pub(crate) mod hash;
#[doc(hidden)]
pub(crate) mod inputs;
pub(crate) mod journal;
mod lines;
pub(crate) mod manifest;
pub(crate) mod outputs;
pub(crate) mod pattern;
pub(crate) mod progress;
#[doc(hidden)]
pub(crate) mod shard;
pub(crate) mod spread;
pub(crate) mod walk;

use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread;

use self::inputs::Input;

/// Works on all inputs with `threads` threads. Passes each result to `sink` with the index of its input, in the order
/// of completion.
///
/// If `work` panics, `panicked` gives the result: one file must not stop the others.
///
/// Inputs are started in their order. An error of `sink` ends the work after the files that were already started.
pub fn for_each<T: Send, E>(
    inputs: &[Input],
    threads: usize,
    work: impl Fn(&Input) -> T + Sync,
    panicked: impl Fn(&Input) -> T + Sync,
    mut sink: impl FnMut(usize, T) -> Result<(), E>,
) -> Result<(), E> {
    let next = AtomicUsize::new(0);
    let stopped = AtomicBool::new(false);
    // The channel is bounded, so that fast workers do not pile up results for a slow sink.
    let (sender, receiver) = mpsc::sync_channel(4 * threads);
    thread::scope(|scope| {
        for _ in 0..threads.min(inputs.len()) {
            let (sender, next, stopped, work, panicked) = (sender.clone(), &next, &stopped, &work, &panicked);
            scope.spawn(move || {
                while !stopped.load(Ordering::Relaxed) {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    let Some(input) = inputs.get(index) else { break };
                    let worked = catch_unwind(AssertUnwindSafe(|| work(input)));
                    let result = worked.unwrap_or_else(|_| panicked(input));
                    if sender.send((index, result)).is_err() {
                        break;
                    }
                }
            });
        }
        drop(sender);
        for (index, result) in &receiver {
            if let Err(error) = sink(index, result) {
                stopped.store(true, Ordering::Relaxed);
                // A worker that waits for space in the channel must not wait forever.
                drop(receiver);
                return Err(error);
            }
        }
        Ok(())
    })
}

/// The error of a file whose reader or writer panicked.
pub(crate) const PANICKED: &str =
    "internal error: mocap crashed while it read or wrote the file; please report this file";

/// Sorts results into the order of their inputs.
pub(crate) struct InOrder<T> {
    next: usize,
    early: BTreeMap<usize, T>,
}

impl<T> InOrder<T> {
    pub(crate) fn new() -> Self {
        Self {
            next: 0,
            early: BTreeMap::new(),
        }
    }

    pub(crate) fn push(&mut self, index: usize, result: T) {
        self.early.insert(index, result);
    }

    /// The next result, if it is ready.
    pub(crate) fn pop(&mut self) -> Option<T> {
        let result = self.early.remove(&self.next)?;
        self.next += 1;
        Some(result)
    }
}

/// The requested number of threads, or else the number of cores.
pub(crate) fn thread_count(asked: Option<NonZeroUsize>) -> usize {
    /// More threads than any machine has cores, and few enough for any system.
    const MOST_THREADS: usize = 512;
    asked
        .or_else(|| thread::available_parallelism().ok())
        .map_or(1, NonZeroUsize::get)
        .min(MOST_THREADS)
}
