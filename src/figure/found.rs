//! Counts searches for bones on each thread. Tests check that a job searches once for each scene. Release builds count
//! nothing.

use std::cell::Cell;

thread_local! {
    static SEARCHES: Cell<usize> = const { Cell::new(0) };
}

/// Counts a search. Bones that a file states are not searched for.
pub(super) fn count() {
    SEARCHES.set(SEARCHES.get() + 1);
}

/// The number of searches for bones during `act`, on this thread.
pub fn searches(act: impl FnOnce()) -> usize {
    let before = SEARCHES.get();
    act();
    SEARCHES.get() - before
}
