//! Describes the skeleton as a tree of bones, and finds its chains and its pairs of limbs.

use glam::Vec3;
use mocap_scene::pose::{Binding, Pose};
use mocap_scene::scene::{NodeId, NodeKind, Scene};

use crate::names::Name;
use crate::names::words::Part;

/// The largest number of nodes of a chain that are examined. A limb with twist and helper joints has a dozen.
const MOST_IN_A_CHAIN: usize = 16;

/// The largest number of children of one node among which pairs are searched. Hands and faces have fewer. Hundreds of
/// children are markers.
const MOST_CHILDREN: usize = 64;

/// The largest relative difference between the lengths of a pair's limbs, as a fraction. Solvers fit each side
/// separately.
const PAIR_TOLERANCE: f32 = 0.2;

/// The smallest length of a limb, as a fraction of the longest chain of the skeleton from its root.
const SHORTEST_LIMB: f32 = 0.12;

/// If more than this fraction of the joints has no length, the OFFSETs of the file count as missing.
const NO_LENGTHS: f32 = 0.8;

/// A skeleton counts as naming its bones if at least this number of joints have names of body parts. Hips, two legs and
/// two arms of three joints each are 13 joints, of which one may lack a name.
const NAMED_JOINTS: usize = 12;

/// The penalty for a joint whose name has no meaning, in a skeleton that names its bones. It replaces the fit of the
/// name to a part. It is as large as the score that the lengths of an optional bone can add.
const NAMELESS: f32 = -0.4;

/// The fit of a joint that a map names as another part. No length outweighs this penalty.
const STATED_OTHERWISE: f32 = -8.0;

/// The nodes of a scene, with the meanings of their names and the lengths of their bones.
pub(super) struct Tree {
    /// The meaning of each name.
    pub(super) names: Vec<Name>,
    /// The world position of each node at rest.
    pub(super) at: Vec<Vec3>,
    /// The parent of each node.
    pub(super) parent: Vec<Option<usize>>,
    /// The children of each node.
    pub(super) children: Vec<Vec<usize>>,
    /// For each node, whether the file can animate it.
    pub(super) is_joint: Vec<bool>,
    /// The distance of each node from its parent.
    pub(super) bone: Vec<f32>,
    /// The length of the longest chain from the node down.
    pub(super) reach: Vec<f32>,
    /// Whether the skeleton names its bones. A joint without a meaningful name is then less likely a bone.
    is_named: bool,
    /// The joints that a map names. They have the names of their bones.
    pub(super) stated: Vec<usize>,
}

impl Tree {
    pub(super) fn new(scene: &Scene, stated: Vec<usize>) -> Self {
        let count = scene.nodes.len();
        let parent: Vec<_> = scene.nodes.iter().map(|node| node.parent.map(NodeId::index)).collect();
        let mut children = vec![Vec::new(); count];
        for (index, parent) in parent.iter().enumerate() {
            if let Some(parent) = *parent {
                children[parent].push(index);
            }
        }
        let at = rest_positions(scene);
        let bone: Vec<f32> = (0..count)
            .map(|index| parent[index].map_or(0.0, |parent| at[index].distance(at[parent])))
            .map(|length| if length.is_finite() { length } else { 0.0 })
            .collect();
        let mut reach = vec![0.0_f32; count];
        for index in (0..count).rev() {
            if let Some(parent) = parent[index] {
                reach[parent] = reach[parent].max(reach[index] + bone[index]);
            }
        }
        let names: Vec<Name> = scene.nodes.iter().map(|node| Name::read(&node.name)).collect();
        let with_part = names.iter().filter(|name| !name.meaning.is_empty() && !name.is_helper);
        Self {
            is_named: with_part.count() >= NAMED_JOINTS,
            names,
            at,
            parent,
            children,
            is_joint: scene.nodes.iter().map(|node| node.kind == NodeKind::Joint).collect(),
            bone,
            reach,
            stated,
        }
    }

    /// The fit of a node's name to a part, as [`Name::fits`]. If the skeleton names its bones, a name without a meaning
    /// fits less.
    pub(super) fn fits(&self, node: usize, part: Part) -> f32 {
        let name = &self.names[node];
        let says_nothing = name.meaning.is_empty() && !name.is_helper;
        if self.stated.contains(&node) && !name.says(part) {
            STATED_OTHERWISE
        } else if self.is_named && says_nothing {
            NAMELESS
        } else {
            name.fits(part)
        }
    }

    /// The nodes above `node`, from its parent up to the root.
    fn above(&self, node: usize) -> impl Iterator<Item = usize> {
        std::iter::successors(self.parent[node], |above| self.parent[*above])
    }

    /// Whether `node` is `above` or a descendant of `above`.
    pub(super) fn is_within(&self, node: usize, above: usize) -> bool {
        node == above || self.above(node).any(|other| other == above)
    }

    /// The nodes on the path from one node to another through the tree, including both.
    pub(super) fn path(&self, from: usize, to: usize) -> Vec<usize> {
        let up: Vec<usize> = std::iter::once(from).chain(self.above(from)).collect();
        let mut down = Vec::new();
        let mut node = to;
        let meeting = loop {
            if let Some(index) = up.iter().position(|other| *other == node) {
                break index;
            }
            down.push(node);
            match self.parent[node] {
                Some(parent) => node = parent,
                // The nodes are in two trees, with no path between them. A scene has one root.
                None => break up.len() - 1,
            }
        };
        let mut path = up[..=meeting].to_vec();
        path.extend(down.into_iter().rev());
        path
    }

    /// The length of a path through the tree.
    pub(super) fn length_of(&self, path: &[usize]) -> f32 {
        path.windows(2)
            .map(|pair| self.at[pair[0]].distance(self.at[pair[1]]))
            .sum()
    }

    /// The length of the path between two nodes.
    pub(super) fn between(&self, from: usize, to: usize) -> f32 {
        self.length_of(&self.path(from, to))
    }

    /// The longest chain that begins with `start`: its nodes, including end sites. Of two chains of similar length, the
    /// chain with more joints is chosen, so that a stub next to a limb is not chosen.
    pub(super) fn chain(&self, start: usize) -> Vec<usize> {
        let mut chain = vec![start];
        let mut node = start;
        while chain.len() < MOST_IN_A_CHAIN {
            let longest = |child: &usize| {
                let helps = self.names[*child].is_helper && self.children[*child].len() < 2;
                let length = self.bone[*child] + self.reach[*child];
                if helps { 0.5 * length } else { length }
            };
            let next = self.children[node]
                .iter()
                .copied()
                .max_by(|a, b| longest(a).total_cmp(&longest(b)));
            let Some(next) = next else { break };
            chain.push(next);
            node = next;
        }
        chain
    }
}

/// Two similar limbs that are children of one node.
#[derive(Clone, Debug)]
pub(super) struct Pair {
    /// The parent of both limbs.
    pub(super) branch: usize,
    /// The first node of each limb, in the order of the file.
    pub(super) roots: [usize; 2],
    /// The larger reach of the two limbs, from the branch.
    pub(super) reach: f32,
}

/// The pairs of limbs that can be arms or legs, the longest first.
pub(super) fn pairs(tree: &Tree, most: usize) -> Vec<Pair> {
    let mut pairs = Vec::new();
    let longest = tree.reach.get(trunk_of(tree)).copied().unwrap_or(0.0);
    for (branch, children) in tree.children.iter().enumerate() {
        if children.len() < 2 || children.len() > MOST_CHILDREN {
            continue;
        }
        let length = |child: usize| tree.bone[child] + tree.reach[child];
        let limbs: Vec<(usize, usize)> = children
            .iter()
            .copied()
            .filter(|&child| !tree.children[child].is_empty() && length(child) > SHORTEST_LIMB * longest)
            .map(|child| (child, tree.chain(child).len()))
            .collect();
        for (index, &(a, nodes_of_a)) in limbs.iter().enumerate() {
            for &(b, nodes_of_b) in &limbs[index + 1..] {
                if are_alike(tree, a, b, nodes_of_a.abs_diff(nodes_of_b)) {
                    pairs.push(Pair {
                        branch,
                        roots: [a, b],
                        reach: length(a).max(length(b)),
                    });
                }
            }
        }
    }
    pairs.sort_by(|a, b| b.reach.total_cmp(&a.reach));
    pairs.truncate(most);
    pairs
}

/// The fraction of a node's descendants in one of its limbs above which the node only carries that limb.
const CARRIES: f32 = 0.9;

/// The topmost node whose descendants are not nearly all below one child. Its ancestors only place the figure, and some
/// have an OFFSET of many metres.
fn trunk_of(tree: &Tree) -> usize {
    let mut below = vec![1_usize; tree.parent.len()];
    for node in (0..below.len()).rev() {
        if let Some(parent) = tree.parent[node] {
            below[parent] += below[node];
        }
    }
    let carried = |node: usize| {
        let most = CARRIES * (*below.get(node)? - 1) as f32;
        let mut children = tree.children.get(node)?.iter().copied();
        children.find(|child| below[*child] as f32 >= most)
    };
    let mut node = 0;
    while let Some(child) = carried(node) {
        node = child;
    }
    node
}

/// Whether two limbs can be the left and the right limb of a body.
fn are_alike(tree: &Tree, a: usize, b: usize, more_nodes: usize) -> bool {
    let (names_a, names_b) = (&tree.names[a], &tree.names[b]);
    if names_a.side.is_some() && names_a.side == names_b.side {
        return false;
    }
    let length = |limb: usize| tree.bone[limb] + tree.reach[limb];
    let (long, short) = (length(a).max(length(b)), length(a).min(length(b)));
    if names_a.mirrors(names_b) {
        return short > 0.4 * long;
    }
    short > (1.0 - PAIR_TOLERANCE) * long && more_nodes <= 1
}

/// The positions of the nodes at rest. If only the position channels of the file have the lengths, these are the
/// positions in the first frame.
pub(crate) fn rest_positions(scene: &Scene) -> Vec<Vec3> {
    let rest = Pose::rest(scene);
    let positions = |pose: &Pose| {
        (0..scene.nodes.len())
            .map(|index| pose.position(NodeId::new(index)))
            .collect()
    };
    let bones = scene.nodes.iter().filter(|node| node.parent.is_some());
    let without = bones
        .clone()
        .filter(|node| node.transform.w_axis.truncate() == Vec3::ZERO)
        .count();
    let all = bones.count();
    match scene.animations.first() {
        Some(animation) if all > 3 && without as f32 > NO_LENGTHS * all as f32 => {
            let mut pose = rest;
            pose.sample(&Binding::new(scene, animation), animation, 0.0);
            positions(&pose)
        }
        _ => positions(&rest),
    }
}
