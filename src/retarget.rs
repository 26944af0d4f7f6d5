//! Moves the motion of one humanoid onto the skeleton of another.
//!
//! Every mapped bone of both skeletons gets a frame that is the identity in the T-pose: left is +X, up is +Y, forward is
//! +Z. In these frames one pose is the same rotations on every body, so a rotation of the source is the target's, bone by
//! bone. This is the transfer that VRM describes for its animations, written for rotations in the world (vrm-c,
//! vrm-specification, `VRMC_vrm_animation-1.0/how_to_transform_human_pose.md`). The hips move by the path of the source,
//! scaled by the length of the legs. `docs/retargeting.md` has the formulas.
//!
//! ```
//! use mocap::retarget::{RetargetOptions, Retargeter};
//!
//! let source = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
//! let mut target = mocap::import("fixtures/skeletons/human_vrm1.gltf")?;
//! let mut retargeter = Retargeter::new(&source, &target, &RetargetOptions::default())?;
//! target.animations = vec![retargeter.animation(&source, &source.animations[0])];
//! # Ok::<(), mocap::Error>(())
//! ```

mod body;
mod feet;
mod ground;
mod level;
mod limb_angles;
mod measure;
mod plan;
mod root;
mod rotations;
mod skin;
mod vrm_humanoid;

use glam::Quat;

use self::body::Body;
pub use self::limb_angles::LimbAngles;
use self::measure::Moving;
pub use self::measure::{Clamped, FeetReport, FootMotion, LimbError, RetargetReport, Verdict};
pub use self::plan::Unmapped;
use self::plan::{Plan, Twisted};
use self::root::Root;
pub use self::vrm_humanoid::vrm_humanoid;
use crate::edit::{FootLockReport, contacts_of, follow_feet};
use crate::error::{Code, Diagnostic, Error, Result};
use crate::pose::{Binding, Pose};
use crate::scene::{Animation, Channel, Keys, NodeId, Scene};
use crate::skeleton::Humanoid;

/// How large the steps of the target are.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Scale {
    /// In the proportion of the legs.
    #[default]
    Auto,
    /// As long as those of the source, in metres.
    None,
    /// This many times as long as those of the source, in metres.
    Factor(f64),
}

/// How a [`Retargeter`] moves a motion.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RetargetOptions {
    /// How large the steps of the target are.
    pub scale: Scale,
    /// Which joints of the source are which bones. Default: [`humanoid`](crate::skeleton::humanoid()) finds them.
    pub source: Option<Humanoid>,
    /// Which joints of the target are which bones. Default: as for the source.
    pub target: Option<Humanoid>,
}

/// Moves poses of one skeleton onto another.
///
/// Everything that does not depend on the pose is computed when it is made. A pose then takes neither a look-up nor an
/// allocation:
///
/// ```
/// use mocap::retarget::{RetargetOptions, Retargeter};
/// use mocap::{Binding, Pose};
///
/// let source = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
/// let target = mocap::import("fixtures/skeletons/human_default.gltf")?;
/// let mut retargeter = Retargeter::new(&source, &target, &RetargetOptions::default())?;
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
pub struct Retargeter {
    source: Body,
    target: Body,
    plan: Plan,
    root: Root,
    /// The rotations of the source's joints in the frames of the T-pose, at the current pose.
    frames: Vec<Quat>,
    /// The twists that several joints share, at the current pose.
    twisted: Vec<Twisted>,
    /// The rotation of each target node to its parent, at the current pose.
    node_to_parent: Vec<Quat>,
    /// The same to the world.
    node_to_world: Vec<Quat>,
}

impl Retargeter {
    /// Prepares the motion of the skeleton of `source` onto that of `target`. The animations of `source` tell where its
    /// floor is; both scenes may have any unit, axes and rest pose.
    ///
    /// # Errors
    /// [`Code::NotHumanoid`] where one of the skeletons is not a humanoid, or has a hierarchy
    /// onto which no pose can be put.
    pub fn new(source: &Scene, target: &Scene, options: &RetargetOptions) -> Result<Self> {
        let from = Body::new(source, options.source.clone(), "source")?;
        let to = Body::target(target, options.target.as_ref())?;
        let plan = Plan::new(&from, &to, target);
        let root = Root::new(&from, &to, source, target, options.scale)?;
        Ok(Self {
            frames: vec![Quat::IDENTITY; plan.tracks.len()],
            twisted: plan.twisted(),
            node_to_parent: to.rest_rotations.clone(),
            node_to_world: vec![Quat::IDENTITY; target.nodes.len()],
            source: from,
            target: to,
            plan,
            root,
        })
    }

    /// Bones that only one of the skeletons has, and others that are not moved, each with the reason.
    pub fn unmapped(&self) -> &[Unmapped] {
        &self.plan.unmapped
    }

    /// How many times as long the steps of the target are, in the units of the two scenes.
    pub fn scale(&self) -> f64 {
        f64::from(self.root.scale)
    }

    /// The joints of the target that are moved, parents first. The first one is the hips, which are moved over the ground
    /// too.
    pub fn driven(&self) -> impl Iterator<Item = NodeId> {
        self.plan.drives.iter().map(|drive| drive.node)
    }

    /// Puts a pose of the source on the target. `target` is a pose of the target's scene, at first its rest pose; joints
    /// without a counterpart keep what they have.
    pub fn pose(&mut self, source: &Pose, target: &mut Pose) {
        let hips = self.solve(source);
        for drive in &self.plan.drives {
            let Some(matrix) = target.node_to_parent.get_mut(drive.node.index()) else {
                continue;
            };
            let mut trs = drive.rest;
            trs.rotation = self.node_to_parent[drive.node.index()];
            if drive.node == self.target.hips {
                trs.translation = hips;
            }
            *matrix = trs.matrix();
        }
        target.update_world();
    }

    /// The rotations of all target nodes for a pose of the source, and the translation of the hips to their parent.
    fn solve(&mut self, source: &Pose) -> glam::Vec3 {
        for (frame, track) in self.frames.iter_mut().zip(&self.plan.tracks) {
            *frame = track.frame(&self.source, source);
        }
        self.plan.twist(&self.frames, &mut self.twisted);
        let to_world = self.target.axes;
        let mut drives = self.plan.drives.iter().peekable();
        for index in 0..self.node_to_world.len() {
            let parent = self.target.parents[index].map_or(Quat::IDENTITY, |parent| self.node_to_world[parent]);
            if let Some(drive) = drives.next_if(|drive| drive.node.index() == index) {
                let rotation = to_world * drive.frame(&self.frames, &self.twisted) * drive.frame_to_joint;
                self.node_to_world[index] = rotation;
                self.node_to_parent[index] = (parent.inverse() * rotation).normalize();
            } else {
                self.node_to_world[index] = parent * self.node_to_parent[index];
            }
        }
        let hips_to_world = self.node_to_world[self.target.hips.index()];
        self.root.hips(source, hips_to_world)
    }

    /// A whole animation of `source`, the scene from which the retargeter was made, on the target: a key at every tick.
    /// Joints that are not moved have no channel.
    pub fn animation(&mut self, source: &Scene, animation: &Animation) -> Animation {
        let ticks = ticks(animation);
        let binding = Binding::new(source, animation);
        let mut pose = Pose::rest(source);
        let mut places = Vec::with_capacity(ticks.len());
        let mut rotations: Vec<Vec<Quat>> = vec![Vec::with_capacity(ticks.len()); self.plan.drives.len()];
        for &tick in &ticks {
            pose.sample(&binding, animation, tick);
            places.push(self.solve(&pose));
            for (keys, drive) in rotations.iter_mut().zip(&self.plan.drives) {
                let rotation = self.node_to_parent[drive.node.index()];
                // On the shorter arc from the key before.
                let turned_away = keys.last().is_some_and(|last| last.dot(rotation) < 0.0);
                keys.push(if turned_away { -rotation } else { rotation });
            }
        }
        let channels = std::iter::zip(rotations, &self.plan.drives).map(|(values, drive)| Channel {
            node_name: self.target.names[drive.node.index()].clone(),
            node: Some(drive.node),
            position_keys: match drive.node == self.target.hips {
                true => keys(std::mem::take(&mut places), &ticks),
                false => Keys::constant(drive.rest.translation),
            },
            rotation_keys: keys(values, &ticks),
            scaling_keys: Keys::constant(drive.rest.scale),
        });
        Animation {
            name: animation.name.clone(),
            ticks_per_second: animation.ticks_per_second,
            duration: animation.duration,
            channels: channels.collect(),
        }
    }

    /// Holds the feet of `moved`, an animation of the scene `target`, still while those of the source stand, and as high
    /// above the floor as they are: contacts are found in the source, and the legs follow as in
    /// [`foot_lock`](crate::edit::foot_lock()). `animation` is the index of the source's animation.
    ///
    /// A target with other proportions slides where the source does not, although each of its limbs points where that of
    /// the source points. [`RetargetReport::slides`] says whether it does.
    ///
    /// # Errors
    /// As [`foot_lock`](crate::edit::foot_lock()); `moved` is then unchanged.
    pub fn lock_feet(
        &self,
        source: &Scene,
        animation: usize,
        target: &Scene,
        moved: &mut Animation,
    ) -> Result<FootLockReport> {
        let Some(motion) = source.animations.get(animation) else {
            return Err(no_animation(animation, source));
        };
        let contacts = contacts_of(source, motion, &self.source.humanoid)?;
        let Some(followed) = feet::followed(&self.source, &self.target, target, &self.root, &contacts) else {
            return Ok(FootLockReport::default());
        };
        let mut scene = Scene {
            nodes: target.nodes.clone(),
            animations: vec![moved.clone()],
            metadata: target.metadata.clone(),
            ..Scene::default()
        };
        let report = follow_feet(&mut scene, 0, &self.target.humanoid, &followed)?;
        if let Some(locked) = scene.animations.pop() {
            *moved = locked;
        }
        Ok(report)
    }

    /// An animation of `source`, by its index, on the skeleton of `target`, and how well it is the same. With `lock_feet` its
    /// feet are held as [`lock_feet`](Self::lock_feet) holds them, where they do not move alike and are better so.
    ///
    /// # Errors
    /// As [`lock_feet`](Self::lock_feet), and [`Code::NoMotion`] where there is no such animation.
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
        let moved = self.animation(source, animation);
        let found = self.measure(source, animation, target, &moved);
        if lock_feet && found.feet.is_some() && !found.feet_move_alike() {
            let mut locked = moved.clone();
            let lock = self.lock_feet(source, index, target, &mut locked)?;
            let after = self.measure(source, animation, target, &locked).with_lock(&lock);
            if after.is_better_locked_than(&found) {
                return Ok((locked, after));
            }
        }
        Ok((moved, found))
    }

    /// Measures how well `moved`, an animation of the scene `target`, is `animation` of the scene `source`: both of them
    /// posed frame by frame, the directions of arms and legs, and what the feet do.
    pub fn measure(&self, source: &Scene, animation: &Animation, target: &Scene, moved: &Animation) -> RetargetReport {
        let (from, to) = self.moving(source, animation, target, moved);
        let metres = self.target.metres_per_unit / self.source.metres_per_unit;
        measure::measure(
            &from,
            &to,
            &ticks(animation),
            self.scale() * metres,
            &self.root,
            &self.plan.unmapped,
        )
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

/// Whether a motion can be put on the skeleton of `target`, as [`Retargeter::new`] asks. Without `bones` they are guessed.
///
/// # Errors
/// [`Code::NotHumanoid`] where the skeleton is not a humanoid, or has a hierarchy onto which no
/// pose can be put.
pub fn check_target(target: &Scene, bones: Option<&Humanoid>) -> Result<()> {
    Body::target(target, bones).map(|_| ())
}

/// The whole ticks of an animation, and its end.
fn ticks(animation: &Animation) -> Vec<f64> {
    let mut ticks: Vec<f64> = (0..animation.frame_count()).map(|tick| tick as f64).collect();
    if ticks.last().is_some_and(|last| *last < animation.duration) {
        ticks.push(animation.duration);
    }
    ticks
}

/// Keys at `ticks`; one where all values are the same.
fn keys<T: Copy + PartialEq>(mut values: Vec<T>, ticks: &[f64]) -> Keys<T> {
    if let Some(&first) = values.first()
        && values.iter().all(|value| *value == first)
    {
        values.truncate(1);
        return Keys::every_tick(values);
    }
    Keys::at_ticks(values, ticks.to_vec())
}
