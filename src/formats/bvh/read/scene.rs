//! Makes nodes and channels from the joints and the numbers.

use std::collections::HashMap;
use std::thread;

use bytemuck::Zeroable;
use glam::{Mat4, Quat, Vec3};
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::math::rotation::{Axis, lanes};
use mocap_scene::scene::report::RootOffsetUsed;
use mocap_scene::scene::{
    Animation, Assumption, Channel, Confidence, Format, GROUP_OF_ROOTS, Keys, Node, NodeId, NodeKind, RootOffset,
    RotationOrder, Scene, Topic,
};

use super::channel::ChannelKind;
use super::hierarchy::{Hierarchy, Joint};
use super::motion::Header;
use super::positions::{self, Positions};
use super::rows::{self, Block, Sink};
use crate::ReadOptions;
use crate::warnings::Warnings;

/// The keys read so far, one track for each joint. End sites have no track.
pub(super) struct Tracks<'h> {
    hierarchy: &'h Hierarchy,
    root_offset: RootOffset,
    root_offset_used: Option<RootOffsetUsed>,
    frames: usize,
    joints: Vec<Track>,
}

/// The keys of one joint.
struct Track {
    columns: Columns,
    position_keys: Vec<Vec3>,
    rotation_keys: Vec<Quat>,
    scaling_keys: Vec<Vec3>,
}

/// The columns of one joint in a row, and their meaning.
struct Columns {
    joint: usize,
    /// The OFFSET of the joint, for axes without a column.
    offset: Vec3,
    /// The columns of the position: x, y and z.
    position: [Option<usize>; 3],
    scale: [Option<usize>; 3],
    /// The axis and the column of each rotation channel, in the order of the file.
    rotation: Vec<(Axis, usize)>,
}

impl Columns {
    fn new(index: usize, joint: &Joint) -> Self {
        let mut columns = Self {
            joint: index,
            offset: joint.offset,
            position: [None; 3],
            scale: [None; 3],
            rotation: Vec::new(),
        };
        for (column, &kind) in (joint.first_column..).zip(&joint.channels) {
            match kind {
                ChannelKind::Position(axis) => columns.position[axis as usize] = Some(column),
                ChannelKind::Scale(axis) => columns.scale[axis as usize] = Some(column),
                ChannelKind::Rotation(axis) => columns.rotation.push((axis, column)),
            }
        }
        columns
    }

    fn has_position(&self) -> bool {
        self.position.iter().any(Option::is_some)
    }

    fn has_scale(&self) -> bool {
        self.scale.iter().any(Option::is_some)
    }

    /// The position of the joint in a frame. On axes with a position channel, the channel replaces the OFFSET.
    fn position_at(&self, block: &Block, frame: usize) -> Vec3 {
        let mut position = self.offset;
        for (axis, column) in self.position.iter().enumerate() {
            if let Some(column) = column {
                position[axis] = block.column(*column)[frame] as f32;
            }
        }
        position
    }

    fn scale_at(&self, block: &Block, frame: usize) -> Vec3 {
        Vec3::from(
            self.scale
                .map(|column| column.map_or(1.0, |column| block.column(column)[frame] as f32)),
        )
    }
}

impl Track {
    fn new(index: usize, joint: &Joint) -> Self {
        Self {
            columns: Columns::new(index, joint),
            position_keys: Vec::new(),
            rotation_keys: Vec::new(),
            scaling_keys: Vec::new(),
        }
    }

    fn append(&mut self, block: &Block) {
        let frames = block.frames();
        self.rotation_keys
            .resize(self.rotation_keys.len() + frames, Quat::IDENTITY);
        if self.columns.has_position() {
            self.position_keys.resize(self.position_keys.len() + frames, Vec3::ZERO);
        }
        if self.columns.has_scale() {
            self.scaling_keys.resize(self.scaling_keys.len() + frames, Vec3::ONE);
        }
        self.last_frames(frames).fill(block);
    }

    fn reserve(&mut self, frames: usize) {
        self.rotation_keys.reserve_exact(frames);
        if self.columns.has_position() {
            self.position_keys.reserve_exact(frames);
        }
        if self.columns.has_scale() {
            self.scaling_keys.reserve_exact(frames);
        }
    }

    /// A view of the last frames.
    fn last_frames(&mut self, frames: usize) -> TrackFrames<'_> {
        let start = self.rotation_keys.len() - frames;
        TrackFrames {
            columns: &self.columns,
            position_keys: self.position_keys.get_mut(start..).unwrap_or_default(),
            rotation_keys: &mut self.rotation_keys[start..],
            scaling_keys: self.scaling_keys.get_mut(start..).unwrap_or_default(),
        }
    }

    /// Appends frames of zeros.
    fn extend(&mut self, frames: usize) {
        extend_by_zeros(&mut self.rotation_keys, frames);
        if self.columns.has_position() {
            extend_by_zeros(&mut self.position_keys, frames);
        }
        if self.columns.has_scale() {
            extend_by_zeros(&mut self.scaling_keys, frames);
        }
    }

    fn truncate(&mut self, frames: usize) {
        truncate(&mut self.position_keys, frames);
        truncate(&mut self.rotation_keys, frames);
        truncate(&mut self.scaling_keys, frames);
    }

    fn positions(&self) -> Positions<'_> {
        Positions {
            offset: self.columns.offset,
            axes: self.columns.position.map(|column| column.is_some()),
            keys: &self.position_keys,
        }
    }

    /// Adds the OFFSET to the positions, on the axes with a column.
    fn add_offset(&mut self) {
        let axes = self.columns.position.map(|column| f32::from(column.is_some()));
        let offset = self.columns.offset * Vec3::from(axes);
        self.position_keys.iter_mut().for_each(|key| *key += offset);
    }

    fn into_channel(self, node_name: &str) -> Channel {
        let position_keys = match self.columns.has_position() {
            true => Keys::every_tick(self.position_keys),
            false => Keys::constant(self.columns.offset),
        };
        let scaling_keys = match self.columns.has_scale() {
            true => Keys::every_tick(self.scaling_keys),
            false => Keys::constant(Vec3::ONE),
        };
        Channel {
            node_name: node_name.to_owned(),
            node: None,
            position_keys,
            rotation_keys: Keys::every_tick(self.rotation_keys),
            scaling_keys,
        }
    }
}

/// The kernel provides zeroed memory page by page, to the thread that first writes to a page.
fn extend_by_zeros<T: Zeroable + Copy>(keys: &mut Vec<T>, frames: usize) {
    let mut longer = bytemuck::zeroed_vec(keys.len() + frames);
    longer[..keys.len()].copy_from_slice(keys);
    *keys = longer;
}

fn truncate<T>(keys: &mut Vec<T>, frames: usize) {
    keys.truncate(frames);
    keys.shrink_to_fit();
}

/// A range of frames in the keys of one joint. Tracks that the joint lacks are empty.
struct TrackFrames<'a> {
    columns: &'a Columns,
    position_keys: &'a mut [Vec3],
    rotation_keys: &'a mut [Quat],
    scaling_keys: &'a mut [Vec3],
}

impl TrackFrames<'_> {
    fn fill(&mut self, block: &Block) {
        let columns = self.columns;
        // A joint without rotation channels has a constant rotation track, with one key per frame like any other.
        let angles: Vec<(Axis, &[f64])> = columns
            .rotation
            .iter()
            .map(|&(axis, column)| (axis, block.column(column)))
            .collect();
        let frames = block.frames();
        lanes::fill(&angles, &mut self.rotation_keys[..frames]);
        for (frame, key) in self.position_keys.iter_mut().take(frames).enumerate() {
            *key = columns.position_at(block, frame);
        }
        for (frame, key) in self.scaling_keys.iter_mut().take(frames).enumerate() {
            *key = columns.scale_at(block, frame);
        }
    }

    /// Splits off the first `frames` frames.
    fn split_off(&mut self, frames: usize) -> Self {
        Self {
            columns: self.columns,
            position_keys: split_off(&mut self.position_keys, frames),
            rotation_keys: split_off(&mut self.rotation_keys, frames),
            scaling_keys: split_off(&mut self.scaling_keys, frames),
        }
    }
}

fn split_off<'a, T>(keys: &mut &'a mut [T], frames: usize) -> &'a mut [T] {
    keys.split_off_mut(..frames.min(keys.len())).unwrap_or_default()
}

/// A range of frames in all tracks.
pub(super) struct Frames<'a>(Vec<TrackFrames<'a>>);

impl rows::Frames for Frames<'_> {
    fn split_off(&mut self, frames: usize) -> Self {
        Self(self.0.iter_mut().map(|track| track.split_off(frames)).collect())
    }

    fn fill(&mut self, block: &Block) {
        for track in &mut self.0 {
            track.split_off(block.frames()).fill(block);
        }
    }
}

impl<'h> Tracks<'h> {
    pub(super) fn new(hierarchy: &'h Hierarchy, options: &ReadOptions) -> Self {
        let joints = hierarchy
            .joints
            .iter()
            .enumerate()
            .filter(|(_, joint)| !joint.is_end_site);
        Self {
            hierarchy,
            root_offset: options.root_offset,
            root_offset_used: None,
            frames: 0,
            joints: joints.map(|(index, joint)| Track::new(index, joint)).collect(),
        }
    }

    /// Decides the meaning of position channels, after all frames are read.
    fn settle_positions(&mut self, warnings: &mut Warnings) -> Vec<Assumption> {
        if self.frames == 0 {
            return Vec::new();
        }
        for track in &mut self.joints {
            let is_root = self.hierarchy.joints[track.columns.joint].parent.is_none();
            if !is_root || !track.columns.has_position() {
                continue;
            }
            let used = match self.root_offset {
                RootOffset::Auto => {
                    let feet = positions::lowest_at_rest(self.hierarchy, track.columns.joint);
                    positions::root_offset(&track.positions(), feet)
                }
                policy => RootOffsetUsed {
                    policy,
                    reason: "an option of the reader states this".to_owned(),
                    confidence: Confidence::Sure,
                },
            };
            if used.policy == RootOffset::Add {
                track.add_offset();
            }
            self.root_offset_used.get_or_insert(used);
        }
        let roots = |track: &Track| self.hierarchy.joints[track.columns.joint].parent.is_none();
        let moving = |track: &&Track| !roots(track) && track.columns.has_position();
        let joints: Vec<_> = self.joints.iter().filter(moving).map(Track::positions).collect();
        if let Some(assumption) = positions::are_moves(&joints) {
            let mut added: Vec<_> = self.joints.iter_mut().filter(|track| moving(&&**track)).collect();
            added.iter_mut().for_each(|track| track.add_offset());
            return vec![assumption];
        }
        self.settle_world_positions(warnings).into_iter().collect()
    }

    /// Detects world positions. If the world positions give bones of constant length, makes the positions relative to
    /// the parents.
    fn settle_world_positions(&mut self, warnings: &mut Warnings) -> Option<Assumption> {
        let mut tracks = vec![None; self.hierarchy.joints.len()];
        for (index, track) in self.joints.iter().enumerate() {
            tracks[track.columns.joint] = Some(index);
        }
        let positions_of = |joint: usize| tracks[joint].map(|index| self.joints[index].positions());
        let far = positions::far_from_offset(self.hierarchy, positions_of)?;
        let has_scale = self.joints.iter().any(|track| track.columns.has_scale());
        let is_world = !has_scale && positions::are_in_world(self.hierarchy, &far, positions_of);
        let first = &self.hierarchy.joints[*far.first()?];
        let read_as = if is_world {
            "mocap read these positions as world positions, which keeps the bone lengths"
        } else {
            "mocap read these positions relative to the parent, as in the format"
        };
        warnings.push(Code::WorldPositions, || {
            let message = format!("the positions of a joint are far beyond the length of its OFFSET; {read_as}");
            let mut warning = Diagnostic::new(Code::WorldPositions, message).in_joint(&first.name);
            warning.count = far.len() as u64;
            warning
        });
        if !is_world {
            return None;
        }
        for frame in 0..self.frames {
            self.put_in_parents(&tracks, frame);
        }
        Some(Assumption {
            topic: Topic::JointPositions,
            choice: "world".to_owned(),
            reason: format!(
                "the positions of {} joints are far beyond the length of their OFFSETs, and as world positions they \
                    keep the bone lengths",
                far.len()
            ),
            confidence: Some(Confidence::Likely),
        })
    }

    /// Makes the world positions of a frame relative to the parents.
    fn put_in_parents(&mut self, tracks: &[Option<usize>], frame: usize) {
        let mut world: Vec<(Vec3, Quat)> = vec![(Vec3::ZERO, Quat::IDENTITY); tracks.len()];
        for (index, joint) in self.hierarchy.joints.iter().enumerate() {
            let Some(track) = tracks[index].map(|track| &mut self.joints[track]) else {
                continue;
            };
            let (translation, rotation) = joint
                .parent
                .map_or((Vec3::ZERO, Quat::IDENTITY), |parent| world[parent]);
            let has_place = track.columns.position.iter().all(Option::is_some);
            let here = if has_place {
                let here = track.position_keys[frame];
                if joint.parent.is_some() {
                    track.position_keys[frame] = rotation.inverse() * (here - translation);
                }
                here
            } else {
                let local = track.position_keys.get(frame).copied().unwrap_or(joint.offset);
                translation + rotation * local
            };
            world[index] = (here, rotation * track.rotation_keys[frame]);
        }
    }
}

impl Sink for Tracks<'_> {
    fn reserve(&mut self, frames: usize) {
        self.joints.iter_mut().for_each(|track| track.reserve(frames));
    }

    fn append(&mut self, block: &Block) {
        self.frames += block.frames();
        for track in &mut self.joints {
            track.append(block);
        }
    }

    type Frames<'a>
        = Frames<'a>
    where
        Self: 'a;

    fn extend(&mut self, frames: usize, threads: usize) -> Frames<'_> {
        self.frames += frames;
        // The allocator must zero memory that this program has used before, which takes time.
        let chunk = self.joints.len().div_ceil(threads).max(1);
        thread::scope(|scope| {
            let mut chunks = self.joints.chunks_mut(chunk);
            let own = chunks.next();
            let extend = move |tracks: &mut [Track]| tracks.iter_mut().for_each(|track| track.extend(frames));
            for tracks in chunks {
                scope.spawn(move || extend(tracks));
            }
            own.map(extend);
        });
        Frames(self.joints.iter_mut().map(|track| track.last_frames(frames)).collect())
    }

    fn truncate(&mut self, frames: usize) {
        self.frames = frames;
        for track in &mut self.joints {
            track.truncate(frames);
        }
    }

    fn frames(&self) -> usize {
        self.frames
    }
}

/// The scene of a complete file, without meshes.
pub(super) fn build(
    hierarchy: &Hierarchy,
    header: Option<&Header>,
    mut tracks: Tracks<'_>,
    warnings: &mut Warnings,
) -> Scene {
    warn_of_duplicate_names(hierarchy, warnings);
    let assumptions = tracks.settle_positions(warnings);
    let mut scene = Scene {
        nodes: build_nodes(hierarchy),
        ..Scene::default()
    };
    scene.metadata.format = Some(Format::Bvh);
    scene.metadata.root_offset = tracks.root_offset_used;
    scene.metadata.assumptions = assumptions;
    if let Some(header) = header.filter(|_| tracks.frames > 0) {
        let channel = |track: Track| {
            let name = &hierarchy.joints[track.columns.joint].name;
            track.into_channel(name)
        };
        scene.animations.push(Animation {
            name: "Motion".to_owned(),
            ticks_per_second: header.frame_rate,
            duration: (tracks.frames - 1) as f64,
            channels: tracks.joints.into_iter().map(channel).collect(),
        });
    }
    scene
}

/// One node for each joint, in their order. Several roots get one parent, because the node graph has one root.
fn build_nodes(hierarchy: &Hierarchy) -> Vec<Node> {
    let roots = hierarchy.joints.iter().filter(|joint| joint.parent.is_none()).count();
    let group = (roots > 1).then(|| Node {
        name: GROUP_OF_ROOTS.to_owned(),
        kind: NodeKind::Group,
        ..Node::default()
    });
    let first = usize::from(group.is_some());
    let joints = hierarchy.joints.iter().map(|joint| Node {
        name: joint.name.clone(),
        kind: if joint.is_end_site {
            NodeKind::EndSite
        } else {
            NodeKind::Joint
        },
        parent: match joint.parent {
            Some(parent) => Some(NodeId::new(first + parent)),
            None => group.is_some().then_some(NodeId::new(0)),
        },
        transform: Mat4::from_translation(joint.offset),
        rotation_order: rotation_order(joint),
        source: Some(joint.source),
        ..Node::default()
    });
    group.clone().into_iter().chain(joints).collect()
}

/// The order of the rotation channels, if each axis has one.
fn rotation_order(joint: &Joint) -> Option<RotationOrder> {
    let axes = joint.channels.iter().filter_map(|&kind| match kind {
        ChannelKind::Rotation(axis) => Some(axis as usize),
        ChannelKind::Position(_) | ChannelKind::Scale(_) => None,
    });
    let axes: Vec<usize> = axes.collect();
    RotationOrder::from_axes(axes.try_into().ok()?)
}

fn warn_of_duplicate_names(hierarchy: &Hierarchy, warnings: &mut Warnings) {
    let mut joints_of_name = HashMap::<&str, usize>::new();
    let named = hierarchy.joints.iter().filter(|joint| !joint.is_end_site);
    for joint in named.clone() {
        *joints_of_name.entry(&joint.name).or_default() += 1;
    }
    for joint in named {
        let count = joints_of_name.insert(&joint.name, 1).unwrap_or(1);
        if count > 1 {
            warnings.push(Code::DuplicateName, || {
                Diagnostic::new(
                    Code::DuplicateName,
                    format!("{count} joints are called \"{}\"", joint.name),
                )
                .in_joint(&joint.name)
            });
        }
    }
}
