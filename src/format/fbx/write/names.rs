//! Names as the scene has them, each once: Unreal Engine refuses a second bone of a name, and others take the first.

use std::collections::{HashMap, HashSet};

/// The name of a file that every system takes, without its extension; empty where nothing is left of it.
pub(super) fn file_stem(name: &str) -> String {
    /// Windows takes these for devices.
    const DEVICES: [&str; 4] = ["con", "prn", "aux", "nul"];
    /// Characters, of at most four bytes, where most systems have 255 bytes.
    const MOST: usize = 50;
    let is_forbidden = |c: char| c.is_control() || ":*?\"<>|/\\".contains(c);
    let name: String = name
        .chars()
        .map(|c| if is_forbidden(c) { '_' } else { c })
        .take(MOST)
        .collect();
    let name = name.trim().trim_matches('.').trim();
    let lower = name.to_ascii_lowercase();
    let port = lower.strip_prefix("com").or_else(|| lower.strip_prefix("lpt"));
    let is_port = port.is_some_and(|port| port.len() == 1 && port.bytes().all(|byte| byte.is_ascii_digit()));
    let is_device = is_port || DEVICES.contains(&lower.split('.').next().unwrap_or_default());
    match is_device {
        true => format!("_{name}"),
        false => name.to_owned(),
    }
}

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
        self.first_free(wanted, str::to_owned)
    }

    /// A unique name of a file: some systems do not tell capitals from small letters.
    pub(super) fn unique_file(&mut self, wanted: &str, instead: &str) -> String {
        let wanted = if wanted.is_empty() { instead } else { wanted };
        self.first_free(wanted.to_owned(), str::to_lowercase)
    }

    fn first_free(&mut self, wanted: String, key: impl Fn(&str) -> String) -> String {
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
