//! The contents of a scene, counted by kind, so that readers and writers account for the losses.

use std::collections::HashSet;
use std::fmt;

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::{Animation, Channel, Keys, Node, NodeKind, SKELETON_MATERIAL, Scene};

/// The largest difference of a position or a scale that is no change, as a fraction: the rounding of products and of
/// text.
const ROUNDING: f32 = 1e-4;

/// Declares [`DataKind`] from one line for each: its documentation, the variant, its name in JSON, and what one and
/// several are called.
macro_rules! kinds {
    ($(#[$about:meta] $variant:ident $name:literal $one:literal $many:literal)*) => {
        /// A kind of data of a file.
        ///
        /// [`DataLoss`] has an example.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
        #[serde(rename_all = "kebab-case")]
        #[non_exhaustive]
        pub enum DataKind {
            $(#[$about] $variant,)*
        }

        impl DataKind {
            /// Every kind.
            pub const ALL: &[Self] = &[$(Self::$variant),*];

            /// Its name in JSON, which does not change between versions.
            pub const fn as_str(self) -> &'static str {
                match self { $(Self::$variant => $name,)* }
            }

            /// What `count` of them are called in a sentence.
            const fn noun(self, count: u64) -> &'static str {
                match (self, count) { $((Self::$variant, 1) => $one, (Self::$variant, _) => $many,)* }
            }
        }
    };
}

kinds! {
    /// Animations.
    Clips "clips" "clip" "clips"
    /// Moments at which curves of joints have keys.
    Frames "frames" "frame" "frames"
    /// Frame rates of clips.
    FrameRates "frame-rates" "frame rate" "frame rates"
    /// Lengths of clips in seconds.
    Durations "durations" "duration" "durations"
    /// The unit of length that a file states.
    Units "units" "unit of length" "units of length"
    /// Joints and markers that move in any clip.
    MovingJoints "moving-joints" "moving joint" "moving joints"
    /// Joints below other joints whose position in their parent changes in any clip.
    PositionCurves "position-curves" "curve of a joint's position" "curves of joints' positions"
    /// Joints whose scale changes in any clip.
    ScaleCurves "scale-curves" "curve of a joint's scale" "curves of joints' scales"
    /// Joints with a scale at rest.
    RestScales "rest-scales" "scale of a joint at rest" "scales of joints at rest"
    /// Expressions, and weights of morph targets, that change in any clip.
    FaceCurves "face-curves" "face curve" "face curves"
    /// Markers that are not seen in every frame.
    MarkerGaps "marker-gaps" "marker with gaps" "markers with gaps"
    /// Meshes of a file, but for meshes that draw its skeleton.
    Meshes "meshes" "mesh" "meshes"
    /// Meshes that joints move.
    Skins "skins" "skin" "skins"
    /// Skins that blend dual quaternions.
    DualQuaternionSkins "dual-quaternion-skins" "dual quaternion skin" "dual quaternion skins"
    /// Sets of texture coordinates.
    UvSets "uv-sets" "UV set" "UV sets"
    /// Meshes with a colour for each vertex.
    VertexColors "vertex-colors" "mesh with vertex colours" "meshes with vertex colours"
    /// Morph targets, also called blend shapes.
    MorphTargets "morph-targets" "morph target" "morph targets"
    /// Expressions of a character, which say what moves its face.
    Expressions "expressions" "expression" "expressions"
    /// Materials.
    Materials "materials" "material" "materials"
    /// Textures.
    Textures "textures" "texture" "textures"
    /// Named moments of a recording.
    Events "events" "event" "events"
    /// Analog channels of a recording.
    AnalogChannels "analog-channels" "analog channel" "analog channels"
    /// Force plates.
    ForcePlates "force-plates" "force plate" "force plates"
    /// Links of a robot.
    Links "links" "link" "links"
    /// Bodies and meshes that show a link of a robot, or with which it touches others.
    LinkShapes "link-shapes" "shape of a link" "shapes of links"
    /// Links of a robot with a mass.
    LinkMasses "link-masses" "mass of a link" "masses of links"
    /// Joints of a robot that follow others.
    CoupledJoints "coupled-joints" "joint that follows another" "joints that follow others"
    /// Joints of a robot with limits.
    JointLimits "joint-limits" "joint limit" "joint limits"
    /// Cameras.
    Cameras "cameras" "camera" "cameras"
    /// Lights.
    Lights "lights" "light" "lights"
    /// Objects of a file with data of other programs.
    Extras "extras" "object with extras" "objects with extras"
}

/// Data of a file that its output does not have.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::scene::report::{DataKind, DataLoss};
/// use mocap::{Exporter, Format};
///
/// let scene = mocap::import("fixtures/real/py_c3d_motion.c3d")?;
/// let written = Exporter::new().write(&scene, Format::Trc)?;
/// assert!(written.losses.contains(&DataLoss::new(DataKind::ForcePlates, 2)));
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct DataLoss {
    /// The kind.
    pub kind: DataKind,
    /// How many.
    pub count: u64,
}

impl DataLoss {
    /// So many of a kind.
    pub const fn new(kind: DataKind, count: u64) -> Self {
        Self { kind, count }
    }
}

impl fmt::Display for DataLoss {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.count, self.kind.noun(self.count))
    }
}

impl DataKind {
    /// Whether an output without it may stand still.
    #[doc(hidden)]
    pub const fn is_motion(self) -> bool {
        matches!(
            self,
            Self::Clips
                | Self::Frames
                | Self::Durations
                | Self::MovingJoints
                | Self::PositionCurves
                | Self::ScaleCurves
                | Self::FaceCurves
        )
    }

    /// How many a scene holds.
    #[doc(hidden)]
    pub fn count(self, scene: &Scene) -> u64 {
        let recorded = scene.metadata.recorded.as_deref();
        let meshes = || scene.own_meshes();
        let count = match self {
            Self::Clips => scene.animations.len(),
            Self::MovingJoints => nodes(scene, false, Channel::moves),
            Self::Frames => scene.animations.iter().map(Animation::frame_count).sum(),
            Self::FrameRates | Self::Durations => scene.animations.len(),
            Self::Units => usize::from(scene.metadata.metres_per_unit.is_some()),
            Self::PositionCurves => {
                let curves = |animation| scene.position_curves(animation);
                scene.animations.iter().flat_map(curves).collect::<HashSet<_>>().len()
            }
            Self::RestScales => {
                let is_scaled = |node: &&Node| {
                    let (scale, ..) = node.transform.to_scale_rotation_translation();
                    node.kind == NodeKind::Joint && !scale.abs_diff_eq(Vec3::ONE, ROUNDING)
                };
                scene.nodes.iter().filter(is_scaled).count()
            }
            Self::ScaleCurves => nodes(scene, false, |channel| varies(&channel.scaling_keys)),
            Self::FaceCurves => scene.weight_curves() + scene.expression_curves(),
            Self::MarkerGaps => {
                let markers = scene
                    .animations
                    .iter()
                    .map(|animation| scene.points_with_gaps(animation));
                markers
                    .map(|found| found.into_iter().flatten().count())
                    .max()
                    .unwrap_or_default()
            }
            Self::Meshes => meshes().count(),
            Self::Skins => meshes().filter(|mesh| !mesh.bones.is_empty()).count(),
            Self::UvSets => meshes().filter(|mesh| !mesh.texture_coords.is_empty()).count(),
            // A mesh of several materials has each target several times.
            Self::MorphTargets => {
                let named = meshes().flat_map(|mesh| {
                    let targets = mesh.morph_targets.iter();
                    targets.map(move |target| (&mesh.name, &target.name))
                });
                named.collect::<HashSet<_>>().len()
            }
            Self::Materials => {
                let own = scene.materials.iter();
                own.filter(|material| !material.name.starts_with(SKELETON_MATERIAL))
                    .count()
            }
            Self::Textures => scene.textures.len(),
            Self::Events => recorded.map_or(0, |recorded| recorded.events.len()),
            Self::AnalogChannels => recorded.map_or(0, |recorded| recorded.channels.len()),
            Self::ForcePlates => recorded.map_or(0, |recorded| recorded.plates.len()),
            // A scene has no place for them.
            Self::DualQuaternionSkins
            | Self::VertexColors
            | Self::Expressions
            | Self::Links
            | Self::LinkShapes
            | Self::LinkMasses
            | Self::CoupledJoints
            | Self::JointLimits
            | Self::Cameras
            | Self::Lights
            | Self::Extras => 0,
        };
        count as u64
    }
}

impl Scene {
    /// Accounts for what the file has and the scene has not; nothing where `count` is 0.
    #[doc(hidden)]
    pub fn lose(&mut self, kind: DataKind, count: usize) {
        let lost = &mut self.metadata.lost;
        match lost.iter_mut().find(|loss| loss.kind == kind) {
            Some(loss) => loss.count += count as u64,
            None if count > 0 => lost.push(DataLoss {
                kind,
                count: count as u64,
            }),
            None => {}
        }
    }
}

impl Scene {
    /// How many expressions, of which each has a node, any clip changes.
    #[doc(hidden)]
    pub fn expression_curves(&self) -> usize {
        nodes(self, true, |channel| varies(&channel.position_keys))
    }

    /// How many curves of a face a clip has in which nothing else moves; `None` where joints move too, or nothing does.
    #[doc(hidden)]
    pub fn face_curves_alone(&self, clip: usize) -> Option<DataLoss> {
        let channels = self.animations.get(clip)?.channels.iter();
        let moving = channels.filter(|channel| channel.moves() || varies(&channel.scaling_keys));
        let (of_face, others): (Vec<&Channel>, Vec<&Channel>) = moving.partition(|channel| is_of_face(self, channel));
        let unread = self.metadata.lost.iter().find(|loss| loss.kind == DataKind::FaceCurves);
        let unread = unread.map_or(0, |loss| loss.count);
        let count = unread + (of_face.len() + self.weight_curves_in(clip)) as u64;
        (others.is_empty() && count > 0).then_some(DataLoss::new(DataKind::FaceCurves, count))
    }

    /// Whether anything moves in any clip: joints, markers, scales, expressions or weights of morph targets.
    #[doc(hidden)]
    pub fn moves(&self) -> bool {
        self.animations.iter().any(Animation::moves) || self.weight_curves() > 0
    }

    /// The clip that stands for the motion: the first in which joints move, else the first.
    #[doc(hidden)]
    pub fn main_clip(&self) -> usize {
        self.animations.iter().position(Animation::moves).unwrap_or_default()
    }
}

impl Animation {
    /// Whether any of its channels changes.
    #[doc(hidden)]
    pub fn moves(&self) -> bool {
        let mut channels = self.channels.iter();
        channels.any(|channel| channel.moves() || varies(&channel.scaling_keys))
    }
}

impl Channel {
    /// Whether the position of its node changes by more than a rounding.
    #[doc(hidden)]
    pub fn goes(&self) -> bool {
        let positions = &self.position_keys.values;
        let is_elsewhere = |position: &Vec3| position.distance(positions[0]) > ROUNDING * positions[0].length();
        positions.iter().any(is_elsewhere)
    }

    /// Whether its node turns or goes anywhere.
    #[doc(hidden)]
    pub fn moves(&self) -> bool {
        varies(&self.rotation_keys) || varies(&self.position_keys)
    }
}

/// Whether keys have more than one value: a part of a take may be still.
fn varies<T: PartialEq>(keys: &Keys<T>) -> bool {
    keys.values.iter().any(|value| *value != keys.values[0])
}

fn is_of_face(scene: &Scene, channel: &Channel) -> bool {
    let node = channel.node.and_then(|id| scene.nodes.get(id.index()));
    node.is_some_and(|node| node.face.is_some())
}

/// Nodes, of faces or of others, with a channel of any clip that `moves`.
fn nodes(scene: &Scene, of_face: bool, moves: impl Fn(&Channel) -> bool) -> usize {
    let channels = scene.animations.iter().flat_map(|animation| &animation.channels);
    let moving = channels.filter(|channel| moves(channel) && is_of_face(scene, channel) == of_face);
    let nodes: HashSet<_> = moving.map(|channel| (channel.node, &channel.node_name)).collect();
    nodes.len()
}
