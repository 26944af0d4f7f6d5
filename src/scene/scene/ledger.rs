//! Counts the contents of a scene by kind, so that readers and writers can report losses.

use std::collections::HashSet;
use std::fmt;

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::{Animation, Channel, Keys, Node, NodeKind, SKELETON_MATERIAL, Scene};

/// The largest relative difference of a position or a scale that counts as no change: the rounding of products and of
/// text.
const ROUNDING: f32 = 1e-4;

/// Declares [`DataKind`] from one line for each kind: its documentation, its variant, its name in JSON, and its noun in
/// the singular and the plural.
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
            /// All kinds.
            pub const ALL: &[Self] = &[$(Self::$variant),*];

            /// The name in JSON. The name does not change between versions.
            pub const fn as_str(self) -> &'static str {
                match self { $(Self::$variant => $name,)* }
            }

            /// The noun for `count` items in a sentence.
            const fn noun(self, count: u64) -> &'static str {
                match (self, count) { $((Self::$variant, 1) => $one, (Self::$variant, _) => $many,)* }
            }
        }
    };
}

kinds! {
    /// Animations.
    Clips "clips" "clip" "clips"
    /// Times at which curves of joints have keys.
    Frames "frames" "frame" "frames"
    /// Frame rates of clips.
    FrameRates "frame-rates" "frame rate" "frame rates"
    /// Durations of clips in seconds.
    Durations "durations" "duration" "durations"
    /// The unit of length that a file states.
    Units "units" "stated unit of length" "stated units of length"
    /// Joints and markers that move in a clip.
    MovingJoints "moving-joints" "moving joint" "moving joints"
    /// Joints whose position relative to their parent joint changes in a clip.
    PositionCurves "position-curves" "curve of a joint's position" "curves of joints' positions"
    /// Joints whose scale changes in a clip.
    ScaleCurves "scale-curves" "curve of a joint's scale" "curves of joints' scales"
    /// Joints with a scale in the rest pose.
    RestScales "rest-scales" "scale of a joint at rest" "scales of joints at rest"
    /// Expressions and morph target weights that change in a clip.
    FaceCurves "face-curves" "face curve" "face curves"
    /// Markers with missing frames.
    MarkerGaps "marker-gaps" "marker with gaps" "markers with gaps"
    /// Meshes of a file, except meshes that draw its skeleton.
    Meshes "meshes" "mesh" "meshes"
    /// Meshes that are deformed by joints.
    Skins "skins" "skin" "skins"
    /// Skins with dual quaternion blending.
    DualQuaternionSkins "dual-quaternion-skins" "dual quaternion skin" "dual quaternion skins"
    /// Sets of texture coordinates.
    UvSets "uv-sets" "UV set" "UV sets"
    /// Meshes with vertex colours.
    VertexColors "vertex-colors" "mesh with vertex colours" "meshes with vertex colours"
    /// Morph targets, also called blend shapes.
    MorphTargets "morph-targets" "morph target" "morph targets"
    /// Expressions of a character, which control its face.
    Expressions "expressions" "expression" "expressions"
    /// Materials.
    Materials "materials" "material" "materials"
    /// Textures.
    Textures "textures" "texture" "textures"
    /// Textures of materials besides their colour: normals, roughness, emission and others.
    SurfaceMaps "surface-maps" "texture besides the colour" "textures besides the colour"
    /// Chains of joints that swing, such as hair: spring bones.
    Springs "springs" "spring chain" "spring chains"
    /// Nodes that follow other nodes by a constraint.
    Constraints "constraints" "node constraint" "node constraints"
    /// Settings of a VRM character: its gaze, its first-person view, its toon shading.
    CharacterSettings "character-settings" "setting of a character" "settings of a character"
    /// Named times of a recording.
    Events "events" "event" "events"
    /// Analog channels of a recording.
    AnalogChannels "analog-channels" "analog channel" "analog channels"
    /// Force plates.
    ForcePlates "force-plates" "force plate" "force plates"
    /// Links of a robot.
    Links "links" "link" "links"
    /// Shapes and meshes for the display or the collisions of a robot's links.
    LinkShapes "link-shapes" "shape of a link" "shapes of links"
    /// Robot links with a mass.
    LinkMasses "link-masses" "mass of a link" "masses of links"
    /// Robot joints that follow other joints.
    CoupledJoints "coupled-joints" "joint that follows another" "joints that follow others"
    /// Robot joints with limits.
    JointLimits "joint-limits" "joint limit" "joint limits"
    /// Cameras.
    Cameras "cameras" "camera" "cameras"
    /// Lights.
    Lights "lights" "light" "lights"
    /// Objects of a file with application-specific data.
    Extras "extras" "object with extras" "objects with extras"
}

/// Data that a file has and its output lacks.
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
    /// The kind of data.
    pub kind: DataKind,
    /// The number of items.
    pub count: u64,
}

impl DataLoss {
    /// A loss of `count` items of a kind.
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
    /// Whether this kind is motion, so that an output without it may not move.
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

    /// The number of items in a scene.
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
            // A mesh with several materials has each target several times.
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
            Self::Extras => scene.metadata.clip_extras.count(),
            // A scene cannot hold these kinds.
            Self::DualQuaternionSkins
            | Self::VertexColors
            | Self::Expressions
            | Self::SurfaceMaps
            | Self::Springs
            | Self::Constraints
            | Self::CharacterSettings
            | Self::Links
            | Self::LinkShapes
            | Self::LinkMasses
            | Self::CoupledJoints
            | Self::JointLimits
            | Self::Cameras
            | Self::Lights => 0,
        };
        count as u64
    }
}

impl Scene {
    /// Records data that the file has and the scene lacks. Records nothing if `count` is 0.
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
    /// The number of expressions that change in any clip. Each expression has a node.
    #[doc(hidden)]
    pub fn expression_curves(&self) -> usize {
        nodes(self, true, |channel| varies(&channel.position_keys))
    }

    /// The number of face curves in a clip in which only the face moves. `None` if joints move too, or if nothing
    /// moves.
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

    /// Whether anything moves in any clip: joints, markers, scales, expressions or morph target weights.
    #[doc(hidden)]
    pub fn moves(&self) -> bool {
        self.animations.iter().any(Animation::moves) || self.weight_curves() > 0
    }

    /// The clip that represents the motion: the first clip with moving joints, or else the first clip.
    #[doc(hidden)]
    pub fn main_clip(&self) -> usize {
        self.animations.iter().position(Animation::moves).unwrap_or_default()
    }
}

impl Animation {
    /// Whether any channel changes.
    #[doc(hidden)]
    pub fn moves(&self) -> bool {
        let mut channels = self.channels.iter();
        channels.any(|channel| channel.moves() || varies(&channel.scaling_keys))
    }
}

impl Channel {
    /// Whether the position of the node changes by more than rounding.
    #[doc(hidden)]
    pub fn goes(&self) -> bool {
        let positions = &self.position_keys.values;
        let is_elsewhere = |position: &Vec3| position.distance(positions[0]) > ROUNDING * positions[0].length();
        positions.iter().any(is_elsewhere)
    }

    /// Whether the node rotates or changes its position.
    #[doc(hidden)]
    pub fn moves(&self) -> bool {
        varies(&self.rotation_keys) || varies(&self.position_keys)
    }
}

/// Whether keys have more than one value. Keys of a still interval may all be equal.
fn varies<T: PartialEq>(keys: &Keys<T>) -> bool {
    keys.values.iter().any(|value| *value != keys.values[0])
}

fn is_of_face(scene: &Scene, channel: &Channel) -> bool {
    let node = channel.node.and_then(|id| scene.nodes.get(id.index()));
    node.is_some_and(|node| node.face.is_some())
}

/// The number of face nodes, or of other nodes, with a channel that `moves` in any clip.
fn nodes(scene: &Scene, of_face: bool, moves: impl Fn(&Channel) -> bool) -> usize {
    let channels = scene.animations.iter().flat_map(|animation| &animation.channels);
    let moving = channels.filter(|channel| moves(channel) && is_of_face(scene, channel) == of_face);
    let nodes: HashSet<_> = moving.map(|channel| (channel.node, &channel.node_name)).collect();
    nodes.len()
}
