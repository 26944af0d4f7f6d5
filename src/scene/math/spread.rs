//! Distributes work over all cores.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

/// Does the work on all cores, and returns the results in the order of the work.
pub fn spread<W: Sync, T: Send>(work: &[W], of: impl Fn(&W) -> T + Sync) -> Vec<T> {
    let threads = thread::available_parallelism()
        .map_or(1, usize::from)
        .min(work.len().max(1));
    if threads == 1 {
        return work.iter().map(of).collect();
    }
    let next = AtomicUsize::new(0);
    let mut results: Vec<(usize, T)> = thread::scope(|scope| {
        let worker = || {
            let mut own = Vec::new();
            loop {
                let index = next.fetch_add(1, Ordering::Relaxed);
                match work.get(index) {
                    Some(work) => own.push((index, of(work))),
                    None => return own,
                }
            }
        };
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(worker)).collect();
        let joined = workers.into_iter().map(thread::ScopedJoinHandle::join);
        joined
            .flat_map(|result| result.unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
            .collect()
    });
    results.sort_unstable_by_key(|(index, _)| *index);
    results.into_iter().map(|(_, result)| result).collect()
}
