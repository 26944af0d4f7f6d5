//! Random choices for tests that try a part of what there is: another part in each run.
//!
//! The seed is printed where a test fails; `MOCAP_SEED=7 cargo test` makes the same choices again.
//! `MOCAP_ALL=1 cargo test` tries everything.

use std::env;
use std::hash::{BuildHasher, RandomState};

/// Whether everything is tried, and not a sample.
pub(crate) fn is_all() -> bool {
    env::var_os("MOCAP_ALL").is_some_and(|value| value != "0")
}

/// A generator of random numbers: SplitMix64 (Steele, Lea and Flood, 2014).
pub(crate) struct Sample(u64);

impl Sample {
    pub(crate) fn new() -> Self {
        let seed = env::var("MOCAP_SEED").map_or_else(
            |_| RandomState::new().hash_one(0),
            |seed| seed.parse().expect("MOCAP_SEED is a number"),
        );
        println!("MOCAP_SEED={seed}");
        Self(seed)
    }

    /// Every `parts`th of the items, from one on that the seed chooses; all of them with `MOCAP_ALL`. There must be
    /// `parts` items at least, in an order that does not depend on the file system.
    pub(crate) fn some<T>(&mut self, items: impl IntoIterator<Item = T>, parts: usize) -> Vec<T> {
        let parts = if is_all() { 1 } else { parts };
        let first = self.below(parts);
        let chosen: Vec<T> = items.into_iter().skip(first).step_by(parts).collect();
        assert!(!chosen.is_empty(), "fewer items than parts");
        chosen
    }

    /// A number from 0 to `end`, without `end`.
    pub(crate) fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((mixed ^ (mixed >> 31)) % end as u64) as usize
    }
}
