//! The ledger: which kinds of data the files of a format hold, and so what is lost where a scene is written.
//!
//! A row says what its format keeps or converts, and everything else is lost. `docs/losses.md` is the table of it.

use std::collections::BTreeSet;

use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::pose::Binding;
use mocap_scene::scene::report::{DataKind, DataLoss};
use mocap_scene::scene::{Format, Node, NodeId, NodeKind, Scene};

use crate::FormatInfo;

/// What becomes of a kind of data in the files of a format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[doc(hidden)]
pub enum Carriage {
    /// It is in the files.
    Kept,
    /// The files have something else in its place, from which a program computes the same motion.
    Converted,
    /// It is in the files where they are the file of the scene with another motion: [`Scene::original`].
    PassedThrough,
    /// It is not in the files, which a warning says.
    Lost,
}

impl Carriage {
    /// Its word in the table.
    #[doc(hidden)]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Kept => "kept",
            Self::Converted => "converted",
            Self::PassedThrough => "kept of glTF",
            Self::Lost => "lost",
        }
    }
}

/// Kinds of data and what becomes of them.
#[doc(hidden)]
pub(crate) type Carried = &'static [(DataKind, Carriage)];

/// The row of formats that hold characters: skeletons, motions and skinned meshes.
pub(crate) const OF_CHARACTERS: Carried = &[
    (DataKind::Clips, Carriage::Kept),
    (DataKind::MovingJoints, Carriage::Kept),
    (DataKind::ScaleCurves, Carriage::Kept),
    (DataKind::Meshes, Carriage::Kept),
    (DataKind::Skins, Carriage::Kept),
    (DataKind::UvSets, Carriage::Kept),
    (DataKind::Materials, Carriage::Kept),
    (DataKind::Textures, Carriage::Kept),
];

/// The joints of a scene that have no place in `written`, which is what a format has of it, and how many of them move
/// and are lost: the joints below another one turn with it.
pub(crate) fn joints_left_out(scene: &Scene, written: &Scene) -> (Vec<String>, DataLoss) {
    let is_left = |node: &Node| written.nodes.iter().all(|other| other.name != node.name);
    let joints = scene
        .nodes
        .iter()
        .filter(|node| node.kind == NodeKind::Joint && node.face.is_none());
    let names = joints.filter(|node| is_left(node)).map(|node| node.name.clone());
    let mut has_place: Vec<bool> = scene.nodes.iter().map(|node| !is_left(node)).collect();
    // Parents stand before children.
    for (index, node) in scene.nodes.iter().enumerate().rev() {
        if let (Some(parent), true) = (node.parent, has_place[index]) {
            has_place[parent.index()] = true;
        }
    }
    let is_lost = |node: NodeId| {
        let joint = &scene.nodes[node.index()];
        !has_place[node.index()] && joint.kind == NodeKind::Joint && joint.face.is_none()
    };
    let mut lost = BTreeSet::new();
    for animation in &scene.animations {
        for (node, channel) in Binding::new(scene, animation).driven() {
            if is_lost(node) && animation.channels[channel].moves() {
                lost.insert(node);
            }
        }
    }
    (
        names.collect(),
        DataLoss::new(DataKind::MovingJoints, lost.len() as u64),
    )
}

impl FormatInfo {
    /// What becomes of a kind of data in the files of this format.
    #[doc(hidden)]
    pub fn carriage(&self, kind: DataKind) -> Carriage {
        if self.passed_through.contains(&kind) {
            return Carriage::PassedThrough;
        }
        let mut rows = self.carried.iter();
        let row = rows.find(|(carried, _)| *carried == kind);
        row.map_or(Carriage::Lost, |(_, carriage)| *carriage)
    }

    /// What is lost where a scene is written in this format, with what the reader of the scene left out.
    #[doc(hidden)]
    pub fn losses(&self, scene: &Scene) -> Vec<DataLoss> {
        let is_passed = self.keeps_characters && scene.original.is_some();
        let read = |kind: DataKind| match self.carriage(kind) {
            Carriage::Lost => kind.count(scene),
            Carriage::PassedThrough if !is_passed => kind.count(scene),
            Carriage::Kept if kind == DataKind::Clips && self.has_one_clip => kind.count(scene).saturating_sub(1),
            _ => 0,
        };
        // The model that a VMD is for has them.
        let is_of_model = self.format == Format::Vmd && scene.metadata.mmd.is_some();
        let unread = |kind: DataKind| -> u64 {
            let is_elsewhere = is_of_model && kind == DataKind::Meshes;
            let of_kind = scene.metadata.lost.iter().filter(move |loss| loss.kind == kind);
            match is_elsewhere || is_passed && self.carriage(kind) != Carriage::Lost {
                true => 0,
                false => of_kind.map(|loss| loss.count).sum(),
            }
        };
        let losses = DataKind::ALL
            .iter()
            .map(|&kind| DataLoss::new(kind, read(kind) + unread(kind)));
        losses.filter(|loss| loss.count > 0).collect()
    }

    /// The warning of a loss.
    #[doc(hidden)]
    pub fn loss_warning(&self, loss: DataLoss) -> Diagnostic {
        let verb = if loss.count == 1 { "is" } else { "are" };
        let warning = Diagnostic::new(
            Code::NotCarriedOver,
            format!("{loss} {verb} not in the output, {}", self.name),
        );
        match loss.kind {
            DataKind::AnalogChannels => warning.help("`mocap analog` writes them"),
            DataKind::ForcePlates => warning.help("`mocap forces` writes their forces"),
            DataKind::Events => warning.help("`mocap info` lists them"),
            DataKind::Clips => warning.help("{clip} takes another"),
            _ => warning,
        }
    }
}
