//! Node names that no client changes, drops or confuses.

use std::collections::{HashMap, HashSet};

use super::Renamed;
use crate::scene::{NodeKind, Scene};

/// Characters that some client strips or takes for a separator: three.js `[ ] . : /`, Unity and Bevy `/`, Godot `. : /`.
const RESERVED: [char; 5] = ['[', ']', '.', ':', '/'];

/// Makes unique names.
#[derive(Default)]
pub(super) struct Names {
    taken: HashSet<String>,
    /// The last suffix tried for each name, so that making names unique takes linear time.
    last_suffix: HashMap<String, u32>,
}

impl Names {
    /// `wanted`, or the first of `wanted_2`, `wanted_3`, ... that is free.
    pub(super) fn unique(&mut self, wanted: &str) -> String {
        if self.taken.insert(as_three_js_sees_it(wanted)) {
            return wanted.to_owned();
        }
        loop {
            let suffix = self.last_suffix.entry(wanted.to_owned()).or_insert(1);
            *suffix += 1;
            let name = format!("{wanted}_{suffix}");
            if self.taken.insert(as_three_js_sees_it(&name)) {
                return name;
            }
        }
    }

    /// A name for every node of `scene`, in its order, and the changed ones.
    pub(super) fn of_nodes(&mut self, scene: &Scene) -> (Vec<String>, Vec<Renamed>) {
        let mut renamed = Vec::new();
        let names = scene.nodes.iter().enumerate().map(|(index, node)| {
            let name = match (node.name.trim(), node.kind) {
                ("", NodeKind::Joint) => "Joint".to_owned(),
                ("", NodeKind::EndSite) => "EndSite".to_owned(),
                ("", NodeKind::Group) => "Group".to_owned(),
                (name, _) => harmless(name),
            };
            let name = self.unique(&name);
            if name != node.name {
                let (from, to) = (node.name.clone(), name.clone());
                renamed.push(Renamed { node: index, from, to });
            }
            name
        });
        (names.collect(), renamed)
    }
}

/// `name` with `_` in place of every reserved or invisible character.
fn harmless(name: &str) -> String {
    let is_bad = |c: char| RESERVED.contains(&c) || c.is_control();
    name.chars().map(|c| if is_bad(c) { '_' } else { c }).collect()
}

/// three.js binds tracks to nodes by names in which white space is replaced by `_`.
fn as_three_js_sees_it(name: &str) -> String {
    name.chars().map(|c| if c.is_whitespace() { '_' } else { c }).collect()
}
