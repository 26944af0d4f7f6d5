//! Decides which of four standing legs are front legs, and which are left. Also finds neck, head and tail.

use std::collections::BTreeMap;

use glam::Vec3;
use mocap_scene::scene::{NodeId, Side};

use super::{Legs, Limb, Quadruped, QuadrupedLeg};
use crate::Confidence;
use crate::humanoid::topology::Tree;
use crate::names::words::{AnimalPart, Part};

/// The cosine of the angle between a leg and its first bone below which the first bone is a girdle: 66 degrees.
const ASIDE: f32 = 0.4;

/// The smallest length of a neck or a tail, as a fraction of the length of the legs. Ears and helpers are shorter.
const SHORTEST_CHAIN: f32 = 0.15;

/// The weight of the axes of a robot's file in the vote on which pair is in front. It is the largest weight, because
/// robots have +X forward (REP 103 of ROS).
const BY_AXES: f32 = 4.0;

/// The weight of names of front and hind legs, in the same vote. It is the largest weight for animals.
const BY_NAME: f32 = 3.0;

/// The weight of a named head or tail, in the same vote. It is below the weight of named legs.
const BY_HEAD_OR_TAIL: f32 = 2.0;

/// The weight of the path, in the same vote. Animals seldom walk backward.
const BY_TRAVEL: f32 = 1.5;

/// The weight of the toes, in the same vote. They point forward, but tips in some files are misplaced.
const BY_TOES: f32 = 1.0;

/// The weight of the tree, in the same vote. In most files, the hind legs are nearer to the root.
const BY_TREE: f32 = 0.75;

/// The smallest length of a path that counts, as a fraction of the length of the legs. A shorter path is sway.
const TRAVELLED: f32 = 1.0;

/// The smallest distance of toes in front of their paws, as a fraction of the length of the legs. A smaller distance is
/// rounding.
const TOES_AHEAD: f32 = 0.03;

/// The positions of all nodes in the poses in which four legs stand.
pub(super) struct Stance<'a> {
    pub(super) tree: &'a Tree,
    pub(super) views: Vec<Vec<Vec3>>,
    pub(super) pairs: [&'a Legs; 2],
    pub(super) length: f32,
    /// Whether +X is forward at rest, as in the file of a robot.
    pub(super) is_robot: bool,
}

impl Stance<'_> {
    /// The mean over the poses.
    fn mean(&self, value: impl Fn(&[Vec3]) -> f32) -> f32 {
        let sum: f32 = self.views.iter().map(|view| value(view)).sum();
        sum / self.views.len().max(1) as f32
    }

    /// The direction from the second pair to the first pair.
    fn along(&self, view: &[Vec3]) -> Vec3 {
        (self.pairs[0].middle(view) - self.pairs[1].middle(view)).normalize_or_zero()
    }

    /// The distance of a node from the middle of the trunk towards the first pair, in lengths of legs.
    fn ahead(&self, node: usize) -> f32 {
        self.mean(|view| {
            let middle = 0.5 * (self.pairs[0].middle(view) + self.pairs[1].middle(view));
            (view[node] - middle).dot(self.along(view)) / self.length
        })
    }

    /// The votes on whether the first pair is in front. Positive votes confirm it.
    fn votes(&self) -> Vec<f32> {
        let tree = self.tree;
        let [one, other] = self.pairs;
        let named = one.named(tree) - other.named(tree);
        let of_nodes = |is_wanted: &dyn Fn(usize) -> bool| {
            let nodes = (0..tree.names.len()).filter(|node| tree.is_joint[*node] && is_wanted(*node));
            nodes.map(|node| self.ahead(node)).sum::<f32>()
        };
        let head = of_nodes(&|node| tree.names[node].says(Part::Head));
        let tail = of_nodes(&|node| tree.names[node].animal == Some(AnimalPart::Tail));
        let limbs = || self.pairs.iter().flat_map(|legs| &legs.limbs);
        let toes = self.mean(|view| {
            let along = self.along(view);
            let ahead = limbs().map(|limb| (view[limb.tip] - view[limb.paw]).dot(along));
            0.25 * ahead.sum::<f32>() / self.length
        });
        let steps = self.views.windows(2).map(|pair| {
            let moved = one.middle(&pair[1]) + other.middle(&pair[1]) - one.middle(&pair[0]) - other.middle(&pair[0]);
            0.5 * moved.dot(self.along(&pair[0]))
        });
        // The last view is the rest pose, which is no part of the path.
        let count = self.views.len().saturating_sub(2);
        let travel = steps.take(count).sum::<f32>() / self.length;
        let is_below = |node: usize, above: usize| node != above && tree.is_within(node, above);
        let axes = match self.is_robot {
            true => self.along(&tree.at).x,
            false => 0.0,
        };
        let mut votes = vec![BY_NAME * named.clamp(-1.0, 1.0)];
        for (weight, value, least) in [
            (BY_AXES, axes, 0.0),
            (BY_HEAD_OR_TAIL, head, 0.0),
            (BY_HEAD_OR_TAIL, -tail, 0.0),
            (BY_TRAVEL, travel, TRAVELLED),
            (BY_TOES, toes, TOES_AHEAD),
        ] {
            votes.push(if value.abs() > least {
                weight * value.signum()
            } else {
                0.0
            });
        }
        votes.push(
            match (is_below(one.branch, other.branch), is_below(other.branch, one.branch)) {
                (true, _) => BY_TREE,
                (_, true) => -BY_TREE,
                _ => 0.0,
            },
        );
        votes
    }

    /// A limb without its girdle: a first bone that does not point down, and carries the leg sideways.
    fn without_girdle(&self, limb: &Limb) -> Limb {
        let down = self.mean(|view| {
            let leg = (view[limb.paw] - view[limb.upper]).normalize_or_zero();
            (view[limb.lower] - view[limb.upper]).normalize_or_zero().dot(leg)
        });
        match (limb.girdle, limb.ankle) {
            (None, Some(ankle)) if down < ASIDE => Limb {
                girdle: Some(limb.upper),
                upper: limb.lower,
                lower: ankle,
                ankle: None,
                ..limb.clone()
            },
            _ => limb.clone(),
        }
    }

    pub(super) fn read(mut self) -> Quadruped {
        let votes = self.votes();
        let sum: f32 = votes.iter().sum();
        if sum < 0.0 {
            self.pairs.swap(0, 1);
        }
        let against: f32 = votes
            .iter()
            .filter(|vote| vote.signum() != sum.signum())
            .map(|vote| vote.abs())
            .sum();
        let mut agrees: Option<bool> = None;
        let read = self
            .pairs
            .map(|pair| pair.limbs.each_ref().map(|limb| self.without_girdle(limb)));
        let legs = [0, 1].map(|index| {
            let (pair, [one, other]) = (self.pairs[index], &read[index]);
            let left = self.mean(|view| {
                let up = pair
                    .limbs
                    .iter()
                    .map(|limb| view[limb.upper] - view[limb.paw])
                    .sum::<Vec3>();
                (view[one.upper] - view[other.upper]).dot(up.cross(self.along(view)))
            });
            let ordered = if left > 0.0 { [one, other] } else { [other, one] };
            let named = ordered.map(|limb| limb.nodes().find_map(|node| self.tree.names[node].side));
            if let [Some(Side::Left), Some(Side::Right)] | [Some(Side::Right), Some(Side::Left)] = named {
                agrees = Some(agrees.unwrap_or(true) && named[0] == Some(Side::Left));
            }
            ordered
        });
        let (confidence, reason) = match agrees {
            Some(false) => (Confidence::Unsure, "the names exchange left and right"),
            _ if sum == 0.0 => (Confidence::Unsure, "nothing shows which legs are in front"),
            _ if against > 0.5 * sum.abs() => (
                Confidence::Unsure,
                "the signs of front and hind legs contradict each other",
            ),
            Some(true) if votes[0] != 0.0 => (
                Confidence::Sure,
                "four legs stand below a trunk, and have the names of legs",
            ),
            _ => (Confidence::Likely, "four legs stand below a trunk"),
        };
        let [fore, hind] = self.pairs.map(|pair| pair.branch);
        let trunk = self.tree.path(hind, fore);
        let (neck, head, tail) = self.ends(&trunk);
        let ids = |nodes: &[usize]| nodes.iter().map(|node| NodeId::new(*node)).collect::<Vec<_>>();
        let leg = |is_fore: bool, side: Side, limb: &Limb| QuadrupedLeg {
            is_fore,
            side,
            girdle: limb.girdle.map(NodeId::new),
            upper: NodeId::new(limb.upper),
            lower: NodeId::new(limb.lower),
            ankle: limb.ankle.map(NodeId::new),
            paw: NodeId::new(limb.paw),
        };
        let [[left_fore, right_fore], [left_hind, right_hind]] = legs;
        Quadruped {
            confidence,
            reason: reason.to_owned(),
            pelvis: NodeId::new(hind),
            spine: ids(trunk.get(1..trunk.len().saturating_sub(1)).unwrap_or_default()),
            withers: NodeId::new(fore),
            neck: ids(&neck),
            head: head.map(NodeId::new),
            tail: ids(&tail),
            legs: [
                leg(true, Side::Left, left_fore),
                leg(true, Side::Right, right_fore),
                leg(false, Side::Left, left_hind),
                leg(false, Side::Right, right_hind),
            ],
        }
    }

    /// The neck, the head and the tail: chains that branch from the trunk or from its ancestors.
    fn ends(&self, trunk: &[usize]) -> (Vec<usize>, Option<usize>, Vec<usize>) {
        let tree = self.tree;
        let above = |node: &usize| std::iter::successors(tree.parent[*node], |node| tree.parent[*node]);
        let mut stems: Vec<usize> = trunk.to_vec();
        stems.extend(trunk.first().into_iter().flat_map(above));
        let roots: Vec<usize> = self
            .pairs
            .iter()
            .flat_map(|legs| &legs.limbs)
            .map(|limb| limb.root)
            .collect();
        let holds_a_leg = |node: usize| roots.iter().any(|root| tree.is_within(*root, node));
        let starts = stems.iter().flat_map(|stem| &tree.children[*stem]).copied();
        let starts = starts.filter(|start| tree.is_joint[*start] && !stems.contains(start) && !holds_a_leg(*start));
        // Chains with a leg are excluded above.
        let mut chains: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for start in starts {
            let length = tree.bone[start] + tree.reach[start];
            if length > SHORTEST_CHAIN * self.length {
                chains.insert(start, tree.chain(start));
            }
        }
        let says = |chain: &[usize], parts: &[Part]| {
            chain
                .iter()
                .any(|node| parts.iter().any(|part| tree.names[*node].says(*part)))
        };
        let is_tail = |chain: &[usize]| {
            chain
                .iter()
                .any(|node| tree.names[*node].animal == Some(AnimalPart::Tail))
        };
        let end = |chain: &[usize]| chain.last().map_or(0.0, |node| self.ahead(*node));
        let [front, rear] = self
            .pairs
            .map(|pair| 0.5 * (self.ahead(pair.limbs[0].upper) + self.ahead(pair.limbs[1].upper)));
        let named_head = chains.values().find(|chain| says(chain, &[Part::Neck, Part::Head]));
        let neck = named_head.or_else(|| {
            let ahead = chains.values().filter(|chain| end(chain) > front && !is_tail(chain));
            ahead.max_by(|a, b| end(a).total_cmp(&end(b)))
        });
        let tail = chains.values().find(|chain| is_tail(chain)).or_else(|| {
            let behind = chains
                .values()
                .filter(|chain| end(chain) < rear && Some(*chain) != neck && !says(chain, &[Part::Spine]));
            behind.min_by(|a, b| end(a).total_cmp(&end(b)))
        });
        let joints = |chain: Option<&Vec<usize>>| -> Vec<usize> {
            let nodes = chain.into_iter().flatten().copied();
            nodes.filter(|node| tree.is_joint[*node]).collect()
        };
        let (mut neck, mut tail) = (joints(neck), joints(tail));
        neck.retain(|node| !tree.names[*node].is_helper);
        // A joint named tail counts as a helper, because people have no tail. An animal keeps such joints.
        tail.retain(|node| !tree.names[*node].is_helper || tree.names[*node].animal.is_some());
        let named = neck.iter().position(|node| tree.names[*node].says(Part::Head));
        let branches = || neck.iter().position(|node| tree.children[*node].len() > 2);
        let at = named.or_else(branches).or(neck.len().checked_sub(1));
        let head = at.map(|at| neck[at]);
        neck.truncate(at.unwrap_or(0));
        (neck, head, tail)
    }
}
