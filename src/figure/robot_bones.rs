//! Finds the links of a robot that are bones of a humanoid, by the shape of its tree. Names help if they have a
//! meaning.
//!
//! A bone is a group of joints: three hinges of a hip make a thigh. Chains of joints without a branch are limbs. Two
//! limbs that begin at one link and mirror each other are a pair. The pair that reaches lowest is the legs. The pair
//! that begins highest is the arms. In a limb, the knee or the elbow is the joint with the name of a knee or an elbow.
//! If several joints have this name, the first joint with an axis across the limb is chosen. If no joint has this name,
//! the joint with the longest links above and below it is chosen, or otherwise the fourth joint.

mod feet;
pub mod moving;
pub mod sole;
mod standing;
pub mod t_pose;

use std::collections::BTreeMap;

use glam::{DMat3, DVec3};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::scene::report::SourceLines;
use mocap_scene::scene::robot::{Placement, Robot};
use mocap_scene::scene::{HumanoidBone as Bone, Metadata, Node, NodeId, NodeKind, Scene, Side, UpAxis};
use serde::Serialize;

pub use self::standing::{links_of_four_legs, sort_legs, standing_limbs};
use super::humanoid::HumanoidMap;
use super::names::{self, Name};

/// The names of the links that are bones; `None` for a bone that the robot lacks. Links do not follow other links.
pub type RobotMap = HumanoidMap;

/// A bone of a humanoid in a robot: a link, and the joints that rotate it relative to the parent bone.
///
/// `RobotOptions` has an example.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct RobotBone {
    /// The bone of the humanoid.
    pub bone: Bone,
    /// The link that moves with the bone, as an index into [`Robot::links`].
    pub link: usize,
    /// The links whose joints rotate the bone, from the body outwards. The last is `link`, or an ancestor of `link`.
    pub joints: Vec<usize>,
    /// The start of the bone with all joints at 0, in the coordinate frame of the base: the point nearest to the axes
    /// of its joints.
    pub at: DVec3,
}

/// The largest height difference between the ends of a pair, as a fraction of the height of the robot.
const LEVEL: f64 = 0.03;

/// The smallest cosine of the angle between an axis and a limb at which the joint rolls the limb and does not bend it.
const ALONG: f64 = 0.8;

/// The smallest number of joints of a limb.
const LIMB: usize = 3;

/// The largest height of the end of a standing limb above the lowest end, as a fraction of the leg. Arms end higher.
const LOW: f64 = 0.2;

/// The smallest set of bones of a humanoid, and of an upper body.
const LEGS: [Bone; 6] = [
    Bone::LeftUpperLeg,
    Bone::LeftLowerLeg,
    Bone::LeftFoot,
    Bone::RightUpperLeg,
    Bone::RightLowerLeg,
    Bone::RightFoot,
];
const ARMS: [Bone; 4] = [
    Bone::LeftUpperArm,
    Bone::LeftLowerArm,
    Bone::RightUpperArm,
    Bone::RightLowerArm,
];

/// The smallest length of the upper and of the lower part of a limb, as a fraction of the limb. A knee or an elbow
/// divides the limb.
const HALF: f64 = 0.25;

/// A chain of moving links without a branch.
#[derive(Clone, Debug)]
struct Limb {
    /// The moving link, or the base, from which it branches off.
    from: usize,
    links: Vec<usize>,
}

/// The bones of the humanoid that a robot has. The bones of `map` replace inferred ones.
///
/// # Errors
/// [`Code::NotHumanoid`] if the robot has neither two legs nor two arms (upper bodies on wheels have two arms);
/// [`Code::InvalidValue`] if no link has a name of the map.
pub fn robot_bones(robot: &Robot, map: Option<&RobotMap>) -> Result<Vec<RobotBone>> {
    if let Some(link) = map.and_then(|map| map.follow.keys().next()) {
        let message = format!(
            "the map lets the link {link:?} follow another link, but only the joints of a robot move its links"
        );
        let diagnostic = Diagnostic::new(Code::InvalidValue, message);
        return Err(diagnostic.help("leave \"follow\" out of the map").into());
    }
    let tree = Tree::new(robot);
    let mut links: BTreeMap<Bone, usize> = match tree.find() {
        Ok(links) => links,
        Err(_) if map.is_some_and(|map| map.len() >= 5) => BTreeMap::new(),
        Err(reason) => {
            let message = format!("the robot is not a humanoid: {reason}");
            return Err(Diagnostic::new(Code::NotHumanoid, message)
                .help("name the links that are its bones in a map of the robot: {robot-map}")
                .into());
        }
    };
    for (bone, name) in map.into_iter().flat_map(|map| &map.bones) {
        let Some(name) = name else {
            links.remove(bone);
            continue;
        };
        let Some(link) = robot.links.iter().position(|link| link.name == *name) else {
            let message = format!("no link is called {name:?}, which the map names as {}", bone.as_str());
            return Err(Diagnostic::new(Code::InvalidValue, message).into());
        };
        links.insert(*bone, link);
    }
    let is_leg = |bone: &Bone| LEGS.contains(bone);
    let needed: &[Bone] = match links.keys().any(is_leg) || !ARMS.iter().all(|arm| links.contains_key(arm)) {
        true => &LEGS,
        false => &ARMS,
    };
    for bone in [Bone::Hips].iter().chain(needed) {
        if !links.contains_key(bone) {
            let message = format!("the robot is not a humanoid: no link is the bone {}", bone.as_str());
            return Err(Diagnostic::new(Code::NotHumanoid, message)
                .help("name the links that are its bones in a map of the robot: {robot-map}")
                .into());
        }
    }
    let taken: Vec<usize> = links.values().copied().collect();
    let bones = links.iter().map(|(&bone, &link)| {
        // A foot may be a part of the link of the shin.
        if taken.iter().filter(|other| **other == link).count() > 1 && bone.on(Side::Left) == Bone::LeftFoot {
            let at = tree.lowest_point(link).unwrap_or(tree.transforms[link].translation);
            let joints = Vec::new();
            return RobotBone { bone, link, joints, at };
        }
        let joints = tree.joints_to(link, &taken);
        let at = tree.centre(&joints).unwrap_or(tree.transforms[link].translation);
        RobotBone { bone, link, joints, at }
    });
    Ok(bones.collect())
}

/// A robot as a scene in metres, +Z up, with one node for each link. In the rest pose every joint is at 0. The links
/// that are bones of a humanoid are marked.
pub fn robot_scene(robot: &Robot) -> Scene {
    let nodes = robot.links.iter().map(|link| Node {
        name: link.name.clone(),
        kind: NodeKind::Joint,
        parent: link.parent.map(NodeId::new),
        transform: link.joint.link_to_parent(0.0).to_matrix(),
        source: Some(SourceLines {
            name: link.line,
            ..SourceLines::default()
        }),
        ..Node::default()
    });
    let mut scene = Scene {
        nodes: nodes.collect(),
        metadata: Metadata {
            format: robot.format,
            metres_per_unit: Some(1.0),
            up: Some(UpAxis::Z),
            ..Metadata::default()
        },
        ..Scene::default()
    };
    for bone in robot_bones(robot, None).unwrap_or_default() {
        let marked = &mut scene.nodes[bone.link].humanoid_bone;
        // A foot that is a part of the shin has no node.
        if marked.is_none() || !bone.joints.is_empty() {
            *marked = Some(bone.bone);
        }
    }
    scene
}

/// The moving links of a robot.
struct Tree<'a> {
    robot: &'a Robot,
    transforms: Vec<Placement>,
    /// For each link, the moving links below it: its children, and the children of links that are fixed to it.
    children: Vec<Vec<usize>>,
}

impl<'a> Tree<'a> {
    fn new(robot: &'a Robot) -> Self {
        let moves = |link: usize| link == 0 || robot.links[link].joint.moves();
        let mut carrier = vec![0; robot.links.len()];
        let mut children = vec![Vec::new(); robot.links.len()];
        for (index, link) in robot.links.iter().enumerate() {
            let Some(parent) = link.parent else { continue };
            carrier[index] = if moves(parent) { parent } else { carrier[parent] };
            if moves(index) {
                children[carrier[index]].push(index);
            }
        }
        Self {
            robot,
            transforms: robot.zero_pose(),
            children,
        }
    }

    fn end(&self, limb: &Limb) -> DVec3 {
        limb.links.last().map_or(DVec3::ZERO, |link| self.anchor(*link))
    }

    fn start(&self, limb: &Limb) -> DVec3 {
        limb.links.first().map_or(DVec3::ZERO, |link| self.anchor(*link))
    }

    /// A point on the axis of a link's joint.
    fn anchor(&self, link: usize) -> DVec3 {
        self.transforms[link].point(self.robot.links[link].joint.anchor)
    }

    fn limbs(&self) -> Vec<Limb> {
        let mut limbs = Vec::new();
        for (from, children) in self.children.iter().enumerate() {
            if from > 0 && children.len() < 2 {
                continue;
            }
            for &first in children {
                let mut links = vec![first];
                let mut last = first;
                while let [next] = self.children[last][..] {
                    links.push(next);
                    last = next;
                }
                limbs.push(Limb { from, links });
            }
        }
        limbs
    }

    /// The pairs of limbs, each with the left limb first. Pairs that begin at the end of another pair are fingers.
    fn pairs(&self, limbs: &[Limb], height: f64) -> Vec<[Limb; 2]> {
        let pairs = self.mirrored(limbs, height);
        let ends = pairs.iter().flatten().filter_map(|limb| limb.links.last().copied());
        let ends: Vec<usize> = ends.collect();
        pairs.into_iter().filter(|pair| !ends.contains(&pair[0].from)).collect()
    }

    fn mirrored(&self, limbs: &[Limb], height: f64) -> Vec<[Limb; 2]> {
        let mut pairs = Vec::new();
        let long = limbs.iter().enumerate().filter(|(_, limb)| limb.links.len() >= LIMB);
        let long: Vec<_> = long.collect();
        for (index, (_, a)) in long.iter().enumerate() {
            for (_, b) in &long[index + 1..] {
                let across = self.start(a) - self.start(b);
                let is_level = |difference: DVec3| difference.z.abs() <= LEVEL * height;
                let is_pair = a.from == b.from
                    && a.links.len() == b.links.len()
                    && is_level(across)
                    && is_level(self.end(a) - self.end(b))
                    && across.truncate().length() > LEVEL * height;
                if !is_pair {
                    continue;
                }
                let is_left = |limb: &Limb| self.side_by_name(limb);
                let a_is_left = match (is_left(a), is_left(b)) {
                    (Some(Side::Left), Some(Side::Right)) => true,
                    (Some(Side::Right), Some(Side::Left)) => false,
                    // +X is forward, by the convention of ROS.
                    _ => across.y > 0.0,
                };
                let (a, b) = ((*a).clone(), (*b).clone());
                pairs.push(if a_is_left { [a, b] } else { [b, a] });
            }
        }
        pairs
    }

    /// The names of a link and of the joint above it.
    fn names(&self, link: usize) -> [&str; 2] {
        let link = &self.robot.links[link];
        [&link.name, &link.joint.name]
    }

    fn words(&self, link: usize) -> Vec<String> {
        self.names(link).into_iter().flat_map(names::words).collect()
    }

    fn has_word(&self, link: usize, word: &str) -> bool {
        self.words(link).iter().any(|found| found.contains(word))
    }

    /// Whether the names mean that a limb is an arm.
    fn is_arm(&self, limb: &Limb) -> bool {
        let mut words = limb.links.iter().flat_map(|link| self.words(*link));
        words.any(|word| word.ends_with("arm") || ["shoulder", "elbow", "wrist"].iter().any(|part| word.contains(part)))
    }

    fn side_by_name(&self, limb: &Limb) -> Option<Side> {
        let names = limb.links.iter().flat_map(|link| self.names(*link));
        let sides: Vec<Side> = names.filter_map(|name| Name::read(name).side).collect();
        let left = sides.iter().filter(|side| **side == Side::Left).count();
        match left.cmp(&(sides.len() - left)) {
            std::cmp::Ordering::Greater => Some(Side::Left),
            std::cmp::Ordering::Less => Some(Side::Right),
            std::cmp::Ordering::Equal => None,
        }
    }

    /// Finds the link of each bone.
    fn find(&self) -> Result<BTreeMap<Bone, usize>, String> {
        let heights = self.transforms.iter().map(|link| link.translation.z);
        let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), z| {
            (low.min(z), high.max(z))
        });
        let height = high - low;
        let limbs = self.limbs();
        let pairs = self.pairs(&limbs, height);
        let standing = self.standing_limbs();
        if standing.len() > 2 {
            let words = if standing.len() == 4 { "four" } else { "more than two" };
            return Err(format!("it has {words} legs"));
        }
        let reach = |pair: &[Limb; 2]| self.end(&pair[0]).z;
        let lowest = pairs.iter().filter(|pair| !self.is_arm(&pair[0]));
        let lowest = lowest.min_by(|a, b| reach(a).total_cmp(&reach(b)));
        let Some(legs) = lowest else {
            let highest = pairs
                .iter()
                .max_by(|a, b| self.start(&a[0]).z.total_cmp(&self.start(&b[0]).z));
            let Some(arms) = highest else {
                return Err("no two limbs with at least three joints mirror each other, so it has no legs".to_owned());
            };
            // An upper body, on wheels or fixed: its base is the hips.
            let mut bones = BTreeMap::from([(Bone::Hips, 0)]);
            self.add_arms(arms, &limbs, &pairs, 0, &mut bones);
            return Ok(bones);
        };
        let leg = self.start(&legs[0]).z - self.end(&legs[0]).z;
        if leg < 0.2 * height {
            return Err("the limbs that reach lowest do not point down with all joints at 0".to_owned());
        }
        let others = pairs.iter().filter(|pair| {
            pair.iter()
                .all(|limb| legs.iter().all(|leg| leg.links[0] != limb.links[0]))
        });
        let is_below_a_leg = |limb: &Limb| legs.iter().any(|leg| leg.links.contains(&limb.from));
        let arms = others
            .filter(|pair| !is_below_a_leg(&pair[0]))
            .max_by(|a, b| self.start(&a[0]).z.total_cmp(&self.start(&b[0]).z));
        if let Some(arms) = arms
            && reach(arms) < reach(legs) + 0.2 * leg
        {
            return Err("it has four legs".to_owned());
        }
        let mut bones = BTreeMap::from([(Bone::Hips, legs[0].from)]);
        for (side, limb) in Side::ALL.into_iter().zip(legs) {
            let [first, knee] = self.middle(limb, "knee");
            let mut add = |bone: Bone, index: usize| bones.insert(bone.on(side), limb.links[index]);
            add(Bone::LeftUpperLeg, first - 1);
            add(Bone::LeftLowerLeg, knee);
            if knee + 1 < limb.links.len() {
                // An ankle has at most three joints. Further joints are toes.
                add(Bone::LeftFoot, (knee + 3).min(limb.links.len() - 1));
            } else if let Some(foot) = self.fixed_foot(limb.links[knee]) {
                bones.insert(Bone::LeftFoot.on(side), foot);
            }
        }
        if let Some(arms) = arms {
            self.add_arms(arms, &limbs, &pairs, legs[0].from, &mut bones);
        }
        Ok(bones)
    }

    /// Adds the bones of the arms, the chest and the head.
    fn add_arms(
        &self,
        arms: &[Limb; 2],
        limbs: &[Limb],
        pairs: &[[Limb; 2]],
        hips: usize,
        bones: &mut BTreeMap<Bone, usize>,
    ) {
        for (side, limb) in Side::ALL.into_iter().zip(arms) {
            let [first, elbow] = self.middle(limb, "elbow");
            let mut add = |bone: Bone, index: usize| bones.insert(bone.on(side), limb.links[index]);
            add(Bone::LeftUpperArm, first - 1);
            add(Bone::LeftLowerArm, elbow);
            if elbow + 1 < limb.links.len() {
                add(Bone::LeftHand, (elbow + 3).min(limb.links.len() - 1));
            }
        }
        let chest = arms[0].from;
        if chest != hips {
            bones.insert(Bone::Chest, chest);
        }
        let is_limb = |limb: &Limb| pairs.iter().flatten().any(|other| other.links[0] == limb.links[0]);
        let shoulders = self.start(&arms[0]).z;
        let head = limbs.iter().find(|limb| {
            let named = limb
                .links
                .iter()
                .any(|link| self.has_word(*link, "head") || self.has_word(*link, "neck"));
            limb.from == chest && !is_limb(limb) && (named || self.start(limb).z > shoulders)
        });
        if let Some(&head) = head.and_then(|limb| limb.links.last()) {
            bones.insert(Bone::Head, head);
        }
    }

    /// The first and the last joint of the knee or elbow in a limb, as indices. The first joint is the first one that
    /// has the name and bends the limb, because joints before it roll the upper bone. The last joint is the last one
    /// with the name. If no joint has the name, both are the joint of [`Self::halving`], or otherwise the fourth joint,
    /// or the middle joint of a short limb.
    fn middle(&self, limb: &Limb, word: &str) -> [usize; 2] {
        let mut named = (1..limb.links.len()).filter(|index| self.has_word(limb.links[*index], word));
        if let Some(last) = named.clone().next_back() {
            return [named.find(|index| self.bends(limb, *index)).unwrap_or(last), last];
        }
        if let Some(index) = self.halving(limb) {
            return [index; 2];
        }
        let usual = match limb.links.len() {
            0..=3 => limb
                .links
                .len()
                .saturating_sub(1)
                .min(if word == "knee" { 1 } else { 2 }),
            _ => 3,
        };
        [usual.max(1); 2]
    }

    /// The joint that bends a limb of more than four joints, if no joint has the name of a knee or an elbow. It has the
    /// longest links above and below it, unlike the joints of hips, shoulders, ankles and wrists.
    fn halving(&self, limb: &Limb) -> Option<usize> {
        let (start, end) = (self.start(limb), self.end(limb));
        let shorter = |index: usize| {
            let at = self.anchor(limb.links[index]);
            at.distance(start).min(at.distance(end))
        };
        let bending = (1..limb.links.len()).filter(|index| self.bends(limb, *index));
        let best = bending.max_by(|a, b| shorter(*a).total_cmp(&shorter(*b)))?;
        (limb.links.len() > 4 && shorter(best) > HALF * start.distance(end)).then_some(best)
    }

    /// Whether the axis of a joint is across the limb above it and below it.
    fn bends(&self, limb: &Limb, index: usize) -> bool {
        let link = limb.links[index];
        let axis = self.transforms[link].rotation * self.robot.links[link].joint.axis;
        let at = self.anchor(link);
        let segments = [at - self.start(limb), self.end(limb) - at];
        let along = segments.map(|segment| segment.normalize_or_zero().dot(axis).abs());
        along.into_iter().all(|cosine| cosine < ALONG)
    }

    /// The joints between a link and its nearest ancestor that is a bone, from the top down.
    fn joints_to(&self, link: usize, bones: &[usize]) -> Vec<usize> {
        let mut joints = Vec::new();
        let mut at = Some(link);
        while let Some(here) = at {
            if here != link && bones.contains(&here) {
                break;
            }
            if self.robot.links[here].joint.moves() {
                joints.push(here);
            }
            at = self.robot.links[here].parent;
        }
        joints.reverse();
        joints
    }

    /// The point nearest to the axes of some joints. Of many joints, the last three count, because clavicles and spines
    /// come before them. In a direction that the axes do not determine, it is the point of the first joint.
    fn centre(&self, joints: &[usize]) -> Option<DVec3> {
        /// The weight of the first joint, as a fraction of the weight of an axis. It only decides the direction that
        /// the axes do not determine.
        const PULL: f64 = 1e-4;

        /// The number of last joints that count: a ball joint has three.
        const JOINTS: usize = 3;
        let joints = &joints[joints.len().saturating_sub(JOINTS)..];
        let first = self.anchor(*joints.first()?);
        let mut matrix = DMat3::from_diagonal(DVec3::splat(PULL));
        let mut vector = PULL * first;
        for &joint in joints {
            let axis = self.transforms[joint].rotation * self.robot.links[joint].joint.axis;
            let outer = DMat3::from_cols(axis * axis.x, axis * axis.y, axis * axis.z);
            let across = DMat3::IDENTITY - outer;
            matrix += across;
            vector += across * self.anchor(joint);
        }
        Some(matrix.inverse() * vector).filter(|centre| centre.is_finite())
    }
}
