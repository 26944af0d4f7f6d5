//! Reads the counters of `-C instrument-coverage` in the process: how often each region of the library ran.

/// The steps that each counter has reached so far. Without the feature `coverage`, this is empty.
#[derive(Default)]
pub(crate) struct Seen {
    /// A bit for each step of each counter.
    steps: Vec<u8>,
}

/// The step of a count, as in AFL: a higher count is new only if it reaches the next step.
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

    /// Records the counts since the reset, and returns whether any counter reached a new step.
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

    /// Records which counters are above 0, and returns whether any counter was 0 in all earlier inputs.
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

    /// The number of counters above 0 so far, and of all counters.
    pub(crate) fn count(&self) -> (usize, usize) {
        let hit = self.steps.iter().filter(|steps| **steps != 0).count();
        (hit, self.steps.len())
    }
}

/// The counters of the process. Other threads may change them at the same time; a lost count does no harm.
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
