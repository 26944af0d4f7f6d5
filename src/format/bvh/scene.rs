//! Joints and numbers into a node graph and channels.

use std::collections::HashMap;

use glam::{Mat4, Quat, Vec3};

use super::channel::ChannelKind;
use super::hierarchy::{Hierarchy, Joint};
use super::motion::Header;
use super::rows::{Block, Sink};
use crate::error::{Code, Diagnostic};
use crate::format::ReadOptions;
use crate::format::warnings::Warnings;
use crate::rotation::{Axis, lanes};
use crate::scene::{
    Animation, Channel, GROUP_OF_ROOTS, Keys, Node, NodeId, NodeKind, RootOffset, RootOffsetUsed, RotationOrder, Scene,
};

/// The keys read so far, a track a joint. End sites have none.
pub(super) struct Tracks<'h> {
    hierarchy: &'h Hierarchy,
    root_offset: RootOffset,
    root_offset_used: Option<RootOffsetUsed>,
    /// Whether the first frame was seen.
    is_begun: bool,
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

/// Where the values of one joint stand in a row, and what they mean.
#[derive(Clone)]
struct Columns {
    joint: usize,
    /// Stands where no column says otherwise; added to the position channels where `adds_offset`.
    offset: Vec3,
    adds_offset: bool,
    /// Columns of x, y and z.
    position: [Option<usize>; 3],
    scale: [Option<usize>; 3],
    /// Axis and column, in the order written.
    rotation: Vec<(Axis, usize)>,
}

impl Columns {
    fn new(index: usize, joint: &Joint) -> Self {
        let mut columns = Self {
            joint: index,
            offset: joint.offset,
            adds_offset: false,
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

    /// Position channels replace the OFFSET axis by axis, or are added to it.
    fn position_at(&self, block: &Block, frame: usize) -> Vec3 {
        let mut position = self.offset;
        for (axis, column) in self.position.iter().enumerate() {
            if let Some(column) = column {
                let value = block.column(*column)[frame] as f32;
                position[axis] = if self.adds_offset {
                    position[axis] + value
                } else {
                    value
                };
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
        let columns = &self.columns;
        let frames = 0..block.frames();
        // A joint without rotation channels keeps its rotation, which is a track like any other: a key a frame.
        let angles: Vec<(Axis, &[f64])> = columns
            .rotation
            .iter()
            .map(|&(axis, column)| (axis, block.column(column)))
            .collect();
        lanes::append(&angles, block.frames(), &mut self.rotation_keys);
        if columns.has_position() {
            self.position_keys
                .extend(frames.clone().map(|frame| columns.position_at(block, frame)));
        }
        if columns.has_scale() {
            self.scaling_keys
                .extend(frames.map(|frame| columns.scale_at(block, frame)));
        }
    }

    /// A track of the same joint without keys.
    fn part(&self) -> Self {
        Self {
            columns: self.columns.clone(),
            position_keys: Vec::new(),
            rotation_keys: Vec::new(),
            scaling_keys: Vec::new(),
        }
    }

    fn extend(&mut self, part: &Self) {
        self.position_keys.extend_from_slice(&part.position_keys);
        self.rotation_keys.extend_from_slice(&part.rotation_keys);
        self.scaling_keys.extend_from_slice(&part.scaling_keys);
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
            position_keys,
            rotation_keys: Keys::every_tick(self.rotation_keys),
            scaling_keys,
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
            is_begun: false,
            frames: 0,
            joints: joints.map(|(index, joint)| Track::new(index, joint)).collect(),
        }
    }

    /// Decides for every root from the first frame whether its position channels stand in place of the OFFSET.
    fn choose_root_offset(&mut self, block: &Block) {
        for columns in self.joints.iter_mut().map(|track| &mut track.columns) {
            let is_root = self.hierarchy.joints[columns.joint].parent.is_none();
            if !is_root || !columns.has_position() {
                continue;
            }
            let used = match self.root_offset {
                RootOffset::Auto => guess_root_offset(columns, block),
                policy => RootOffsetUsed {
                    policy,
                    reason: "as asked for".to_owned(),
                },
            };
            columns.adds_offset = used.policy == RootOffset::Add;
            self.root_offset_used.get_or_insert(used);
        }
    }
}

impl Sink for Tracks<'_> {
    fn append(&mut self, block: &Block) {
        if !self.is_begun {
            self.choose_root_offset(block);
            self.is_begun = true;
        }
        self.frames += block.frames();
        for track in &mut self.joints {
            track.append(block);
        }
    }

    fn part(&self) -> Self {
        Self {
            hierarchy: self.hierarchy,
            root_offset: self.root_offset,
            // What the first frame has decided holds for all parts.
            root_offset_used: self.root_offset_used.clone(),
            is_begun: self.is_begun,
            frames: 0,
            joints: self.joints.iter().map(Track::part).collect(),
        }
    }

    fn extend(&mut self, part: Self) {
        self.frames += part.frames;
        for (track, part) in self.joints.iter_mut().zip(&part.joints) {
            track.extend(part);
        }
    }
}

/// In nearly every real file the first position is the OFFSET again, or a place of its own: the channels replace it.
/// In a few the position is relative to the OFFSET, which shows in a first position of about zero.
fn guess_root_offset(columns: &Columns, block: &Block) -> RootOffsetUsed {
    /// Of the OFFSET's length. The real files that want adding stay below 0.0101, those that do not above 0.3.
    const NEAR_ZERO: f32 = 0.02;
    let axes = [0, 1, 2]
        .into_iter()
        .filter_map(|axis| Some((columns.offset[axis], columns.position[axis]?)));
    let offset = axes.clone().map(|(offset, _)| offset * offset).sum::<f32>().sqrt();
    let position = axes
        .map(|(_, column)| block.column(column)[0].abs() as f32)
        .fold(0.0, f32::max);
    let (policy, reason) = if offset == 0.0 {
        (RootOffset::Replace, "the root's OFFSET is zero")
    } else if position <= NEAR_ZERO * offset {
        (
            RootOffset::Add,
            "the first frame's root position is near zero while the OFFSET is not",
        )
    } else {
        (RootOffset::Replace, "the first frame's root position is not near zero")
    };
    RootOffsetUsed {
        policy,
        reason: reason.to_owned(),
    }
}

/// The scene of a whole file, without meshes.
pub(super) fn build(
    hierarchy: &Hierarchy,
    header: Option<&Header>,
    tracks: Tracks<'_>,
    warnings: &mut Warnings,
) -> Scene {
    warn_of_duplicate_names(hierarchy, warnings);
    let mut scene = Scene {
        nodes: build_nodes(hierarchy),
        ..Scene::default()
    };
    scene.metadata.format = super::FORMAT.name.to_owned();
    scene.metadata.root_offset = tracks.root_offset_used;
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

/// One node a joint, in their order. Several roots get one parent, because a graph has one root.
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

/// The order of the rotation channels, where each axis has one.
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
