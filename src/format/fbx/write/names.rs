//! Names as the scene has them, each once: Unreal Engine refuses a second bone of a name, and others take the first.

use std::collections::{HashMap, HashSet};

/// Makes unique names.
#[derive(Default)]
pub(super) struct Names {
    taken: HashSet<String>,
    /// The last suffix tried for each name, so that the time is linear.
    last_suffix: HashMap<String, u32>,
}

impl Names {
    /// `wanted`, or else `instead` where it is empty; or the first of `wanted_2`, `wanted_3`, ... that is free. Control
    /// characters become `_`, because two of them separate a name from its class.
    pub(super) fn unique(&mut self, wanted: &str, instead: &str) -> String {
        let wanted = if wanted.trim().is_empty() { instead } else { wanted };
        let wanted: String = wanted.chars().map(|c| if c.is_control() { '_' } else { c }).collect();
        if self.taken.insert(wanted.clone()) {
            return wanted;
        }
        loop {
            let suffix = self.last_suffix.entry(wanted.clone()).or_insert(1);
            *suffix += 1;
            let name = format!("{wanted}_{suffix}");
            if self.taken.insert(name.clone()) {
                return name;
            }
        }
    }
}
