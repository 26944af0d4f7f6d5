//! Retargets the motion of a creature to another skeleton by joint names.
//!
//! For a creature, only the joint names are known. A joint of the target gets the world rotation that the source joint
//! of the same name has, relative to the rest pose. The highest moving joint gets the path over the ground, scaled by
//! the lengths of the bones. This path puts the lowest joints at the height that they have at rest. If the rest poses
//! differ, the poses in motion also differ. The report has the angles between bones.

use std::collections::HashMap;

use glam::{Mat4, Quat, Vec3};
use mocap_figure::Figure;
use mocap_figure::rig::Rig;
use mocap_figure::ticks::{Ticks, ticks};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::limits::positive;
use mocap_scene::math::directions::rotation_of;
use mocap_scene::math::up_axis::from_to;
use mocap_scene::pose::{Binding, Pose, Trs};
use mocap_scene::scene::report::{AppliedStep, SecondMotion};
use mocap_scene::scene::{Animation, Channel, Keys, NodeId, NodeKind, Scene, UpAxis};

use super::measure::skin::{SkinnedMotion, examine};
use super::quality::{ByNames, RetargetReport, verdict};
use super::skin_report::SkinReport;
use super::{Scale, no_animation};

/// The smallest number of common joint names of two skeletons of one kind. Fewer common names may be chance.
const FEWEST: usize = 4;

/// The smallest fraction of the source's joints with a common name: half, so that a rig with helpers is accepted.
const MOST_OF_THEM: f64 = 0.5;

/// The fraction of all frames whose lowest joint may be below the ground: a twentieth, as for contacts.
const BELOW: f64 = 0.05;

/// Retargets motions of a creature to another creature of the same kind.
#[derive(Clone, Debug)]
pub(crate) struct CreatureRetargeter {
    pairs: Vec<Pair>,
    /// The rotation from the world of the source to the world of the target.
    to_target: Quat,
    /// The pair of joints that gets the path over the ground.
    carrier: usize,
    scale: f32,
    /// The metres per unit of the target, divided by the metres per unit of the source.
    metres: f64,
    /// The metres per unit of the target.
    target_metres: f64,
    /// The height of the lowest joint: in the target at rest, and in the source in motion.
    lowest: (f32, f32),
    up: Vec3,
    source_up: Vec3,
    found: ByNames,
    /// The target with joints as children of the joints that they follow.
    rig: Option<Box<Rig>>,
}

/// Two joints with the same name.
#[derive(Clone, Copy, Debug)]
struct Pair {
    source: NodeId,
    target: NodeId,
    source_rest: Quat,
    target_rest: Quat,
    /// The pair of the nearest ancestor that has a pair.
    above: Option<usize>,
}

impl CreatureRetargeter {
    /// Prepares to retarget the motions of `source` to `target`.
    ///
    /// # Errors
    /// [`Code::NotHumanoid`] if both skeletons are not creatures of one kind, or have too few names in common.
    /// [`Code::InvalidValue`] if `scale` is not above 0.
    pub(crate) fn new(source: (&Scene, &Figure), target: (&Scene, &Figure), scale: Scale) -> Result<Self> {
        let creature = one_kind(source.1, target.1)?;
        let (from, to) = (source.1.survey.up.value, target.1.survey.up.value);
        let upright = rotation_of(&from_to(from, to));
        let rig = Rig::new(target.0, &target.1.humanoid.follow).map(Box::new);
        let target = (rig.as_deref().map_or(target.0, |rig| &rig.scene), target.1);
        let rests = (Pose::rest(source.0), Pose::rest(target.0));
        let (mut pairs, lacking) = pairs(source.0, target.0, (&rests.0, &rests.1));
        let all = pairs.len() + lacking.len();
        if pairs.len() < FEWEST || (pairs.len() as f64) < MOST_OF_THEM * all as f64 {
            let message = format!(
                "both are {creature}, but only {} of {all} joints of the source have the name of a joint of the target",
                pairs.len()
            );
            return Err(Diagnostic::new(Code::NotHumanoid, message)
                .help(
                    "rename the joints of one skeleton to the names of the other; creatures are matched by joint names",
                )
                .into());
        }
        above(&mut pairs, source.0);
        let up = rotation_of(&from_to(UpAxis::Y, to)) * Vec3::Y;
        let heading = heading(&pairs, (&rests.0, &rests.1), upright, up);
        let lengths = |at: &dyn Fn(&Pair) -> Vec3| -> f64 {
            let links = pairs.iter().filter_map(|pair| Some((pair, &pairs[pair.above?])));
            links.map(|(pair, above)| f64::from(at(pair).distance(at(above)))).sum()
        };
        let long = (
            lengths(&|pair| rests.0.position(pair.source)),
            lengths(&|pair| rests.1.position(pair.target)),
        );
        let metres = target.1.survey.metres_per_unit / source.1.survey.metres_per_unit;
        let scale = match scale {
            Scale::Auto if long.0 > 0.0 && long.1 > 0.0 => long.1 / long.0,
            Scale::Auto | Scale::None => metres.recip(),
            Scale::Factor(factor) => metres.recip() * positive(Code::InvalidValue, "scale", factor)?,
        };
        let source_up = rotation_of(&from_to(UpAxis::Y, from)) * Vec3::Y;
        let rest_height = pairs.iter().map(|pair| rests.1.position(pair.target).dot(up));
        Ok(Self {
            carrier: carrier(&pairs, source.0),
            to_target: (heading * upright).normalize(),
            scale: scale as f32,
            metres,
            target_metres: target.1.survey.metres_per_unit,
            lowest: (
                rest_height.fold(f32::INFINITY, f32::min),
                lowest_in_motion(&pairs, source.0, source_up),
            ),
            up,
            source_up,
            found: ByNames {
                creature: creature.to_owned(),
                joints: pairs.len(),
                lacking,
                by_parts: false,
            },
            pairs,
            rig,
        })
    }

    /// The retargeting step for the record of a file.
    pub(crate) fn step(&self, target: &Scene) -> AppliedStep {
        AppliedStep::Retarget {
            onto: SecondMotion::of(target),
            scale: f64::from(self.scale) * self.metres,
            lock_feet: false,
        }
    }

    /// An animation of `source`, by its index, on the skeleton of `target`, and the angles between the bones of the two
    /// skeletons.
    ///
    /// # Errors
    /// [`Code::NoMotion`] if there is no such animation.
    pub(crate) fn clip(&self, source: &Scene, index: usize, target: &Scene) -> Result<(Animation, RetargetReport)> {
        let Some(animation) = source.animations.get(index) else {
            return Err(no_animation(index, source));
        };
        let target = self.rig.as_deref().map_or(target, |rig| &rig.scene);
        let all = ticks(animation);
        let binding = Binding::new(source, animation);
        let (mut from, mut to) = (Pose::rest(source), Pose::rest(target));
        let mut rotations: Vec<Vec<Quat>> = self.pairs.iter().map(|_| Vec::with_capacity(all.len())).collect();
        let mut path = Vec::with_capacity(all.len());
        let mut angles = Angles::default();
        for &tick in &all {
            from.sample(&binding, animation, tick);
            path.push(self.pose(&from, &mut to, target, &mut rotations));
            angles.add(self, &from, &to);
        }
        let at = Ticks::new(&all);
        let channels = self
            .pairs
            .iter()
            .zip(rotations)
            .enumerate()
            .map(|(index, (pair, values))| {
                let node = &target.nodes[pair.target.index()];
                let rest = Trs::from_matrix(node.transform);
                Channel {
                    node_name: node.name.clone(),
                    node: Some(pair.target),
                    position_keys: match index == self.carrier {
                        true => at.keys(std::mem::take(&mut path)),
                        false => Keys::constant(rest.translation),
                    },
                    rotation_keys: at.rotation_keys(values),
                    scaling_keys: Keys::constant(rest.scale),
                }
            });
        let mut moved = Animation {
            name: animation.name.clone(),
            ticks_per_second: animation.ticks_per_second,
            duration: animation.duration,
            channels: channels.collect(),
        };
        moved.sort_channels();
        let mut report = angles.report(self, animation, all.len());
        report.skin = self.skin(source, animation, (target, &moved), &all);
        report.verdict = verdict(&report);
        if let Some(rig) = self.rig.as_deref() {
            moved = rig.in_file(&moved);
        }
        Ok((moved, report))
    }

    /// The skin of `moved`, an animation of the scene `target`.
    fn skin(
        &self,
        source: &Scene,
        animation: &Animation,
        (target, moved): (&Scene, &Animation),
        all: &[f64],
    ) -> Option<SkinReport> {
        let rest = Pose::rest(target);
        let skins = target.own_meshes().filter(|mesh| !mesh.bones.is_empty());
        let heights = skins.flat_map(|mesh| rest.skin(mesh)).map(|vertex| vertex.dot(self.up));
        let motion = SkinnedMotion {
            scene: target,
            animation: moved,
            up: self.up,
            metres_per_unit: self.target_metres,
            floor_at_rest: None,
            floor: heights.fold(f32::INFINITY, f32::min),
            joints: self.pairs.iter().map(|pair| pair.target).collect(),
            person: None,
        };
        let binding = Binding::new(source, animation);
        let mut from = Pose::rest(source);
        examine(&motion, all, &mut |tick| {
            from.sample(&binding, animation, tick);
            let heights = self
                .pairs
                .iter()
                .map(|pair| from.position(pair.source).dot(self.source_up));
            self.scale * (self.lowest.1 - heights.fold(f32::INFINITY, f32::min)).max(0.0)
        })
    }

    /// Sets the target to a pose of the source, stores the rotations, and returns the translation of the carrier.
    fn pose(&self, from: &Pose, to: &mut Pose, target: &Scene, kept: &mut [Vec<Quat>]) -> Vec3 {
        let pair_of: HashMap<NodeId, usize> = (self.pairs.iter().enumerate())
            .map(|(index, pair)| (pair.target, index))
            .collect();
        let mut carried = Vec3::ZERO;
        for (index, node) in target.nodes.iter().enumerate() {
            let parent = node
                .parent
                .map_or(Mat4::IDENTITY, |parent| to.node_to_world[parent.index()]);
            if let Some(&at) = pair_of.get(&NodeId::new(index)) {
                let pair = &self.pairs[at];
                let moved = rotation_of(&from.node_to_world[pair.source.index()]) * pair.source_rest.inverse();
                let world = self.to_target * moved * self.to_target.inverse() * pair.target_rest;
                let local = (rotation_of(&parent).inverse() * world).normalize();
                // Use the shorter arc from the previous key.
                let turned_away = kept[at].last().is_some_and(|last| last.dot(local) < 0.0);
                kept[at].push(if turned_away { -local } else { local });
                let mut trs = Trs::from_matrix(node.transform);
                trs.rotation = local;
                if at == self.carrier {
                    let position = self.scale * (self.to_target * from.position(pair.source));
                    let height = self.lowest.0 - self.scale * self.lowest.1;
                    trs.translation = parent.inverse().transform_point3(position + height * self.up);
                    carried = trs.translation;
                }
                to.node_to_parent[index] = trs.matrix();
            }
            to.node_to_world[index] = parent * to.node_to_parent[index];
        }
        carried
    }
}

/// The kind of creature that both figures have.
fn one_kind(source: &Figure, target: &Figure) -> Result<&'static str> {
    let words = |figure: &Figure| match (figure.humanoid.creature, figure.humanoid.found) {
        (Some(creature), _) => format!("{} ({})", creature.as_str(), figure.humanoid.reason),
        (None, true) => "a humanoid".to_owned(),
        (None, false) => format!("neither a humanoid nor a known creature: {}", figure.humanoid.reason),
    };
    match (source.humanoid.creature, target.humanoid.creature) {
        (Some(one), Some(other)) if one == other => Ok(one.as_str()),
        _ => {
            let message = format!("the target is {}, and the source is {}", words(target), words(source));
            Err(Diagnostic::new(Code::NotHumanoid, message)
                .help("choose a motion of the same kind of creature, with the same joint names")
                .into())
        }
    }
}

/// A name without its namespace, in lower case, of letters and digits.
pub(crate) fn key(name: &str) -> String {
    let own = name.rsplit([':', '|']).next().unwrap_or(name);
    own.chars()
        .filter(|c| c.is_alphanumeric())
        .flat_map(char::to_lowercase)
        .collect()
}

/// The joints with the same name, in the order of the target, and the names of the source's joints that the target
/// lacks. If several joints have a name, the first is used.
fn pairs(source: &Scene, target: &Scene, rests: (&Pose, &Pose)) -> (Vec<Pair>, Vec<String>) {
    let mut of_source: HashMap<String, NodeId> = HashMap::new();
    for (index, node) in source.nodes.iter().enumerate() {
        if node.kind == NodeKind::Joint && !key(&node.name).is_empty() {
            of_source.entry(key(&node.name)).or_insert(NodeId::new(index));
        }
    }
    let mut pairs = Vec::new();
    for (index, node) in target.nodes.iter().enumerate() {
        let found = of_source
            .remove(&key(&node.name))
            .filter(|_| node.kind == NodeKind::Joint);
        if let Some(joint) = found {
            pairs.push(Pair {
                source: joint,
                target: NodeId::new(index),
                source_rest: rotation_of(&rests.0.node_to_world[joint.index()]),
                target_rest: rotation_of(&rests.1.node_to_world[index]),
                above: None,
            });
        }
    }
    let mut lacking: Vec<NodeId> = of_source.into_values().collect();
    lacking.sort_unstable();
    let names = lacking.into_iter().map(|node| source.nodes[node.index()].name.clone());
    (pairs, names.collect())
}

/// Finds for each pair the pair of the nearest ancestor in the source.
fn above(pairs: &mut [Pair], source: &Scene) {
    let pair_of: HashMap<NodeId, usize> = pairs.iter().enumerate().map(|(at, pair)| (pair.source, at)).collect();
    for pair in pairs {
        let mut node = source.nodes[pair.source.index()].parent;
        while let Some(joint) = node {
            pair.above = pair_of.get(&joint).copied();
            node = match pair.above {
                Some(_) => None,
                None => source.nodes[joint.index()].parent,
            };
        }
    }
}

/// The rotation about the target's up axis that brings the source's rest pose nearest to the target's rest pose.
fn heading(pairs: &[Pair], rests: (&Pose, &Pose), upright: Quat, up: Vec3) -> Quat {
    let (mut sine, mut cosine) = (0.0, 0.0);
    for (pair, other) in pairs.iter().filter_map(|pair| Some((pair, &pairs[pair.above?]))) {
        let from = upright * (rests.0.position(pair.source) - rests.0.position(other.source));
        let to = rests.1.position(pair.target) - rests.1.position(other.target);
        let (from, to) = (from.reject_from_normalized(up), to.reject_from_normalized(up));
        sine += up.dot(from.cross(to));
        cosine += from.dot(to);
    }
    let angle = sine.atan2(cosine);
    match angle.is_finite() {
        true => Quat::from_axis_angle(up, angle),
        false => Quat::IDENTITY,
    }
}

/// The highest pair whose joint changes its position, or else the highest pair.
fn carrier(pairs: &[Pair], source: &Scene) -> usize {
    let moves = |pair: &Pair| {
        source.animations.iter().any(|animation| {
            let binding = Binding::new(source, animation);
            let mut driven = binding.driven();
            driven.any(|(node, channel)| node == pair.source && animation.channels[channel].position_keys.len() > 1)
        })
    };
    let highest = |at: usize| {
        let depth = |node: NodeId| std::iter::successors(Some(node), |node| source.nodes[node.index()].parent).count();
        (depth(pairs[at].source), at)
    };
    let moving = (0..pairs.len()).filter(|at| moves(&pairs[*at]));
    let found = moving.min_by_key(|at| highest(*at));
    found
        .or_else(|| (0..pairs.len()).min_by_key(|at| highest(*at)))
        .unwrap_or(0)
}

/// The height below which the lowest joint of the source is in a twentieth of the frames.
fn lowest_in_motion(pairs: &[Pair], source: &Scene, up: Vec3) -> f32 {
    let mut heights = Vec::new();
    let mut pose = Pose::rest(source);
    for animation in &source.animations {
        let binding = Binding::new(source, animation);
        for tick in ticks(animation) {
            pose.sample(&binding, animation, tick);
            let lowest = pairs.iter().map(|pair| pose.position(pair.source).dot(up));
            heights.push(lowest.fold(f32::INFINITY, f32::min));
        }
    }
    heights.sort_unstable_by(f32::total_cmp);
    heights
        .get((heights.len() as f64 * BELOW) as usize)
        .copied()
        .unwrap_or(0.0)
}

/// The angles between the bones of source and target, in all frames.
#[derive(Default)]
struct Angles {
    sum: f64,
    count: usize,
    largest: f64,
}

impl Angles {
    fn add(&mut self, mover: &CreatureRetargeter, from: &Pose, to: &Pose) {
        let links = mover
            .pairs
            .iter()
            .filter_map(|pair| Some((pair, &mover.pairs[pair.above?])));
        for (pair, above) in links {
            let was = mover.to_target * (from.position(pair.source) - from.position(above.source));
            let is = to.position(pair.target) - to.position(above.target);
            let angle = f64::from(was.cross(is).length().atan2(was.dot(is)).to_degrees());
            self.sum += angle;
            self.count += 1;
            self.largest = self.largest.max(angle);
        }
    }

    fn report(&self, mover: &CreatureRetargeter, animation: &Animation, frames: usize) -> RetargetReport {
        let mean = self.sum / self.count.max(1) as f64;
        let scale = f64::from(mover.scale) * mover.metres;
        RetargetReport {
            mean_degrees: mean,
            max_degrees: self.largest,
            by_names: Some(mover.found.clone()),
            ..RetargetReport::of_limbs(animation.name.clone(), frames, scale, Vec::new())
        }
    }
}
