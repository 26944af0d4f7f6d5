//! Node names in the file. The names are unique for every client, so that each client finds every node.

use mocap_scene::scene::Scene;

use super::NodeRename;
use crate::unique_names::UniqueNames;

/// The separator of path segments in Unity, which finds animated nodes by path.
const SEPARATOR: char = '/';

/// Characters that three.js removes from names while loading.
const REMOVED_BY_THREE_JS: [char; 5] = ['[', ']', '.', ':', '/'];

/// Makes unique names.
#[derive(Default)]
pub(super) struct Names(UniqueNames);

impl Names {
    /// `wanted`, or the first of `wanted_2`, `wanted_3`, ... that is free.
    pub(super) fn unique(&mut self, wanted: &str) -> String {
        self.0.first_free(wanted.to_owned(), as_three_js_sees_it)
    }

    /// A name for every node of `scene`, in order, and the changed names.
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

/// The name of a node in three.js, and of the tracks that three.js binds by name: `_` replaces white space, and some
/// characters are removed.
fn as_three_js_sees_it(name: &str) -> String {
    let kept = name.chars().filter(|c| !REMOVED_BY_THREE_JS.contains(c));
    kept.map(|c| if c.is_whitespace() { '_' } else { c }).collect()
}
