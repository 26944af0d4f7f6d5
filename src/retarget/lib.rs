//! Retargets motions to characters, skeletons and robots.
//!
//! A [`Retargeter`] takes whole files. It does these steps:
//!
//! - Convert the source to metres with +Y up, and find its bones.
//! - Determine the T-pose. If the first frame is a rest pose, use it for the T-pose, and then drop it.
//! - Retarget each motion, and lock feet to the ground if the result is better.
//! - Give every clip its own name, its provenance and a report.
//!
//! `docs/retargeting-algorithm.md` and `docs/robots-algorithm.md` have the algorithms.
//!
//! ```
//! # std::env::set_current_dir("../..").unwrap();
//! use mocap::Importer;
//! use mocap::retarget::{RetargetOptions, Retargeter};
//!
//! let walk = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
//! let hero = Importer::new().gltf_meshes(true).import_character("fixtures/skeletons/human_vrm1.gltf")?;
//! let retargeter = Retargeter::new(walk, hero, RetargetOptions::new())?;
//! for clip in retargeter.clips() {
//!     println!("{}: {:.2} degrees", clip.animation.name, clip.report.mean_degrees());
//! }
//! let file: Vec<u8> = retargeter.character_file()?.unwrap().into_bytes()?; // the character, and the clips
//! # let _ = file;
//! # Ok::<(), mocap::Error>(())
//! ```
//!
//! A [`PoseRetargeter`] retargets single poses, for engines. [`robot`] retargets to robots.
//!
//! Every mapped bone of both skeletons gets a coordinate frame that is the identity in the T-pose: left is +X, up is
//! +Y, forward is +Z. In these coordinate frames, a pose has the same rotations on every body. So each bone of the
//! target gets the rotation of the source's bone. VRM describes this transfer for its animations, with rotations in the
//! world (vrm-c, vrm-specification, `VRMC_vrm_animation-1.0/how_to_transform_human_pose.md`). The hips move along the
//! path of the source, scaled by the length of the legs.
//!
//! ```
//! # std::env::set_current_dir("../..").unwrap();
//! use mocap::retarget::{PoseRetargetOptions, PoseRetargeter};
//!
//! let source = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
//! let mut target = mocap::import("fixtures/skeletons/human_vrm1.gltf")?;
//! let mut retargeter = PoseRetargeter::new(&source, &target, &PoseRetargetOptions::default())?;
//! target.animations = vec![retargeter.animation(&source, &source.animations[0])];
//! # Ok::<(), mocap::Error>(())
//! ```

// Tests may unwrap and print; the library may not.
#![warn(clippy::unwrap_used, clippy::print_stdout, clippy::print_stderr)]

mod above_floor;
mod animal;
mod by_names;
mod clip;
mod feet;
pub(crate) mod files;
mod hand_report;
mod hands;
#[doc(hidden)]
pub mod internals;
mod limb_angles;
#[cfg(feature = "live")]
pub mod live;
mod measure;
mod plan;
mod quality;
pub mod report;
pub mod robot;
mod root;
mod rules;
mod scale_text;
mod sight;
mod skin;
mod skin_report;
mod solve;
mod trunk;

use std::borrow::Cow;

use glam::{Quat, Vec3};
use mocap_edit::report::DetectedContacts;
use mocap_edit::report::FootLockReport;
use mocap_edit::{FootLockWeights, contacts_of, follow_feet};
use mocap_figure::body::Body;
use mocap_figure::ground;
use mocap_figure::rig::Rig;
use mocap_figure::ticks::ticks;
use mocap_figure::{Figure, Humanoid, HumanoidBone};
use mocap_scene::error::{Code, Diagnostic, Error, Result};
use mocap_scene::options::setters;
use mocap_scene::pose::{Binding, Pose};
use mocap_scene::scene::report::{AppliedStep, SecondMotion};
use mocap_scene::scene::{Animation, NodeId, Scene};

use self::above_floor::Surface;
pub(crate) use self::by_names::CreatureRetargeter;
pub use self::files::{RetargetOptions, Retargeter, Target};
#[doc(hidden)]
pub use self::files::{SourceMotion, apply_steps, apply_steps_with_bones, second_motion, whole};
use self::hands::Arm;
use self::measure::Moving;
use self::plan::Plan;
use self::plan::UnmappedBone;
use self::quality::RetargetReport;
use self::root::Root;
use self::solve::Solved;

/// The scale of the target's root motion.
///
/// [`PoseRetargeter`] has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Scale {
    /// The ratio of the leg lengths.
    #[default]
    Auto,
    /// No scale: the steps have the same length in metres as in the source.
    None,
    /// A factor of the steps of the source, in metres per metre of the source.
    Factor(f64),
}

/// The options of a [`PoseRetargeter`].
///
/// [`PoseRetargeter`] has an example.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct PoseRetargetOptions {
    /// The scale of the target's root motion.
    pub scale: Scale,
    /// The joint of each bone of the source. Default: [`Humanoid::of`](mocap_figure::Humanoid::of) finds the bones.
    pub source: Option<Humanoid>,
    /// The joint of each bone of the target. Default: [`Humanoid::of`](mocap_figure::Humanoid::of) finds the bones.
    pub target: Option<Humanoid>,
    /// The weights of [`PoseRetargeter::lock_feet`].
    pub foot_lock: FootLockWeights,
    /// Whether [`PoseRetargeter::clip`] keeps the directions of arms, even if the hands then miss their contacts.
    /// Default: `false`; the hands touch the parts that the source's hands touch.
    pub free_hands: bool,
}

setters! {
    PoseRetargetOptions {
        scale: Scale,
        source: Option<Humanoid>,
        target: Option<Humanoid>,
        foot_lock: FootLockWeights,
        free_hands: bool,
    }
}

/// Retargets poses from one skeleton to another.
///
/// Everything that does not depend on the pose is computed once, by [`new`](Self::new). A pose then needs neither a
/// look-up nor an allocation:
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::retarget::{PoseRetargetOptions, PoseRetargeter};
/// use mocap::{Binding, Pose};
///
/// let source = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
/// let target = mocap::import("fixtures/skeletons/human_default.gltf")?;
/// let mut retargeter = PoseRetargeter::new(&source, &target, &PoseRetargetOptions::default())?;
///
/// let binding = Binding::new(&source, &source.animations[0]);
/// let (mut from, mut to) = (Pose::rest(&source), Pose::rest(&target));
/// for tick in 0..10 {
///     from.sample(&binding, &source.animations[0], f64::from(tick));
///     retargeter.pose(&from, &mut to);
/// }
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct PoseRetargeter {
    source: Body,
    target: Body,
    plan: Plan,
    root: Root,
    foot_lock: FootLockWeights,
    free_hands: bool,
    /// The values computed for the current pose.
    solved: Solved<1>,
    /// The rig and its pose, if joints of the target follow joints other than their parents. All other fields refer to
    /// the scene of the rig.
    rig: Option<Box<(Rig, Pose)>>,
}

impl PoseRetargeter {
    /// Prepares to retarget motions of the skeleton of `source` to the skeleton of `target`. The animations of `source`
    /// show the height of its floor. Both scenes may have any unit, axes and rest pose.
    ///
    /// # Errors
    /// [`Code::NotHumanoid`] if one of the skeletons is not a humanoid, or its hierarchy cannot be posed.
    pub fn new(source: &Scene, target: &Scene, options: &PoseRetargetOptions) -> Result<Self> {
        let figure = |scene: &Scene, bones: &Option<Humanoid>| {
            let bones = bones.clone().unwrap_or_else(|| Humanoid::of(scene));
            Figure::with_bones(scene, bones)
        };
        let figures = (figure(source, &options.source), figure(target, &options.target));
        let retargeter = Self::with_figures((source, figures.0), (target, figures.1), options.scale)?;
        let retargeter = retargeter.with_foot_lock(options.foot_lock);
        Ok(retargeter.with_free_hands(options.free_hands))
    }

    /// This retargeter with or without hand contacts.
    pub(crate) fn with_free_hands(mut self, free_hands: bool) -> Self {
        self.free_hands = free_hands;
        self
    }

    /// This retargeter with other weights of [`lock_feet`](Self::lock_feet).
    pub(crate) fn with_foot_lock(mut self, weights: FootLockWeights) -> Self {
        self.foot_lock = weights;
        self
    }

    /// Like [`Self::new`] for two known figures.
    ///
    /// # Errors
    /// The errors of [`Self::new`].
    pub(crate) fn with_figures(
        (source, from): (&Scene, Figure),
        (target, to): (&Scene, Figure),
        scale: Scale,
    ) -> Result<Self> {
        let from = Body::of_figure(source, from, "source")?;
        let rig = Rig::new(target, &to.humanoid.follow);
        let (target, to) = match &rig {
            Some(rig) => (&rig.scene, Figure::with_bones(&rig.scene, to.humanoid.in_rig(rig))),
            None => (target, to),
        };
        let to = Body::target(target, to)?;
        let mut plan = Plan::new(&from, &to, target);
        let root = Root::new((&from, source), (&to, target), scale, &mut plan.watched)?;
        Ok(Self {
            solved: Solved::new(&plan, plan.watched.joints.len()),
            source: from,
            target: to,
            plan,
            root,
            foot_lock: FootLockWeights::default(),
            free_hands: false,
            rig: rig.map(|rig| {
                let pose = Pose::rest(&rig.scene);
                Box::new((rig, pose))
            }),
        })
    }

    /// The bones that only one of the skeletons has, and other bones that are not retargeted, each with the reason.
    pub fn unmapped(&self) -> &[UnmappedBone] {
        &self.plan.unmapped
    }

    /// The number of bones that move in an animation of the source and are missing on the target.
    pub(crate) fn lost_bones(&self, source: &Scene, animation: &Animation) -> u64 {
        let is_lost =
            |bone| self.target.joint(bone).is_none() && self.plan.unmapped.iter().any(|lack| lack.bone == bone);
        let joints = HumanoidBone::ALL.iter().filter(|bone| is_lost(**bone));
        let joints: Vec<NodeId> = joints.filter_map(|bone| self.source.joint(*bone)).collect();
        let moves = |channel: usize| animation.channels[channel].moves();
        let binding = Binding::new(source, animation);
        let lost = binding
            .driven()
            .filter(|(node, channel)| joints.contains(node) && moves(*channel));
        lost.count() as u64
    }

    /// The scale of the target's root motion, in the units of the two scenes.
    pub fn scale(&self) -> f64 {
        f64::from(self.root.scale)
    }

    /// The retargeting step for the record of a file. `target` is the scene of the target.
    pub fn step(&self, target: &Scene, lock_feet: bool) -> AppliedStep {
        AppliedStep::Retarget {
            onto: SecondMotion::of(target),
            scale: self.scale() * self.target.metres_per_unit / self.source.metres_per_unit,
            lock_feet,
        }
    }

    /// The joints of the target that are retargeted, parents first. The first joint is the hips, which also have the
    /// root motion.
    pub fn driven(&self) -> impl Iterator<Item = NodeId> {
        let rig = self.rig.as_deref().map(|(rig, _)| rig);
        let drives = self.plan.drives.iter().map(|drive| drive.node);
        let drives = drives.map(move |node| rig.map_or(node, |rig| rig.node_of_file(node)));
        let followers = rig.into_iter().flat_map(Rig::followers).map(|(node, _)| node);
        let is_drive = move |node: &NodeId| {
            let in_rig = rig.map_or(*node, |rig| rig.node(*node));
            self.plan.drives.iter().any(|drive| drive.node == in_rig)
        };
        drives.chain(followers.filter(move |node| !is_drive(node)))
    }

    /// Applies a pose of the source to the target. `target` is a pose of the target's scene, at first its rest pose.
    /// Joints without a counterpart do not change.
    pub fn pose(&mut self, source: &Pose, target: &mut Pose) {
        self.solved.seen.set(0, source, &self.source, &self.plan.watched);
        self.solved.solve(&self.plan, &self.root);
        match self.rig.take() {
            Some(mut rig) => {
                let (skeleton, pose) = &mut *rig;
                skeleton.take_pose(target, pose);
                self.set_pose(pose);
                skeleton.give_pose(pose, target);
                self.rig = Some(rig);
            }
            None => self.set_pose(target),
        }
    }

    /// Sets the retargeted joints to the computed pose.
    fn set_pose(&self, target: &mut Pose) {
        for (drive, rotation) in self.plan.drives.iter().zip(&self.solved.to_parent) {
            let Some(matrix) = target.node_to_parent.get_mut(drive.node.index()) else {
                continue;
            };
            let mut trs = drive.rest;
            trs.rotation = Quat::from_array(rotation.lane(0));
            if drive.node == self.target.hips {
                trs.translation = Vec3::from_array(self.solved.hips.lane(0));
            }
            *matrix = trs.matrix();
        }
        target.update_world();
    }

    /// Retargets an animation of `source`, the scene from which the retargeter was made: a key at every tick. Joints
    /// that are not retargeted have no channel.
    pub fn animation(&mut self, source: &Scene, animation: &Animation) -> Animation {
        self.in_file(self.animation_in_rig(source, animation))
    }

    /// Like [`Self::animation`], in the scene of [`Self::skeleton`].
    fn animation_in_rig(&self, source: &Scene, animation: &Animation) -> Animation {
        clip::animation((&self.source, source), &self.target, &self.plan, &self.root, animation)
    }

    /// The scene of the target's figure: `target`, or a scene in which joints are children of the joints that they
    /// follow.
    fn skeleton<'a>(&'a self, target: &'a Scene) -> &'a Scene {
        self.rig.as_deref().map_or(target, |(rig, _)| &rig.scene)
    }

    /// An animation of `target` in the scene of [`Self::skeleton`].
    fn in_rig<'a>(&self, target: &Scene, moved: &'a Animation) -> Cow<'a, Animation> {
        match self.rig.as_deref() {
            Some((rig, _)) => Cow::Owned(rig.in_rig(target, moved)),
            None => Cow::Borrowed(moved),
        }
    }

    /// Converts an animation from the scene of [`Self::skeleton`] to the target.
    fn in_file(&self, moved: Animation) -> Animation {
        match self.rig.as_deref() {
            Some((rig, _)) => rig.in_file(&moved),
            None => moved,
        }
    }

    /// Locks the feet of `moved`, an animation of the scene `target`, while the feet of the source are in contact.
    /// Locked feet keep their height above the floor. Contacts are found in the source. The legs follow as in
    /// [`foot_lock`](mocap_edit::foot_lock()). `animation` is the index of the source's animation.
    ///
    /// On other proportions, the feet of the target slide where the source's feet do not, although each limb has the
    /// direction of the source's limb. [`RetargetReport::slides`] tells whether they slide.
    ///
    /// # Errors
    /// The errors of [`foot_lock`](mocap_edit::foot_lock()). After an error, `moved` is unchanged.
    pub fn lock_feet(
        &self,
        source: &Scene,
        animation: usize,
        target: &Scene,
        moved: &mut Animation,
    ) -> Result<FootLockReport> {
        let mut locked = self.in_rig(target, moved).into_owned();
        let report = self.lock_in_rig(source, animation, self.skeleton(target), &mut locked)?;
        *moved = self.in_file(locked);
        Ok(report)
    }

    /// Like [`Self::lock_feet`], in the scene of [`Self::skeleton`].
    fn lock_in_rig(
        &self,
        source: &Scene,
        animation: usize,
        target: &Scene,
        moved: &mut Animation,
    ) -> Result<FootLockReport> {
        let Some(motion) = source.animations.get(animation) else {
            return Err(no_animation(animation, source));
        };
        let contacts = self.contacts(source, motion)?;
        let Some(followed) = feet::followed(
            &self.source,
            &self.target,
            target,
            &self.root,
            &contacts,
            self.foot_lock,
        ) else {
            return Ok(FootLockReport::default());
        };
        let mut scene = Scene {
            nodes: target.nodes.clone(),
            animations: vec![std::mem::take(moved)],
            metadata: target.metadata.clone(),
            ..Scene::default()
        };
        // The motion is unchanged after an error.
        let report = follow_feet(&mut scene, 0, &self.target.figure, &followed);
        if let Some(locked) = scene.animations.pop() {
            *moved = locked;
        }
        report
    }

    /// The height of the source's floor above the origin of its file, scaled to the target.
    pub(crate) fn source_floor(&self) -> f64 {
        let floor = self.root.source_ankle - ground::ankle(&self.source);
        f64::from(self.root.height_scale * floor)
    }

    /// The figure of the source.
    pub(crate) fn source_figure(&self) -> &Figure {
        &self.source.figure
    }

    /// The contacts of an animation of `source`, for the left and right foot of the body.
    pub(crate) fn contacts(&self, source: &Scene, animation: &Animation) -> Result<DetectedContacts> {
        contacts_of(source, animation, &self.source.figure)
    }

    /// Retargets an animation of `source`, by its index, to the skeleton of `target`, and reports its quality. With
    /// `lock_feet`, feet are locked as in [`lock_feet`](Self::lock_feet), unless they move like the source's feet or
    /// the result is not better. The skin is raised above the floor. Hands keep the contacts of the source's hands,
    /// unless [`free_hands`](PoseRetargetOptions::free_hands) is set.
    ///
    /// # Errors
    /// The errors of [`lock_feet`](Self::lock_feet), and [`Code::NoMotion`] if there is no such animation.
    pub fn clip(
        &mut self,
        source: &Scene,
        index: usize,
        target: &Scene,
        lock_feet: bool,
    ) -> Result<(Animation, RetargetReport)> {
        let Some(animation) = source.animations.get(index) else {
            return Err(no_animation(index, source));
        };
        let target = self.skeleton(target);
        let mut moved = self.animation_in_rig(source, animation);
        let (from, to) = self.moving(source, animation, target, &moved);
        let floor = Surface::new(&to, self.root.target_ankle).filter(|_| lock_feet);
        let floor = floor.map(|surface| (surface, above_floor::allowed(&from, &self.root)));
        let raise = |moved: &mut Animation| {
            let (surface, allowed) = floor.as_ref()?;
            let (_, to) = self.moving(source, animation, target, moved);
            let raises = above_floor::raises_of_body(&to, surface, allowed)?;
            above_floor::raise_body(&self.target, moved, &raises, &self.root);
            Some(())
        };
        raise(&mut moved);
        let mut report = self.measure_in_rig(source, animation, target, &moved);
        let mut lock = None;
        if lock_feet && report.feet.is_some() && !report.feet_move_alike() {
            let free = feet::FreeLegs::new(&self.target, target, &moved);
            let found = self.lock_in_rig(source, index, target, &mut moved)?;
            let after = self.measure_in_rig(source, animation, target, &moved).with_lock(&found);
            match after.is_better_locked_than(&report) {
                true => (report, lock) = (after, Some(found)),
                false => free.give_back(&mut moved),
            }
        }
        let mut is_changed = false;
        let (from, to) = self.moving(source, animation, target, &moved);
        let kept = (!self.free_hands)
            .then(|| hands::keep(&from, &to, &self.root))
            .flatten();
        let hands = kept.map(|(kept, hands)| {
            is_changed = true;
            hands::set_rotations(&self.target, &mut moved, kept);
            hands
        });
        if let Some((surface, allowed)) = &floor {
            let (_, to) = self.moving(source, animation, target, &moved);
            let may_raise = |limb: &Arm| !(self.free_hands && limb.is_arm);
            let raised = above_floor::raise_ends(&to, surface, allowed, may_raise);
            is_changed |= !raised.is_empty();
            hands::set_rotations(&self.target, &mut moved, raised);
            // A raised foot may lower its knee.
            is_changed |= raise(&mut moved).is_some();
        }
        if is_changed {
            let mut after = self.measure_in_rig(source, animation, target, &moved);
            if let Some(lock) = &lock {
                after = after.with_lock(lock);
            }
            if let Some(hands) = hands {
                after.keep_hands(hands, &report);
            }
            report = after;
        }
        Ok((self.in_file(moved), report))
    }

    /// Measures how well `moved`, an animation of the scene `target`, follows `animation` of the scene `source`. Both
    /// are posed frame by frame. The report has the directions of arms and legs, and the contacts of the feet.
    pub fn measure(&self, source: &Scene, animation: &Animation, target: &Scene, moved: &Animation) -> RetargetReport {
        self.measure_in_rig(source, animation, self.skeleton(target), &self.in_rig(target, moved))
    }

    /// Like [`Self::measure`], in the scene of [`Self::skeleton`].
    fn measure_in_rig(
        &self,
        source: &Scene,
        animation: &Animation,
        target: &Scene,
        moved: &Animation,
    ) -> RetargetReport {
        let (from, to) = self.moving(source, animation, target, moved);
        let metres = self.target.metres_per_unit / self.source.metres_per_unit;
        let mut report = measure::measure(
            &from,
            &to,
            &ticks(animation),
            self.scale() * metres,
            &self.root,
            &self.plan.unmapped,
        );
        if let Some((rig, _)) = self.rig.as_deref() {
            let name = |node: NodeId| self.target.names[rig.node(node).index()].clone();
            report.followers = rig
                .followers()
                .map(|(joint, other)| (name(joint), name(other)))
                .collect();
        }
        report
    }

    /// Both bodies with their motions.
    fn moving<'a>(
        &'a self,
        source: &'a Scene,
        animation: &'a Animation,
        target: &'a Scene,
        moved: &'a Animation,
    ) -> (Moving<'a>, Moving<'a>) {
        let moving = |body, scene, animation| Moving { body, scene, animation };
        (
            moving(&self.source, source, animation),
            moving(&self.target, target, moved),
        )
    }
}

fn no_animation(index: usize, source: &Scene) -> Error {
    let message = format!(
        "there is no animation {index}: the source has {}",
        source.animations.len()
    );
    Diagnostic::new(Code::NoMotion, message).into()
}

/// Checks whether a motion can be retargeted to the figure of `target`, as in [`PoseRetargeter::new`].
///
/// # Errors
/// [`Code::NotHumanoid`] if the skeleton is not a humanoid, or its hierarchy cannot be posed.
pub(crate) fn check_figure(target: &Scene, figure: &Figure) -> Result<()> {
    if let Some(rig) = Rig::new(target, &figure.humanoid.follow) {
        let humanoid = figure.humanoid.clone().in_rig(&rig);
        return Body::target(&rig.scene, Figure::with_bones(&rig.scene, humanoid)).map(|_| ());
    }
    // The T-pose is computed here, so that every clone of the figure has it.
    figure.t_pose(target);
    Body::target(target, figure.clone()).map(|_| ())
}
