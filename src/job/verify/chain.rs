//! Forward kinematics in double precision, for scenes and glTF files.

use std::borrow::Cow;
use std::collections::HashMap;

use glam::{DMat4, DQuat, DVec3, Quat, Vec3};

use mocap_formats::gltf::{Bend, File, Values};
use mocap_scene::error::Result;
use mocap_scene::pose::{Binding, of_flat};
use mocap_scene::scene::{Face, Keys, NodeId, NodeKind, Scene};

/// The largest deviation of a joint that keeps its position, as a fraction of the distance to its parent.
const SAME_PLACE: f64 = 1e-5;

/// Two rotations are equal if the cosine of half the angle between them differs from 1 by at most this number.
const SAME_ROTATION: f64 = 1e-9;

/// The largest change of a component of a track that counts as constant, in units of length or as a fraction of the
/// value. Programs change constant values by rounding.
const STAYS: f32 = 1e-5;

/// Above this number of collected times, equal times are dropped.
const MANY_KEYS: usize = 1 << 18;

/// Nodes with their tracks, parents before children.
pub(super) struct Skeleton<'a> {
    pub(super) joints: Vec<Joint<'a>>,
    /// The time of the last key, in seconds.
    pub(super) end: f64,
    /// A joint with stepped keys, if any.
    pub(super) stepped: Option<String>,
}

pub(super) struct Joint<'a> {
    #[doc(hidden)]
    pub name: String,
    #[doc(hidden)]
    pub parent: Option<usize>,
    pub(super) kind: NodeKind,
    /// Whether the node has something visible.
    pub(super) shows: bool,
    /// The role of the node for the face of a VRM animation.
    pub(super) face: Option<Face>,
    rest: (DVec3, DQuat, DVec3),
    /// The matrix of a node without tracks. This matrix may contain shear.
    still: Option<DMat4>,
    translation: Option<Track<'a, Vec3>>,
    rotation: Option<Track<'a, Quat>>,
    scale: Option<Track<'a, Vec3>>,
}

/// The keys of one property, and their times.
struct Track<'a, T: Clone> {
    #[doc(hidden)]
    pub times: Times<'a>,
    #[doc(hidden)]
    pub values: Cow<'a, [T]>,
}

impl Joint<'_> {
    /// Whether the position of the joint relative to its parent changes.
    fn travels(&self) -> bool {
        self.translation.as_ref().is_some_and(|track| {
            let first = track.values.first().copied().unwrap_or_default();
            let changes = |value: &Vec3| value.distance(first) > STAYS * (1.0 + first.length());
            track.values.iter().any(changes)
        })
    }

    fn moves(&self) -> bool {
        let turns = |track: &Track<Quat>| {
            track
                .values
                .iter()
                .any(|value| !value.abs_diff_eq(track.values[0], STAYS))
        };
        let scales = |track: &Track<Vec3>| {
            track
                .values
                .iter()
                .any(|value| !value.abs_diff_eq(track.values[0], STAYS))
        };
        self.travels() || self.rotation.as_ref().is_some_and(turns) || self.scale.as_ref().is_some_and(scales)
    }
}

enum Times<'a> {
    /// One key for each tick, and ticks per second.
    EveryTick(f64),
    /// Ticks, and ticks per second.
    Ticks(&'a [f64], f64),
    /// Seconds.
    Seconds(Vec<f32>),
}

impl<'a> Skeleton<'a> {
    /// The nodes of `scene` and the keys of a clip; without a clip, the rest pose.
    pub(super) fn of_scene(scene: &'a Scene, clip: Option<usize>) -> Self {
        let joint = |node: &mocap_scene::scene::Node| {
            let matrix = node.transform.as_dmat4();
            let (mut scale, mut rotation, translation) = matrix.to_scale_rotation_translation();
            if !rotation.is_finite() {
                (scale, rotation) = of_flat(&matrix);
            }
            Joint {
                shows: !node.meshes.is_empty(),
                face: node.face.clone(),
                still: Some(matrix),
                ..Joint::at_rest(
                    node.name.clone(),
                    node.parent.map(NodeId::index),
                    node.kind,
                    (translation, rotation, scale),
                )
            }
        };
        let mut joints: Vec<_> = scene.nodes.iter().map(joint).collect();
        let mut end = 0.0;
        if let Some(animation) = clip.and_then(|clip| scene.animations.get(clip)) {
            let rate = animation.ticks_per_second;
            end = animation.duration / rate;
            for (node, channel) in Binding::new(scene, animation).driven() {
                let (joint, channel) = (&mut joints[node.index()], &animation.channels[channel]);
                joint.still = None;
                joint.translation = Track::of_keys(&channel.position_keys, rate);
                joint.rotation = Track::of_keys(&channel.rotation_keys, rate);
                joint.scale = Track::of_keys(&channel.scaling_keys, rate);
            }
        }
        Self {
            joints,
            end,
            stepped: None,
        }
    }
}

impl Skeleton<'static> {
    /// The nodes of a file's default scene and the tracks of a clip; without a clip, the rest pose.
    pub(super) fn of_file(file: &File<'_>, clip: Option<usize>) -> Result<Self> {
        let listed = file.nodes()?;
        let only_show = file.only_show()?;
        let mut faces = file.faces();
        let mut joint_of = HashMap::new();
        let mut joints = Vec::with_capacity(listed.len());
        for node in &listed {
            let at = match file.transform(node.index) {
                // The node only shows a weight of the face. A reader ignores its other tracks, even if they are
                // invalid.
                Err(_) if only_show.contains(&node.index) => continue,
                at => at?,
            };
            joint_of.insert(node.index, joints.len());
            let parent = node
                .parent
                .and_then(|parent| joint_of.get(&listed[parent].index).copied());
            let rest = (at.translation.as_dvec3(), at.rotation.as_dquat(), at.scale.as_dvec3());
            let kind = if file.is_end_site(node.index) {
                NodeKind::EndSite
            } else {
                NodeKind::Joint
            };
            joints.push(Joint {
                shows: file.shows(node.index),
                face: faces.remove(&node.index),
                still: Some(at.matrix.as_dmat4()),
                ..Joint::at_rest(file.source_name(node.index), parent, kind, rest)
            });
        }
        let tracks = match clip.filter(|clip| *clip < file.animations().len()) {
            Some(clip) => file.tracks(clip)?,
            None => Vec::new(),
        };
        let (mut end, mut stepped) = (0.0, None);
        for track in tracks {
            let Some(&known) = joint_of.get(&track.node) else {
                continue;
            };
            end = track.times.last().map_or(end, |last| f64::max(end, f64::from(*last)));
            let (joint, times) = (&mut joints[known], Times::Seconds(track.times));
            joint.still = None;
            if matches!(track.bent, Some((Bend::Step, _))) {
                stepped.get_or_insert_with(|| joint.name.clone());
            }
            match track.values {
                Values::Translations(values) => joint.translation = Some(Track::owned(times, values)),
                Values::Rotations(values) => joint.rotation = Some(Track::owned(times, values)),
                Values::Scales(values) => joint.scale = Some(Track::owned(times, values)),
            }
        }
        Ok(Self { joints, end, stepped })
    }
}

impl Skeleton<'_> {
    /// Clears `world`, and fills it with the node-to-world matrix of every joint at `seconds`.
    pub(super) fn world(&self, seconds: f64, world: &mut Vec<DMat4>) {
        world.clear();
        for joint in &self.joints {
            let node_to_parent = joint.node_to_parent(seconds);
            world.push(match joint.parent {
                Some(parent) => world[parent] * node_to_parent,
                None => node_to_parent,
            });
        }
    }

    /// The numbers of joints and of end sites among these nodes.
    pub(super) fn count(&self, nodes: impl Iterator<Item = usize>) -> [usize; 2] {
        let (end_sites, joints): (Vec<usize>, Vec<usize>) =
            nodes.partition(|node| self.joints[*node].kind == NodeKind::EndSite);
        [joints.len(), end_sites.len()]
    }

    /// For every joint, whether it rotates without moving another joint, because all its descendants are at its
    /// position. No position then shows the rotation.
    pub(super) fn turning_ends(&self) -> Vec<bool> {
        let mut reaches = vec![false; self.joints.len()];
        for (index, joint) in self.joints.iter().enumerate().rev() {
            let keys = joint.translation.as_ref().map_or(&[][..], |track| &track.values);
            let stands_away = match keys {
                [] => joint.rest.0 != DVec3::ZERO,
                keys => keys.iter().any(|key| *key != Vec3::ZERO),
            };
            if let Some(parent) = joint.parent {
                reaches[parent] |= reaches[index] || stands_away;
            }
        }
        let rotates = |joint: &Joint| joint.rotation.as_ref().is_some_and(|track| track.values.len() > 1);
        self.joints
            .iter()
            .zip(reaches)
            .map(|(joint, reaches)| rotates(joint) && !reaches)
            .collect()
    }

    /// For each joint, its root: the highest ancestor that is not a group.
    pub(super) fn roots(&self) -> Vec<usize> {
        let mut roots = Vec::with_capacity(self.joints.len());
        for (index, joint) in self.joints.iter().enumerate() {
            let is_below_root = |parent: &usize| self.joints[*parent].kind != NodeKind::Group;
            roots.push(joint.parent.filter(is_below_root).map_or(index, |parent| roots[parent]));
        }
        roots
    }

    /// For each joint, the joint whose path over the ground carries it. This is the root, or if the root does not move,
    /// the travelling descendant with the most descendants. `None` for joints above a travelling joint that do not
    /// move.
    pub(super) fn carriers(&self) -> Vec<Option<usize>> {
        let roots = self.roots();
        let mut first = vec![None; self.joints.len()];
        let mut sizes = vec![0_usize; self.joints.len()];
        for (index, joint) in self.joints.iter().enumerate() {
            let parent = joint.parent.filter(|_| roots[index] != index);
            let above = parent.and_then(|parent| first[parent]);
            first[index] = above.or(joint.moves().then_some(index));
            first[index].into_iter().for_each(|first: usize| sizes[first] += 1);
        }
        let main = |root: usize| {
            let below = || (0..first.len()).filter(|index| roots[*index] == root && first[*index] == Some(*index));
            let all_travel = below().all(|joint| self.joints[joint].travels());
            let largest = below().rev().max_by_key(|joint| sizes[*joint]);
            largest.filter(|largest| all_travel && *largest != root)
        };
        let mut mains = HashMap::new();
        let carriers = std::iter::zip(&roots, &first).map(|(root, first)| {
            match *mains.entry(*root).or_insert_with(|| main(*root)) {
                Some(main) => first.map(|_| main),
                None => Some(*root),
            }
        });
        carriers.collect()
    }

    /// The times of all keys of tracks that state times: in seconds, ascending, without duplicates.
    pub(super) fn key_seconds(&self) -> Vec<f32> {
        fn of<'a, T: Clone>(track: Option<&'a Track<T>>) -> &'a [f32] {
            match track.map(|track| &track.times) {
                Some(Times::Seconds(times)) => times,
                _ => &[],
            }
        }
        let of_joint = |joint: &Joint| -> Vec<f32> {
            let (translation, rotation) = (of(joint.translation.as_ref()), of(joint.rotation.as_ref()));
            [translation, rotation, of(joint.scale.as_ref())].concat()
        };
        let (mut all, mut most): (Vec<f32>, usize) = (Vec::new(), MANY_KEYS);
        for joint in &self.joints {
            all.extend(of_joint(joint));
            // Usually all tracks have keys at the same times, so duplicates are dropped early.
            if all.len() > most {
                sort(&mut all);
                most = most.max(2 * all.len());
            }
        }
        sort(&mut all);
        all
    }

    /// The first and the last key, in seconds, of the tracks that change in this time range.
    pub(super) fn span(&self, first: f64, last: f64) -> Option<(f64, f64)> {
        let of_joint = |joint: &Joint| {
            let translation = joint.translation.as_ref().and_then(|track| track.span(first, last));
            let rotation = joint.rotation.as_ref().and_then(|track| track.span(first, last));
            let scale = joint.scale.as_ref().and_then(|track| track.span(first, last));
            [translation, rotation, scale]
        };
        let spans = self.joints.iter().flat_map(of_joint).flatten();
        spans.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }
}

impl Joint<'_> {
    /// Whether the joint always keeps its rest position.
    pub(super) fn keeps_place(&self) -> bool {
        let tolerance = SAME_PLACE * self.rest.0.length();
        let track = self.translation.as_ref().map_or(&[][..], |track| &track.values);
        track
            .iter()
            .all(|value| value.as_dvec3().distance(self.rest.0) <= tolerance)
    }

    /// Whether the joint has the position and rotation of the rest pose in every frame.
    pub(super) fn is_still(&self) -> bool {
        let rotations = self.rotation.as_ref().map_or(&[][..], |track| &track.values);
        let is_rest = |rotation: &Quat| unit(rotation).dot(self.rest.1).abs() >= 1.0 - SAME_ROTATION;
        self.keeps_place() && rotations.iter().all(is_rest)
    }

    fn at_rest(name: String, parent: Option<usize>, kind: NodeKind, rest: (DVec3, DQuat, DVec3)) -> Self {
        let (translation, rotation, scale) = (None, None, None);
        Self {
            name,
            parent,
            kind,
            shows: false,
            face: None,
            rest,
            still: None,
            translation,
            rotation,
            scale,
        }
    }

    /// The translation and the rotation of the joint relative to its parent at `seconds`.
    pub(super) fn own(&self, seconds: f64) -> (DVec3, DQuat) {
        let (_, rotation, translation) = self.node_to_parent(seconds).to_scale_rotation_translation();
        (translation, rotation)
    }

    fn node_to_parent(&self, seconds: f64) -> DMat4 {
        if let Some(still) = self.still {
            return still;
        }
        let vector = |track: &Option<Track<Vec3>>, rest| {
            track
                .as_ref()
                .map_or(rest, |track| track.at(seconds, |value| value.as_dvec3(), DVec3::lerp))
        };
        let rotation = self
            .rotation
            .as_ref()
            .map_or(self.rest.1, |track| track.at(seconds, unit, DQuat::slerp));
        DMat4::from_scale_rotation_translation(
            vector(&self.scale, self.rest.2),
            rotation.normalize(),
            vector(&self.translation, self.rest.0),
        )
    }
}

fn sort(times: &mut Vec<f32>) {
    times.sort_unstable_by(f32::total_cmp);
    times.dedup();
}

fn unit(rotation: &Quat) -> DQuat {
    rotation.as_dquat().normalize()
}

impl<T: Clone + PartialEq> Track<'_, T> {
    /// The first and the last key in seconds within this time range, if a value changes in the range.
    fn span(&self, first: f64, last: f64) -> Option<(f64, f64)> {
        let end = self.values.len() - 1;
        // Include the keys around the range: values also change between these keys and the ends of the range.
        let from = self.after(first).saturating_sub(1);
        let mut to = self.after(last);
        if to > 0 && self.time(to - 1) >= last {
            to -= 1;
        }
        let to = to.min(end);
        let part = self.values.get(from..=to)?;
        let changes = part.windows(2).any(|pair| pair[0] != pair[1]);
        changes.then(|| (self.time(0).max(first), self.time(end).min(last)))
    }
}

impl<'a, T: Clone> Track<'a, T> {
    fn of_keys(keys: &'a Keys<T>, ticks_per_second: f64) -> Option<Self> {
        let times = match &keys.ticks {
            None => Times::EveryTick(ticks_per_second),
            Some(ticks) => Times::Ticks(ticks, ticks_per_second),
        };
        (!keys.is_empty()).then(|| Self {
            times,
            values: Cow::Borrowed(keys.values.as_slice()),
        })
    }

    fn owned(times: Times<'a>, values: Vec<T>) -> Self {
        Self {
            times,
            values: values.into(),
        }
    }

    /// The index of the first key after `seconds`; there may be no such key.
    fn after(&self, seconds: f64) -> usize {
        match &self.times {
            // Rounding may move a whole tick slightly if it comes from a division. Then the neighbouring key gives the
            // same result.
            Times::EveryTick(rate) => ((seconds * rate).floor() + 1.0).max(0.0) as usize,
            Times::Ticks(ticks, rate) => ticks.partition_point(|tick| tick / rate <= seconds),
            Times::Seconds(times) => times.partition_point(|time| f64::from(*time) <= seconds),
        }
    }

    fn time(&self, key: usize) -> f64 {
        match &self.times {
            Times::EveryTick(rate) => key as f64 / rate,
            Times::Ticks(ticks, rate) => ticks[key] / rate,
            Times::Seconds(times) => f64::from(times[key]),
        }
    }

    /// The value at `seconds`, interpolated between the neighbouring keys. Beyond the ends, the value of the nearest
    /// key.
    fn at<V>(&self, seconds: f64, convert: impl Fn(&T) -> V, mix: impl Fn(V, V, f64) -> V) -> V {
        let last = self.values.len() - 1;
        let next = self.after(seconds);
        if next == 0 || next > last {
            return convert(&self.values[next.saturating_sub(1).min(last)]);
        }
        let fraction = (seconds - self.time(next - 1)) / (self.time(next) - self.time(next - 1));
        mix(
            convert(&self.values[next - 1]),
            convert(&self.values[next]),
            fraction.clamp(0.0, 1.0),
        )
    }
}
