//! How often each region of the library ran: the counters of `-C instrument-coverage`, read in the process.

/// Which counters rose above which steps so far. Without the feature `coverage` there is nothing to guide by.
#[derive(Default)]
pub(crate) struct Seen {
    /// A bit for each step of each counter.
    steps: Vec<u8>,
}

/// The step of a count, as AFL has them: more of the same is news only where it is many more.
fn step(count: u64) -> u8 {
    match count {
        0 => 0,
        1 => 1,
        2 => 2,
        3 => 4,
        4..=7 => 8,
        8..=15 => 16,
        16..=31 => 32,
        32..=127 => 64,
        _ => 128,
    }
}

impl Seen {
    /// Sets all counters to 0, before an input is tried.
    pub(crate) fn reset() {
        counters().fill(0);
    }

    /// Notes what ran since, and tells whether anything did that had not, or had less often.
    pub(crate) fn note(&mut self) -> bool {
        let counters = counters();
        self.steps.resize(counters.len(), 0);
        let mut is_new = false;
        for (seen, count) in self.steps.iter_mut().zip(counters.iter()) {
            let step = step(*count);
            is_new |= *seen & step != step;
            *seen |= step;
        }
        is_new
    }

    /// Notes which counters are above 0, and tells whether any was not before.
    pub(crate) fn reach(&mut self) -> bool {
        let counters = counters();
        self.steps.resize(counters.len(), 0);
        let mut is_new = false;
        for (seen, count) in self.steps.iter_mut().zip(counters.iter()) {
            is_new |= *seen == 0 && *count != 0;
            *seen |= step(*count);
        }
        is_new
    }

    /// Counters above 0 so far, and all there are.
    pub(crate) fn count(&self) -> (usize, usize) {
        let hit = self.steps.iter().filter(|steps| **steps != 0).count();
        (hit, self.steps.len())
    }
}

/// The counters of the process. Other threads of it may count too; a lost count is no harm.
#[cfg(feature = "coverage")]
#[expect(unsafe_code, reason = "the counters are variables of the linker")]
fn counters() -> &'static mut [u64] {
    unsafe extern "C" {
        fn __llvm_profile_begin_counters() -> *mut u64;
        fn __llvm_profile_end_counters() -> *mut u64;
    }
    // SAFETY: the runtime of LLVM gives the two ends of one array of 64-bit counters, which lives as long as the
    // process. One thread alone calls this, and it ends its use before it calls again.
    unsafe {
        let (start, end) = (__llvm_profile_begin_counters(), __llvm_profile_end_counters());
        std::slice::from_raw_parts_mut(start, end.offset_from_unsigned(start))
    }
}

#[cfg(not(feature = "coverage"))]
fn counters() -> &'static mut [u64] {
    &mut []
}
