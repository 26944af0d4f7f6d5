//! A scene whose motions are moved.

use std::ops::Range;

use mocap_figure::convert::Conversion;
use mocap_figure::{Figure, Humanoid, is_at_rest_alike};
use mocap_scene::error::Result;
use mocap_scene::scene::{Animation, Assumption, Scene};

use crate::robot::RobotRetargeter;
use crate::robot::quadruped::QuadrupedRetargeter;
use crate::{CreatureRetargeter, PoseRetargeter};

/// A scene in metres with +Y up whose motions go onto a target.
///
/// [`Retargeter::prepare`](super::Retargeter::prepare) makes it of a scene as it was read;
/// [`converted`](Self::converted) of one that [`Conversion::apply`](mocap_figure::Conversion::apply) has changed
/// already.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::Conversion;
/// use mocap::retarget::{Retargeter, RetargetOptions, SourceMotion};
///
/// let mut walk = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
/// Conversion::new().frame_rate(30.0).apply(&mut walk)?;
/// let target = mocap::import("fixtures/skeletons/human_default.gltf")?;
/// let mut retargeting = Retargeter::onto(target, RetargetOptions::new())?;
/// retargeting.add(SourceMotion::converted(walk).named("stroll"))?;
/// assert_eq!(retargeting.clips()[0].animation.name, "stroll");
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct SourceMotion {
    /// The scene, and the bones in it where they are found already.
    #[doc(hidden)]
    pub scene: Scene,
    #[doc(hidden)]
    pub bones: Option<Humanoid>,
    /// The name of its clip. Default: the name of the file, without the extension.
    pub name: String,
    /// What the file does not state, with reasons.
    pub assumptions: Vec<Assumption>,
    /// Whether [`Retargeter::add`](super::Retargeter::add) has left out a rest pose in the first frame.
    pub is_rest_pose_left_out: bool,
    /// Whether the conversion has taken other frames, and so knows of a rest pose in the first.
    pub(super) has_other_frames: bool,
    /// The motion with all its frames, where the conversion has taken others, or with those of other motions of its
    /// skeleton: it shows where the T-pose is.
    #[doc(hidden)]
    pub whole: Option<Box<Scene>>,
}

impl SourceMotion {
    /// A scene that is in metres with +Y up.
    pub fn converted(scene: Scene) -> Self {
        let origin = scene.metadata.origin.as_ref();
        Self {
            name: origin.map_or_else(String::new, |origin| origin.stem().to_owned()),
            scene,
            assumptions: Vec::new(),
            is_rest_pose_left_out: false,
            has_other_frames: false,
            whole: None,
            bones: None,
        }
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Names its clip.
    #[must_use]
    pub fn named(mut self, name: impl Into<String>) -> Self {
        self.name = name.into();
        self
    }

    /// The scene in which the T-pose is looked for. Where a step has changed the skeleton, it is the changed one.
    pub(super) fn shows_t_pose(&self) -> &Scene {
        let whole = self.whole.as_deref();
        whole
            .filter(|whole| is_at_rest_alike(whole, &self.scene))
            .unwrap_or(&self.scene)
    }

    /// Leaves out a rest pose in the first frame, unless the conversion has done so. `figure` is that of
    /// [`shows_t_pose`](Self::shows_t_pose).
    pub(super) fn leave_out_rest_pose(&mut self, figure: &Figure) -> Result<()> {
        self.whole = None;
        if !self.has_other_frames {
            self.is_rest_pose_left_out = Conversion::leave_out_rest_pose(&mut self.scene, figure)?;
        }
        Ok(())
    }

    /// The name of the source, and that of the clip where the source has several.
    pub(super) fn clip_name(&self, index: usize) -> String {
        let animations = &self.scene.animations;
        match (animations.len(), animations[index].name.as_str()) {
            (1, _) | (_, "") => self.name.clone(),
            (_, name) => name.to_owned(),
        }
    }
}

/// The scene after a conversion with all its frames, or with those of `shown`, which are in its space; `None` where
/// nothing is shown and the conversion takes no others. All frames say where the T-pose is: a part of a motion is moved
/// as it is in the whole.
#[doc(hidden)]
pub fn whole(
    scene: &mut Scene,
    figure: &Figure,
    shown: Option<&[Animation]>,
    conversion: &Conversion,
) -> Result<Option<Box<Scene>>> {
    if scene.animations.is_empty() || (shown.is_none() && !conversion.takes_other_frames()) {
        return Ok(None);
    }
    let mut all_frames = match shown {
        Some(shown) => {
            let own = std::mem::replace(&mut scene.animations, shown.to_vec());
            let all_frames = scene.clone();
            scene.animations = own;
            all_frames
        }
        None => scene.clone(),
    };
    conversion.clone().all_frames().convert(&mut all_frames, figure)?;
    Ok(Some(Box::new(all_frames)))
}

/// A source, and what has moved its motions.
#[derive(Clone, Debug)]
pub(super) struct SourceMotions {
    pub(super) source: SourceMotion,
    pub(super) mover: Mover,
    /// Which of the clips are its own.
    pub(super) clips: Range<usize>,
}

/// What moves motions.
#[derive(Clone, Debug)]
pub(super) enum Mover {
    Body(Box<PoseRetargeter>),
    Creature(Box<CreatureRetargeter>),
    Robot(Box<RobotRetargeter>),
    Quadruped(Box<QuadrupedRetargeter>),
    /// Nothing: the source is a face without a body.
    Face,
}
