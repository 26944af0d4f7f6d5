//! The ledger: the kinds of data that the files of a format hold, and so the losses of a written scene.
//!
//! A row states the kinds that its format keeps or converts. All other kinds are lost. `docs/losses.md` has the table.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::path::Path;

use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::pose::Binding;
use mocap_scene::scene::report::{DataKind, DataLoss};
use mocap_scene::scene::{Animation, Format, Keys, Node, NodeId, NodeKind, Scene, Topic};

use crate::FormatInfo;

/// The largest relative difference of equal frame rates: the rounding of a frame time with four digits.
const SAME_RATE: f64 = 1e-4;

/// The largest distance in frames between a time and a frame at which both count as equal.
const AT_FRAME: f64 = 1e-3;

/// The treatment of a kind of data in the files of a format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[doc(hidden)]
pub enum Carriage {
    /// The files hold the data.
    Kept,
    /// The files hold other data, from which a program computes the same motion.
    Converted,
    /// The files have a pose for each frame. Keys between frames are lost, and a motion ends at a frame.
    AtFrames,
    /// The files hold the data for the root, but not for other joints.
    OfRoot,
    /// The files hold the weights of morph targets, but not expressions.
    OfTargets,
    /// The files hold the data if they are the scene's source file with another motion: [`Scene::original`].
    PassedThrough,
    /// The files do not hold the data. A warning reports the loss.
    Lost,
}

impl Carriage {
    /// The word for the treatment in the table.
    #[doc(hidden)]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Kept => "kept",
            Self::Converted => "converted",
            Self::AtFrames => "at frames",
            Self::OfRoot => "root only",
            Self::OfTargets => "morph curves",
            Self::PassedThrough => "kept from glTF",
            Self::Lost => "lost",
        }
    }
}

/// Kinds of data and their treatment.
#[doc(hidden)]
pub(crate) type Carried = &'static [(DataKind, Carriage)];

/// The treatment of data in formats for characters: skeletons, motions and skinned meshes.
pub(crate) const OF_CHARACTERS: Carried = &[
    (DataKind::Clips, Carriage::Kept),
    (DataKind::Frames, Carriage::Kept),
    (DataKind::FrameRates, Carriage::Kept),
    (DataKind::Durations, Carriage::Kept),
    (DataKind::Units, Carriage::Converted),
    (DataKind::MovingJoints, Carriage::Kept),
    (DataKind::PositionCurves, Carriage::Kept),
    (DataKind::ScaleCurves, Carriage::Kept),
    (DataKind::RestScales, Carriage::Kept),
    (DataKind::FaceCurves, Carriage::OfTargets),
    (DataKind::MorphTargets, Carriage::Kept),
    (DataKind::Meshes, Carriage::Kept),
    (DataKind::Skins, Carriage::Kept),
    (DataKind::UvSets, Carriage::Kept),
    (DataKind::Materials, Carriage::Kept),
    (DataKind::Textures, Carriage::Kept),
];

/// The joints of a scene that are not in `written`, the scene as a format holds it. Also returns the number of these
/// joints that move, because their descendants lose this motion too.
pub(crate) fn joints_left_out(scene: &Scene, written: &Scene) -> (Vec<String>, DataLoss) {
    let is_left = |node: &Node| written.nodes.iter().all(|other| other.name != node.name);
    let joints = scene
        .nodes
        .iter()
        .filter(|node| node.kind == NodeKind::Joint && node.face.is_none());
    let names = joints.filter(|node| is_left(node)).map(|node| node.name.clone());
    let mut has_place: Vec<bool> = scene.nodes.iter().map(|node| !is_left(node)).collect();
    // Parents precede children, so the reverse order visits children first.
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

/// The joints other than the hips whose position relative to the parent changes in the scene, but not in `humanoid`,
/// the scene as a humanoid format holds it.
pub(crate) fn positions_left_out(scene: &Scene, humanoid: &Scene) -> DataLoss {
    let hips = humanoid.nodes.first().map(|hips| hips.name.as_str());
    let hips = scene.nodes.iter().position(|node| Some(node.name.as_str()) == hips);
    let is_below_hips = |node: &NodeId| {
        let above = |node: &NodeId| scene.nodes[node.index()].parent;
        std::iter::successors(above(node), above).any(|node| Some(node.index()) == hips)
    };
    let clip = scene.animations.first();
    let curves = clip.map_or_else(Vec::new, |clip| scene.position_curves(clip));
    let count = curves.iter().filter(|node| is_below_hips(node)).count();
    DataLoss::new(DataKind::PositionCurves, count as u64)
}

fn is_between_frames(tick: f64, ticks_per_frame: f64) -> bool {
    let frame = tick / ticks_per_frame;
    (frame - frame.round()).abs() > AT_FRAME
}

/// The number of key times of a clip that are between the frames of a file.
fn frames_lost(clip: &Animation, ticks_per_frame: f64) -> usize {
    fn times<T>(keys: &Keys<T>) -> (usize, &[f64]) {
        (keys.len(), keys.ticks.as_deref().unwrap_or_default())
    }
    let tracks = || {
        let channels = clip.channels.iter().flat_map(|channel| {
            let [positions, scales] = [&channel.position_keys, &channel.scaling_keys].map(times);
            [positions, times(&channel.rotation_keys), scales]
        });
        channels.filter(|(keys, _)| *keys > 1)
    };
    let every_tick = tracks()
        .filter(|(_, ticks)| ticks.is_empty())
        .map(|(keys, _)| keys)
        .max();
    let every_tick = every_tick.unwrap_or_default();
    let is_lost = |tick: &f64| is_between_frames(*tick, ticks_per_frame);
    let is_further = |tick: &f64| tick.fract() != 0.0 || *tick >= every_tick as f64;
    let timed = tracks().flat_map(|(_, ticks)| ticks.iter().copied());
    let mut lost: Vec<f64> = timed.filter(|tick| is_further(tick) && is_lost(tick)).collect();
    lost.sort_unstable_by(f64::total_cmp);
    lost.dedup();
    lost.len() + (0..every_tick).filter(|tick| is_lost(&(*tick as f64))).count()
}

/// Writer options that change the losses.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, Default)]
pub struct LedgerOptions {
    /// Whether only the root has position channels.
    pub rotations_only: bool,
    /// Whether a sidecar file states the unit of length.
    pub sidecar: bool,
}

/// Whether the files of a format state a unit of length, as the format's row says. The writers use this function
/// instead of the table of formats, because the table would link every reader.
pub fn states_unit(format: Format) -> bool {
    !matches!(format, Format::Bvh | Format::AsfAmc | Format::Bip)
}

impl FormatInfo {
    /// The treatment of a kind of data in the files of this format.
    #[doc(hidden)]
    pub fn carriage(&self, kind: DataKind) -> Carriage {
        if self.passed_through.contains(&kind) {
            return Carriage::PassedThrough;
        }
        let mut rows = self.carried.iter();
        let row = rows.find(|(carried, _)| *carried == kind);
        row.map_or(Carriage::Lost, |(_, carriage)| *carriage)
    }

    /// Whether files of this format hold the morph targets of an input's meshes. Morph targets of a file that is passed
    /// through need not be read.
    #[doc(hidden)]
    pub fn takes_morph_targets(&self, input: &Path) -> bool {
        let extension = input.extension().unwrap_or_default();
        let is_passed = |known: &&str| extension.eq_ignore_ascii_case(known);
        let mut passed = self.extensions.iter().chain(&["vrm"]).filter(|_| self.keeps_characters);
        self.carriage(DataKind::MorphTargets) == Carriage::Kept && !passed.any(is_passed)
    }

    /// The clips of a scene that a file of this format holds.
    fn clips<'a>(&self, scene: &'a Scene) -> &'a [Animation] {
        let count = if self.has_one_clip { 1 } else { usize::MAX };
        &scene.animations[..count.min(scene.animations.len())]
    }

    /// The number of clips whose frame rate differs in the file.
    fn lost_rates(&self, scene: &Scene) -> usize {
        let rates = || self.clips(scene).iter().map(|clip| clip.ticks_per_second);
        let fastest = self.has_one_rate.then(|| rates().fold(0.0, f64::max));
        let is_other = |rate: f64| {
            let written = self.rate.or(fastest).unwrap_or(rate);
            (rate - written).abs() > SAME_RATE * written
        };
        rates().filter(|rate| is_other(*rate)).count()
    }

    /// The lost items of a kind in a scene.
    fn lost_of(&self, kind: DataKind, scene: &Scene, chosen: LedgerOptions) -> u64 {
        let is_passed = self.keeps_characters && scene.original.is_some();
        let clips = || self.clips(scene).iter();
        let count = match (self.carriage(kind), kind) {
            (_, DataKind::FrameRates) => self.lost_rates(scene),
            (Carriage::AtFrames, DataKind::Durations) => {
                let is_lost = |clip: &&Animation| is_between_frames(clip.duration, self.ticks_per_frame(clip));
                clips().filter(is_lost).count()
            }
            (Carriage::AtFrames, _) => clips().map(|clip| frames_lost(clip, self.ticks_per_frame(clip))).sum(),
            (Carriage::Lost, DataKind::Units) => {
                let is_guessed = scene
                    .metadata
                    .assumptions
                    .iter()
                    .any(|guess| guess.topic == Topic::Unit);
                let is_stated = !is_guessed && scene.metadata.format.is_some_and(states_unit);
                usize::from(is_stated && !(self.has_sidecar && chosen.sidecar))
            }
            (Carriage::Kept, DataKind::PositionCurves) if chosen.rotations_only && self.has_sidecar => {
                clips().map(|clip| scene.position_curves(clip).len()).sum()
            }
            // Without position channels, all joints but the root stay in place.
            (Carriage::Converted, DataKind::ScaleCurves) if chosen.rotations_only && self.has_sidecar => {
                return kind.count(scene);
            }
            // A glTF file always has the extras of clips.
            (Carriage::PassedThrough, DataKind::Extras) => 0,
            (Carriage::Lost, _) => return kind.count(scene),
            (Carriage::PassedThrough, _) if !is_passed => return kind.count(scene),
            // The curves of expressions are node channels.
            (Carriage::Kept, DataKind::FaceCurves) => scene.weight_curves(),
            (Carriage::OfTargets, _) if is_passed => 0,
            (Carriage::OfTargets, _) => scene.expression_curves() + scene.weight_curves_without_meshes(),
            (Carriage::Kept, DataKind::Clips) => scene.animations.len() - clips().len(),
            _ => 0,
        };
        count as u64
    }

    /// The number of clip ticks per frame of a file.
    fn ticks_per_frame(&self, clip: &Animation) -> f64 {
        self.rate.map_or(1.0, |rate| clip.ticks_per_second / rate)
    }

    /// The losses of a scene in this format, including the data that its reader dropped.
    #[doc(hidden)]
    pub fn losses(&self, scene: &Scene, chosen: LedgerOptions) -> Vec<DataLoss> {
        let is_passed = self.keeps_characters && scene.original.is_some();
        let is_kept = self.format == Format::Fbx && scene.metadata.fbx.is_some();
        // In VMD, the MikuMikuDance model has the meshes.
        let is_of_model = self.format == Format::Vmd && scene.metadata.mmd.is_some();
        let unread = |kind: DataKind| -> u64 {
            let is_elsewhere = is_of_model && kind == DataKind::Meshes;
            let of_kind = scene.metadata.lost.iter().filter(move |loss| loss.kind == kind);
            match is_elsewhere || is_kept || is_passed && self.carriage(kind) != Carriage::Lost {
                true => 0,
                false => of_kind.map(|loss| loss.count).sum(),
            }
        };
        let losses = DataKind::ALL
            .iter()
            .map(|&kind| DataLoss::new(kind, self.lost_of(kind, scene, chosen) + unread(kind)));
        losses.filter(|loss| loss.count > 0).collect()
    }

    /// The warnings of losses: one warning for each loss with a remedy, and one warning for all other losses.
    #[doc(hidden)]
    pub fn loss_warnings(&self, losses: &[DataLoss]) -> Vec<Diagnostic> {
        let (others, remedied): (Vec<DataLoss>, Vec<DataLoss>) =
            losses.iter().partition(|loss| self.remedy(loss.kind).is_none());
        let groups = remedied.iter().map(std::slice::from_ref).chain([&others[..]]);
        let warning = |group: &[DataLoss]| {
            let verb = match group {
                [loss] if loss.count == 1 => "is",
                _ => "are",
            };
            let counted: Vec<String> = group.iter().map(ToString::to_string).collect();
            let (last, before) = counted.split_last()?;
            let all = match before {
                [] => last.clone(),
                before => format!("{} and {last}", before.join(", ")),
            };
            let message = format!("{all} {verb} not in the output, {}", self.name);
            let warning = Diagnostic::new(Code::NotCarriedOver, message);
            Some(match self.remedy(group[0].kind) {
                Some(remedy) => warning.help(remedy),
                None => warning,
            })
        };
        groups.filter_map(warning).collect()
    }

    /// The remedy for the loss of a kind of data; `None` if no remedy exists.
    #[doc(hidden)]
    pub fn remedy(&self, kind: DataKind) -> Option<Cow<'static, str>> {
        let remedy = match kind {
            DataKind::AnalogChannels => "`mocap analog` writes these channels",
            DataKind::ForcePlates => "`mocap forces` writes the forces of these plates",
            DataKind::Events => "`mocap info` lists these events",
            DataKind::Clips => "{clip} selects another clip",
            DataKind::FaceCurves if self.carriage(kind) == Carriage::OfTargets => {
                "write .vrma, or .glb of a .vrm, which keep expressions"
            }
            DataKind::FaceCurves => "write .glb, .fbx or .usda, which keep curves of morph targets",
            DataKind::Units => {
                "files of this format state no unit; {out-unit} chooses the unit that the next program expects, and \
                 {sidecar} writes it to a file beside the output"
            }
            DataKind::PositionCurves if self.has_sidecar => "leave out {channels}, or write 6",
            DataKind::PositionCurves => "limbs keep their directions and lengths",
            DataKind::Frames | DataKind::FrameRates | DataKind::Durations => match self.rate {
                Some(rate) => {
                    let remedy = format!(
                        "a file of this format has {rate} frames a second; {{fps}} resamples a motion before it is \
                         written"
                    );
                    return Some(remedy.into());
                }
                None => "{fps} with a higher rate keeps more frames",
            },
            _ => return None,
        };
        Some(remedy.into())
    }
}
