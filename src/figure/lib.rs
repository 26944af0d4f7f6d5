//! Infers what a motion file does not state: its unit, its up axis, its exact frame rate, and whether its first frame
//! is part of the motion. Also infers the body: the joint of each bone, the facing, and the T-pose.
//!
//! Every answer is a guess with a reason. [`Figure`] does not change the scene. The caller decides whether to use a
//! guess.

// Tests may unwrap and print, but the library may not.
#![warn(clippy::unwrap_used, clippy::print_stdout, clippy::print_stderr)]

#[doc(hidden)]
pub mod animal;
#[doc(hidden)]
pub mod axes;
mod axis;
#[doc(hidden)]
pub mod body;
mod bone_names;
#[doc(hidden)]
pub mod contacts;
pub mod convert;
mod extent;
#[doc(hidden)]
pub mod ground;
pub(crate) mod hierarchy;
mod humanoid;
#[doc(hidden)]
pub mod joint_angles;
pub(crate) mod knuckles;
mod limb_angles;
mod measure;
mod name_joints;
#[doc(hidden)]
pub mod names;
mod placing;
mod poses;
pub mod report;
#[doc(hidden)]
pub mod rig;
#[cfg(feature = "robots")]
#[doc(hidden)]
pub mod robot_bones;
#[cfg(feature = "robots")]
mod robot_clip;
#[doc(hidden)]
pub mod rotations;
#[doc(hidden)]
pub mod t_pose;
#[doc(hidden)]
pub mod ticks;
#[doc(hidden)]
pub mod track;
mod unit;
mod up;
#[doc(hidden)]
pub mod vrm_humanoid;
#[doc(hidden)]
pub mod watched;

use std::sync::OnceLock;

use glam::{Mat3, Vec3};
use serde::Serialize;

use mocap_scene::error::Result;
use mocap_scene::process::{first_frame_is_rest_pose, frame_rate};
use mocap_scene::scene::{Assumption, RootOffset, Scene, Topic, UpAxis};

pub use mocap_scene::scene::{Confidence, HumanoidBone, Side};

pub use self::axis::Axis;
pub use self::bone_names::BoneNames;
pub use self::convert::Conversion;
use self::ground::Ground;
use self::humanoid::quadruped_of;
pub use self::humanoid::{Creature, Humanoid, HumanoidMap};
#[doc(hidden)]
pub use self::limb_angles::LimbAngles;
#[doc(hidden)]
pub use self::name_joints::apply_names;
pub use self::name_joints::name_joints;
#[doc(hidden)]
pub use self::poses::is_at_rest_alike;
use self::report::{Guess, Quadruped, RestPose};
#[cfg(feature = "robots")]
#[doc(hidden)]
pub use self::robot_clip::robot_clip;
#[doc(hidden)]
pub use self::t_pose::TPose;
pub use self::unit::Unit;
#[doc(hidden)]
pub use self::vrm_humanoid::vrm_humanoid;

/// The guesses about an imported scene before any step changes it. [`Figure::survey`] has them. Only a few frames are
/// examined, so that a long take costs no more than a short one.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::scene::UpAxis;
/// use mocap::figure::{Figure, Unit};
///
/// let found = Figure::new(&mocap::import("fixtures/real/cmu_01_01.bvh")?).survey;
/// assert_eq!(found.unit.value, Unit::Cmu);
/// assert_eq!(found.up.value, UpAxis::Y);
/// assert_eq!(found.frame_rate.map(|rate| rate.value), Some(120.0)); // the file says .0083333
/// assert!(found.first_frame_is_rest_pose);
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Survey {
    /// The unit of length.
    pub unit: Guess<Unit>,
    /// Metres per unit of length: the value that the file states, else the value of [`unit`](Self::unit).
    pub metres_per_unit: f64,
    /// Whether the file states its unit, in
    /// [`Metadata::metres_per_unit`](mocap_scene::scene::Metadata::metres_per_unit), so that nothing is guessed.
    pub unit_is_stated: bool,
    /// The up axis.
    pub up: Guess<UpAxis>,
    /// Whether the scene states its up axis, in [`Metadata::up`](mocap_scene::scene::Metadata::up), so that nothing is
    /// guessed.
    pub up_is_stated: bool,
    /// The intended frames per second, if the frame time is rounded. Absent if the frame time is exact, or not near a
    /// usual rate.
    pub frame_rate: Option<Guess<f64>>,
    /// Whether the first frame is a rest pose, and the motion jumps after it.
    pub first_frame_is_rest_pose: bool,
}

/// The axis of [`Figure::up`], without its confidence and its reason.
#[doc(hidden)]
pub fn up(scene: &Scene) -> Axis {
    if let Some(up) = scene.metadata.up {
        return Axis::from(up);
    }
    let humanoid = Humanoid::of(scene);
    let body = measure::Measures::new(scene, &humanoid).up();
    let animal = || animal::up(scene, quadruped_of(scene, &humanoid).as_ref()?);
    let of_body = body.or_else(animal).map(|up| up.value);
    let extent = || extent::Extent::new(scene, &placing::placing(scene, &humanoid));
    of_body.unwrap_or_else(|| Axis::from(extent().up().value))
}

/// The assumptions about everything that the file of `scene` does not state. These are the assumptions of the reader,
/// the use of the root's OFFSET, and the guesses of [`Figure::assumptions`].
#[doc(hidden)]
pub fn assumptions(scene: &Scene) -> Vec<Assumption> {
    let mut assumptions = scene.metadata.assumptions.clone();
    if let Some(used) = &scene.metadata.root_offset {
        let choice = match used.policy {
            RootOffset::Add => "add",
            RootOffset::Auto | RootOffset::Replace => "replace",
        };
        assumptions.push(Assumption {
            topic: Topic::RootOffset,
            choice: choice.to_owned(),
            reason: used.reason.clone(),
            confidence: Some(used.confidence),
        });
    }
    assumptions.extend(Figure::new(scene).assumptions());
    assumptions
}

/// The body in a scene, with all known and guessed facts about it. A figure is computed once for a scene, and then
/// shared.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::figure::{Axis, Figure, HumanoidBone};
/// use mocap::figure::report::RestPose;
///
/// let scene = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
/// let figure = Figure::new(&scene);
/// assert_eq!((figure.up.value, figure.facing.value), (Axis::Y, Axis::Z));
/// assert_eq!(figure.rest_pose.value, RestPose::TPose);
/// assert!(figure.humanoid.joint(HumanoidBone::LeftHand).is_some());
/// assert!(figure.t_pose(&scene).unwrap().largest_rotation() < 40.0);
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct Figure {
    /// Guesses of values that the file does not state.
    pub survey: Survey,
    /// The up axis of the motion's world, with its sign.
    pub up: Guess<Axis>,
    /// The facing of the figure in the rest pose.
    pub facing: Guess<Axis>,
    /// The kind of the rest pose.
    pub rest_pose: Guess<RestPose>,
    /// The largest relative difference between the lengths of a left and a right bone. The reason names the bones.
    pub asymmetry: Option<Guess<f64>>,
    /// The joint of each bone.
    pub humanoid: Humanoid,
    /// The T-pose, computed on first use, because it examines a few hundred frames.
    #[serde(skip)]
    t_pose: OnceLock<Option<TPose>>,
    /// The ground, computed on first use, because it also examines a few hundred frames.
    #[serde(skip)]
    ground: OnceLock<Option<Ground>>,
    /// The animal, computed on first use.
    #[serde(skip)]
    quadruped: OnceLock<Option<Quadruped>>,
}

impl PartialEq for Figure {
    /// Compares all fields that are computed at once. T-pose, ground and animal follow from these fields and the scene.
    fn eq(&self, other: &Self) -> bool {
        self.survey == other.survey
            && self.up == other.up
            && self.facing == other.facing
            && self.rest_pose == other.rest_pose
            && self.asymmetry == other.asymmetry
            && self.humanoid == other.humanoid
    }
}

impl Figure {
    /// Finds the figure of `scene`.
    pub fn new(scene: &Scene) -> Self {
        Self::with_bones(scene, Humanoid::of(scene))
    }

    /// Finds the figure of `scene` with some known bones.
    ///
    /// # Errors
    /// [`Code::InvalidValue`](mocap_scene::Code::InvalidValue) if a name of the map is not the name of a joint.
    pub fn mapped(scene: &Scene, map: &HumanoidMap) -> Result<Self> {
        let humanoid = Humanoid::of(scene).with_map(scene, map.clone())?;
        Ok(Self::with_bones(scene, humanoid))
    }

    /// The T-pose of the figure; `None` if it is not a humanoid. `scene` must be the scene of the figure.
    pub fn t_pose(&self, scene: &Scene) -> Option<&TPose> {
        self.t_pose.get_or_init(|| TPose::new(scene, self)).as_ref()
    }

    /// The parts of an animal on four legs; `None` if it is not one. `scene` must be the scene of the figure.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::figure::Figure;
    ///
    /// let scene = mocap::import("fixtures/made/dog_walk.bvh")?;
    /// let figure = Figure::new(&scene);
    /// let dog = figure.quadruped(&scene).expect("an animal on four legs");
    /// assert!(dog.legs[0].is_fore && !dog.legs[2].is_fore);
    /// # Ok::<(), mocap::Error>(())
    /// ```
    pub fn quadruped(&self, scene: &Scene) -> Option<&Quadruped> {
        let find = || quadruped_of(scene, &self.humanoid);
        self.quadruped.get_or_init(find).as_ref()
    }

    /// The height of the ground along the up axis, in units of the file: the height of the soles in contact, or 0 if
    /// the soles are near 0. Contacts, pictures and retargeting use this height. `None` if the figure is not a
    /// humanoid, or without a motion. `scene` must be the scene of the figure.
    pub fn ground(&self, scene: &Scene) -> Option<Guess<f64>> {
        Some(self.ground_of(scene)?.guess())
    }

    /// The ground, with the resting levels of the feet.
    #[doc(hidden)]
    pub fn ground_of(&self, scene: &Scene) -> Option<&Ground> {
        let find = || Ground::new(scene, &self.humanoid, self.up_direction(), self.metres());
        self.ground.get_or_init(find).as_ref()
    }

    /// The up direction in the motion's world.
    #[doc(hidden)]
    pub fn up_direction(&self) -> Vec3 {
        self.up.value.direction().unwrap_or(Vec3::Y)
    }

    /// For each node, whether it only places the figure, such as a root on the floor whose child is the hips. The line
    /// from such a node to the next joint is not a bone. `scene` must be the scene of the figure.
    #[doc(hidden)]
    pub fn placing(&self, scene: &Scene) -> Vec<bool> {
        placing::placing(scene, &self.humanoid)
    }

    /// Metres per unit of the scene.
    #[doc(hidden)]
    pub fn metres(&self) -> f32 {
        self.survey.metres_per_unit as f32
    }

    /// The rotation from left (+X), up (+Y) and forward (+Z) of a standing figure to the motion's world.
    #[doc(hidden)]
    pub fn figure_to_world(&self) -> Mat3 {
        let up = self.up_direction();
        let usual = match self.up.value {
            Axis::Z | Axis::NegZ => Vec3::NEG_Y,
            _ => Vec3::Z,
        };
        let facing = self.facing.value.direction();
        let forward = facing.filter(|facing| facing.dot(up).abs() < 0.5).unwrap_or(usual);
        Mat3::from_cols(up.cross(forward), up, forward)
    }

    /// Finds the figure of `scene` with known bones.
    pub fn with_bones(scene: &Scene, humanoid: Humanoid) -> Self {
        let body = measure::Measures::new(scene, &humanoid);
        let extents = std::cell::OnceCell::new();
        let figure = || extents.get_or_init(|| extent::Extent::new(scene, &placing::placing(scene, &humanoid)));
        let stated_axis = scene.metadata.up.map(|up| Guess {
            value: Axis::from(up),
            ..stated(up).map(Axis::Y)
        });
        let quadruped = OnceLock::new();
        let animal = || quadruped.get_or_init(|| quadruped_of(scene, &humanoid)).as_ref();
        let axis = stated_axis.or_else(|| body.up());
        let axis = axis.or_else(|| animal::up(scene, animal()?));
        let up = match (&axis, scene.metadata.up) {
            (_, Some(up)) => stated(up),
            (Some(axis), None) => axis.clone().map(axis.value.up().unwrap_or_default()),
            (None, None) => figure().up(),
        };
        let axis = axis.unwrap_or_else(|| up.clone().map(Axis::from(up.value)));
        let facing = body.facing();
        let rest_pose = body.rest_pose(axis.value);
        let asymmetry = body.asymmetry();
        let unit = body.unit().unwrap_or_else(|| figure().unit());
        let survey = Survey {
            metres_per_unit: scene.metadata.metres_per_unit.unwrap_or(unit.value.metres()),
            unit,
            unit_is_stated: scene.metadata.metres_per_unit.is_some(),
            up,
            up_is_stated: scene.metadata.up.is_some(),
            frame_rate: scene
                .animations
                .first()
                .and_then(|animation| frame_rate(animation.ticks_per_second)),
            first_frame_is_rest_pose: first_frame_is_rest_pose(scene, 0),
        };
        Self {
            survey,
            up: axis,
            facing,
            rest_pose,
            asymmetry,
            humanoid,
            t_pose: OnceLock::new(),
            ground: OnceLock::new(),
            quadruped,
        }
    }
}

impl Figure {
    /// The guesses of the survey and about the figure, in the form of
    /// [`Metadata::assumptions`](mocap_scene::scene::Metadata::assumptions).
    pub fn assumptions(&self) -> Vec<Assumption> {
        let mut all = self.survey.assumptions();
        all.extend(self.assumptions_of_figure());
        all
    }

    /// The guesses about the figure: whether it is a humanoid, and for a humanoid its facing, its rest pose and its
    /// sides.
    pub fn assumptions_of_figure(&self) -> Vec<Assumption> {
        let mut all = Vec::new();
        let mut add = |topic, choice: &str, confidence: Confidence, reason: &str| {
            all.push(Assumption {
                topic,
                choice: choice.to_owned(),
                reason: reason.to_owned(),
                confidence: Some(confidence),
            });
        };
        let humanoid = &self.humanoid;
        let found = if humanoid.found { "yes" } else { "no" };
        let confidences = humanoid.bones.values().map(|joint| joint.confidence);
        let least = confidences.max_by_key(|confidence| *confidence as u8);
        add(
            Topic::Humanoid,
            found,
            least.unwrap_or(Confidence::Likely),
            &humanoid.reason,
        );
        if humanoid.found {
            let (facing, pose) = (&self.facing, &self.rest_pose);
            add(Topic::Facing, facing.value.as_str(), facing.confidence, &facing.reason);
            add(Topic::RestPose, pose.value.as_str(), pose.confidence, &pose.reason);
            let (sides, confidence) = (humanoid.sides.as_str(), humanoid.sides_confidence);
            add(Topic::Sides, sides, confidence, &humanoid.sides_reason);
        }
        all
    }
}

/// A value that the scene states.
fn stated(up: UpAxis) -> Guess<UpAxis> {
    Guess {
        value: up,
        confidence: Confidence::Sure,
        reason: "the file states this axis, or the reader rotated the scene to this axis".to_owned(),
    }
}

impl Survey {
    /// The unit of the file, stated or guessed.
    #[doc(hidden)]
    pub fn unit_of_file(&self) -> Assumption {
        let stated = || Assumption {
            reason: "the file states it".to_owned(),
            confidence: Some(Confidence::Sure),
            ..Assumption::new(Topic::Unit, Unit::of_metres(self.metres_per_unit).choice())
        };
        self.assumption(Topic::Unit).unwrap_or_else(stated)
    }

    /// The guess about `topic`; `None` if there is no such guess.
    pub fn assumption(&self, topic: Topic) -> Option<Assumption> {
        let mut assumptions = self.assumptions().into_iter();
        assumptions.find(|assumption| assumption.topic == topic)
    }

    /// The guesses in the form of [`Metadata::assumptions`](mocap_scene::scene::Metadata::assumptions).
    pub fn assumptions(&self) -> Vec<Assumption> {
        let assumption = |topic, choice: String, reason: &str, confidence| Assumption {
            topic,
            choice,
            reason: reason.to_owned(),
            confidence: Some(confidence),
        };
        let up = self.up.value.as_str();
        let mut all = Vec::new();
        if !self.unit_is_stated {
            let guess = &self.unit;
            all.push(assumption(
                Topic::Unit,
                guess.value.choice(),
                &guess.reason,
                guess.confidence,
            ));
        }
        if !self.up_is_stated {
            all.push(assumption(
                Topic::Up,
                up.to_owned(),
                &self.up.reason,
                self.up.confidence,
            ));
        }
        if let Some(rate) = &self.frame_rate {
            all.push(assumption(
                Topic::FrameRate,
                rate.value.to_string(),
                &rate.reason,
                rate.confidence,
            ));
        }
        if self.first_frame_is_rest_pose {
            let reason = "nearly all rotations of the frame are zero, and the motion jumps after the frame";
            let choice = "rest-pose".to_owned();
            all.push(assumption(Topic::FirstFrame, choice, reason, Confidence::Likely));
        }
        all
    }
}

#[cfg(debug_assertions)]
#[doc(hidden)]
pub mod found;
