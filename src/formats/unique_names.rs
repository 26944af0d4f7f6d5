//! Unique names.

use std::collections::{HashMap, HashSet};

use mocap_scene::scene::{NodeKind, Scene};

use crate::report::NodeRename;

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

    /// The name of a node in a file, for a format that does not quote names. `_` replaces each character that is not
    /// `allowed`. An empty name becomes `Joint`, `EndSite` or `Group`. A change is added to `renamed`.
    pub(crate) fn of_node(
        &mut self,
        scene: &Scene,
        node: usize,
        allowed: impl Fn(char) -> bool,
        key: impl Fn(&str) -> String,
        renamed: &mut Vec<NodeRename>,
    ) -> String {
        let from = &scene.nodes[node].name;
        let wanted = match (from.trim(), scene.nodes[node].kind) {
            ("", NodeKind::Joint) => "Joint".to_owned(),
            ("", NodeKind::EndSite) => "EndSite".to_owned(),
            ("", NodeKind::Group) => "Group".to_owned(),
            (name, _) => name.chars().map(|c| if allowed(c) { c } else { '_' }).collect(),
        };
        let to = self.first_free(wanted, key);
        if to != *from {
            renamed.push(NodeRename {
                node,
                from: from.clone(),
                to: to.clone(),
                is_asked_for: false,
            });
        }
        to
    }
}

/// Whether a reader may end a line or a column at the character, or show nothing for it.
pub(crate) fn is_separator(c: char) -> bool {
    c.is_control() || matches!(c, '\u{2028}' | '\u{2029}')
}
