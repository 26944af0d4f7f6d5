//! Node names as the file has them, as far as clients take them: each client finds every node.

use mocap_scene::scene::Scene;

use super::NodeRename;
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
    pub(super) fn of_nodes(&mut self, scene: &Scene) -> (Vec<String>, Vec<NodeRename>) {
        let mut renamed = Vec::new();
        let is_allowed = |c: char| c != SEPARATOR && !c.is_control();
        let names = (0..scene.nodes.len())
            .map(|node| {
                self.0
                    .of_node(scene, node, is_allowed, as_three_js_sees_it, &mut renamed)
            })
            .collect();
        (names, renamed)
    }
}

/// three.js gives nodes, and the tracks that it binds to them by name, names in which `_` replaces white space and some
/// characters are missing.
fn as_three_js_sees_it(name: &str) -> String {
    let kept = name.chars().filter(|c| !REMOVED_BY_THREE_JS.contains(c));
    kept.map(|c| if c.is_whitespace() { '_' } else { c }).collect()
}
