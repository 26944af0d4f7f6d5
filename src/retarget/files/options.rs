//! The options of a retargeting.

use mocap_edit::FootLockWeights;
use mocap_figure::HumanoidMap;
use mocap_figure::convert::{Conversion, RootMotion};

use crate::Scale;
use crate::robot::Weights;
use crate::robot::report::{Floor, TimeScale};

/// The options of a [`Retargeter`](super::Retargeter).
///
/// ```
/// use mocap::retarget::Scale;
/// use mocap::retarget::RetargetOptions;
///
/// let options = RetargetOptions::new().scale(Scale::None).lock_feet(false);
/// # let _ = options;
/// ```
#[derive(Clone, Debug)]
#[must_use]
pub struct RetargetOptions {
    pub(super) scale: Scale,
    pub(super) lock_feet: bool,
    pub(super) keep_hands: bool,
    pub(super) source_bones: HumanoidMap,
    pub(super) target_bones: HumanoidMap,
    pub(super) conversion: Conversion,
    pub(super) replace_animations: bool,
    pub(super) velocity_limits: bool,
    pub(super) passes: u8,
    pub(super) floor: Floor,
    pub(super) time_scale: TimeScale,
    pub(super) root: RootMotion,
    pub(super) robot_weights: Weights,
    pub(super) foot_lock_weights: FootLockWeights,
}

impl Default for RetargetOptions {
    fn default() -> Self {
        Self {
            scale: Scale::Auto,
            lock_feet: true,
            keep_hands: true,
            source_bones: HumanoidMap::new(),
            target_bones: HumanoidMap::new(),
            conversion: Conversion::new(),
            replace_animations: false,
            velocity_limits: false,
            passes: 2,
            floor: Floor::Auto,
            time_scale: TimeScale::default(),
            root: RootMotion::Keep,
            robot_weights: Weights::default(),
            foot_lock_weights: FootLockWeights::default(),
        }
    }
}

impl RetargetOptions {
    /// The defaults.
    pub fn new() -> Self {
        Self::default()
    }

    /// The scale of the target's root motion. Default: [`Scale::Auto`], the ratio of the leg lengths.
    pub fn scale(mut self, scale: Scale) -> Self {
        self.scale = scale;
        self
    }

    /// Whether feet are locked to the ground while the source's feet are in contact. A foot of a character is locked
    /// only if it would slide more than the source's foot. Default: `true`.
    pub fn lock_feet(mut self, lock: bool) -> Self {
        self.lock_feet = lock;
        self
    }

    /// Whether the hands of a character touch the same parts as the hands of the source: each other, the head, the
    /// trunk, the legs, the floor. Default: `true`.
    pub fn keep_hands(mut self, keep: bool) -> Self {
        self.keep_hands = keep;
        self
    }

    /// Joints of the sources for bones, if the guess of [`Humanoid::of`](mocap_figure::Humanoid::of) is wrong; `None`
    /// for a bone that the sources lack. Default: empty.
    pub fn source_bones(mut self, bones: HumanoidMap) -> Self {
        self.source_bones = bones;
        self
    }

    /// The joint of the target, or the link of a robot, for each stated bone. Default: empty.
    pub fn target_bones(mut self, bones: HumanoidMap) -> Self {
        self.target_bones = bones;
        self
    }

    /// The conversion of the sources before retargeting: unit and up axis if you know them, a trimmed part, another
    /// frame rate. The output of the conversion stays in metres with +Y up. Default: [`Conversion::new`], which guesses
    /// unit and axis.
    pub fn conversion(mut self, conversion: Conversion) -> Self {
        self.conversion = conversion;
        self
    }

    /// Whether the new animations replace the animations in the file of a character. Default: `false`, both are kept.
    pub fn replace_animations(mut self, replace: bool) -> Self {
        self.replace_animations = replace;
        self
    }

    /// The root motion of clips on a character or a skeleton. It stays in the hips, is removed, or moves with the
    /// heading to the topmost node above the hips. Feet are locked and measured before this change. Default:
    /// [`RootMotion::Keep`].
    pub fn root(mut self, root: RootMotion) -> Self {
        self.root = root;
        self
    }

    /// Whether the joints of a robot also keep within the velocity limits of its file. The joints of a character have
    /// no limits. Default: `false`.
    pub fn velocity_limits(mut self, limit: bool) -> Self {
        self.velocity_limits = limit;
        self
    }

    /// The number of solver passes for a motion on a robot, 1 or 2:
    /// [`RobotOptions::passes`](crate::robot::RobotOptions::passes). Default: 2.
    pub fn passes(mut self, passes: u8) -> Self {
        self.passes = passes;
        self
    }

    /// The floor of a motion on a robot: [`RobotOptions::floor`](crate::robot::RobotOptions::floor). Default:
    /// [`Floor::Auto`].
    pub fn floor(mut self, floor: Floor) -> Self {
        self.floor = floor;
        self
    }

    /// The playback speed of a motion on a robot:
    /// [`RobotOptions::time_scale`](crate::robot::RobotOptions::time_scale). Default: the speed of the source.
    pub fn time_scale(mut self, scale: TimeScale) -> Self {
        self.time_scale = scale;
        self
    }

    /// The weights of the robot solver. Default: [`Weights::default`].
    pub fn robot_weights(mut self, weights: Weights) -> Self {
        self.robot_weights = weights;
        self
    }

    /// The weights of the foot lock. Default: [`FootLockWeights::default`].
    pub fn foot_lock_weights(mut self, weights: FootLockWeights) -> Self {
        self.foot_lock_weights = weights;
        self
    }
}
