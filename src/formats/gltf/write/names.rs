//! Node names as the file has them, as far as clients take them: each client finds every node.

use mocap_scene::scene::{NodeKind, Scene};

use super::Renamed;
use crate::unique_names::UniqueNames;

/// What separates the names of a path in Unity, which finds animated nodes by it.
const SEPARATOR: char = '/';

/// Characters that three.js removes from names when it loads them.
const REMOVED_BY_THREE_JS: [char; 5] = ['[', ']', '.', ':', '/'];

/// Makes unique names.
#[derive(Default)]
pub(super) struct Names(UniqueNames);

impl Names {
    /// `wanted`, or the first of `wanted_2`, `wanted_3`, ... that is free.
    pub(super) fn unique(&mut self, wanted: &str) -> String {
        self.0.first_free(wanted.to_owned(), as_three_js_sees_it)
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
                renamed.push(Renamed {
                    node: index,
                    from,
                    to,
                    is_asked_for: false,
                });
            }
            name
        });
        (names.collect(), renamed)
    }
}

/// `name` with `_` instead of every separator and every invisible character.
fn harmless(name: &str) -> String {
    let is_bad = |c: char| c == SEPARATOR || c.is_control();
    name.chars().map(|c| if is_bad(c) { '_' } else { c }).collect()
}

/// three.js gives nodes, and the tracks that it binds to them by name, names in which `_` replaces white space and some
/// characters are missing.
fn as_three_js_sees_it(name: &str) -> String {
    let kept = name.chars().filter(|c| !REMOVED_BY_THREE_JS.contains(c));
    kept.map(|c| if c.is_whitespace() { '_' } else { c }).collect()
}
