//! Counts how often bones are searched for, on each thread. Tests hold that a job searches once for each scene. Builds
//! without debug assertions, which are those for users, count nothing.

use std::cell::Cell;

thread_local! {
    static SEARCHES: Cell<usize> = const { Cell::new(0) };
}

/// Counts a search. Bones that a file states are not searched for.
pub(super) fn count() {
    SEARCHES.set(SEARCHES.get() + 1);
}

/// How often bones are searched for in `act`, on this thread.
pub fn searches(act: impl FnOnce()) -> usize {
    let before = SEARCHES.get();
    act();
    SEARCHES.get() - before
}
