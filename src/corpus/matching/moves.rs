//! The frames of a database as poses of one skeleton.

use std::collections::HashMap;
use std::path::Path;

use glam::{Mat4, Quat, Vec3};
use mocap_edit::{Mirror, Step, StepInput, knee_at_rest};
use mocap_figure::contacts::ball;
use mocap_figure::{Figure, HumanoidBone as Bone};
use mocap_retarget::{RetargetOptions, Retargeter};
use mocap_scene::error::{Code, Diagnostic, Error, Result};
use mocap_scene::ik::seen_hinge;
use mocap_scene::limits::Limits;
use mocap_scene::pose::{Binding, Pose, Trs};
use mocap_scene::scene::{Animation, Node, NodeId, Scene, Side};

use super::clip::IndexedClip;
use super::database::Database;
use super::features::{FEATURE_RATE, FEATURES, LEG, Root, Track};
use crate::survey::report::ClipRow;
use crate::survey::{Motion, clip_name};

/// The poses of a database's frames on the skeleton of a character, for a [`Controller`](super::Controller).
///
/// [`Controller`](super::Controller) has an example.
#[derive(Clone, Debug)]
pub struct Moves {
    scene: Scene,
    figure: Figure,
    pub(super) rest: Pose,
    pub(super) hips: NodeId,
    /// The scale of the hips in the rest pose, in the world.
    pub(super) hips_scale: Vec3,
    /// The transform from the world to the parent of the hips. The parent and its ancestors stay in the rest pose.
    pub(super) world_to_above: Mat4,
    /// Thigh, shin and foot of both sides.
    pub(super) legs: [[NodeId; 3]; 2],
    /// The hinge axes of both knees, in the coordinate frames of the thighs, not normalized.
    pub(super) knees: [Vec3; 2],
    /// The balls of both feet, or the ankles of a body without toes.
    pub(super) balls: [NodeId; 2],
    /// The nodes of the character that move, except the hips.
    pub(super) nodes: Vec<NodeId>,
    /// The transforms of these nodes relative to their parents in the rest pose.
    pub(super) at_rest: Vec<Trs>,
    /// One entry for each frame.
    pub(super) frames: Vec<Frame>,
    /// Rotations relative to the parents, frame by frame.
    rotations: Vec<Quat>,
    pub(super) features: Vec<[f32; FEATURES]>,
    /// The size of this body relative to the body of the features.
    pub(super) scale: f32,
}

/// The data of a frame, except the rotations of its nodes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub(super) root: Root,
    /// The position of the hips in the world.
    pub(super) position: Vec3,
    pub(super) rotation: Quat,
    pub(super) contacts: u8,
    pub(super) is_first: bool,
    pub(super) is_last: bool,
}

impl Moves {
    /// Makes an empty list for a character, in metres with +Y up. [`Conversion`](mocap_figure::Conversion) converts a
    /// character to these units.
    ///
    /// # Errors
    /// [`Code::NotHumanoid`] for a body without hips or legs.
    pub fn new(character: &Scene) -> Result<Self> {
        let scene = Scene {
            animations: Vec::new(),
            ..character.clone()
        };
        let figure = Figure::new(&scene);
        let lacks = || {
            let message = format!("motion matching needs hips and two legs: {}", figure.humanoid.reason);
            Diagnostic::new(Code::NotHumanoid, message)
        };
        let joint = |bone: Bone| figure.humanoid.joint(bone);
        let leg = |side: Side| -> Option<[NodeId; 3]> {
            let [thigh, shin, foot] = [Bone::LeftUpperLeg, Bone::LeftLowerLeg, Bone::LeftFoot];
            Some([joint(thigh.on(side))?, joint(shin.on(side))?, joint(foot.on(side))?])
        };
        let [left, right] = Side::ALL.map(leg);
        let legs = [left.ok_or_else(lacks)?, right.ok_or_else(lacks)?];
        let hips = joint(Bone::Hips).ok_or_else(lacks)?;
        let rest = Pose::rest(&scene);
        let length = |[thigh, shin, foot]: [NodeId; 3]| {
            let [thigh, shin, foot] = [thigh, shin, foot].map(|node| rest.position(node));
            thigh.distance(shin) + shin.distance(foot)
        };
        let scale = length(legs[0]) / LEG;
        if !(scale.is_finite() && scale > 0.0) {
            return Err(lacks().into());
        }
        let balls = [0, 1].map(|side| ball(&scene, &figure.humanoid, Side::ALL[side]).unwrap_or(legs[side][2]));
        let is_below = |node: &NodeId| {
            let mut above = scene.nodes[node.index()].parent;
            while let Some(parent) = above.filter(|parent| *parent != hips) {
                above = scene.nodes[parent.index()].parent;
            }
            above.is_some()
        };
        let nodes: Vec<NodeId> = (0..scene.nodes.len()).map(NodeId::new).filter(is_below).collect();
        let at_rest = nodes
            .iter()
            .map(|node| Trs::from_matrix(rest.node_to_parent[node.index()]));
        let above = scene.nodes[hips.index()].parent;
        Ok(Self {
            hips_scale: Trs::from_matrix(rest.node_to_world[hips.index()]).scale,
            world_to_above: above.map_or(Mat4::IDENTITY, |above| rest.node_to_world[above.index()].inverse()),
            at_rest: at_rest.collect(),
            knees: legs.map(|[thigh, ..]| knee_at_rest(&rest, &figure, thigh)),
            rest,
            hips,
            legs,
            balls,
            nodes,
            frames: Vec::new(),
            rotations: Vec::new(),
            features: Vec::new(),
            scale,
            figure,
            scene,
        })
    }

    /// Retargets all motions of a database to a character with [`Retargeter`]. The character is in metres with +Y up.
    /// `open` reads a file by its name in the database. `open` is not called for files whose motions the database has.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::matching::{Database, IndexedClip, Moves};
    ///
    /// let walk = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
    /// let database = Database::new(IndexedClip::of(&walk, "fixtures/real/cmu_12_01_walk.bvh", true));
    /// let mut hero = mocap::import("fixtures/real/rokoko_dance.bvh")?;
    /// mocap::Conversion::new().apply(&mut hero)?;
    /// let moves = Moves::of(&database, &hero, |file| mocap::import(file))?;
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// The errors of [`new`](Self::new), [`add`](Self::add), [`Retargeter`] and `open`; [`Code::InvalidDatabase`] if a
    /// file has changed since it was indexed.
    pub fn of(database: &Database, character: &Scene, mut open: impl FnMut(&str) -> Result<Scene>) -> Result<Self> {
        let mut moves = Self::new(character)?;
        let mut files: HashMap<&str, HashMap<String, Animation>> = HashMap::new();
        for clip in database.clips() {
            let ClipRow { file, clip: name, .. } = &clip.row;
            let of_file = |error: Error| error.with_path(Path::new(file));
            let names = files.entry(file).or_default();
            if !names.contains_key(name) {
                match database.packed(clip) {
                    Some(clip) => {
                        let scene = clip.motion().map_err(of_file)?;
                        let animation = on_character(scene, character).map_err(of_file)?.into_values().next();
                        names.extend(animation.map(|animation| (name.clone(), animation)));
                    }
                    None => {
                        let scene = open(file)?;
                        let origin = scene.metadata.origin.as_ref();
                        if origin.is_none_or(|origin| origin.sha256 != clip.row.sha256) {
                            return Err(of_file(changed()));
                        }
                        names.extend(on_character(scene, character).map_err(of_file)?);
                    }
                }
            }
            let animation = names.get(name).ok_or_else(|| of_file(changed()))?;
            moves.add(clip, animation).map_err(of_file)?;
        }
        Ok(moves)
    }

    /// Adds the frames of a clip of the database. Call this function for each clip, in the order of the database.
    /// `animation` is the motion of the clip on the character, retargeted by
    /// [`Retargeter`](mocap_retarget::Retargeter). If the clip is mirrored, this function mirrors the motion.
    ///
    /// # Errors
    /// [`Code::LimitExceeded`] if there are too many poses, and the errors of [`Mirror`].
    pub fn add(&mut self, clip: &IndexedClip, animation: &Animation) -> Result<()> {
        let count = clip.features().len();
        let values = (self.frames.len() + count).saturating_mul(self.nodes.len()) as u64;
        let most = Limits::default().max_values;
        if values > most {
            let message = format!("the poses of the database have {values} rotations, more than the limit of {most}");
            return Err(Diagnostic::new(Code::LimitExceeded, message).into());
        }
        self.scene.animations = vec![animation.clone()];
        if clip.mirrored {
            Mirror::new().apply(&mut self.scene, &StepInput::new().humanoid(&self.figure.humanoid))?;
        }
        let animation = self.scene.animations.remove(0);
        let motion = Motion::new(&self.scene, &animation, &self.figure)?;
        let track = motion.body.as_ref().and_then(|body| Track::new(&motion, body));
        let no_motion = || Diagnostic::new(Code::NoMotion, "a clip of the database moves no joint of the character");
        let track = track.filter(|track| track.frames() > 0).ok_or_else(no_motion)?;
        let binding = Binding::new(&self.scene, &animation);
        let mut pose = self.rest.clone();
        for frame in 0..count {
            let tick = (frame as f64 / FEATURE_RATE * animation.ticks_per_second).min(animation.duration);
            pose.sample(&binding, &animation, tick);
            for (knee, leg) in self.knees.iter_mut().zip(self.legs) {
                *knee += seen_hinge(&pose, leg);
            }
            let hips = Trs::from_matrix(pose.node_to_world[self.hips.index()]);
            self.frames.push(Frame {
                root: track.roots[frame.min(track.frames() - 1)],
                position: hips.translation,
                rotation: hips.rotation,
                contacts: clip.contacts()[frame],
                is_first: frame == 0,
                is_last: frame + 1 == count,
            });
            let locals = self.nodes.iter().map(|node| pose.node_to_parent[node.index()]);
            self.rotations
                .extend(locals.map(|matrix| Trs::from_matrix(matrix).rotation));
        }
        self.features.extend_from_slice(clip.features());
        Ok(())
    }

    /// A node of the character.
    pub(super) fn node(&self, node: NodeId) -> &Node {
        &self.scene.nodes[node.index()]
    }

    /// The rotations of the moving nodes in a frame, relative to their parents.
    pub(super) fn rotations(&self, frame: usize) -> &[Quat] {
        &self.rotations[frame * self.nodes.len()..(frame + 1) * self.nodes.len()]
    }
}

/// The motions of a file, retargeted to the character. The keys are the names of the clips in the database.
fn on_character(scene: Scene, character: &Scene) -> Result<HashMap<String, Animation>> {
    let names: Vec<String> = scene.animations.iter().enumerate().map(clip_name).collect();
    let clips = Retargeter::new(scene, character.clone(), RetargetOptions::new())?.into_clips();
    Ok(names
        .into_iter()
        .zip(clips.into_iter().map(|clip| clip.animation))
        .collect())
}

fn changed() -> Error {
    Diagnostic::new(Code::InvalidDatabase, "the file has changed since it was indexed")
        .help("make the database again with mocap index")
        .into()
}
