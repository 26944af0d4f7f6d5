//! The [`Retargeter`], which retargets whole files: it runs the steps of a retargeting in their order.

mod clip;
mod face;
mod joined;
mod options;
mod outputs;
mod over_ground;
mod source;
mod target;

use std::collections::HashSet;

use mocap_figure::convert::{FirstFrame, RootMotion};
use mocap_figure::rig::Rig;
use mocap_figure::{Figure, Humanoid, HumanoidBone};
use mocap_formats::gltf::report::Provenance;
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::scene::report::{AppliedStep, DataKind, DataLoss, SecondMotion};
use mocap_scene::scene::{Animation, Format, Scene, face_shape};

pub use self::clip::{ClipReport, RetargetedClip};
pub use self::joined::{apply_steps, apply_steps_with_bones, second_motion};
pub use self::options::RetargetOptions;
use self::source::{Mover, SourceMotions};
pub use self::source::{SourceMotion, whole};
pub use self::target::Target;
use crate::animal::AnimalRetargeter;
use crate::robot::four_legs::has_four_legs;
use crate::robot::quadruped::QuadrupedRetargeter;
use crate::robot::report::{Floor, RobotReport};
use crate::robot::{Robot, RobotMotion, RobotOptions, RobotRetargeter, robot_bones, robot_scene};
use crate::{CreatureRetargeter, PoseRetargeter, check_figure};
use mocap_figure::LimbAngles;

/// Retargets whole files. It owns the scenes and the clips.
///
/// [`new`](Self::new) retargets one source to a target. For several sources, [`onto`](Self::onto) takes the target, and
/// [`add`](Self::add) takes each source. A clone of a retargeter without sources is cheap, so every thread may have a
/// clone.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::Importer;
/// use mocap::retarget::{Retargeter, RetargetOptions};
///
/// let robot = Importer::new().import_robot("fixtures/robots/g1_29dof_rev_1_0.urdf")?;
/// let mut retargeting = Retargeter::onto(robot, RetargetOptions::new())?;
/// for file in ["fixtures/real/cmu_12_01_walk.bvh", "fixtures/real/cmu_short.bvh"] {
///     let source = retargeting.prepare(mocap::import(file)?)?;
///     retargeting.add(source)?;
/// }
/// let names: Vec<&str> = retargeting.clips().iter().map(|clip| clip.animation.name.as_str()).collect();
/// assert_eq!(names, ["cmu_12_01_walk", "cmu_short"]);
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Retargeter {
    /// The target. It has a root above the hips if the options ask for a root.
    target: Target,
    /// The figure of the target; `None` for a robot.
    figure: Option<Figure>,
    options: RetargetOptions,
    /// The names of clips in the file of a character that keeps its animations, and of the clips that were added.
    names: HashSet<String>,
    sources: Vec<SourceMotions>,
    clips: Vec<RetargetedClip>,
}

impl Retargeter {
    /// Retargets all motions of `source`, an unconverted scene, to a target: a [`Target`], or a value that becomes one.
    ///
    /// # Errors
    /// The errors of [`onto`](Self::onto), [`prepare`](Self::prepare) and [`add`](Self::add).
    pub fn new(source: Scene, target: impl Into<Target>, options: RetargetOptions) -> Result<Self> {
        let mut retargeting = Self::onto(target, options)?;
        let source = retargeting.prepare(source)?;
        retargeting.add(source)?;
        Ok(retargeting)
    }

    /// Takes a target, which has no motion yet, and finds its bones.
    ///
    /// # Errors
    /// - [`Code::NotHumanoid`] if the target is neither a humanoid nor a creature of a known kind, or if its hierarchy
    ///   cannot be posed
    /// - [`Code::InvalidValue`] if [`target_bones`](RetargetOptions::target_bones) names a joint that the target lacks,
    ///   or if the skeleton of a robot's file is given as a character
    pub fn onto(target: impl Into<Target>, options: RetargetOptions) -> Result<Self> {
        let mut target = target.into();
        refuse_robot(&target)?;
        let mut bones = bones_of(&target, &options)?;
        let hips = bones.as_ref().and_then(|bones| bones.joint(HumanoidBone::Hips));
        if let (RootMotion::Extract, Some(hips)) = (options.root, hips) {
            target = over_ground::with_root(target, hips)?;
            bones = bones_of(&target, &options)?;
        }
        let scene = target.scene();
        let figure = bones.map(|bones| Figure::with_bones(&scene, bones));
        let is_checked = |figure: &&Figure| figure.humanoid.creature.is_none() && !is_face_of_shapes(&scene);
        if let Some(figure) = figure.as_ref().filter(is_checked) {
            check_figure(&scene, figure)?;
        }
        // An output that is written from a scene has only the new motions.
        let stay = matches!(target, Target::Character(_)) && !options.replace_animations;
        let names = scene.animations.iter().filter(|_| stay);
        let names = names.map(|animation| animation.name.clone()).collect();
        drop(scene);
        Ok(Self {
            target,
            figure,
            options,
            names,
            sources: Vec::new(),
            clips: Vec::new(),
        })
    }

    /// Converts an unconverted scene to metres with +Y up, by [`conversion`](RetargetOptions::conversion).
    ///
    /// # Errors
    /// The errors of [`Conversion::apply`](mocap_figure::convert::Conversion::apply); also [`Code::InvalidValue`] if
    /// [`source_bones`](RetargetOptions::source_bones) names a joint that the scene lacks.
    pub fn prepare(&self, scene: Scene) -> Result<SourceMotion> {
        let figure = Figure::mapped(&scene, &self.options.source_bones)?;
        self.prepare_figure(scene, &figure)
    }

    /// Like [`prepare`](Self::prepare) for a scene with a known figure, with
    /// [`source_bones`](RetargetOptions::source_bones).
    ///
    /// # Errors
    /// The errors of [`Conversion::apply`](mocap_figure::convert::Conversion::apply).
    pub fn prepare_figure(&self, scene: Scene, figure: &Figure) -> Result<SourceMotion> {
        self.prepare_shown(scene, figure, None)
    }

    /// Like [`prepare`](Self::prepare), but the T-pose is also inferred from `shown`, other motions of the skeleton.
    /// They have the unit and axes of the unconverted scene.
    #[doc(hidden)]
    pub fn prepare_shown(
        &self,
        mut scene: Scene,
        figure: &Figure,
        shown: Option<&[Animation]>,
    ) -> Result<SourceMotion> {
        let conversion = self.options.conversion.clone();
        let mut conversion = conversion.bones(self.options.source_bones.clone());
        let whole = whole(&mut scene, figure, shown, &conversion)?;
        let has_other_frames = whole.is_some() || conversion.takes_other_frames();
        let leaves_out_rest_pose = has_other_frames && figure.survey.first_frame_is_rest_pose;
        // Another frame rate would mix the rest pose into the motion, and a trimmed part may begin with the rest pose.
        if leaves_out_rest_pose {
            conversion = conversion.first_frame(FirstFrame::DropRestPose);
        }
        let (assumptions, inserted) = conversion.convert(&mut scene, figure)?;
        Ok(SourceMotion {
            assumptions,
            bones: Some(figure.humanoid.clone().after(inserted)),
            is_rest_pose_left_out: leaves_out_rest_pose,
            has_other_frames,
            whole,
            ..SourceMotion::converted(scene)
        })
    }

    /// Retargets all motions of a source, and returns the source in the form that was retargeted. If the source has one
    /// motion, the clip has the name of the source. If the source has several, the clips keep their names. If another
    /// clip of the output has the name, a number is added.
    ///
    /// # Errors
    /// - [`Code::NotHumanoid`] if the source is not a humanoid. With a creature as the target: if the source is of
    ///   another kind, or lacks the names of the target's joints
    /// - [`Code::NoMotion`] if the source has no animation
    /// - [`Code::InvalidValue`] if [`source_bones`](RetargetOptions::source_bones) names a joint that the source lacks
    ///
    /// The clips are unchanged after an error.
    pub fn add(&mut self, source: SourceMotion) -> Result<&SourceMotion> {
        if source.scene.animations.is_empty() {
            return Err(Diagnostic::new(Code::NoMotion, "the file contains no motion").into());
        }
        let (mut moving, names) = (self.moving(source)?, self.names.clone());
        let (source, first) = (&moving.source, self.clips.len());
        for index in 0..source.scene.animations.len() {
            let name = self.free_name(source.clip_name(index));
            let moved = self.moved(&mut moving.mover, &source.scene, index, name);
            match moved {
                Ok(clip) => self.clips.push(clip),
                Err(error) => {
                    self.clips.truncate(first);
                    self.names = names;
                    return Err(error);
                }
            }
        }
        let has_face = !matches!(self.target, Target::Robot(_));
        let is_moving = |clip: &RetargetedClip| clip.animation.moves() || has_face && !clip.face.is_empty();
        let is_lost = source.scene.moves()
            || source
                .scene
                .metadata
                .lost
                .iter()
                .any(|loss| loss.kind == DataKind::FaceCurves);
        if is_lost && !self.clips[first..].iter().any(is_moving) {
            self.clips.truncate(first);
            self.names = names;
            let message = "no joint would move: the target has no joint that moves in the source";
            return Err(Diagnostic::new(Code::NoMotion, message)
                .help("retarget onto a body that has these joints")
                .into());
        }
        moving.clips = first..self.clips.len();
        self.sources.push(moving);
        Ok(&self.sources[self.sources.len() - 1].source)
    }

    /// Measures how well a motion of the target robot follows the main clip of `reference`, an unconverted scene. Any
    /// program may have written the motion. The reference is resampled to the frame rate of the motion.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::Importer;
    /// use mocap::retarget::{RetargetOptions, Retargeter};
    ///
    /// let robot = Importer::new().import_robot("fixtures/robots/h1.urdf")?;
    /// let walk = mocap::import("fixtures/real/cmu_short.bvh")?;
    /// let made = Retargeter::new(walk.clone(), robot.clone(), RetargetOptions::new())?;
    /// let motion = made.clips()[0].robot_motion.as_ref().unwrap();
    /// let report = Retargeter::onto(robot, RetargetOptions::new())?.judge(walk, motion)?;
    /// assert!(report.scores.unwrap().mpbpe_local < 0.2);
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// The errors of [`Self::prepare`] and [`RobotRetargeter::judge`]; [`Code::InvalidValue`] if the target is not a
    /// robot on two legs.
    pub fn judge(&self, mut reference: Scene, motion: &RobotMotion) -> Result<RobotReport> {
        let mut judge = self.clone();
        judge.options.conversion = judge.options.conversion.frame_rate(motion.fps);
        judge.options.floor = Floor::Keep;
        reference.put_main_clip_first();
        let source = judge.prepare(reference)?;
        if source.scene.animations.is_empty() {
            return Err(Diagnostic::new(Code::NoMotion, "the file contains no motion").into());
        }
        let moving = judge.moving(source)?;
        let Mover::Robot(mut retargeter) = moving.mover else {
            let message = "only motions of robots with two legs can be judged, but the target is another kind of body";
            return Err(Diagnostic::new(Code::InvalidValue, message).into());
        };
        retargeter.judge(&moving.source.scene, 0, motion)
    }

    /// The retargeter for the motions of a source. It drops a rest pose in the first frame of the source.
    fn moving(&self, mut source: SourceMotion) -> Result<SourceMotions> {
        let scene = source.shows_t_pose();
        let bones = match &source.bones {
            Some(bones) => bones.clone(),
            None => Humanoid::of(scene).with_map(scene, self.options.source_bones.clone())?,
        };
        let from = Figure::with_bones(scene, bones);
        let of_scene = from.clone();
        let mover = match (&self.target, &self.figure) {
            _ if scene.is_face_alone() => Mover::Face,
            (Target::Character(_) | Target::Skeleton(_), figure) => {
                let target = self.target.scene();
                let figure = figure.clone().unwrap_or_else(|| Figure::new(&target));
                match figure.humanoid.creature {
                    Some(_) => {
                        let figures = ((scene, &from), (&*target, &figure));
                        let options = (self.options.scale, self.options.lock_feet);
                        match AnimalRetargeter::new(figures.0, figures.1, options.0, options.1)? {
                            Some(animal) => Mover::Animal(Box::new(animal)),
                            None => {
                                let creatures = CreatureRetargeter::new(figures.0, figures.1, options.0)?;
                                Mover::Creature(Box::new(creatures))
                            }
                        }
                    }
                    None => {
                        let figures = ((scene, from), (&*target, figure));
                        let retargeter = PoseRetargeter::with_figures(figures.0, figures.1, self.options.scale)?;
                        let retargeter = retargeter.with_foot_lock(self.options.foot_lock_weights);
                        Mover::Body(Box::new(retargeter.with_free_hands(!self.options.keep_hands)))
                    }
                }
            }
            (Target::Robot(robot), _) => {
                let options = RobotOptions {
                    scale: self.options.scale,
                    source: Some(from.humanoid.clone()),
                    map: self.options.target_bones.clone(),
                    velocity_limits: self.options.velocity_limits,
                    passes: self.options.passes,
                    floor: self.options.floor,
                    time_scale: self.options.time_scale,
                    lock_feet: self.options.lock_feet,
                    weights: self.options.robot_weights,
                    foot_lock: self.options.foot_lock_weights,
                };
                match is_quadruped(robot, &self.options) {
                    true => Mover::Quadruped(Box::new(QuadrupedRetargeter::new(scene, from, robot, &options)?)),
                    false => Mover::Robot(Box::new(RobotRetargeter::new(scene, robot, &options)?)),
                }
            }
        };
        // The frame is dropped only now, because it shows the T-pose.
        source.leave_out_rest_pose(&of_scene)?;
        Ok(SourceMotions {
            source,
            mover,
            clips: 0..0,
        })
    }

    /// Retargets one motion of a source to the target.
    fn moved(&self, mover: &mut Mover, source: &Scene, index: usize, name: String) -> Result<RetargetedClip> {
        let mut provenance = Provenance::of_clip(source, index);
        let lock_feet = self.options.lock_feet;
        // The source at the speed of the motion, if the robot does not move at the speed of the source.
        let mut at_speed = None;
        let (mut clip, step) = match (mover, &self.target) {
            (Mover::Robot(retargeter), Target::Robot(robot)) => {
                let (motion, report, scaled) = retargeter.scaled_clip(source, index)?;
                at_speed = scaled;
                let source = at_speed.as_ref().unwrap_or(source);
                let step = AppliedStep::Retarget {
                    onto: SecondMotion::of(&robot_scene(robot)),
                    scale: report.scale,
                    lock_feet,
                };
                let limbs = retargeter.limb_angles(source, &source.animations[index], &motion);
                let moved = RetargetedClip::of_robot(motion.to_animation(robot), report, motion);
                (moved.with_limb_angles(limbs), step)
            }
            (Mover::Quadruped(retargeter), Target::Robot(robot)) => {
                let (motion, report, scaled) = retargeter.clip(source, index)?;
                at_speed = scaled;
                let step = AppliedStep::Retarget {
                    onto: SecondMotion::of(&robot_scene(robot)),
                    scale: report.scale,
                    lock_feet,
                };
                (
                    RetargetedClip::of_robot(motion.to_animation(robot), report, motion),
                    step,
                )
            }
            (Mover::Body(retargeter), target) => {
                let target = target.scene();
                let (animation, report) = retargeter.clip(source, index, &target, lock_feet)?;
                let step = retargeter.step(&target, lock_feet);
                let lost = retargeter.lost_bones(source, &source.animations[index]);
                if lost > 0 {
                    provenance.losses.push(DataLoss::new(DataKind::MovingJoints, lost));
                }
                (RetargetedClip::of_body(animation, report), step)
            }
            (Mover::Animal(retargeter), target) => {
                let target = target.scene();
                let (animation, report) = retargeter.clip(source, index, &target)?;
                (RetargetedClip::of_body(animation, report), retargeter.step(&target))
            }
            (Mover::Creature(retargeter), target) => {
                let target = target.scene();
                let (animation, report) = retargeter.clip(source, index, &target)?;
                (RetargetedClip::of_body(animation, report), retargeter.step(&target))
            }
            (Mover::Face, target) => {
                let step = AppliedStep::Retarget {
                    onto: SecondMotion::of(&target.scene()),
                    scale: 1.0,
                    lock_feet: false,
                };
                (RetargetedClip::of_face(&source.animations[index]), step)
            }
            (Mover::Robot(_) | Mover::Quadruped(_), _) => {
                unreachable!("a robot's retargeter is made for a robot alone")
            }
        };
        let source = at_speed.as_ref().unwrap_or(source);
        let warp = at_speed.as_ref().and_then(|scaled| scaled.metadata.steps.last());
        provenance.steps.extend(warp.cloned());
        provenance.steps.push(step);
        provenance.steps.extend(self.change_over_ground(&mut clip)?);
        clip.provenance = provenance;
        clip.set_face(source.face_tracks(&source.animations[index]));
        clip.extras = source.clip_extras(index);
        clip.rename(name);
        Ok(clip)
    }

    /// Removes the root motion of a clip on a body, or moves it to a node above the hips.
    fn change_over_ground(&self, clip: &mut RetargetedClip) -> Result<Option<AppliedStep>> {
        let step = match self.options.root {
            RootMotion::Keep => return Ok(None),
            RootMotion::InPlace => AppliedStep::InPlace,
            RootMotion::Extract => AppliedStep::RootMotion,
        };
        let target = self.target.scene();
        let humanoid = self.humanoid();
        let bones = humanoid.and_then(|bones| Some((bones.joint(HumanoidBone::Hips)?, &bones.follow)));
        let (hips, follow) = bones.ok_or_else(|| {
            let message = "the target has no hips, so its root motion is unknown";
            Diagnostic::new(Code::NotHumanoid, message).help("leave out {in-place} and {root-motion}")
        })?;
        match Rig::new(&target, follow) {
            Some(rig) => {
                let mut animation = rig.in_rig(&target, &clip.animation);
                over_ground::change(&rig.scene, rig.node(hips), &mut animation, self.options.root);
                clip.animation = rig.in_file(&animation);
            }
            None => over_ground::change(&target, hips, &mut clip.animation, self.options.root),
        }
        Ok(Some(step))
    }

    /// Names the clips, in their order. If another clip of the output has the name, a number is added.
    ///
    /// # Errors
    /// [`Code::InvalidValue`] if the number of names differs from the number of clips.
    #[doc(hidden)]
    pub fn name_clips(&mut self, names: &[String]) -> Result<()> {
        if names.len() != self.clips.len() {
            let (names, clips) = (names.len(), self.clips.len());
            let message = format!("{names} names are given for {clips} clips");
            return Err(Diagnostic::new(Code::InvalidValue, message).into());
        }
        for clip in &self.clips {
            self.names.remove(&clip.animation.name);
        }
        for (index, name) in names.iter().enumerate() {
            let name = self.free_name(name.clone());
            self.clips[index].rename(name);
        }
        Ok(())
    }

    /// The name, with a number if another clip of the output has the name.
    fn free_name(&mut self, name: String) -> String {
        let numbered = (2..).map(|number| format!("{name}_{number}"));
        let mut candidates = std::iter::once(name.clone()).chain(numbered);
        let free = candidates.find(|candidate| self.names.insert(candidate.clone()));
        free.unwrap_or(name)
    }

    /// The clips of all sources, in the order in which they were added.
    pub fn clips(&self) -> &[RetargetedClip] {
        &self.clips
    }

    /// The clips of all sources, without a copy.
    pub fn into_clips(self) -> Vec<RetargetedClip> {
        self.clips
    }

    /// The sources in the form that was retargeted: in metres with +Y up, without a rest pose in the first frame.
    pub fn sources(&self) -> impl Iterator<Item = &SourceMotion> {
        self.sources.iter().map(|moving| &moving.source)
    }

    /// The target.
    pub fn target(&self) -> &Target {
        &self.target
    }

    /// The joint of each bone of the target; `None` for a robot, whose links are groups of joints: [`robot_bones`].
    pub fn humanoid(&self) -> Option<&Humanoid> {
        self.figure.as_ref().map(|figure| &figure.humanoid)
    }

    /// The angles between the limbs of a clip, by its index, and the limbs of its source at each tick. `None` if there
    /// is no such clip, and for an animal.
    pub fn limb_angles(&self, clip: usize) -> Option<Vec<LimbAngles>> {
        let moving = self.sources.iter().find(|moving| moving.clips.contains(&clip))?;
        let Mover::Body(retargeter) = &moving.mover else {
            return self.clips[clip].limb_angles.clone();
        };
        let source = &moving.source.scene;
        let animation = &source.animations[clip - moving.clips.start];
        let target = self.target.scene();
        Some(retargeter.limb_angles(source, animation, &target, &self.clips[clip].animation))
    }
}

/// Whether a scene is a face: it has morph targets. The track of a face needs only these morph targets.
fn is_face_of_shapes(scene: &Scene) -> bool {
    let mut targets = scene.meshes.iter().flat_map(|mesh| &mesh.morph_targets);
    targets.any(|target| face_shape(&target.name).is_some())
}

/// The bones of a target; `None` for a robot.
fn bones_of(target: &Target, options: &RetargetOptions) -> Result<Option<Humanoid>> {
    let found = match target {
        Target::Character(character) => character
            .humanoid()
            .cloned()
            .unwrap_or_else(|| Humanoid::of(character.scene())),
        Target::Skeleton(scene) => Humanoid::of(scene),
        Target::Robot(robot) => {
            if !is_quadruped(robot, options) {
                robot_bones(robot, Some(&options.target_bones))?;
            }
            return Ok(None);
        }
    };
    found.with_map(&target.scene(), options.target_bones.clone()).map(Some)
}

/// Whether a robot is not a humanoid and walks on four legs.
fn is_quadruped(robot: &Robot, options: &RetargetOptions) -> bool {
    robot_bones(robot, Some(&options.target_bones)).is_err() && has_four_legs(robot)
}

/// Refuses the scene of a robot's file as a character: the axes of its links would make a motion wrong.
fn refuse_robot(target: &Target) -> Result<()> {
    match target {
        Target::Skeleton(scene) if matches!(scene.metadata.format, Some(Format::Urdf | Format::Mjcf)) => Err(
            Diagnostic::new(Code::InvalidValue, "the target is a robot, not a character")
                .help("name it as a robot: \"target\": {\"robot\": {\"file\": ...}} in a job, or mocap robot")
                .into(),
        ),
        _ => Ok(()),
    }
}
