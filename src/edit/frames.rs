//! The frames of an animation as transforms, which steps change and write back. A node whose transforms are stored here
//! is a stored node.

mod constant;
mod gaps;
mod track;
mod weights;

use glam::{Quat, Vec3};

use mocap_figure::contacts;
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::limits::{self, FrameBudget, Limits};
use mocap_scene::math::quaternion::in_hemisphere_of;
use mocap_scene::pose::{Binding, Pose, Trs};
use mocap_scene::scene::{Animation, Channel, Keys, NodeId, NodeKind, Scene};

use self::constant::{constant_value, is_near, is_same_rotation};
use self::track::{ConstantParts, TrsTrack};
use self::weights::Weights;
pub(super) use self::weights::lost_weights;

/// The transform of every animated node to its parent, at every whole tick and at the end of the animation.
#[derive(Clone)]
pub(super) struct Frames<'a> {
    /// The tick of each frame.
    pub(super) ticks: Vec<f64>,
    /// Frames per second.
    pub(super) rate: f64,
    /// For each node of the scene, its index in `nodes`; `None` for a node that is not stored, because no channel
    /// drives it.
    columns: Vec<Option<usize>>,
    /// The stored nodes, in the order of the scene.
    nodes: Vec<NodeId>,
    /// The transforms of each stored node.
    tracks: Vec<TrsTrack<'a>>,
    held: usize,
    /// For each stored node, the values that were constant in the animation.
    constant: Vec<ConstantParts>,
    /// For a scene of points without a skeleton: whether each point is seen in each frame.
    visible: Option<Vec<bool>>,
    /// The weights of the morph targets of the scene.
    weights: Weights,
}

impl Frames<'static> {
    /// A copy of the frames of `animation`, an index into the animations of `scene`. The frames may be written back
    /// into the scene. `also` has nodes that the step will move, so they are stored even if no channel drives them.
    pub(super) fn new(scene: &Scene, animation: usize, also: &[NodeId]) -> Result<Self> {
        Ok(Frames::reading(scene, animation, also)?.with(TrsTrack::owned))
    }
}

impl<'a> Frames<'a> {
    /// Like [`new`](Self::new), but a track shares the keys of the scene until it changes.
    pub(super) fn reading(scene: &'a Scene, animation: usize, also: &[NodeId]) -> Result<Self> {
        let Some(clip) = scene.animations.get(animation) else {
            let message = format!(
                "there is no animation {animation}: the scene has {}",
                scene.animations.len()
            );
            return Err(Diagnostic::new(Code::NoMotion, message).into());
        };
        let mut frames = Self::of(scene, clip, also)?;
        frames.weights = Weights::new(scene, animation, &frames.ticks)?;
        Ok(frames)
    }

    /// The frames of `animation`, which need not be in `scene`. Morph targets are not read.
    pub(super) fn of(scene: &Scene, animation: &'a Animation, also: &[NodeId]) -> Result<Self> {
        let binding = Binding::new(scene, animation);
        let mut columns: Vec<Option<usize>> = vec![None; scene.nodes.len()];
        let mut nodes: Vec<NodeId> = binding
            .driven()
            .map(|(node, _)| node)
            .chain(also.iter().copied())
            .collect();
        nodes.sort_unstable();
        nodes.dedup();
        for (column, node) in nodes.iter().enumerate() {
            columns[node.index()] = Some(column);
        }
        let whole = animation.duration.max(0.0).floor();
        let stated: usize = animation
            .channels
            .iter()
            .map(|channel| channel.position_keys.len() + channel.rotation_keys.len() + channel.scaling_keys.len())
            .sum();
        // If the motion ends between two ticks, its end needs one more frame.
        let frames = FrameBudget::stated_by(&Limits::default(), stated as u64).frames(whole + 1.0, nodes.len())?;
        let mut ticks: Vec<f64> = (0..frames - 1).map(|tick| tick as f64).collect();
        if animation.duration - whole > 1e-6 {
            ticks.push(animation.duration);
        }
        let rest: Vec<Trs> = nodes
            .iter()
            .map(|node| Trs::from_matrix(scene.nodes[node.index()].transform))
            .collect();
        let mut tracks = vec![TrsTrack::default(); nodes.len()];
        // Keys at every whole tick are the values of the frames.
        if ticks.last().is_some_and(|tick| tick.fract() == 0.0) {
            for (node, channel) in binding.driven() {
                if let Some(column) = columns[node.index()] {
                    tracks[column] = TrsTrack::of_channel(&animation.channels[channel], ticks.len());
                }
            }
        }
        let is_known = |(node, channel): (NodeId, usize)| {
            let column = columns[node.index()];
            column.is_some_and(|column| tracks[column].has_all_of(&animation.channels[channel]))
        };
        let sampled = if binding.driven().all(is_known) { 1 } else { ticks.len() };
        let mut row = rest.clone();
        for (frame, &tick) in ticks.iter().enumerate().take(sampled) {
            row.copy_from_slice(&rest);
            binding.sample(animation, tick, |node, trs| {
                if let Some(column) = columns[node.index()] {
                    row[column] = trs;
                }
            });
            for (track, trs) in tracks.iter_mut().zip(&row) {
                track.push(frame, *trs, ticks.len());
            }
        }
        let constant = tracks
            .iter()
            .map(|track| ConstantParts::of(track, ticks.len()))
            .collect();
        let gaps = scene.points_with_gaps(animation);
        let visible = gaps.iter().any(Option::is_some).then(|| {
            let of_frame = |tick: &f64| {
                let tick = *tick;
                let is_seen = |node: &NodeId| gaps[node.index()].is_none_or(|keys| keys.is_seen(tick));
                nodes.iter().map(is_seen).collect::<Vec<bool>>()
            };
            ticks.iter().flat_map(of_frame).collect()
        });
        Ok(Self {
            ticks,
            rate: animation.ticks_per_second,
            columns,
            tracks,
            held: nodes.len(),
            nodes,
            constant,
            visible,
            weights: Weights::default(),
        })
    }

    /// Stores a node that no channel drives, because the step will move it.
    pub(super) fn hold(&mut self, scene: &Scene, node: NodeId) {
        if self.column(node).is_some() {
            return;
        }
        let rest = Trs::from_matrix(scene.nodes[node.index()].transform);
        let column = self.nodes.partition_point(|held| *held < node);
        let track = TrsTrack::new(std::iter::once(rest), 1);
        self.constant.insert(column, ConstantParts::of(&track, 1));
        self.tracks.insert(column, track);
        self.nodes.insert(column, node);
        self.held = self.nodes.len();
        for (column, node) in self.nodes.iter().enumerate() {
            self.columns[node.index()] = Some(column);
        }
    }

    /// Whether the position of a node relative to its parent changes during the motion. Changes by a step count only
    /// after a call of [`settle`](Self::settle).
    pub(super) fn moves(&self, node: NodeId) -> bool {
        let column = self.column(node);
        column.is_some_and(|column| self.constant[column].translation.is_none())
    }

    /// Makes a track constant again if it was constant and differs from this constant only by rounding errors, as
    /// [`write_all`](Self::write_all) does.
    pub(super) fn settle(&mut self) {
        for (track, constant) in self.tracks.iter_mut().zip(&mut self.constant) {
            track.settle(constant);
            *constant = ConstantParts::of(track, self.ticks.len());
        }
    }

    /// Refuses an animation that moves no node, because no node can carry the figure.
    pub(super) fn require_nodes(&self) -> Result<()> {
        match self.nodes.is_empty() {
            true => Err(Diagnostic::new(Code::NoMotion, "the animation has no channel of a node of the scene").into()),
            false => Ok(()),
        }
    }

    /// The stored nodes, in the order of the scene.
    pub(super) fn nodes(&self) -> &[NodeId] {
        &self.nodes
    }

    /// The transforms, frame by frame, of the node at `column` of [`nodes`](Self::nodes), the nodes whose values are
    /// stored here.
    pub(super) fn track(&self, column: usize) -> Vec<Trs> {
        (0..self.len()).map(|frame| self.at(frame, column)).collect()
    }

    /// Sets the transforms of the node at `column` of [`nodes`](Self::nodes), frame by frame.
    pub(super) fn set_track(&mut self, column: usize, track: &[Trs]) {
        for (frame, trs) in track.iter().enumerate() {
            self.set_at(frame, column, *trs);
        }
    }

    /// The rotations, frame by frame, of the node at `column` of [`nodes`](Self::nodes).
    pub(super) fn rotations(&self, column: usize) -> impl Iterator<Item = Quat> {
        (0..self.len()).map(move |frame| self.rotation(frame, column))
    }

    /// The rotation of the node at `column` of [`nodes`](Self::nodes).
    #[inline]
    pub(super) fn rotation(&self, frame: usize, column: usize) -> Quat {
        self.tracks[column].rotation.at(frame)
    }

    /// The translation of the node at `column` of [`nodes`](Self::nodes).
    #[inline]
    pub(super) fn translation(&self, frame: usize, column: usize) -> Vec3 {
        self.tracks[column].translation.at(frame)
    }

    /// Sets the rotations of the node at `column` of [`nodes`](Self::nodes), frame by frame.
    pub(super) fn set_rotations(&mut self, column: usize, rotations: &[Quat]) {
        let frames = self.len();
        for (frame, rotation) in rotations.iter().enumerate() {
            self.tracks[column].rotation.set(frame, *rotation, frames);
        }
    }

    /// The translations, frame by frame, of the node at `column` of [`nodes`](Self::nodes).
    pub(super) fn translations(&self, column: usize) -> impl Iterator<Item = Vec3> {
        (0..self.len()).map(move |frame| self.translation(frame, column))
    }

    /// The column of a node in [`nodes`](Self::nodes). `None` if the values of the node are not stored here.
    pub(super) fn column(&self, node: NodeId) -> Option<usize> {
        self.columns[node.index()]
    }

    /// The transform of the node at `column` of [`nodes`](Self::nodes).
    #[inline]
    pub(super) fn at(&self, frame: usize, column: usize) -> Trs {
        self.tracks[column].at(frame)
    }

    fn set_at(&mut self, frame: usize, column: usize, trs: Trs) {
        let frames = self.len();
        self.tracks[column].set(frame, trs, frames);
    }

    /// All transforms of a frame, in the order of [`nodes`](Self::nodes).
    pub(super) fn row(&self, frame: usize) -> Vec<Trs> {
        (0..self.held).map(|column| self.at(frame, column)).collect()
    }

    /// Sets all transforms of a frame.
    pub(super) fn set_row(&mut self, frame: usize, row: &[Trs]) {
        for (column, trs) in row.iter().enumerate() {
            self.set_at(frame, column, *trs);
        }
    }

    /// All transforms at a fractional frame number, interpolated between two frames. Before the first frame, the
    /// transforms of the first frame; after the last frame, the transforms of the last frame.
    pub(super) fn row_at(&self, frame: f64) -> Vec<Trs> {
        let last = self.len().saturating_sub(1);
        let frame = frame.clamp(0.0, last as f64);
        let (before, fraction) = (frame.floor() as usize, (frame - frame.floor()) as f32);
        if fraction == 0.0 {
            return self.row(before);
        }
        let after = (before + 1).min(last);
        let between = |column: usize| between(self.at(before, column), self.at(after, column), fraction);
        (0..self.held).map(between).collect()
    }

    /// Frames at whole ticks with the transforms of `rows`. All points count as seen. Each frame keeps its weights of
    /// morph targets.
    pub(super) fn with_rows(&self, rows: Vec<Vec<Trs>>) -> Self {
        let track = |column: usize| TrsTrack::new(rows.iter().map(|row| row[column]), rows.len());
        self.with_tracks((0..self.held).map(track).collect(), rows.len())
    }

    /// Frames at whole ticks with the transforms of the frames `chosen`, in which all points are seen.
    fn picked(&self, chosen: &[usize]) -> Self {
        self.with_tracks(
            self.tracks.iter().map(|track| track.picked(chosen)).collect(),
            chosen.len(),
        )
    }

    /// These frames after `track` converted each track to another form. `track` must not change a transform.
    fn with<'b>(self, track: impl Fn(TrsTrack<'a>) -> TrsTrack<'b>) -> Frames<'b> {
        Frames {
            tracks: self.tracks.into_iter().map(track).collect(),
            ticks: self.ticks,
            rate: self.rate,
            columns: self.columns,
            nodes: self.nodes,
            held: self.held,
            constant: self.constant,
            visible: self.visible,
            weights: self.weights,
        }
    }

    /// A copy with only the changed values. [`write`](Self::write) needs no other values if the frames share the other
    /// keys with the scene.
    pub(super) fn changes(self) -> Frames<'static> {
        self.with(TrsTrack::changes)
    }

    fn with_tracks(&self, tracks: Vec<TrsTrack<'a>>, frames: usize) -> Self {
        Self {
            visible: None,
            weights: self.weights.with_frames(frames),
            ticks: (0..frames).map(|tick| tick as f64).collect(),
            rate: self.rate,
            columns: self.columns.clone(),
            nodes: self.nodes.clone(),
            tracks,
            held: self.held,
            constant: self.constant.clone(),
        }
    }

    /// The number of frames from 0 to `last` in a new motion that is made of these frames and of `others`. Fails if
    /// this number is far too large for the amount of data.
    pub(super) fn up_to(&self, last: f64, others: &[&Self]) -> Result<usize> {
        let stated: usize = [self].iter().chain(others).map(|frames| frames.values()).sum();
        Ok(FrameBudget::stated_by(&Limits::default(), stated as u64).frames(last, self.held)?)
    }

    /// Replaces the animation by these frames: the keys of all stored nodes, and the duration.
    pub(super) fn write_all(&self, scene: &mut Scene, animation: usize) {
        if self.visible.is_none() {
            gaps::report_filled(scene, animation);
        }
        self.write(scene, animation, &self.nodes, &self.nodes);
        let driven: Vec<(NodeId, usize)> = Binding::new(scene, &scene.animations[animation]).driven().collect();
        for (node, channel) in driven {
            let scales: Vec<Vec3> = (0..self.len())
                .filter_map(|frame| Some(self.get(frame, node)?.scale))
                .collect();
            let keys = &mut scene.animations[animation].channels[channel].scaling_keys;
            if !keys.is_empty() || scales.iter().any(|scale| *scale != Vec3::ONE) {
                *keys = self.keys(scales, self.constant_of(node).scale, is_near);
            }
        }
        scene.animations[animation].duration = self.ticks.last().copied().unwrap_or(0.0);
        self.weights.write(scene, animation, &self.ticks);
    }

    pub(super) fn len(&self) -> usize {
        self.ticks.len()
    }

    /// The number of frames times the number of stored nodes.
    fn values(&self) -> usize {
        self.len() * self.held
    }

    /// The whole number of frames nearest to a time, at least 1.
    pub(super) fn frames_in(&self, seconds: f64) -> usize {
        contacts::frames_in(seconds, self.rate, self.len())
    }

    /// Returns `frames`, the number of frames that a filter averages before and after each frame. Fails if the filter
    /// would take too long for this motion.
    pub(super) fn filter_radius(&self, frames: usize) -> Result<usize> {
        Ok(limits::filter_radius(frames, self.values())?)
    }

    /// Sets `pose`, a pose of the same scene, to a frame.
    pub(super) fn pose(&self, frame: usize, pose: &mut Pose) {
        for (node, column) in self.columns.iter().enumerate() {
            if let Some(column) = column {
                pose.node_to_parent[node] = self.at(frame, *column).matrix();
            }
        }
        pose.update_world();
    }

    /// The transform of a stored node; `None` for any other node.
    pub(super) fn get(&self, frame: usize, node: NodeId) -> Option<Trs> {
        let column = self.columns[node.index()]?;
        Some(self.at(frame, column))
    }

    /// Sets the transform of a stored node. Does nothing for any other node.
    pub(super) fn set(&mut self, frame: usize, node: NodeId, trs: Trs) {
        if let Some(column) = self.columns[node.index()] {
            self.set_at(frame, column, trs);
        }
    }

    /// Sets the rotation of `node` to its rotation in `pose`. The translation and the scale of `node` do not change.
    pub(super) fn set_rotation_of(&mut self, frame: usize, node: NodeId, pose: &Pose) {
        if let Some(old) = self.get(frame, node) {
            let rotation = Trs::from_matrix(pose.node_to_parent[node.index()]).rotation;
            let rotation = in_hemisphere_of(old.rotation, rotation.normalize());
            self.set(frame, node, Trs { rotation, ..old });
        }
    }

    /// Writes the rotations of the nodes `rotated` and the positions of the nodes `moved` as keys. A track that still
    /// shares the keys of the scene is not written. The rotation of an end site moves nothing, so an end site gets no
    /// channel.
    pub(super) fn write(&self, scene: &mut Scene, animation: usize, rotated: &[NodeId], moved: &[NodeId]) {
        let driven: Vec<(NodeId, usize)> = Binding::new(scene, &scene.animations[animation]).driven().collect();
        for (nodes, is_rotation) in [(rotated, true), (moved, false)] {
            for &node in nodes {
                let known = driven
                    .iter()
                    .find(|(other, _)| *other == node)
                    .map(|(_, channel)| *channel);
                let channels = &mut scene.animations[animation].channels;
                let channel = known.or_else(|| channels.iter().position(|channel| channel.node == Some(node)));
                if channel.is_none() && is_rotation && scene.nodes[node.index()].kind == NodeKind::EndSite {
                    continue;
                }
                let channel = channel.unwrap_or_else(|| {
                    channels.push(Channel {
                        node_name: scene.nodes[node.index()].name.clone(),
                        node: Some(node),
                        ..Channel::default()
                    });
                    channels.len() - 1
                });
                let Some(column) = self.column(node) else { continue };
                let (track, constant) = (&self.tracks[column], self.constant[column]);
                if is_rotation {
                    if !track.rotation.is_unchanged() {
                        let values = self.rotations(column).collect();
                        channels[channel].rotation_keys = self.keys(values, constant.rotation, is_same_rotation);
                    }
                } else if !track.translation.is_unchanged() {
                    let values = self.translations(column).collect();
                    channels[channel].position_keys = match self.has_gaps() && !self.gaps(column).is_empty() {
                        true => self.keys_of_point(values, column),
                        false => self.keys(values, constant.translation, is_near),
                    };
                }
            }
        }
    }

    /// For a mirrored motion: gives each node the constant values of its partner.
    pub(super) fn exchange(&mut self, partners: &[NodeId]) {
        let of_partner = |node: &NodeId| self.constant_of(partners[node.index()]);
        self.constant = self.nodes.iter().map(of_partner).collect();
    }

    fn constant_of(&self, node: NodeId) -> ConstantParts {
        self.columns[node.index()].map_or_else(ConstantParts::default, |column| self.constant[column])
    }

    /// The keys of a track. A track that was `constant` stays constant if its values differ only by rounding errors.
    /// Any other track becomes constant only if all its values are equal, so that a slow motion is kept.
    fn keys<T: Copy + PartialEq>(&self, values: Vec<T>, constant: Option<T>, is_near: fn(T, T) -> bool) -> Keys<T> {
        match constant_value(&values, constant, is_near) {
            _ if values.is_empty() => Keys::default(),
            Some(constant) => Keys::constant(constant),
            None => Keys::at_ticks(values, self.ticks.clone()),
        }
    }
}

/// Interpolates between two transforms.
pub(super) fn between(from: Trs, to: Trs, fraction: f32) -> Trs {
    Trs {
        translation: from.translation.lerp(to.translation, fraction),
        rotation: from.rotation.slerp(to.rotation, fraction),
        scale: from.scale.lerp(to.scale, fraction),
    }
}

/// The positions of `nodes` in the world in every frame, one list for each node.
pub(super) fn tracks(frames: &Frames, scene: &Scene, nodes: &[NodeId]) -> Vec<Vec<Vec3>> {
    let mut pose = Pose::rest(scene);
    // `vec![list; count]` would clone the list, and a clone of an empty list has no capacity.
    let mut tracks: Vec<Vec<Vec3>> = nodes.iter().map(|_| Vec::with_capacity(frames.len())).collect();
    // Only `nodes` and the nodes above them are computed. For feet, this saves the arms and the fingers. A parent comes
    // before its children.
    let parent = |index: usize| Some(scene.nodes[index].parent?.index()).filter(|parent| *parent < index);
    let mut is_above = vec![false; scene.nodes.len()];
    nodes.iter().for_each(|node| is_above[node.index()] = true);
    for index in (0..scene.nodes.len()).rev() {
        if let Some(parent) = parent(index).filter(|_| is_above[index]) {
            is_above[parent] = true;
        }
    }
    let above: Vec<usize> = (0..scene.nodes.len()).filter(|index| is_above[*index]).collect();
    for frame in 0..frames.len() {
        for &index in &above {
            if let Some(column) = frames.columns[index] {
                pose.node_to_parent[index] = frames.at(frame, column).matrix();
            }
            pose.node_to_world[index] = match parent(index) {
                Some(parent) => pose.node_to_world[parent] * pose.node_to_parent[index],
                None => pose.node_to_parent[index],
            };
        }
        for (track, node) in tracks.iter_mut().zip(nodes) {
            track.push(pose.position(*node));
        }
    }
    tracks
}
