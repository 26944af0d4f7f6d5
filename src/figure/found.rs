//! How often the bones of a skeleton are searched for, in tests: once for a scene, whatever is done to it.

use std::cell::Cell;

thread_local! {
    static SEARCHES: Cell<usize> = const { Cell::new(0) };
}

/// Counts a search. Bones that a file states are not searched for.
pub(super) fn count() {
    SEARCHES.set(SEARCHES.get() + 1);
}

/// How often bones are searched for in `act`, on this thread.
pub(crate) fn searches(act: impl FnOnce()) -> usize {
    let before = SEARCHES.get();
    act();
    SEARCHES.get() - before
}
