//! Names, each once.

use std::collections::{HashMap, HashSet};

/// Makes names unique.
#[derive(Default)]
pub(crate) struct UniqueNames {
    taken: HashSet<String>,
    /// The last suffix tried for each name, so that the time is linear.
    last_suffix: HashMap<String, u32>,
}

impl UniqueNames {
    /// `wanted`, or the first of `wanted_2`, `wanted_3`, ... whose `key` is free.
    pub(crate) fn first_free(&mut self, wanted: String, key: impl Fn(&str) -> String) -> String {
        if self.taken.insert(key(&wanted)) {
            return wanted;
        }
        loop {
            let suffix = self.last_suffix.entry(key(&wanted)).or_insert(1);
            *suffix += 1;
            let name = format!("{wanted}_{suffix}");
            if self.taken.insert(key(&name)) {
                return name;
            }
        }
    }
}
