//! Random choices for tests that try only a part of all cases. Each run tries another part.
//!
//! A failing test prints the seed, and `MOCAP_SEED=7 cargo test` repeats the choices. `MOCAP_ALL=1 cargo test` tries
//! all cases.

use std::env;
use std::hash::{BuildHasher, RandomState};

/// Whether all cases are tried, not only a sample.
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

    /// Every `parts`th item, beginning with an item that the seed chooses. With `MOCAP_ALL`, all items. There must be
    /// at least `parts` items, in an order that does not depend on the file system.
    pub(crate) fn some<T>(&mut self, items: impl IntoIterator<Item = T>, parts: usize) -> Vec<T> {
        let parts = if is_all() { 1 } else { parts };
        let first = self.below(parts);
        let chosen: Vec<T> = items.into_iter().skip(first).step_by(parts).collect();
        assert!(!chosen.is_empty(), "fewer items than parts");
        chosen
    }

    /// A random number from 0 to below `end`.
    pub(crate) fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((mixed ^ (mixed >> 31)) % end as u64) as usize
    }
}
