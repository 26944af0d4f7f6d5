//! Which joint of one skeleton is which of the other.

use std::collections::{HashMap, VecDeque};

use super::chain::{Joint, Skeleton};
use super::{Finding, FindingKind};
use crate::error::{Code, Diagnostic, Result};
use crate::scene::NodeKind;

/// Names that are told at most, of many findings of one kind.
const MOST_NAMES: usize = 8;

/// The joints that two skeletons have in common.
pub(super) struct Pairs {
    /// The indices in the source and in the file.
    pub(super) list: Vec<(usize, usize)>,
    /// Of every joint of the source and of the file, its index in the list.
    of_ours: Vec<Option<usize>>,
    of_theirs: Vec<Option<usize>>,
}

/// Which pairs can be compared in a file that has only some joints of its source.
pub(super) struct Rigid {
    /// Those whose position depends on no other joint.
    pub(super) has_place: Vec<bool>,
    /// Those whose rotation depends on no other joint.
    pub(super) has_turn: Vec<bool>,
}

impl Pairs {
    /// Pairs joints of equal names, several of one name in their order. A name that only one joint has may also differ
    /// in case and in all that is neither letter nor digit.
    ///
    /// # Errors
    /// Where there is no pair.
    pub(super) fn new(ours: &Skeleton, theirs: &Skeleton) -> Result<Self> {
        let simplified = |name: &str| {
            name.chars()
                .filter(|c| c.is_alphanumeric())
                .flat_map(char::to_lowercase)
                .collect()
        };
        let exact = match_names(ours, theirs, std::borrow::ToOwned::to_owned);
        let loose = match_names(ours, theirs, simplified);
        let list = if loose.len() > exact.len() { loose } else { exact };
        if list.is_empty() {
            let message = "the file has no joint of its source";
            return Err(Diagnostic::new(Code::Unrepresentable, message)
                .help("compare it with the file it was made from")
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

    /// The joints of one kind that the file does not have.
    pub(super) fn missing(&self, ours: &Skeleton, kind: NodeKind) -> Vec<String> {
        let joints = ours.joints.iter().zip(&self.of_ours);
        let missing = joints.filter(|(joint, pair)| joint.kind == kind && pair.is_none());
        missing.map(|(joint, _)| joint.name.clone()).collect()
    }

    /// Finds joints that are missing, called otherwise, or on another parent; in a file of this crate, which leaves
    /// nothing out and adds nothing, also end sites that are missing, and joints that are too many.
    pub(super) fn find(
        &self,
        ours: &Skeleton,
        theirs: &Skeleton,
        is_ours: bool,
        has_root_motion: bool,
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
        let renamed = self.list.iter().filter_map(|&(a, b)| {
            let (ours, theirs) = (&ours.joints[a].name, &theirs.joints[b].name);
            (ours != theirs).then(|| format!("\"{ours}\" as \"{theirs}\""))
        });
        find(
            FindingKind::RenamedJoint,
            renamed.collect(),
            "is called otherwise in the file",
            "are called otherwise in the file",
        );
        let moved = self
            .list
            .iter()
            .filter(|(a, b)| self.above(ours, &self.of_ours, *a) != self.above(theirs, &self.of_theirs, *b));
        find(
            FindingKind::MovedJoint,
            moved.map(|(a, _)| quoted(&ours.joints[*a])).collect(),
            "has another parent in the file",
            "have other parents in the file",
        );
        if is_ours {
            let is_group = |name: &str| {
                ours.joints
                    .iter()
                    .any(|joint| joint.kind == NodeKind::Group && joint.name == name)
            };
            // The joint for the path over the ground stands above the first root.
            let mut added = usize::from(has_root_motion);
            let extra = theirs.joints.iter().zip(&self.of_theirs).filter(|(joint, pair)| {
                let is_extra =
                    pair.is_none() && !joint.shows && joint.kind != NodeKind::Group && !is_group(&joint.name);
                let is_expected = is_extra && added > 0;
                added -= usize::from(is_expected);
                is_extra && !is_expected
            });
            let extra = extra.map(|(joint, _)| quoted(joint)).collect();
            find(
                FindingKind::ExtraJoint,
                extra,
                "is not in the source",
                "are not in the source",
            );
        }
    }

    /// What can be compared where a file has only some joints of its source, each with another rest pose.
    pub(super) fn rigid(&self, ours: &Skeleton, theirs: &Skeleton) -> Rigid {
        // A joint whose offset from the one above in a pair is that of the rest pose, at all times.
        let is_attached = |&(a, b): &(usize, usize)| {
            let above = self.above(ours, &self.of_ours, a);
            let mut between = std::iter::successors(ours.joints[a].parent, |joint| ours.joints[*joint].parent)
                .take_while(|joint| self.of_ours[*joint].is_none());
            above == self.above(theirs, &self.of_theirs, b)
                && (above.is_none()
                    || ours.joints[a].keeps_place() && between.all(|joint| ours.joints[joint].is_still()))
        };
        let mut rigid = Rigid {
            has_place: Vec::with_capacity(self.list.len()),
            has_turn: vec![true; self.list.len()],
        };
        // In the order of the source, so that those above come first.
        for pair in &self.list {
            let (above, is_attached) = (self.above(ours, &self.of_ours, pair.0), is_attached(pair));
            let is_below_place = above.is_none_or(|above| rigid.has_place[above]);
            rigid.has_place.push(is_attached && is_below_place);
            if let Some(above) = above.filter(|_| !is_attached) {
                rigid.has_turn[above] = false;
            }
        }
        rigid
    }

    /// The pair of the nearest joint above that is in a pair.
    fn above(&self, skeleton: &Skeleton, pair_of: &[Option<usize>], joint: usize) -> Option<usize> {
        let mut above = skeleton.joints[joint].parent;
        while let Some(joint) = above {
            if pair_of[joint].is_some() {
                return pair_of[joint];
            }
            above = skeleton.joints[joint].parent;
        }
        None
    }
}

fn match_names(ours: &Skeleton, theirs: &Skeleton, key: impl Fn(&str) -> String) -> Vec<(usize, usize)> {
    let mut places: HashMap<(String, bool), VecDeque<usize>> = HashMap::new();
    // Other programs do not mark end sites, so that whether a node is one tells nodes apart only if the file says so.
    let marks = theirs.joints.iter().any(|joint| joint.kind == NodeKind::EndSite);
    let key = |joint: &Joint| (key(&joint.name), marks && joint.kind == NodeKind::EndSite);
    for (place, joint) in theirs.joints.iter().enumerate() {
        places.entry(key(joint)).or_default().push_back(place);
    }
    let sources = ours
        .joints
        .iter()
        .enumerate()
        .filter(|(_, joint)| joint.kind != NodeKind::Group);
    sources
        .filter_map(|(index, joint)| Some((index, places.get_mut(&key(joint))?.pop_front()?)))
        .collect()
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
