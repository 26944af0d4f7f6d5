//! Pairs the joints of two skeletons.

use std::collections::{HashMap, VecDeque};

use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::scene::{HumanoidBone, NodeKind, Scene};

use super::chain::{Joint, Skeleton};
use super::{Finding, FindingKind};

/// The most names in a finding.
const MOST_NAMES: usize = 8;

/// The largest number of joints of one name among which the right parent is searched. This number limits the time for
/// files in which all joints share one name.
const MOST_CANDIDATES: usize = 256;

/// The joints that two skeletons have in common.
pub(super) struct Pairs {
    /// The indices in the source and in the file.
    pub(super) list: Vec<(usize, usize)>,
    /// For every joint of the source, and then of the file: the index of its pair in `list`.
    of_ours: Vec<Option<usize>>,
    of_theirs: Vec<Option<usize>>,
}

/// The comparable pairs of a file that has only some joints of its source.
pub(super) struct Rigid {
    /// Pairs whose position depends on no omitted joint.
    pub(super) has_position: Vec<bool>,
    /// Pairs whose rotation depends on no omitted joint.
    pub(super) has_rotation: Vec<bool>,
}

impl Pairs {
    /// Pairs joints with equal names. Ignores case, and characters other than letters and digits, if this pairs more
    /// joints.
    ///
    /// # Errors
    /// If there is no pair.
    pub(super) fn new(ours: &Skeleton, theirs: &Skeleton) -> Result<Self> {
        let simplified = |name: &str| {
            let letters = name.chars().filter(|c| c.is_alphanumeric());
            match letters.flat_map(char::to_lowercase).collect::<String>() {
                letters if letters.is_empty() => name.trim().to_owned(),
                letters => letters,
            }
        };
        let exact = match_names(ours, theirs, std::borrow::ToOwned::to_owned);
        let loose = match_names(ours, theirs, simplified);
        let list = if loose.len() > exact.len() { loose } else { exact };
        Self::of_list(list, ours, theirs)
    }

    /// The pairs that are bones, in a VRM animation of `source`. A node has the name of its joint in the source. A node
    /// for a bone that the source lacks has the name of the bone, and is not a joint of the source.
    ///
    /// # Errors
    /// If there is no pair.
    pub(super) fn of_bones(self, source: &Scene, ours: &Skeleton, theirs: &Skeleton) -> Result<Self> {
        let states_bones = source.nodes.iter().any(|node| node.humanoid_bone.is_some());
        let is_bone = |&(a, b): &(usize, usize)| {
            let (joint, name) = (&source.nodes[a], &theirs.joints[b].name);
            let is_of_source = !states_bones || joint.humanoid_bone.is_some();
            joint.name == *name && (is_of_source || HumanoidBone::ALL.iter().all(|bone| bone.as_str() != name))
        };
        Self::of_list(self.list.into_iter().filter(is_bone).collect(), ours, theirs)
    }

    fn of_list(list: Vec<(usize, usize)>, ours: &Skeleton, theirs: &Skeleton) -> Result<Self> {
        // A scene without a node has nothing to pair.
        let is_empty = ours.joints.is_empty() && theirs.joints.is_empty();
        if list.is_empty() && !is_empty {
            let message = "the file has no joint of its source";
            return Err(Diagnostic::new(Code::Unrepresentable, message)
                .help("compare the file with the file that it was made from")
                .into());
        }
        let mut of_ours = vec![None; ours.joints.len()];
        let mut of_theirs = vec![None; theirs.joints.len()];
        for (index, &(a, b)) in list.iter().enumerate() {
            of_ours[a] = Some(index);
            of_theirs[b] = Some(index);
        }
        Ok(Self {
            list,
            of_ours,
            of_theirs,
        })
    }

    /// The joints of one kind that the file lacks.
    pub(super) fn missing(&self, ours: &Skeleton, kind: NodeKind) -> Vec<String> {
        let joints = ours.joints.iter().zip(&self.of_ours);
        let missing = joints.filter(|(joint, pair)| joint.kind == kind && pair.is_none());
        missing.map(|(joint, _)| joint.name.clone()).collect()
    }

    /// Finds joints that are missing, renamed, or have another parent. In a file of this crate, which drops and adds
    /// nothing, missing end sites and additional joints are findings too.
    pub(super) fn find(
        &self,
        ours: &Skeleton,
        theirs: &Skeleton,
        is_ours: bool,
        added_roots: usize,
        findings: &mut Vec<Finding>,
    ) {
        let mut find = |kind, names: Vec<String>, singular: &str, plural: &str| {
            if !names.is_empty() {
                let verb = if names.len() == 1 { singular } else { plural };
                findings.push(Finding::new(kind, format!("{} {verb}", listed(&names))));
            }
        };
        let mut missing = self.missing(ours, NodeKind::Joint);
        if is_ours {
            missing.extend(self.missing(ours, NodeKind::EndSite));
        }
        find(
            FindingKind::MissingJoint,
            missing,
            "is not in the file",
            "are not in the file",
        );
        find(
            FindingKind::RenamedJoint,
            self.renamed(ours, theirs),
            "has another name",
            "have other names",
        );
        find(
            FindingKind::MovedJoint,
            self.moved(ours, theirs),
            "has another parent in the file",
            "have other parents in the file",
        );
        if is_ours {
            find(
                FindingKind::ExtraJoint,
                self.extra(ours, theirs, added_roots),
                "is not in the source",
                "are not in the source",
            );
        }
    }

    /// Pairs whose names differ by more than the limits of formats explain.
    fn renamed(&self, ours: &Skeleton, theirs: &Skeleton) -> Vec<String> {
        let mut of_name: HashMap<String, usize> = HashMap::new();
        for joint in &ours.joints {
            *of_name.entry(kept_of(&joint.name)).or_default() += 1;
        }
        let renamed = self.list.iter().filter_map(|&(a, b)| {
            let is_named_by_parent = is_named_by_parent(theirs, b);
            let (ours, theirs) = (&ours.joints[a].name, &theirs.joints[b].name);
            let name = kept_of(ours);
            let is_numbered = without_number(&kept_of(theirs)) == Some(name.as_str()) && of_name[&name] > 1;
            let is_renamed = !is_kept(ours, theirs) && !is_numbered && !is_named_by_parent;
            is_renamed.then(|| format!("\"{ours}\" (\"{theirs}\" in the file)"))
        });
        renamed.collect()
    }

    /// Joints of pairs whose parents are not a pair.
    fn moved(&self, ours: &Skeleton, theirs: &Skeleton) -> Vec<String> {
        // The node of an expression may have any parent.
        let is_moved = |(a, b): &&(usize, usize)| {
            ours.joints[*a].face.is_none()
                && self.above(ours, &self.of_ours, *a) != self.above(theirs, &self.of_theirs, *b)
        };
        let moved = self.list.iter().filter(is_moved);
        moved.map(|(a, _)| quoted(&ours.joints[*a])).collect()
    }

    /// Joints that only the file has. `added_roots` of these joints may be root motion joints above the first root.
    fn extra(&self, ours: &Skeleton, theirs: &Skeleton, mut added_roots: usize) -> Vec<String> {
        let is_group = |name: &str| {
            ours.joints.iter().any(|joint| {
                let is_its = joint.name == name || without_number(name) == Some(joint.name.as_str());
                joint.kind == NodeKind::Group && is_its
            })
        };
        let extra = theirs.joints.iter().zip(&self.of_theirs).filter(|(joint, pair)| {
            let is_extra = pair.is_none() && !joint.shows && joint.kind != NodeKind::Group && !is_group(&joint.name);
            let is_expected = is_extra && added_roots > 0;
            added_roots -= usize::from(is_expected);
            is_extra && !is_expected
        });
        extra.map(|(joint, _)| quoted(joint)).collect()
    }

    /// Finds the comparable pairs of a file that has only some joints of its source, with another rest pose.
    pub(super) fn rigid(&self, ours: &Skeleton, theirs: &Skeleton) -> Rigid {
        // A joint that always keeps its rest offset from its nearest paired ancestor.
        let is_attached = |&(a, b): &(usize, usize)| {
            let above = self.above(ours, &self.of_ours, a);
            let mut between = std::iter::successors(ours.joints[a].parent, |joint| ours.joints[*joint].parent)
                .take_while(|joint| self.of_ours[*joint].is_none());
            above == self.above(theirs, &self.of_theirs, b)
                && (above.is_none()
                    || ours.joints[a].keeps_place() && between.all(|joint| ours.joints[joint].is_still()))
        };
        let mut rigid = Rigid {
            has_position: Vec::with_capacity(self.list.len()),
            has_rotation: vec![true; self.list.len()],
        };
        // In the order of the source, so that ancestors come first.
        for pair in &self.list {
            let (above, is_attached) = (self.above(ours, &self.of_ours, pair.0), is_attached(pair));
            let is_below_place = above.is_none_or(|above| rigid.has_position[above]);
            rigid.has_position.push(is_attached && is_below_place);
            if let Some(above) = above.filter(|_| !is_attached) {
                rigid.has_rotation[above] = false;
            }
        }
        rigid
    }

    /// The pair of the nearest paired ancestor.
    fn above(&self, skeleton: &Skeleton, pair_of: &[Option<usize>], joint: usize) -> Option<usize> {
        paired_above(skeleton, pair_of, joint).and_then(|above| pair_of[above])
    }
}

/// The joints of the file with one key (a name and a kind), in the order of the file. Paired joints at the front are
/// removed.
#[derive(Default)]
struct Candidates(VecDeque<usize>);

/// The state of the pairing of two skeletons.
struct PairSearch<'a, 'b> {
    ours: &'a Skeleton<'b>,
    theirs: &'a Skeleton<'b>,
    /// For every joint of the source, the paired joint of the file.
    of_ours: Vec<Option<usize>>,
    of_theirs: Vec<Option<usize>>,
    /// The number of descendant joints of each joint, in the source and in the file.
    joints_below: [Vec<usize>; 2],
}

/// Pairs joints with equal keys. If several joints share a key, the parents must be a pair too, so that the hand of the
/// left arm stays with the left arm. The remaining joints are paired in their order.
fn match_names(ours: &Skeleton, theirs: &Skeleton, key: impl Fn(&str) -> String) -> Vec<(usize, usize)> {
    // Other programs do not mark end sites, so the mark is part of the key only if the file has marks.
    let marks = theirs.joints.iter().any(|joint| joint.kind == NodeKind::EndSite);
    let key = |joint: &Joint| (key(&joint.name), marks && joint.kind == NodeKind::EndSite);
    let mut candidates: HashMap<(String, bool), Candidates> = HashMap::new();
    for (index, joint) in theirs.joints.iter().enumerate() {
        candidates.entry(key(joint)).or_default().0.push_back(index);
    }
    let counts: HashMap<_, _> = candidates
        .iter()
        .map(|(key, found)| (key.clone(), found.0.len()))
        .collect();
    let keys: Vec<_> = ours.joints.iter().map(key).collect();
    let mut wanted: HashMap<&(String, bool), usize> = HashMap::new();
    for key in &keys {
        *wanted.entry(key).or_default() += 1;
    }
    let mut matching = PairSearch {
        ours,
        theirs,
        of_ours: vec![None; ours.joints.len()],
        of_theirs: vec![None; theirs.joints.len()],
        joints_below: [ours, theirs].map(joints_below),
    };
    for by_parent in [true, false] {
        for (index, key) in keys.iter().enumerate() {
            let Some(found) = candidates.get_mut(key) else { continue };
            let count = counts[key];
            // Many formats omit groups. Then the only node with this name is the joint.
            let is_left_out = ours.joints[index].kind == NodeKind::Group && count < wanted[key];
            if is_left_out || matching.of_ours[index].is_some() {
                continue;
            }
            let is_only_one = count == 1 && wanted[key] == 1;
            // A joint without a name can only be identified by its parent.
            let needs_parent = !is_only_one && (by_parent || key.0.is_empty());
            matching.pair_first(index, found, needs_parent);
        }
    }
    matching.pair_stand_ins();
    // A joint and an end site of the same name are a pair, too.
    for (index, (name, is_end_site)) in keys.iter().enumerate() {
        let other = (name.clone(), !is_end_site);
        if let Some(found) = candidates.get_mut(&other).filter(|_| matching.of_ours[index].is_none()) {
            matching.pair_first(index, found, true);
        }
    }
    let unnamed = (0..ours.joints.len()).filter(|index| is_unnamed(&ours.joints[*index]));
    let mut all = Candidates((0..theirs.joints.len()).collect());
    for index in unnamed {
        if matching.of_ours[index].is_none() && ours.joints[index].kind != NodeKind::Group {
            matching.pair_first(index, &mut all, true);
        }
    }
    let pairs = matching.of_ours.iter().enumerate();
    // A file may have a motion but no joint. Only its groups can be compared.
    let has_joints = ours.joints.iter().any(|joint| joint.kind != NodeKind::Group);
    pairs
        .filter(|(index, _)| !has_joints || ours.joints[*index].kind != NodeKind::Group)
        .filter_map(|(index, pair)| Some((index, (*pair)?)))
        .collect()
}

impl PairSearch<'_, '_> {
    /// Pairs joints whose names a format cannot store: a repeated name gets a number in the file, and an empty name
    /// becomes the joint's kind.
    fn pair_stand_ins(&mut self) {
        let mut candidates: HashMap<String, Candidates> = HashMap::new();
        for (index, joint) in self.theirs.joints.iter().enumerate() {
            if self.of_theirs[index].is_none() {
                let name = kept_of(&joint.name);
                if let Some(name) = without_number(&name) {
                    candidates.entry(name.to_owned()).or_default().0.push_back(index);
                }
                candidates.entry(name).or_default().0.push_back(index);
            }
        }
        for needs_parent in [true, false] {
            for (index, joint) in self.ours.joints.iter().enumerate() {
                let name = match joint.kind {
                    NodeKind::Group => continue,
                    NodeKind::Joint if is_unnamed(joint) => "Joint".to_owned(),
                    NodeKind::EndSite if is_unnamed(joint) => "EndSite".to_owned(),
                    _ => kept_of(&joint.name),
                };
                let is_free = self.of_ours[index].is_none();
                if let Some(found) = candidates.get_mut(&name).filter(|_| is_free) {
                    self.pair_first(index, found, needs_parent);
                }
            }
        }
    }

    /// Pairs a joint of the source with the first of `candidates` that is free.
    fn pair_first(&mut self, ours: usize, candidates: &mut Candidates, needs_parent: bool) {
        while candidates
            .0
            .front()
            .is_some_and(|first| self.of_theirs[*first].is_some())
        {
            candidates.0.pop_front();
        }
        let above = needs_parent.then(|| paired_above(self.ours, &self.of_ours, ours));
        let is_below = |theirs: usize| {
            let Some(above) = above else { return true };
            let parent = paired_above(self.theirs, &self.of_theirs, theirs);
            above.and_then(|above| self.of_ours[above]) == parent
        };
        let free = candidates
            .0
            .iter()
            .take(MOST_CANDIDATES)
            .filter(|theirs| self.of_theirs[**theirs].is_none() && is_below(**theirs));
        // The root of every FBX file is a group that may have the name of a descendant joint.
        let is_group = |skeleton: &Skeleton, joint: usize| skeleton.joints[joint].kind == NodeKind::Group;
        let is_alike = |theirs: &&usize| is_group(self.theirs, **theirs) == is_group(self.ours, ours);
        // Without a name, the number of descendants distinguishes a joint from the node of a mesh.
        let [below_ours, below_theirs] = &self.joints_below;
        let is_shaped =
            |theirs: &&usize| is_unnamed(&self.ours.joints[ours]) && below_theirs[**theirs] == below_ours[ours];
        let shaped = free.clone().filter(is_shaped);
        let in_order = [
            shaped.clone().find(is_alike),
            shaped.clone().next(),
            free.clone().find(is_alike),
        ];
        if let Some(&theirs) = in_order.into_iter().flatten().next().or_else(|| free.clone().next()) {
            self.of_ours[ours] = Some(theirs);
            self.of_theirs[theirs] = Some(ours);
        }
    }
}

/// For every node, the number of its descendants without groups.
fn joints_below(skeleton: &Skeleton) -> Vec<usize> {
    let mut below = vec![0; skeleton.joints.len()];
    for (index, joint) in skeleton.joints.iter().enumerate().rev() {
        if let Some(parent) = joint.parent {
            below[parent] += below[index] + usize::from(joint.kind != NodeKind::Group);
        }
    }
    below
}

/// The nearest ancestor with a pair.
fn paired_above(skeleton: &Skeleton, pair_of: &[Option<usize>], joint: usize) -> Option<usize> {
    let above = |joint: &usize| skeleton.joints[*joint].parent;
    std::iter::successors(above(&joint), above).find(|joint| pair_of[*joint].is_some())
}

fn is_unnamed(joint: &Joint) -> bool {
    joint.name.trim().is_empty()
}

/// Whether two names differ only in characters that some formats do not allow. These are separators, braces and `#`,
/// replaced by `_` or the replacement character, and spaces around the name. An unnamed joint may get any name.
fn is_kept(ours: &str, theirs: &str) -> bool {
    ours.trim().is_empty() || kept_of(ours) == kept_of(theirs)
}

/// The part of a name that every format keeps.
pub(super) fn kept_of(name: &str) -> String {
    let is_replaced = |c: char| c.is_control() || "{}#\u{fffd}\u{2028}\u{2029}".contains(c);
    let stands_for = |c: char| if is_replaced(c) { '_' } else { c };
    name.trim().chars().map(stands_for).collect()
}

/// A name without the number that distinguishes it from equal names, if it has such a number.
fn without_number(name: &str) -> Option<&str> {
    let (name, number) = name.rsplit_once('_')?;
    number.parse::<u32>().is_ok().then_some(name)
}

/// Whether this is an end site with a default name, as in BVH, where end sites have no names.
fn is_named_by_parent(skeleton: &Skeleton, joint: usize) -> bool {
    let joint = &skeleton.joints[joint];
    let parent = joint.parent.map_or("", |parent| &skeleton.joints[parent].name);
    joint.kind == NodeKind::EndSite && joint.name.strip_prefix("EndSite_") == Some(parent)
}

fn quoted(joint: &Joint) -> String {
    format!("\"{}\"", joint.name)
}

fn listed(names: &[String]) -> String {
    let shown = names.iter().take(MOST_NAMES).map(|name| match name.starts_with('"') {
        true => name.clone(),
        false => format!("\"{name}\""),
    });
    let shown: Vec<_> = shown.collect();
    match names.len().checked_sub(MOST_NAMES) {
        None | Some(0) => shown.join(", "),
        Some(more) => format!("{} and {more} more", shown.join(", ")),
    }
}
