//! A scene whose motions are retargeted.

use std::ops::Range;

use mocap_figure::convert::Conversion;
use mocap_figure::{Figure, Humanoid, is_at_rest_alike};
use mocap_scene::error::Result;
use mocap_scene::scene::{Animation, Assumption, Scene};

use crate::animal::AnimalRetargeter;
use crate::robot::RobotRetargeter;
use crate::robot::quadruped::QuadrupedRetargeter;
use crate::{CreatureRetargeter, PoseRetargeter};

/// A scene in metres with +Y up whose motions are retargeted.
///
/// [`Retargeter::prepare`](super::Retargeter::prepare) makes it from an unconverted scene.
/// [`converted`](Self::converted) makes it from a scene that [`Conversion::apply`](mocap_figure::Conversion::apply) has
/// already changed.
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
    /// The scene, and its bones if they are already known.
    #[doc(hidden)]
    pub scene: Scene,
    #[doc(hidden)]
    pub bones: Option<Humanoid>,
    /// The name of the clip. Default: the name of the file, without the extension.
    pub name: String,
    /// The values that the file does not state, with reasons.
    pub assumptions: Vec<Assumption>,
    /// Whether [`Retargeter::add`](super::Retargeter::add) dropped a rest pose in the first frame.
    pub is_rest_pose_left_out: bool,
    /// Whether the conversion changed the frames. If so, it has already kept or dropped a rest pose in the first frame.
    pub(super) has_other_frames: bool,
    /// The scene from which the T-pose is inferred, if it is not `scene`. It has all frames of the motion, or the
    /// frames of several motions of the skeleton.
    #[doc(hidden)]
    pub whole: Option<Box<Scene>>,
}

impl SourceMotion {
    /// A source from a scene that is already in metres with +Y up.
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

    /// Sets the name of the clip.
    #[must_use]
    pub fn named(mut self, name: impl Into<String>) -> Self {
        self.name = name.into();
        self
    }

    /// The scene that shows the T-pose. If a step changed the skeleton, it is the changed scene.
    pub(super) fn shows_t_pose(&self) -> &Scene {
        let whole = self.whole.as_deref();
        whole
            .filter(|whole| is_at_rest_alike(whole, &self.scene))
            .unwrap_or(&self.scene)
    }

    /// Drops a rest pose in the first frame, unless the conversion handled it. `figure` is the figure of
    /// [`shows_t_pose`](Self::shows_t_pose).
    pub(super) fn leave_out_rest_pose(&mut self, figure: &Figure) -> Result<()> {
        self.whole = None;
        if !self.has_other_frames {
            self.is_rest_pose_left_out = Conversion::leave_out_rest_pose(&mut self.scene, figure)?;
        }
        Ok(())
    }

    /// The name of the clip: the name of the source, and the name of the motion if the source has several.
    pub(super) fn clip_name(&self, index: usize) -> String {
        let animations = &self.scene.animations;
        match (animations.len(), animations[index].name.as_str()) {
            (1, _) | (_, "") => self.name.clone(),
            (_, name) => name.to_owned(),
        }
    }
}

/// The converted scene with all its frames. If `shown` is given, the result has the frames of `shown`, whose unit and
/// axes are those of `scene`. `None` if `shown` is absent and the conversion does not change the frames. The T-pose is
/// inferred from all frames, so a part of a motion is retargeted in the same way as the whole motion.
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

/// A source with the retargeter of its motions.
#[derive(Clone, Debug)]
pub(super) struct SourceMotions {
    pub(super) source: SourceMotion,
    pub(super) mover: Mover,
    /// The range of the source's clips among all clips.
    pub(super) clips: Range<usize>,
}

/// A retargeter of motions.
#[derive(Clone, Debug)]
pub(super) enum Mover {
    Body(Box<PoseRetargeter>),
    Animal(Box<AnimalRetargeter>),
    Creature(Box<CreatureRetargeter>),
    Robot(Box<RobotRetargeter>),
    Quadruped(Box<QuadrupedRetargeter>),
    /// No retargeter: the source is a face without a body.
    Face,
}
